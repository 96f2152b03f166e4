"""The path in the image plane, with the robot drawn along it."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from parkproof.report.robot_picture import draw_robot
from parkproof.report.style import (
    FAINT,
    INK,
    MUTED,
    STEP_COLOURS,
    VERMILION,
    Array,
    DrawnRun,
    drawing,
    new_figure,
    save,
    step_legend,
    stretches_of_steps,
    title_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BEYOND = 3.0
"""A path that grows to this many times its size at the end of Step 2 is not shown whole."""

DPI = 100.0
"""Dots per inch of a figure while it is laid out; the saved file may have more."""

ROBOT_INCHES = 0.42
"""Length of the robot on paper: the image plane has no scale of its own to take it from."""

Window = tuple[float, float, float, float]
Rows = NDArray[np.intp]
Flags = NDArray[np.bool_]


def window_of(run: DrawnRun) -> tuple[Window, bool]:
    """Part of the image plane to show, and whether the path stays in it.

    Parameters
    ----------
    run : DrawnRun
        The run.

    Returns
    -------
    tuple
        (x_min, x_max, y_min, y_max), and True if all of the path lies inside.

    Examples
    --------
    >>> window, whole = window_of(run)
    >>> window[0] < -1.0, whole
    (True, True)
    """
    x, y = run.trajectory["xm"], run.trajectory["ym"]
    late = np.flatnonzero(run.trajectory["step"] >= 3)
    until = int(late[0]) + 1 if len(late) else len(x)
    whole, early = _bounding_box(x, y), _bounding_box(x[:until], y[:until])
    size, early_size = (math.hypot(b[1] - b[0], b[3] - b[2]) or 1.0 for b in (whole, early))
    stays = size <= BEYOND * early_size
    shown = whole if stays else early
    if outline := run.scenario.view_outline:
        seen = _bounding_box(*np.transpose(outline))
        if math.hypot(seen[1] - seen[0], seen[3] - seen[2]) < 4.0 * early_size:
            x_low, x_high, y_low, y_high = zip(shown, seen, strict=True)
            shown = min(x_low), max(x_high), min(y_low), max(y_high)
    margin = 0.09 * (math.hypot(shown[1] - shown[0], shown[3] - shown[2]) or 1.0)
    low, high = shown[2] - margin, shown[3] + margin
    if not stays:
        reach = 0.2 * (shown[1] - shown[0])
        low, high = min(low, -reach), max(high, reach)
    return (shown[0] - margin, shown[1] + margin, low, high), stays


def _bounding_box(x: Array, y: Array) -> Window:
    return (
        min(float(x.min()), 0.0), max(float(x.max()), 0.0),
        min(float(y.min()), 0.0), max(float(y.max()), 0.0),
    )  # fmt: skip


def _filled(window: Window, width: float, height: float) -> Window:
    """The window, widened to the shape of a panel so that both axes have one scale."""
    x_low, x_high, y_low, y_high = window
    scale = max((x_high - x_low) / width, (y_high - y_low) / height)
    half_x, half_y = 0.5 * scale * width, 0.5 * scale * height
    x, y = 0.5 * (x_low + x_high), 0.5 * (y_low + y_high)
    return x - half_x, x + half_x, y - half_y, y + half_y


def frame_path(axes: "Axes", run: DrawnRun) -> float:
    """Set up a panel of the image plane: limits, labels, goal, view.

    Parameters
    ----------
    axes : Axes
        The panel, in its place.
    run : DrawnRun
        The run.

    Returns
    -------
    float
        A length for the robot that goes with it.

    Examples
    --------
    >>> bool(frame_path(axes, run) > 0.0)
    True
    """
    width, height = axes.bbox.width / DPI, axes.bbox.height / DPI
    x_low, x_high, y_low, y_high = _filled(window_of(run)[0], width, height)
    axes.set_xlim(x_low, x_high)
    axes.set_ylim(y_low, y_high)
    axes.set_xlabel("x_m (image units)")
    axes.set_ylabel("y_m (image units, upwards)")
    axes.axhline(0.0, color=FAINT, lw=1.0, zorder=0.9)
    axes.axvline(0.0, color=FAINT, lw=1.0, zorder=0.9)
    if outline := run.scenario.view_outline:
        axes.add_patch(Polygon(outline, fc="none", ec=VERMILION, lw=1.1, ls="--"))
        topmost = max(outline, key=lambda corner: (corner[1], corner[0]))
        left = 2.0 * topmost[0] < min(x for x, _ in outline) + max(x for x, _ in outline)
        axes.annotate(
            "camera's view", topmost, xytext=(0, 3), textcoords="offset points",
            ha="left" if left else "right", va="bottom", fontsize=8, color=VERMILION,
        )  # fmt: skip
    length = ROBOT_INCHES / height * (y_high - y_low)
    draw_robot(axes, (0.0, 0.0, 0.0), length=length, colour=INK, ghost=True, zorder=6.0)
    return length


def draw_path(axes: "Axes", run: DrawnRun) -> None:
    """Draw the path of a run, coloured by step, with the robot along it.

    Parameters
    ----------
    axes : Axes
        The panel, in its place.
    run : DrawnRun
        The run.

    Examples
    --------
    >>> draw_path(axes, run)
    >>> axes.get_xlabel()
    'x_m (image units)'
    """
    length = frame_path(axes, run)
    x, y, theta, step = (run.trajectory[name] for name in ("xm", "ym", "theta", "step"))
    rows = _spread(axes, x, y, 0.02 * length)
    for number, first, last in stretches_of_steps(step):
        part = np.concatenate(([first], rows[(rows > first) & (rows < last)], [last]))
        axes.plot(
            x[part], y[part], color=STEP_COLOURS[number], lw={1: 5.0, 2: 3.6}.get(number, 2.0),
            zorder=2.0 + 0.1 * number, alpha=0.9,
        )  # fmt: skip
    inside = _inside(axes, x[rows], y[rows], margin=0.9 * length)
    placed = _places(x[rows], y[rows], step[rows], inside, length)
    for row in rows[placed]:
        pose = float(x[row]), float(y[row]), float(theta[row])
        draw_robot(axes, pose, length=length, colour=STEP_COLOURS[int(step[row])])
    _mark_turns(axes, run, length)
    _mark_travel(axes, x[rows], y[rows], step[rows], (inside, placed), length)
    _name_ends(axes, run, length)
    _mark_exit(axes, run, x[rows], y[rows])
    step_legend(axes, run, loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=5)


def _spread(axes: "Axes", x: Array, y: Array, spacing: float) -> Rows:
    """Rows about a spacing apart along a path, fewer far outside the panel; both ends are kept."""
    (x_low, x_high), (y_low, y_high) = axes.get_xlim(), axes.get_ylim()
    near = _inside(axes, x, y, margin=-max(x_high - x_low, y_high - y_low))
    moved = np.hypot(np.diff(x), np.diff(y))
    travelled = np.concatenate(([0.0], np.cumsum(np.where(near[1:] | near[:-1], moved, spacing))))
    spacing = max(spacing, float(travelled[-1]) / 4000.0) or 1.0
    rows = np.searchsorted(travelled, np.arange(0.0, float(travelled[-1]), spacing))
    return np.unique(np.concatenate((rows, [0, len(x) - 1])))


def _inside(axes: "Axes", x: Array, y: Array, *, margin: float = 0.0) -> Flags:
    """Which points lie inside a panel, clear of its edges by a margin."""
    (x_low, x_high), (y_low, y_high) = axes.get_xlim(), axes.get_ylim()
    across = (x >= x_low + margin) & (x <= x_high - margin)
    inside: Flags = across & (y >= y_low + margin) & (y <= y_high - margin)
    return inside


def _places(x: Array, y: Array, step: NDArray[Any], inside: Flags, length: float) -> list[int]:
    """Where to draw robots: at both ends, at changes of step, between; never over one another."""
    n = len(x)
    changes = (np.flatnonzero(np.diff(step)) + 1).tolist()
    chosen: list[int] = []

    def consider(i: int, distance: float) -> None:
        if inside[i] and np.hypot(x[i], y[i]) > 1.25 * length:
            gaps = [math.hypot(x[i] - x[j], y[i] - y[j]) for j in chosen]
            if min(gaps, default=math.inf) > distance:
                chosen.append(i)

    for i in (0, n - 1, *changes):
        consider(i, 1.25 * length)
    for i in range(n):
        consider(i, 2.2 * length)
    if 0 not in chosen:
        chosen.append(0)
    return chosen


def _mark_travel(
    axes: "Axes",
    x: Array,
    y: Array,
    step: NDArray[Any],
    places: tuple[Flags, list[int]],
    length: float,
) -> None:
    """Draw arrow heads along the path, between the robots, that show which way it goes."""
    inside, robots = places
    taken = [(x[i] + 0.2 * length, y[i]) for i in robots] + [(0.2 * length, 0.0)]
    heads: list[tuple[float, float, int]] = []
    for i in range(1, len(x) - 1):
        across, along = y[i + 1] - y[i - 1], x[i + 1] - x[i - 1]
        if not inside[i] or math.hypot(along, across) == 0.0:
            continue
        gaps = [(math.hypot(x[i] - a, y[i] - b), number == step[i]) for a, b, number in heads]
        if any(gap < (1.6 if same else 0.5) * length for gap, same in gaps) or any(
            math.hypot(x[i] - a, y[i] - b) < 0.85 * length for a, b in taken
        ):
            continue
        heads.append((x[i], y[i], step[i]))
        axes.plot(
            x[i], y[i], marker=(3, 0, math.degrees(math.atan2(across, along)) - 90.0), ms=7.5,
            mfc=STEP_COLOURS[int(step[i])], mec="white", mew=0.8, zorder=3.5,
        )  # fmt: skip


def _mark_turns(axes: "Axes", run: DrawnRun, length: float) -> None:
    """Draw an arc where the robot turned on the spot, from its first heading to its last."""
    x, y, theta = (run.trajectory[name] for name in ("xm", "ym", "theta"))
    for step, first, last in stretches_of_steps(run.trajectory["step"]):
        if step != 0:
            continue
        heading = np.unwrap(theta[first : last + 1])
        angles = np.linspace(heading[0], heading[-1], 60)
        arc_x = x[first] + 0.95 * length * np.cos(angles)
        arc_y = y[first] + 0.95 * length * np.sin(angles)
        axes.plot(arc_x, arc_y, color=STEP_COLOURS[0], lw=1.6, zorder=3.0)
        way = math.degrees(angles[-1]) + math.copysign(90.0, heading[-1] - heading[0])
        axes.plot(
            arc_x[-1], arc_y[-1], marker=(3, 0, way - 90.0), ms=7.5, color=STEP_COLOURS[0],
            mec="white", mew=0.8, zorder=3.5,
        )  # fmt: skip


def _name_ends(axes: "Axes", run: DrawnRun, length: float) -> None:
    """Name start and goal, on opposite sides where they are close together."""
    x, y = float(run.trajectory["xm"][0]), float(run.trajectory["ym"][0])
    close = math.hypot(x, y) < 2.5 * length
    above = close and y >= 0.0
    clear = 1.2 if run.trajectory["step"][0] == 0 else 0.62
    for name, place, sign, gap in (
        ("start", (x, y), 1.0 if above else -1.0, clear),
        ("goal", (0.0, 0.0), 1.0 if close and not above else -1.0, 0.62),
    ):
        axes.annotate(
            name, (place[0] + 0.2 * length, place[1] + sign * gap * length), ha="center",
            va="bottom" if sign > 0.0 else "top", fontsize=8.5, weight="bold", zorder=8.0,
        )  # fmt: skip


def _mark_exit(axes: "Axes", run: DrawnRun, x: Array, y: Array) -> None:
    """Say when the path leaves the panel, if it does, and how far it gets; in the freest corner."""
    xm, ym, t = (run.trajectory[name] for name in ("xm", "ym", "t"))
    outside = np.flatnonzero(~_inside(axes, xm, ym))
    if len(outside) == 0:
        return
    row = max(int(outside[0]) - 1, 0)
    across, along = axes.transAxes.inverted().transform(axes.transData.transform(np.c_[x, y])).T
    width, height = 2.5 * DPI / axes.bbox.width, 0.6 * DPI / axes.bbox.height

    def crowd(corner: tuple[int, int]) -> int:
        near = (abs(across - corner[0]) < width) & (abs(along - corner[1]) < height)
        return int(np.count_nonzero(near))

    excursion = run.metrics.excursion
    corner = min(((1, 0), (0, 0), (1, 1), (0, 1)), key=crowd)
    axes.text(
        0.02 + 0.96 * corner[0], 0.06 + 0.88 * corner[1], color=VERMILION, fontsize=8.5, zorder=9.0,
        s=f"▲ leaves the picture at {t[row]:.1f} s\nand gets {excursion:,.4g} units away",
        transform=axes.transAxes, ha="right" if corner[0] else "left",
        va="top" if corner[1] else "bottom",
    )  # fmt: skip
    before = max(row - 1, 0)
    way = math.degrees(math.atan2(ym[row] - ym[before], xm[row] - xm[before]))
    axes.plot(
        xm[row], ym[row], marker=(3, 0, way - 90.0), ms=11.0, color=VERMILION, mec="white",
        zorder=9.0, clip_on=False,
    )  # fmt: skip


def path_picture(run: DrawnRun, path: Path | str) -> None:
    """Draw the path of a run in the image plane, with the robot along it and the goal.

    Both axes have one scale. The window shows the whole path unless it grows far beyond what it was
    when Step 2 ended; then the picture says where it leaves and how far it gets.

    Parameters
    ----------
    run : DrawnRun
        The run.
    path : Path or str
        The file; its ending says in which format (PNG at 200 dots per inch).

    Examples
    --------
    >>> path_picture(run, directory / "path.png")
    >>> (directory / "path.png").stat().st_size > 10_000
    True
    """
    (x_low, x_high, y_low, y_high), _ = window_of(run)
    width = 9.0
    ratio = min(max((y_high - y_low) / (x_high - x_low), 0.3), 0.72)
    panel_width = width - 0.95
    height = ratio * panel_width + 1.62
    with drawing():
        figure = new_figure(width, height)
        axes = figure.add_axes(
            (0.75 / width, 0.55 / height, panel_width / width, ratio * panel_width / height)
        )
        draw_path(axes, run)
        figure.text(0.75 / width, 1.0 - 0.32 / height, title_of(run), fontsize=12, weight="bold")
        below = 1.0 - 0.54 / height
        figure.text(0.75 / width, below, run.outcome.sentence, fontsize=9, color=MUTED)
        save(figure, path, dpi=200.0)
