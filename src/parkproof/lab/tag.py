"""Finding the robot's tag: AprilTags of the family 36h11, each with its homography to pixels.

The **tag's frame** is the tag as it is printed and read, seen from above: origin at the centre of
the black square, x to the right, y up, its side the unit. Corners go counter-clockwise from bottom
left. Pixels are OpenCV's: the centre of the first one is (0, 0).
"""

import ctypes
import enum
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.lab.devices import Image
from parkproof.model.homography import Homography

if TYPE_CHECKING:
    from pyapriltags import Detection as Found

FAMILY = "tag36h11"
TAGS = 587
"""Tags in the family: ids 0 to 586."""

QUIET = 1 / 8
"""Width of the white margin that a tag needs around its black square, in sides."""

LEAST_SIDE = 8
"""Pictures with fewer rows or columns cannot hold a tag, one pixel a cell."""

_MOST_WRONG_BITS = 1
_LEAST_MARGIN = 25.0
"""Grey levels between cells and threshold: true tags have 60 or more, false ones below 20."""

_CONTRAST = 24
"""Grey levels between black and white below which the detector sees no edges. With its own 5, the
noise of a plain floor makes a picture take twenty times as long."""

_GRID = 4
"""The detector thresholds in squares of so many px: regions that start on this grid give just what
the whole picture gives."""

Point = tuple[float, float]
Corners = tuple[Point, Point, Point, Point]


class Detection(NamedTuple):
    """A tag that was seen.

    Attributes
    ----------
    tag_id : int
        Which one.
    corners : tuple
        Corners of its black square in px, counter-clockwise on the tag from bottom left.
    homography : Homography
        Tag's frame → px, exactly through the corners.
    margin : float
        Grey levels between its cells and the threshold, on average: contrast.

    Examples
    --------
    >>> corners = ((10.0, 50.0), (50.0, 50.0), (50.0, 10.0), (10.0, 10.0))
    >>> seen = Detection(3, corners, square_homography(corners), margin=90.0)
    >>> seen.centre, seen.side
    ((30.0, 30.0), 40.0)
    """

    tag_id: int
    corners: Corners
    homography: Homography
    margin: float

    @property
    def centre(self) -> Point:
        """Image of the tag's centre, px."""
        return self.homography.project(0.0, 0.0)

    @property
    def side(self) -> float:
        """Mean length of its four sides, px."""
        return sum(math.dist(self.corners[k - 1], self.corners[k]) for k in range(4)) / 4.0


class Unseen(enum.Enum):
    """Why there is not one tag of the robot's.

    Examples
    --------
    >>> Unseen.TWICE.sentence
    'two tags have the id of the robot'
    """

    ABSENT = "the tag of the robot is not seen"
    TWICE = "two tags have the id of the robot"

    @property
    def sentence(self) -> str:
        """In words."""
        return self.value


class Near(NamedTuple):
    """Where a tag is looked for first.

    Attributes
    ----------
    u, v : float
        Where its centre is expected, px.
    reach : float
        Half the width of the square that is searched, px: room for the tag with its white margin,
        and for being wrong. See `near`.
    """

    u: float
    v: float
    reach: float


SLACK = 24.0
"""How wrong an expectation may be, px."""


def near(centre: Point, side: float, *, slack: float = SLACK) -> Near:
    """Region in which a tag is found whole if it is about where it is expected.

    Parameters
    ----------
    centre : tuple of float
        Where its centre is expected, px.
    side : float
        Its side, px.
    slack : float
        How wrong the expectation may be, px.

    Returns
    -------
    Near
        For `TagDetector.find`.

    Examples
    --------
    >>> near((320.0, 240.0), side=30.0)
    Near(u=320.0, v=240.0, reach=53.5)
    """
    # Half the diagonal of the tag with its white margin, and a tenth for perspective.
    half = 1.1 * math.sqrt(0.5) * (1.0 + 2.0 * QUIET) * side
    return Near(*centre, reach=math.ceil(2.0 * (half + slack)) / 2.0)


