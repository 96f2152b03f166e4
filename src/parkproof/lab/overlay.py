"""What is drawn on a picture of a run: the tag found, the goal, the paths, and the numbers below.

Colours are those of the figures, one for each step.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.lab.devices import Image
from parkproof.lab.entries import STEP_NAMES
from parkproof.lab.lettering import Colour, text_width, write_text

Points = NDArray[np.float64]
"""Points in the picture, n × 2: u and v in px."""

STEP_RGB: dict[int, Colour] = {
    0: (170, 95, 155),
    1: (230, 159, 0),
    2: (0, 114, 178),
    3: (0, 158, 115),
    4: (139, 146, 155),
}
"""Colour of each step."""

INK: Colour = (27, 31, 36)
PAPER: Colour = (244, 245, 247)
QUIET: Colour = (163, 171, 182)
TRACK: Colour = (58, 64, 72)
ALARM: Colour = (213, 94, 0)

LEAST_WIDTH = 480
"""Narrower pictures are enlarged, so that the words below have room."""

PANEL = 84
"""Height of the panel below a picture 640 px wide."""

FAR = 6000.0
"""No point is drawn further out than this many px: beyond, fixed-point numbers end."""

SPACING = 3.0
"""Points of a path closer together than this many px are drawn as one."""


@dataclass(frozen=True)
class Bar:
    """A number beside its bound.

    Attributes
    ----------
    label : str
        What the bound says, as in "parked by 31.4 s".
    value, limit : float
        The number and the bound, in the same unit; the bar is full where they are equal.
    """

    label: str
    value: float
    limit: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Overlay:
    """What is known of one moment of a run. Its arrays may not change afterwards.

    Attributes
    ----------
    t : float
        Time since the run began, in s.
    goal : tuple of 3 floats
        Image pose (u, v, ψ) of the goal, px and rad.
    step : int or None
        The step of the law, 0 to 4; None before it begins.
    v, omega : float or None
        Speed in m/s and turn rate in rad/s that were sent.
    pose : tuple of 3 floats or None
        Image pose of the robot; None if the tag was not seen.
    tag, goal_tag : array of shape (4, 2) or None
        Corners of the robot's tag, now and at the goal, px.
    path : array of shape (n, 2) or None
        Where the robot has been, px.
    path_steps : array of n ints or None
        The step at each point of the path: its colour.
    planned : array of shape (m, 2) or None
        Where it is going to be, as far as that was planned or predicted, px.
    error_px, error_deg : float or None
        Distance to the goal in px, and of the headings in degrees.
    bar : Bar or None
        A bound and how much of it is used.
    event : str or None
        What has happened, in a sentence.
    alarm : bool
        Whether the event is one to worry about.

    Examples
    --------
    >>> Overlay(t=1.0, goal=(320.0, 240.0, 0.0), step=2).event is None
    True
    """

    t: float
    goal: tuple[float, float, float]
    step: int | None = None
    v: float | None = None
    omega: float | None = None
    pose: tuple[float, float, float] | None = None
    tag: Points | None = None
    goal_tag: Points | None = None
    path: Points | None = None
    path_steps: NDArray[Any] | None = None
    planned: Points | None = None
    error_px: float | None = None
    error_deg: float | None = None
    bar: Bar | None = None
    event: str | None = None
    alarm: bool = False


def overlay_size(width: int, height: int) -> tuple[int, int]:
    """Size of the picture that `overlay` makes.

    Parameters
    ----------
    width, height : int
        Of the camera's picture, px.

    Returns
    -------
    tuple of 2 ints
        Width and height, px.

    Examples
    --------
    >>> overlay_size(640, 480), overlay_size(160, 120)
    ((640, 564), (480, 423))
    """
    zoom = _zoom(width)
    return zoom * width, zoom * height + _panel_height(zoom * width)


def overlay(image: Image, info: Overlay) -> Image:
    """Draw what is known of a moment on a copy of its picture, and the numbers on a panel below.

    Parameters
    ----------
    image : array of uint8
        The camera's picture, grey or RGB, not empty; it is not changed.
    info : Overlay
        What is known.

    Returns
    -------
    array of uint8
        RGB, of the size that `overlay_size` says.

    Examples
    --------
    >>> info = Overlay(t=1.0, goal=(320.0, 240.0, 0.0), step=2, v=0.2, omega=0.0)
    >>> overlay(np.full((480, 640), 128, np.uint8), info).shape
    (564, 640, 3)
    """
    import cv2

    height, width = image.shape[:2]
    zoom = _zoom(width)
    full_width, full_height = overlay_size(width, height)
    canvas: Image = np.empty((full_height, full_width, 3), np.uint8)
    picture = canvas[: zoom * height]
    colour = cv2.cvtColor(image, cv2.COLOR_GRAY2RGB) if image.ndim == 2 else image
    if zoom > 1:
        colour = cv2.resize(colour, (full_width, zoom * height), interpolation=cv2.INTER_NEAREST)
    picture[:] = colour
    pen = _Pen(picture, zoom, max(1.0, full_width / 640.0))
    _draw_paths(pen, info)
    _draw_goal(pen, info)
    _draw_robot(pen, info)
    _draw_panel(canvas[zoom * height :], info)
    return canvas


def _zoom(width: int) -> int:
    return max(1, math.ceil(LEAST_WIDTH / width))


def _panel_height(width: int) -> int:
    return round(PANEL * width / 640.0)


class _Pen:
    """Draws smooth lines in the camera's pixel coordinates."""

    BITS = 4

    def __init__(self, picture: Image, zoom: int, scale: float) -> None:
        self._picture = picture
        self._zoom = zoom
        self.scale = scale

    def line(
        self, points: Any, colour: Colour, *, width: float, closed: bool = False, halo: bool = True
    ) -> None:
        """A line through points, on a dark halo that sets it off."""
        import cv2

        place = self._fixed(points)
        if len(place) < 2:
            return
        strokes = [(INK, width + 2.0)] if halo else []
        for shade, thickness in (*strokes, (colour, width)):
            cv2.polylines(
                self._picture, [place], closed, shade, max(1, round(thickness * self.scale)),
                cv2.LINE_AA, self.BITS,
            )  # fmt: skip

    def dashes(self, points: Any, *, width: float, dash: float) -> None:
        """A line through points whose dashes are light and dark in turn: seen on any ground."""
        import cv2

        place = _finite(points)
        if len(place) < 2:
            return
        self.line(place, INK, width=width, halo=False)
        steps = np.hypot(*np.diff(place, axis=0).T)
        along = np.concatenate(([0.0], np.cumsum(steps)))
        dash *= self.scale / self._zoom
        starts = np.arange(0, min(int(along[-1] / dash) + 1, 400), 2) * dash
        at = np.clip(np.column_stack([starts, starts + dash]), 0.0, along[-1])
        ends = np.stack([np.interp(at, along, place[:, i]) for i in (0, 1)], axis=-1)
        pieces = list(self._fixed(ends).reshape(-1, 2, 2))
        thickness = max(1, round(width * self.scale))
        cv2.polylines(self._picture, pieces, False, PAPER, thickness, cv2.LINE_AA, self.BITS)

    def fill(self, points: Any, colour: Colour) -> None:
        """A filled shape with a dark edge."""
        import cv2

        place = self._fixed(points)
        if len(place) > 2:
            cv2.fillPoly(self._picture, [place], colour, cv2.LINE_AA, self.BITS)
            self.line(points, colour, width=1.0, closed=True, halo=False)

    def _fixed(self, points: Any) -> NDArray[np.int32]:
        """Points of the enlarged picture as fixed-point numbers."""
        place = (_finite(points) + 0.5) * self._zoom - 0.5
        near = np.clip(place, -FAR, FAR)
        return np.round(near * (1 << self.BITS)).astype(np.int32)


