"""The tag's black square: its corners, its homography, and the region where it may be.

The **tag's frame** is the tag as it is printed and read, seen from above: origin at the centre of
the black square, x to the right, y up, its side the unit. Corners go counter-clockwise from bottom
left. Pixels are OpenCV's: the centre of the first one is (0, 0).
"""

import math
from typing import NamedTuple

from parkproof.errors import InputError
from parkproof.lab.picture import LEAST_SIDE
from parkproof.model.homography import Homography

SQUARE = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
"""Corners of the black square in the tag's frame."""

QUIET = 1 / 8
"""Width of the white margin that a tag needs around its black square, in sides."""

_GRID = 4
"""The detector thresholds in squares of so many px: regions that start on this grid give just what
the whole picture gives."""

Point = tuple[float, float]
Corners = tuple[Point, Point, Point, Point]


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


def region_of(near: Near | None, rows: int, columns: int) -> tuple[slice, slice] | None:
    """Rows and columns to search first, on the detector's grid.

    Parameters
    ----------
    near : Near or None
        Where the tag is expected.
    rows, columns : int
        Of the picture.

    Returns
    -------
    tuple of two slices or None
        None if there is no such expectation, or too little of its region is in the picture.

    Examples
    --------
    >>> region_of(Near(u=320.0, v=240.0, reach=53.5), 480, 640)
    (slice(184, 296, None), slice(264, 376, None))
    """
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