def square_homography(corners: Corners) -> Homography:
    """Homography from the tag's frame to px, exactly through four corners.

    Heckbert's closed form for the unit square, moved to the centre.

    Parameters
    ----------
    corners : tuple of four points
        Images of (−½, −½), (½, −½), (½, ½), (−½, ½).

    Returns
    -------
    Homography
        Tag's frame → px, with w3 = 1 at the centre.

    Raises
    ------
    InputError
        If three of the corners lie on a line.

    Examples
    --------
    >>> square_homography(((10.0, 50.0), (50.0, 50.0), (50.0, 10.0), (10.0, 10.0))).entries
    (40.0, 0.0, 30.0, 0.0, -40.0, 30.0, 0.0, 0.0, 1.0)
    """
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = corners
    dx1, dx2, dx3 = x1 - x2, x3 - x2, x0 - x1 + x2 - x3
    dy1, dy2, dy3 = y1 - y2, y3 - y2, y0 - y1 + y2 - y3
    det = dx1 * dy2 - dx2 * dy1
    if det == 0.0:
        raise InputError(
            f"corners = {corners}: three lie on a line; give the four corners of a square"
        )
    g = (dx3 * dy2 - dx2 * dy3) / det
    h = (dx1 * dy3 - dx3 * dy1) / det
    a, b = x1 - x0 + g * x1, x3 - x0 + h * x3
    d, e = y1 - y0 + g * y1, y3 - y0 + h * y3
    w = 1.0 + 0.5 * (g + h)
    u, v = x0 + 0.5 * (a + b), y0 + 0.5 * (d + e)
    return Homography((a / w, b / w, u / w, d / w, e / w, v / w, g / w, h / w, 1.0))


def grey(image: Image) -> NDArray[np.uint8]:
    """Check a picture, and make it grey.

    Parameters
    ----------
    image : array of uint8
        Grey, or RGB.

    Returns
    -------
    array of uint8
        Rows × columns.

    Raises
    ------
    InputError
        If it is no picture: not such an array, or without a pixel.

    Examples
    --------
    >>> grey(np.zeros((48, 64, 3), np.uint8)).shape
    (48, 64)
    >>> grey(np.zeros((0, 64), np.uint8))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: picture of 0 × 64 pixels: ...
    """
    shape = getattr(image, "shape", None)
    if not isinstance(image, np.ndarray) or shape is None or image.dtype != np.uint8:
        kind = image.dtype if isinstance(image, np.ndarray) else type(image).__name__
        raise InputError(
            f"picture of {kind}: must be an array of uint8, 0 black to 255 white; convert it, for "
            "example with image.astype(numpy.uint8)"
        )
    if image.ndim == 3 and shape[2] == 1:
        image = image[:, :, 0]
    if not (image.ndim == 2 or (image.ndim == 3 and shape[2] == 3)):
        raise InputError(
            f"picture of shape {shape}: must be rows × columns, or rows × columns × 3 in the order "
            "red, green, blue; leave out what is more, such as a layer of opacity"
        )
    if min(shape[:2]) < LEAST_SIDE:
        raise InputError(
            f"picture of {shape[0]} × {shape[1]} pixels: must have at least {LEAST_SIDE} rows and "
            "columns to show a tag; check what the camera gives"
        )
    if image.ndim == 2:
        return np.ascontiguousarray(image)
    require("cv2", extra="lab", purpose="finding tags")
    import cv2

    return cast("NDArray[np.uint8]", cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))


class TagDetector:
    """Finds tags in pictures; holds no memory of earlier ones.

    Raises
    ------
    InputError
        If the library for tags is not installed.

    Examples
    --------
    >>> TagDetector().detect(np.full((480, 640), 200, np.uint8))
    []
    """

    def __init__(self) -> None:
        require("pyapriltags", "cv2", extra="lab", purpose="finding tags")
        from pyapriltags import Detector

        # Small tags must not be decimated; snapping edges to gradients is what makes corners good
        # to hundredths of a pixel; blurring first makes everything worse.
        self._detector = Detector(
            families=FAMILY, nthreads=1, quad_decimate=1.0, quad_sigma=0.0, refine_edges=1
        )
        # The constructor rounds this down to 0; with it, tags of 16 px are read without wrong bits.
        settings = self._detector.tag_detector_ptr
        if settings is not None:
            settings.contents.decode_sharpening = 0.25
            _ignore_noise(settings)

    def detect(self, image: Image, *, flipped: bool | None = None) -> list[Detection]:
        """Find all tags in a picture, by id.

        Parameters
        ----------
        image : array of uint8
            Grey or RGB.
        flipped : bool, optional
            Whether the picture shows everything as in a mirror, as some webcams do. If it is not
            given, tags are looked for as they are, and if there is none, in the mirror.

        Returns
        -------
        list of Detection
            None are left out but those with more than one wrong bit, or hardly any contrast.

        Raises
        ------
        InputError
            If it is no picture.
        """
        return self._detect(grey(image), flipped, (0, 0))

    def find(
        self, image: Image, tag_id: int, *, near: Near | None = None, flipped: bool | None = None
    ) -> Detection | Unseen:
        """Find one tag: first where it is expected, which is quick, then in the whole picture.

        A second tag of the same id is noticed where the tag was looked for: call this without
        ``near`` now and then.

        Parameters
        ----------
        image : array of uint8
            Grey or RGB.
        tag_id : int
            Which tag.
        near : Near, optional
            Where it is expected.
        flipped : bool, optional
            As in `detect`.

        Returns
        -------
        Detection or Unseen
            The tag, or why there is not one.

        Raises
        ------
        InputError
            If it is no picture.
        """
        whole = grey(image)
        region = _region(near, *whole.shape)
        if region is not None:
            rows, columns = region
            part = np.ascontiguousarray(whole[rows, columns])
            seen = self._detect(part, flipped, (columns.start, rows.start))
            found = the_one(seen, tag_id)
            if found is not Unseen.ABSENT:
                return found
        return the_one(self._detect(whole, flipped, (0, 0)), tag_id)

    def _detect(
        self, picture: NDArray[np.uint8], flipped: bool | None, origin: tuple[int, int]
    ) -> list[Detection]:
        """Detections in part of a picture that starts at (column, row) ``origin``."""
        seen: list[Detection] = []
        for mirror in (False, True) if flipped is None else (flipped,):
            shown = np.ascontiguousarray(picture[:, ::-1]) if mirror else picture
            width = picture.shape[1] if mirror else None
            seen = [
                _detection(found, origin, width)
                for found in self._detector.detect(shown)
                if found.hamming <= _MOST_WRONG_BITS and found.decision_margin >= _LEAST_MARGIN
            ]
            if seen:
                break
        return sorted(seen, key=lambda detection: (detection.tag_id, detection.corners))