def _finite(points: Any) -> Points:
    place = np.asarray(points, np.float64).reshape(-1, 2)
    return place[np.isfinite(place).all(axis=1)]


def _colour(step: int | None) -> Colour:
    return STEP_RGB.get(-1 if step is None else step, QUIET)


def _draw_paths(pen: _Pen, info: Overlay) -> None:
    """Where the robot was, in the colours of the steps, and where it will be, dashed."""
    if info.planned is not None:
        pen.dashes(info.planned, width=2.0, dash=6.0)
    if info.path is None or len(info.path) < 2:
        return
    path = np.asarray(info.path, np.float64)
    n = len(path)
    steps = np.full(n, -1) if info.path_steps is None else np.asarray(info.path_steps)
    moved = np.nan_to_num(np.hypot(*np.diff(path, axis=0).T), nan=FAR, posinf=FAR)
    place = np.concatenate(([0.0], np.cumsum(moved))) // SPACING
    changes = [0, *(np.flatnonzero(np.diff(steps)) + 1).tolist(), n]
    for first, last in pairwise(changes):
        start = max(first - 1, 0)
        apart = np.flatnonzero(np.diff(place[start:last])) + 1
        rows = start + np.unique(np.concatenate(([0], apart, [last - 1 - start])))
        pen.line(path[rows], _colour(int(steps[first])), width=2.0)


