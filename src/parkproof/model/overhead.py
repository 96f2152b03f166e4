"""The true overhead camera of a scenario: any pinhole camera, or any homography.

It is part of the truth: a law is given the image pose of the robot and β, both of which the robot's
tag shows, and never the camera.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import msgspec

from parkproof.errors import InputError
from parkproof.model.camera import PinholeCamera
from parkproof.model.goal_frame import GainBounds, gain_bounds, goal_homography
from parkproof.model.homography import Homography
from parkproof.model.image_unicycle import image_of
from parkproof.model.unicycle import Pose
from parkproof.scalar import scalar
from parkproof.validate import finite, positive

Corner = tuple[float, float]

Outline = tuple[float, float, float, float, float, float, float, float]
"""x and y of four corners, in order around a picture."""


@scalar
def is_inside(outline: Outline, x: float, y: float) -> bool:
    """Whether a point is in a picture, its border included: on the same side of all four edges.

    Parameters
    ----------
    outline : eight floats
        x and y of the corners, in order around the picture, either way.
    x, y : float
        The point.

    Returns
    -------
    bool
        True inside.

    Examples
    --------
    >>> square = (0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0)
    >>> is_inside(square, 0.5, 1.0), is_inside(square, 0.5, 1.1)
    (True, False)
    """
    ax, ay, bx, by, cx, cy, dx, dy = outline
    one = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
    two = (cx - bx) * (y - by) - (cy - by) * (x - bx)
    three = (dx - cx) * (y - cy) - (dy - cy) * (x - cx)
    four = (ax - dx) * (y - dy) - (ay - dy) * (x - dx)
    return min(one, two, three, four) >= 0.0 or max(one, two, three, four) <= 0.0


@dataclass(frozen=True, kw_only=True)
class OverheadView:
    """What an overhead camera sees of the robot, in the image frame of the goal shown to it.

    Parameters
    ----------
    to_pixels : Homography
        From the floor (the plane of the robot's tag) to pixels.
    image_size : two ints
        Width and height of the picture in px.
    goal : three floats
        Where the robot was when the goal was shown, on the floor.
    unit : float
        Unit of the goal's image frame in px.

    Raises
    ------
    InputError
        If a number is out of its range, the goal is not in the picture, or the horizon is.

    Examples
    --------
    >>> to_pixels = Homography((100.0, 0.0, 320.0, 0.0, 100.0, 240.0, 0.0, 0.0, 1.0))
    >>> view = OverheadView(to_pixels=to_pixels, image_size=(640, 480), goal=(0.0, 0.0, 0.0),
    ...                     unit=50.0)
    >>> view.image_pose((0.5, 0.0, 0.0)), view.sees(9.0, 0.0)
    ((1.0, 0.0, 0.0), False)
    """

    to_pixels: Homography
    image_size: tuple[int, int]
    goal: tuple[float, float, float]
    unit: float

    def __post_init__(self) -> None:
        for value in self.goal:
            finite("goal", value)
        positive("unit", self.unit, example=40.0)
        if min(self.image_size) < 1:
            raise InputError(
                f"image_size = {list(self.image_size)}: must be at least 1 px each way; "
                "write for example image_size = [640, 480]"
            )
        u, v = self.to_pixels.project(*self.goal[:2])
        width, height = self.image_size
        if not (-0.5 <= u <= width - 0.5 and -0.5 <= v <= height - 0.5):
            raise InputError(
                f"goal = {list(self.goal)}: its image ({u:.0f}, {v:.0f}) px is outside the picture "
                f"of {width} × {height} px; move the goal or the camera"
            )
        floor = self.to_pixels.inverse()
        for corner in self._pixel_corners:
            if not floor.depth(*corner) > 0.0:
                raise InputError(
                    f"the picture's corner ({corner[0]:g}, {corner[1]:g}) px looks at or above the "
                    "horizon; tilt the camera less or take a longer focal length"
                )

    @property
    def _pixel_corners(self) -> tuple[Corner, ...]:
        u, v = self.image_size[0] - 0.5, self.image_size[1] - 0.5
        return (-0.5, -0.5), (u, -0.5), (u, v), (-0.5, v)

    @cached_property
    def to_goal(self) -> Homography:
        """Homography from the floor to the goal's image frame, in which β > 0."""
        return goal_homography(self.to_pixels, Pose(*self.goal), self.unit)

    @cached_property
    def from_goal(self) -> Homography:
        """Homography from the goal's image frame to the floor."""
        return self.to_goal.inverse()

    @cached_property
    def corners(self) -> tuple[Corner, ...]:
        """Corners of the picture in the goal's image frame."""
        floor = self.to_pixels.inverse()
        return tuple(self.to_goal.project(*floor.project(*c)) for c in self._pixel_corners)

    def image_pose(self, floor_pose: tuple[float, float, float]) -> tuple[float, float, float]:
        """Image pose, in the goal's frame, of a pose on the floor.

        Parameters
        ----------
        floor_pose : three floats
            x, y and θ on the floor.

        Returns
        -------
        three floats
            x_m, y_m and the image heading.
        """
        x, y, psi = image_of(self.to_goal, Pose(*floor_pose)).pose
        return x, y, psi

    @cached_property
    def outline(self) -> Outline:
        """The same corners as eight numbers."""
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = self.corners
        return ax, ay, bx, by, cx, cy, dx, dy

    @cached_property
    def bounds(self) -> GainBounds:
        """Bounds of a and β over the picture and all headings (sampled along its border)."""
        return gain_bounds(self.to_goal, self.corners)

    def sees(self, x: float, y: float) -> bool:
        """Whether a point of the goal's image frame is in the picture.

        Parameters
        ----------
        x, y : float
            The point.

        Returns
        -------
        bool
            True inside the picture.
        """
        return is_inside(self.outline, x, y)


class PinholeTable(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    dict=True,
    tag_field="kind",
    tag="pinhole",
):
    """A pinhole camera somewhere above the floor (`parkproof.model.camera.PinholeCamera`).

    Parameters
    ----------
    position : two floats
        Floor coordinates of the camera.
    height : float
        Its height over the plane of the robot's tag, positive.
    focal_length : float
        Focal length in px.
    tilt_deg, roll_deg, pan_deg : float
        Angles in degrees; with all 0 it looks straight down.
    aspect : float
        Vertical over horizontal focal length.
    image_size : two ints
        Width and height of the picture in px.
    goal : three floats
        Where the robot was when the goal was shown: x, y, θ (rad) on the floor.
    unit : float
        Unit of the image frame in px, for example the side of the robot's tag at the goal.

    Raises
    ------
    InputError
        If the camera sees the horizon, or the goal is not in the picture.

    Examples
    --------
    >>> camera = PinholeTable(height=3.0, focal_length=500.0, tilt_deg=25.0, unit=40.0)
    >>> camera.view.sees(0.0, 0.0), camera.view.sees(50.0, 0.0)
    (True, False)
    """

    position: tuple[float, float] = (0.0, 0.0)
    height: float
    focal_length: float
    tilt_deg: float = 0.0
    roll_deg: float = 0.0
    pan_deg: float = 0.0
    aspect: float = 1.0
    image_size: tuple[int, int] = (640, 480)
    goal: tuple[float, float, float] = (0.0, 0.0, 0.0)
    unit: float

    def __post_init__(self) -> None:
        _ = self.view

    @cached_property
    def view(self) -> OverheadView:
        """What the camera sees."""
        camera = PinholeCamera(
            position=self.position,
            height=self.height,
            focal_length=self.focal_length,
            image_size=self.image_size,
            tilt=math.radians(finite("tilt_deg", self.tilt_deg)),
            roll=math.radians(finite("roll_deg", self.roll_deg)),
            pan=math.radians(finite("pan_deg", self.pan_deg)),
            aspect=self.aspect,
        )
        return OverheadView(
            to_pixels=camera.homography(),
            image_size=self.image_size,
            goal=self.goal,
            unit=self.unit,
        )


class HomographyTable(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    dict=True,
    tag_field="kind",
    tag="homography",
):
    """A camera given by its homography from the floor to pixels.

    Parameters
    ----------
    matrix : nine floats
        The homography row by row, with positive depth in front of the camera.
    image_size : two ints
        Width and height of the picture in px.
    goal : three floats
        Where the robot was when the goal was shown: x, y, θ (rad) on the floor.
    unit : float
        Unit of the image frame in px.

    Raises
    ------
    InputError
        If the matrix is singular, the picture shows the horizon, or the goal is not in it.

    Examples
    --------
    >>> camera = HomographyTable(matrix=(100, 0, 320, 0, 100, 240, 0, 0, 1), unit=50.0)
    >>> camera.view.image_pose((0.5, 0.0, 0.0))
    (1.0, 0.0, 0.0)
    """

    matrix: tuple[float, float, float, float, float, float, float, float, float]
    image_size: tuple[int, int] = (640, 480)
    goal: tuple[float, float, float] = (0.0, 0.0, 0.0)
    unit: float

    def __post_init__(self) -> None:
        _ = self.view

    @cached_property
    def view(self) -> OverheadView:
        """What the camera sees."""
        return OverheadView(
            to_pixels=Homography(self.matrix),
            image_size=self.image_size,
            goal=self.goal,
            unit=self.unit,
        )


Overhead = PinholeTable | HomographyTable