class _Thresholds(ctypes.Structure):
    """Settings of AprilTag 3 that its wrapper does not show, after those that it shows."""

    _fields_ = (
        ("shown", ctypes.c_char * 28),
        ("min_cluster_pixels", ctypes.c_int),
        ("max_nmaxima", ctypes.c_int),
        ("critical_rad", ctypes.c_float),
        ("cos_critical_rad", ctypes.c_float),
        ("max_line_fit_mse", ctypes.c_float),
        ("min_white_black_diff", ctypes.c_int),
        ("deglitch", ctypes.c_int),
    )


def _ignore_noise(settings: object) -> None:
    """Set the least contrast, if the library's settings lie where AprilTag 3 has them."""
    found = ctypes.cast(settings, ctypes.POINTER(_Thresholds)).contents  # type: ignore[arg-type]  # a pointer to another structure
    defaults = (found.min_cluster_pixels, found.max_nmaxima, found.min_white_black_diff)
    if defaults == (5, 10, 5) and found.deglitch == 0 and found.max_line_fit_mse == 10.0:
        found.min_white_black_diff = _CONTRAST


def _detection(found: "Found", origin: tuple[int, int], width: int | None) -> Detection:
    """In the whole picture's pixels; ``width`` is that of a picture that was mirrored."""
    points = []
    for x, y in found.corners:
        # AprilTag's pixels have their centre at (½, ½).
        u = float(x) - 0.5 if width is None else width - 0.5 - float(x)
        points.append((u + origin[0], float(y) - 0.5 + origin[1]))
    corners = cast("Corners", tuple(points))
    return Detection(
        int(found.tag_id), corners, square_homography(corners), float(found.decision_margin)
    )


def the_one(seen: Sequence[Detection], tag_id: int) -> Detection | Unseen:
    """The tag of the robot among all that were seen.

    Parameters
    ----------
    seen : sequence of Detection
        All of them.
    tag_id : int
        The robot's.

    Returns
    -------
    Detection or Unseen
        The tag, or why there is not one.

    Examples
    --------
    >>> the_one([], 7)
    <Unseen.ABSENT: 'the tag of the robot is not seen'>
    """
    own = [detection for detection in seen if detection.tag_id == tag_id]
    if len(own) == 1:
        return own[0]
    return Unseen.TWICE if own else Unseen.ABSENT


def _region(near: Near | None, rows: int, columns: int) -> tuple[slice, slice] | None:
    """Rows and columns to search first, on the detector's grid; None if that saves nothing."""
    if near is None or not all(map(math.isfinite, near)):
        return None
    spans = []
    for centre, size in ((near.v, rows), (near.u, columns)):
        first = max(0, _GRID * math.floor((centre - near.reach) / _GRID))
        last = min(size, _GRID * math.ceil((centre + near.reach + 1.0) / _GRID))
        if last - first < LEAST_SIDE:
            return None
        spans.append(slice(first, last))
    return spans[0], spans[1]
