"""Finding the robot's tag: AprilTags of the family 36h11, each with its homography to pixels.

The tag's frame, the order of its corners, and pixels are those of `parkproof.lab.tag_square`.
"""

import ctypes
import enum
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from parkproof.extras import require
from parkproof.lab.devices import Image
from parkproof.lab.picture import grey
from parkproof.lab.tag_square import Corners, Near, Point, region_of, square_homography
from parkproof.model.homography import Homography

if TYPE_CHECKING:
    from pyapriltags import Detection as Found

FAMILY = "tag36h11"
TAGS = 587
"""Tags in the family: ids 0 to 586."""

_MOST_WRONG_BITS = 1
_LEAST_MARGIN = 25.0
"""Grey levels between cells and threshold: true tags have 60 or more, false ones below 20."""

_CONTRAST = 24
"""Grey levels between black and white below which the detector sees no edges. With its own 5, the
noise of a plain floor makes a picture take twenty times as long."""


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
        region = region_of(near, *whole.shape)
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