def _draw_goal(pen: _Pen, info: Overlay) -> None:
    """The place to park in: a dashed outline and a hollow arrow."""
    u, v, psi = info.goal
    side = _side(info.goal_tag if info.goal_tag is not None else info.tag)
    if info.goal_tag is not None:
        ring = np.asarray(info.goal_tag, np.float64)
        pen.dashes(np.vstack([ring, ring[:1]]), width=2.0, dash=5.0)
    pen.line(_arrow(u, v, psi, side), PAPER, width=1.0, closed=True)


def _draw_robot(pen: _Pen, info: Overlay) -> None:
    """The tag found, and an arrow along the robot's heading."""
    colour = _colour(info.step)
    if info.tag is not None:
        pen.line(info.tag, colour, width=2.0, closed=True)
    if info.pose is not None and all(map(math.isfinite, info.pose)):
        u, v, psi = info.pose
        arrow = _arrow(u, v, psi, _side(info.tag))
        pen.line(arrow, INK, width=3.0, closed=True, halo=False)
        pen.fill(arrow, colour)


def _side(tag: Points | None) -> float:
    """A length that goes with the robot: the tag's side in px."""
    if tag is None or not np.isfinite(tag).all():
        return 30.0
    ring = np.asarray(tag, np.float64)
    return float(np.mean(np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)))


def _arrow(u: float, v: float, psi: float, side: float) -> Points:
    """Outline of an arrow that begins at (u, v) and reaches well beyond the tag."""
    long, half, neck, head = 1.55 * side, 0.045 * side, 1.15 * side, 0.17 * side
    shape = np.array(
        [(0, -half), (neck, -half), (neck, -head), (long, 0), (neck, head), (neck, half), (0, half)]
    )
    c, s = math.cos(psi), math.sin(psi)
    outline: Points = shape @ np.array([[c, s], [-s, c]]) + (u, v)
    return outline


def _draw_panel(panel: Image, info: Overlay) -> None:
    """The numbers, the last event, and the bound."""
    import cv2

    height, width = panel.shape[:2]
    unit = width / 640.0

    def px(value: float) -> int:
        return int(value * unit + 0.5)

    panel[:] = INK
    colour = _colour(info.step)
    name = "waiting" if info.step is None else f"{info.step} {STEP_NAMES.get(info.step, '')}"
    cv2.rectangle(panel, (0, 0), (width, max(1, px(3)) - 1), colour, -1)
    write_text(panel, name.strip(), (px(16), px(29)), size=px(17), bold=True, colour=_light(colour))
    columns = (
        (148, "time", f"{info.t:.1f} s"),
        (222, "v", _number(info.v, "m/s", 2)),
        (324, "ω", _number(info.omega, "rad/s", 2)),
        (438, "to the goal", _number(info.error_px, "px", 1)),
        (538, "heading off", _number(info.error_deg, "°", 1)),
    )
    for x, label, value in columns:
        write_text(panel, label, (px(x), px(18)), size=px(11), colour=QUIET)
        write_text(panel, value, (px(x), px(36)), size=px(15), colour=PAPER)
    if info.event is not None:
        size = px(12)
        if info.alarm:
            end = px(16) + text_width(info.event, size) + 2 * px(7)
            cv2.rectangle(panel, (px(16), px(51)), (min(end, width), px(70)), ALARM, -1)
        start = px(16) + (px(7) if info.alarm else 0)
        write_text(panel, info.event, (start, px(61)), size=size, colour=PAPER)
    if info.bar is not None:
        fraction = info.bar.value / info.bar.limit if info.bar.limit > 0.0 else 1.0
        used = round(min(max(fraction, 0.0), 1.0) * (width - 2 * px(16)))
        top, bottom = height - px(9), height - px(5)
        cv2.rectangle(panel, (px(16), top), (width - px(16), bottom), TRACK, -1)
        late = fraction > 1.0
        cv2.rectangle(panel, (px(16), top), (px(16) + used, bottom), ALARM if late else colour, -1)
        write_text(
            panel, info.bar.label, (width - px(16), px(61)), size=px(11),
            colour=ALARM if late else QUIET, align="right",
        )  # fmt: skip


def _number(value: float | None, unit: str, digits: int) -> str:
    if value is None or not math.isfinite(value):
        return "–"
    text = f"{value:.{digits}f}".replace("-", "−")
    return f"{text}{unit}" if unit == "°" else f"{text} {unit}"


def _light(colour: Colour) -> Colour:
    """The colour, light enough for letters on dark ground."""
    red, green, blue = (round(0.7 * part + 0.3 * 255) for part in colour)
    return red, green, blue
