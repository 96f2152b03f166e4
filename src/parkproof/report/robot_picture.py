"""A small differential-drive robot seen from above: body, two wheels, castor, heading."""

from typing import TYPE_CHECKING, Any, NamedTuple

from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.transforms import Affine2D

from parkproof.report.style import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Shape(NamedTuple):
    """A differential-drive robot of length 1: the axle at the origin, the castor in front."""

    body: Outline
    wheels: Outline
    castor: Outline
    nose: Outline


def _box(x: float, y: float, width: float, height: float) -> Outline:
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]
    return Outline(corners, closed=True)


def _shape() -> Shape:
    codes = [Outline.MOVETO, Outline.LINETO, *[Outline.CURVE3] * 2, Outline.LINETO]
    codes += [*[Outline.CURVE3] * 2, Outline.LINETO, Outline.CLOSEPOLY]
    front = [(-0.3, -0.3), (0.4, -0.3), (0.7, -0.3), (0.7, 0.0), (0.7, 0.0), (0.7, 0.3)]
    body = Outline([*front, (0.4, 0.3), (-0.3, 0.3), (-0.3, -0.3)], codes)
    wheels = Outline.make_compound_path(
        _box(-0.17, -0.41, 0.34, 0.13), _box(-0.17, 0.28, 0.34, 0.13)
    )
    castor = Outline.unit_circle().transformed(Affine2D().scale(0.06).translate(0.5, 0.0))
    nose = Outline([(0.02, -0.14), (0.3, 0.0), (0.02, 0.14), (0.02, -0.14)], closed=True)
    return Shape(body, wheels, castor, nose)


SHAPE = _shape()


def draw_robot(
    axes: "Axes",
    pose: tuple[float, float, float],
    *,
    length: float,
    colour: str,
    ghost: bool = False,
    zorder: float = 4.0,
) -> list[PathPatch]:
    """Draw the robot as seen from above.

    Parameters
    ----------
    axes : Axes
        Where.
    pose : tuple of 3 floats
        x_m, y_m of the middle of the axle, and the heading θ in rad.
    length : float
        Length of the robot in the units of the axes.
    colour : str
        Colour of its outline and, lighter, of its body.
    ghost : bool
        Draw the place for a robot rather than a robot.
    zorder : float
        What it covers.

    Returns
    -------
    list of PathPatch
        Its parts; `place_robot` moves them.

    Examples
    --------
    >>> parts = draw_robot(axes, (0, 0, 0), length=0.2, colour="#0072b2")
    >>> len(parts) > 3
    True
    """
    if ghost:
        looks: list[tuple[Outline, dict[str, Any]]] = [
            (SHAPE.body, {"fc": "none", "ec": colour, "lw": 1.3, "ls": (0, (3, 2))}),
            (SHAPE.wheels, {"fc": "none", "ec": colour, "lw": 0.9}),
            (SHAPE.nose, {"fc": "none", "ec": colour, "lw": 0.9}),
        ]
    else:
        looks = [
            (SHAPE.wheels, {"fc": INK, "ec": "none"}),
            (SHAPE.body, {"fc": _tint(colour), "ec": colour, "lw": 1.3}),
            (SHAPE.castor, {"fc": "white", "ec": INK, "lw": 0.6}),
            (SHAPE.nose, {"fc": colour, "ec": "none"}),
        ]
    parts = []
    for i, (outline, look) in enumerate(looks):
        part = PathPatch(outline, zorder=zorder + 0.01 * i, joinstyle="round", **look)
        axes.add_patch(part)
        parts.append(part)
    place_robot(axes, parts, pose, length=length)
    return parts


def place_robot(
    axes: "Axes", parts: list[PathPatch], pose: tuple[float, float, float], *, length: float
) -> None:
    """Move a drawn robot.

    Parameters
    ----------
    axes : Axes
        Where it was drawn.
    parts : list of PathPatch
        What `draw_robot` returned.
    pose : tuple of 3 floats
        x_m, y_m, θ.
    length : float
        Its length in the units of the axes.

    Examples
    --------
    >>> parts = draw_robot(axes, (0, 0, 0), length=0.2, colour="#0072b2")
    >>> place_robot(axes, parts, (1.0, 0.0, 0.0), length=0.2)
    """
    x, y, theta = pose
    place = Affine2D().scale(length).rotate(theta).translate(x, y) + axes.transData
    for part in parts:
        part.set_transform(place)


def _tint(colour: str) -> tuple[float, float, float]:
    """The colour mixed with white."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return 0.3 * red + 0.7, 0.3 * green + 0.7, 0.3 * blue + 0.7
