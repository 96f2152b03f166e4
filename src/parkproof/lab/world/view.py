"""Where the camera truly sees the robot's tag: for scoring and for choosing poses in view."""

import math

from parkproof.lab.world.settings import FloorPose, WorldSettings
from parkproof.lab.world.textures import PLATE_CELLS, TAG_CELLS
from parkproof.model.homography import Homography, homography_jacobian

Point = tuple[float, float]

_CORNERS = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
"""On the tag's axes as seen from above, x forward and y to the left, in sides."""


class TagView:
    """The tag's true place in the picture, from the robot's pose on the floor.

    Parameters
    ----------
    settings : WorldSettings
        Camera, lens and tag.
    to_pixels : Homography or None
        From the tag's plane to pixels, without distortion; None: from the settings.

    Examples
    --------
    >>> view = TagView(WorldSettings())
    >>> view.holds((0.0, 0.0, 0.0)), view.holds((2.0, 0.0, 0.0))
    (True, False)
    >>> round(view.size((0.0, 0.0, 0.0)), 2)
    31.41
    """

    def __init__(self, settings: WorldSettings, *, to_pixels: Homography | None = None) -> None:
        self._robot = settings.robot
        self._image_size = settings.camera.image_size
        self._lens = settings.camera.lens()
        nominal = settings.camera.pinhole().homography(settings.robot.tag_height)
        self.to_pixels = nominal if to_pixels is None else to_pixels

    @property
    def tag_side(self) -> float:
        """Side of the tag's black square in m."""
        return self._robot.tag_side

    def appears(self, x: float, y: float) -> Point | None:
        """Where a point of the tag's plane appears, with distortion.

        Parameters
        ----------
        x, y : float
            The point on the floor's axes in m.

        Returns
        -------
        tuple of float or None
            Its place in px, in the picture or beyond it; None if it is behind the camera or
            so far out that the lens has no image of it.
        """
        if not self.to_pixels.depth(x, y) > 0.0:
            return None
        return self._lens.distort(*self.to_pixels.project(x, y))

    def to_floor(self, u: float, v: float) -> Point:
        """Point of the tag's plane that appears at a pixel of the picture.

        Parameters
        ----------
        u, v : float
            The pixel.

        Returns
        -------
        tuple of float
            x and y in m.
        """
        return self.to_pixels.inverse().project(*self._lens.undistort(u, v))

    def tag_centre(self, pose: FloorPose) -> Point:
        """Middle of the tag on the floor's axes.

        Parameters
        ----------
        pose : three floats
            The robot's.

        Returns
        -------
        tuple of float
            x and y in m.
        """
        x, y, theta = pose
        c, s = math.cos(theta), math.sin(theta)
        ahead, left = self._robot.tag_offset
        return x + c * ahead - s * left, y + s * ahead + c * left

    def corners(self, pose: FloorPose, *, scale: float = 1.0) -> list[Point | None]:
        """Corners of the tag's black square in the picture, with distortion.

        In the order of AprilTag's libraries if the tag's angle is counted from its x axis: the
        corner left below as it is printed comes first, then right below, right above, left above.

        Parameters
        ----------
        pose : three floats
            The robot's.
        scale : float
            Of the square; 1.25 for the corners of the white plate.

        Returns
        -------
        list of four points or None
            In px; None as in `appears`.
        """
        x, y = self.tag_centre(pose)
        side = scale * self._robot.tag_side
        angle = pose[2] + self._robot.tag_angle
        c, s = side * math.cos(angle), side * math.sin(angle)
        return [self.appears(x + c * p - s * q, y + s * p + c * q) for p, q in _CORNERS]

    def holds(self, pose: FloorPose, *, margin: float = 0.0, plate: bool = False) -> bool:
        """Whether the tag is in the picture with all its corners.

        Parameters
        ----------
        pose : three floats
            The robot's.
        margin : float
            Least distance to the picture's border in px.
        plate : bool
            Whether its white margin must be in the picture, too.

        Returns
        -------
        bool
            True if it is.
        """
        width, height = self._image_size
        low = -0.5 + margin
        corners = self.corners(pose, scale=PLATE_CELLS / TAG_CELLS if plate else 1.0)
        return all(
            corner is not None
            and low <= corner[0] <= width - 1.0 - low
            and low <= corner[1] <= height - 1.0 - low
            for corner in corners
        )

    def size(self, pose: FloorPose) -> float:
        """Side in px of a square as large as the tag appears, without distortion.

        Parameters
        ----------
        pose : three floats
            The robot's, with the tag in front of the camera.

        Returns
        -------
        float
            Side in px.
        """
        j00, j01, j10, j11 = homography_jacobian(*self.to_pixels.entries, *self.tag_centre(pose))
        return self._robot.tag_side * math.sqrt(abs(j00 * j11 - j01 * j10))

    def width_across(self) -> float:
        """Floor seen across the picture's middle row in m, from border to border."""
        width, height = self._image_size
        v = 0.5 * (height - 1)
        return math.dist(self.to_floor(-0.5, v), self.to_floor(width - 0.5, v))
