"""The part of the goal's image plane that the camera sees."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

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
