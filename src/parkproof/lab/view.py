"""The part of the goal's image plane that the camera sees."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from parkproof.lab.image_pose import TagMount
from parkproof.lab.tag_square import SQUARE

Point = tuple[float, float]


@dataclass(frozen=True)
class ImageView:
    """The picture's border in goal units: a convex polygon.

    Attributes
    ----------
    corners : tuple of points
        In order, either way round.

    Examples
    --------
    >>> view = ImageView(((-4.0, -3.0), (4.0, -3.0), (4.0, 3.0), (-4.0, 3.0)))
    >>> view.clearance(3.0, 0.0), view.clearance(5.0, 0.0)
    (1.0, -1.0)
    """

    corners: tuple[Point, ...]

    @cached_property
    def _sides(self) -> list[tuple[float, float, float]]:
        """Each side as (n_x, n_y, d): the distance inwards is n·p − d."""
        points: Sequence[Point] = self.corners
        pairs = list(zip(points, (*points[1:], points[0]), strict=True))
        area = sum(ax * by - bx * ay for (ax, ay), (bx, by) in pairs)
        turn = math.copysign(1.0, area)
        sides = []
        for (ax, ay), (bx, by) in pairs:
            length = math.hypot(bx - ax, by - ay)
            nx, ny = turn * (ay - by) / length, turn * (bx - ax) / length
            sides.append((nx, ny, nx * ax + ny * ay))
        return sides

    def clearance(self, x: float, y: float) -> float:
        """How far inside the border a point lies, in goal units; negative outside."""
        return min(nx * x + ny * y - d for nx, ny, d in self._sides)

    def room(self, footprint: Sequence[Point], x: float, y: float, theta: float) -> float:
        """How far inside the border a figure lies, in goal units; negative if a part is outside.

        Parameters
        ----------
        footprint : sequence of points
            Corners of the figure in the robot's frame: forward, and to the left.
        x, y, theta : float
            Where the robot is.

        Returns
        -------
        float
            Least clearance of its corners.
        """
        c, s = math.cos(theta), math.sin(theta)
        placed = [(x + c * i - s * j, y + s * i + c * j) for i, j in footprint]
        return min(nx * i + ny * j - d for nx, ny, d in self._sides for i, j in placed)


def tag_footprint(mount: TagMount, scale: float) -> tuple[Point, ...]:
    """Corners of the robot's tag in the robot's frame.

    Parameters
    ----------
    mount : TagMount
        How the tag sits on it.
    scale : float
        Length of a side of the tag, in goal units.

    Returns
    -------
    tuple of four points
        Forward and to the left of the axle's middle, in goal units.

    Examples
    --------
    >>> tag_footprint(TagMount(offset=(-0.5, 0.0)), 2.0)[0]
    (0.0, -1.0)
    """
    c, s = math.cos(mount.angle), math.sin(mount.angle)
    sides = [(i - mount.offset[0], j - mount.offset[1]) for i, j in SQUARE]
    return tuple((scale * (c * i + s * j), scale * (c * j - s * i)) for i, j in sides)
