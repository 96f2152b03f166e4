"""The goal as a picture showed it: where to park, the unit of length, and what the gains can be.

Goal coordinates are those of `parkproof.model.goal_frame.goal_similarity`: origin and heading of
the robot as it was shown, its tag's side there as the unit, β > 0. Gains a are goal units per side
of the tag that the robot drives, so about 1 near the goal.
"""

from pathlib import Path

import msgspec
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.lab.devices import Image
from parkproof.lab.image_pose import ImagePose, TagMount
from parkproof.lab.picture import checked_picture
from parkproof.model.goal_frame import gain_bounds, goal_similarity
from parkproof.model.homography import Homography, Nine, numbers
from parkproof.model.image_unicycle import ImageUnicycle
from parkproof.model.unicycle import Pose, wrap_angle
from parkproof.output import write_whole
from parkproof.validate import finite, increasing, positive

SCHEMA = "parkproof-goal-1"

SEEN_MARGIN = 1.05
"""Factor on gains that frames have shown: noise, and what lies between the frames."""

READABLE = 8.0
"""Tags with sides below so many px cannot be read: what would look smaller is not in view."""


class GainRange(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Bounds of the gains over the view and all headings, in goal coordinates.

    Parameters
    ----------
    a : tuple of float
        Least and greatest a, goal units per side of the tag driven; positive.
    beta : tuple of float
        Least and greatest β; positive.

    Raises
    ------
    InputError
        If a bound is not positive, or they are crossed.

    Examples
    --------
    >>> GainRange(a=(0.8, 1.25), beta=(0.9, 1.1)).a
    (0.8, 1.25)
    """

    a: tuple[float, float]
    beta: tuple[float, float]

    def __post_init__(self) -> None:
        for name in ("a", "beta"):
            low, high = increasing(f"gains.{name}", getattr(self, name))
            positive(f"gains.{name}[0]", low)
            force_setattr(self, name, (low, high))

    @classmethod
    def shown_by(cls, pose: ImagePose, *, unit: float, margin: float = SEEN_MARGIN) -> "GainRange":
        """Bounds that hold what a frame shows, at its place for all headings.

        Parameters
        ----------
        pose : ImagePose
            The robot in that frame, px.
        unit : float
            Px of a goal unit.
        margin : float
            Factor by which the bounds exceed what is seen, at least 1.

        Returns
        -------
        GainRange
            In goal coordinates.

        Examples
        --------
        >>> pose = ImagePose(9.0, 9.0, 0.0, beta=-1.0, a=60.0, side=50.0, a_min=40.0, a_max=60.0)
        >>> GainRange.shown_by(pose, unit=40.0, margin=1.0)
        GainRange(a=(1.0, 1.5), beta=(0.6666666666666666, 1.5))
        """
        ratio = pose.a_max / pose.a_min * margin
        return cls(
            a=(pose.a_min / unit / margin, pose.a_max / unit * margin), beta=(1.0 / ratio, ratio)
        )

    def widened(self, pose: ImagePose, *, unit: float, margin: float = SEEN_MARGIN) -> "GainRange":
        """Bounds that also hold what a frame shows.

        Parameters
        ----------
        pose, unit, margin
            As for `shown_by`.

        Returns
        -------
        GainRange
            This one, if it holds all of it already.

        Examples
        --------
        >>> pose = ImagePose(9.0, 9.0, 0.0, beta=-1.0, a=60.0, side=50.0, a_min=40.0, a_max=60.0)
        >>> GainRange(a=(0.8, 1.25), beta=(0.9, 1.1)).widened(pose, unit=40.0, margin=1.0)
        GainRange(a=(0.8, 1.5), beta=(0.6666666666666666, 1.5))
        """
        more = GainRange.shown_by(pose, unit=unit, margin=margin)
        wide = GainRange(
            a=(min(self.a[0], more.a[0]), max(self.a[1], more.a[1])),
            beta=(min(self.beta[0], more.beta[0]), max(self.beta[1], more.beta[1])),
        )
        return self if wide == self else wide


def extrapolation_margin(unit: float) -> float:
    """Factor on bounds of gains that are extrapolated from one look at a tag.

    A tenth, and what errors of the corners make of the perspective across the picture: more for
    smaller tags. It held for 99 % of random cameras of 640 × 480 px without distortion; under
    distortion the bounds are rough, and what frames show must widen them.

    Parameters
    ----------
    unit : float
        Side of the tag, px.

    Returns
    -------
    float
        At least 1.1.

    Examples
    --------
    >>> [round(extrapolation_margin(unit), 2) for unit in (20.0, 28.0, 40.0, 60.0)]
    [1.76, 1.27, 1.14, 1.11]
    """
    return 1.1 + (18.0 / unit) ** 4


def gain_range(
    homography: Homography,
    unit: float,
    picture: tuple[int, int],
    *,
    margin: float | None = None,
) -> GainRange:
    """Bounds of the gains over the view, from one look at the tag.

    The tag's homography is that of the whole plane in which it moves, known at the tag: over the
    picture it is an extrapolation, hence the margin. Where the tag would look too small to be
    read, the robot is not in view.

    Parameters
    ----------
    homography : Homography
        Tag's frame → px.
    unit : float
        Px of a goal unit, the tag's side in that frame.
    picture : tuple of int
        Width and height of the picture, px.
    margin : float, optional
        Factor by which the bounds exceed what is extrapolated, at least 1; default
        `extrapolation_margin`.

    Returns
    -------
    GainRange
        In goal coordinates.

    Examples
    --------
    >>> straight_on = Homography((40.0, 0.0, 320.0, 0.0, -40.0, 240.0, 0.0, 0.0, 1.0))
    >>> gain_range(straight_on, 40.0, (640, 480), margin=1.1)
    GainRange(a=(0.9090909090909091, 1.1), beta=(0.9090909090909091, 1.1))
    """
    margin = extrapolation_margin(unit) if margin is None else margin
    bounds = gain_bounds(homography, _readable_view(homography, unit, picture))
    ratio = margin * max(abs(bounds.beta_min), abs(bounds.beta_max))
    return GainRange(
        a=(bounds.a_min / unit / margin, bounds.a_max / unit * margin), beta=(1.0 / ratio, ratio)
    )


def _readable_view(
    homography: Homography, unit: float, picture: tuple[int, int]
) -> list[tuple[float, float]]:
    """Polygon of the picture without the part in which the tag would be too small to be read."""
    to_tag = homography.inverse()
    # det J goes with the cube of the inverse map's depth, and the tag's size with its root.
    least = to_tag.depth(*homography.project(0.0, 0.0)) * min(1.0, (READABLE / unit) ** (2 / 3))
    width, height = picture
    corners = [(-0.5, -0.5), (width - 0.5, -0.5), (width - 0.5, height - 0.5), (-0.5, height - 0.5)]
    kept: list[tuple[float, float]] = []
    for (u0, v0), (u1, v1) in zip(corners, corners[1:] + corners[:1], strict=True):
        before, after = to_tag.depth(u0, v0) - least, to_tag.depth(u1, v1) - least
        if before >= 0.0:
            kept.append((u0, v0))
        if before * after < 0.0:
            t = before / (before - after)
            kept.append((u0 + t * (u1 - u0), v0 + t * (v1 - v0)))
    return kept


class Goal(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    tag=SCHEMA,
    tag_field="schema",
):
    """Where to park, as one picture showed it. Its JSON form is the file goal.json.

    Parameters
    ----------
    u, v : float
        Image of the axle's middle, px.
    psi : float
        Image heading in rad.
    unit : float
        Px of a goal unit: the mean side of the tag.
    mirrored : bool
        Whether β < 0 in the picture, as in all but those of a mirror.
    picture : tuple of int
        Width and height of the picture, px.
    mount : TagMount
        How the tag sits on the robot.
    homography : tuple of nine floats
        Tag's frame → px at the goal, row by row.
    a, beta : float
        Gains at the goal, in goal coordinates: a near 1, β > 0.
    gains : GainRange
        Bounds of the gains over the view, as far as one frame lets expect: for information. Courses
        are planned with what frames have shown.

    Raises
    ------
    InputError
        If a number is not finite or out of its range, or the homography singular.
    """

    u: float
    v: float
    psi: float
    unit: float
    mirrored: bool
    picture: tuple[int, int]
    mount: TagMount
    homography: Nine
    a: float
    beta: float
    gains: GainRange

    def __post_init__(self) -> None:
        for name in ("u", "v", "psi"):
            force_setattr(self, name, finite(name, getattr(self, name)))
        for name, example in (("unit", 30.0), ("a", 1.0), ("beta", 1.0)):
            force_setattr(self, name, positive(name, getattr(self, name), example=example))
        for name, size in zip(("width", "height"), self.picture, strict=True):
            positive(f"picture {name}", size, example=640)
        force_setattr(self, "homography", numbers("homography", self.homography, 9))
        _ = Homography(self.homography)

    @property
    def pose(self) -> Pose:
        """Image pose of the goal, px and rad."""
        return Pose(self.u, self.v, self.psi)

    @property
    def flipped(self) -> bool:
        """Whether the picture is that of a mirror: what `TagDetector.find` asks."""
        return not self.mirrored

    @property
    def similarity(self) -> Homography:
        """Pixels → goal coordinates."""
        return goal_similarity(self.pose, self.unit, mirrored=self.mirrored)

    def to_image(self, pose: ImagePose) -> ImageUnicycle:
        """Robot in goal coordinates: x0 = x, x1 = y, θ from the goal's heading, a and β.

        Parameters
        ----------
        pose : ImagePose
            The robot in a frame, px.

        Returns
        -------
        ImageUnicycle
            β is positive, if the frame has the goal's handedness.
        """
        x, y = self.similarity.project(pose.u, pose.v)
        flip = -1.0 if self.mirrored else 1.0
        theta = wrap_angle(flip * (pose.psi - self.psi))
        return ImageUnicycle(Pose(x, y, theta), a=pose.a / self.unit, beta=flip * pose.beta)

    def to_pixels(self, x: float, y: float) -> tuple[float, float]:
        """Pixel of a point in goal coordinates.

        Parameters
        ----------
        x, y : float
            The point, goal units.

        Returns
        -------
        tuple of float
            (u, v) in px.
        """
        return self.similarity.inverse().project(x, y)

    def corners(self) -> list[tuple[float, float]]:
        """Corners of the picture in goal coordinates, from the top left on, clockwise on screen."""
        width, height = self.picture
        right, bottom = width - 0.5, height - 0.5
        similarity = self.similarity
        edges = ((-0.5, -0.5), (right, -0.5), (right, bottom), (-0.5, bottom))
        return [similarity.project(u, v) for u, v in edges]

    def check_picture(self, image: Image) -> None:
        """Raise unless a picture has the size of the goal's.

        Parameters
        ----------
        image : array of uint8
            Rows × columns, or rows × columns × 3.

        Raises
        ------
        InputError
            If it is no picture, or its size is another: pixels would then mean other places.
        """
        height, width = checked_picture(image).shape[:2]
        if (width, height) != self.picture:
            raise InputError(
                f"picture of {width} × {height} pixels: the goal was taught with "
                f"{self.picture[0]} × {self.picture[1]}; set the camera to that size, or teach the "
                "goal again"
            )

    def to_json(self) -> str:
        """Text of goal.json."""
        return msgspec.json.format(msgspec.json.encode(self), indent=1).decode() + "\n"

    def write(self, path: Path | str) -> None:
        """Write goal.json, whole or not at all; one that was there is replaced.

        Parameters
        ----------
        path : Path or str
            The file.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        write_whole(path, self.to_json())

    @classmethod
    def read(cls, path: Path | str) -> "Goal":
        """Read and check goal.json.

        Parameters
        ----------
        path : Path or str
            The file.

        Returns
        -------
        Goal
            What was taught.

        Raises
        ------
        InputError
            If there is no such file, or it is no goal.
        """
        try:
            content = Path(path).read_bytes()
        except OSError as error:
            raise InputError(
                f"cannot read {path}: {error.strerror or error}; write one with: parkproof teach "
                "--out goal.json"
            ) from error
        try:
            return msgspec.json.decode(content, type=cls)
        except (msgspec.DecodeError, RecursionError) as error:
            raise InputError(
                f"{path} is no goal ({SCHEMA}): {error}; write one with: parkproof teach --out "
                "goal.json"
            ) from error
