"""Figures 3 to 8 of the paper for any run, and one overview."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.patches import Rectangle
from matplotlib.ticker import FuncFormatter

from parkproof.report.path_picture import draw_path
from parkproof.report.style import (
    COLUMN_COLOURS,
    FAINT,
    MUTED,
    STEP_COLOURS,
    Array,
    DrawnRun,
    band,
    drawing,
    new_figure,
    save,
    step_legend,
    stretches_of_steps,
    thinned,
    time_of_interest,
    title_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURES: dict[int, tuple[tuple[str, ...], str]] = {
    3: (("x0", "u0"), "The states x0 and u0"),
    4: (("x1", "x2", "u1"), "The states x1, x2 and u1"),
    5: (("tau1", "tau2"), "The control inputs τ1 and τ2"),
    6: (("xm",), "The state x_m"),
    7: (("ym",), "The state y_m"),
    8: (("theta",), "The state θ"),
}
"""Columns and axis label of each figure of the paper."""

LABELS = {
    "xm": "x_m", "ym": "y_m", "theta": "θ", "tau1": "τ1", "tau2": "τ2", "omega": "ω",
}  # fmt: skip
"""How a column is called in a legend, where it is not its name."""

INPUTS = ("tau1", "tau2")

INPUT_FRAME = 20.0
"""The paper's Figure 5 reaches to about this."""

MARGIN = 1.08
"""The frame is this much larger than what was seen until Step 2 ended."""

LEAVES_FRAME = 1.5
"""Where values go beyond this many frames, the axis becomes logarithmic outside the frame."""


CHART = frozenset({"x2", "u0", "u1"})
"""Columns that do not exist at ±90° and are drawn from the run-up on, after turning."""

ROUND = [float(f"{m}e{i}") for i in range(-12, 13) for m in (1, 2, 5)]
"""Round numbers for ticks."""


def paper_figures(
    run: DrawnRun, directory: Path | str, *, until: float | None = None
) -> list[Path]:
    """Draw Figures 3 to 8 of the paper as PNG and SVG.

    Figure 5 is left out for a robot that takes velocities: it has no inputs τ.

    Where a run later leaves the range that it kept to until Step 2 ended, the axis stays linear
    inside that range and is logarithmic beyond it (shaded), so that both can be read.

    Parameters
    ----------
    run : DrawnRun
        The run.
    directory : Path or str
        Where figure3.png to figure8.svg go; it exists.
    until : float, optional
        End of the time axis in s. Default: the whole run, as in the paper.

    Returns
    -------
    list of Path
        The files.

    Examples
    --------
    >>> len(paper_figures(run, directory))
    12
    """
    files = []
    for number, (columns, label) in FIGURES.items():
        if columns == INPUTS and not has_inputs(run):
            continue
        with drawing():
            figure = new_figure(6.4, 4.0)
            _figure(figure, run, columns, label, until)
        for ending in ("png", "svg"):
            files.append(Path(directory) / f"figure{number}.{ending}")
            save(figure, files[-1])
    return files


def _figure(
    figure: "Figure", run: DrawnRun, columns: tuple[str, ...], label: str, until: float | None
) -> None:
    """One figure of the paper: the inputs, which chatter, in a panel each, the rest in one."""
    figure.text(0.018, 0.5, label, rotation=90, ha="center", va="center", fontsize=10)
    left, width, bottom, top, gap = 0.115, 0.865, 0.15, 0.865, 0.06
    panels = [(column,) for column in columns] if columns[0] == "tau1" else [columns]
    height = (top - bottom - gap * (len(panels) - 1)) / len(panels)
    notes: list[str] = []
    for i, panel in enumerate(panels):
        axes = figure.add_axes((left, top - height - i * (height + gap), width, height))
        draw = draw_inputs if panel[0].startswith("tau") else draw_states
        notes += draw(axes, run, panel, until=until)
        axes.tick_params(labelbottom=i == len(panels) - 1)
        if len(columns) > 1:
            lift = 0.035 / height if i == 0 else 0.0
            _name_lines(axes, lift=lift)
    axes.set_xlabel("Time (s)", fontsize=10, labelpad=2.0)
    figure.text(left, 0.016, " ".join(dict.fromkeys(notes)), fontsize=7.0, color=MUTED)
    strip = figure.add_axes((left, top + 0.012, width, 0.022))
    draw_step_strip(strip, run, until=until)
    step_legend(
        strip, run, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5, borderaxespad=0.0,
        columnspacing=0.9, handletextpad=0.5, fontsize=8.0,
    )  # fmt: skip


def _name_lines(axes: "Axes", *, lift: float) -> None:
    """Name the lines of a panel, above it: there a legend never covers a curve."""
    axes.legend(
        loc="lower right", bbox_to_anchor=(1.0, 1.0 + lift), borderaxespad=0.0, ncols=3,
        handlelength=1.4, columnspacing=1.0, handletextpad=0.5,
    )  # fmt: skip


def draw_step_strip(axes: "Axes", run: DrawnRun, *, until: float | None = None) -> None:
    """Draw which step the law was in as a strip of colours over time.

    Parameters
    ----------
    axes : Axes
        A flat panel above another.
    run : DrawnRun
        The run.
    until : float, optional
        End of the time axis in s; default the end of the run.

    Examples
    --------
    >>> draw_step_strip(axes, run)
    >>> len(axes.patches)
    5
    """
    t = run.trajectory["t"]
    for step, first, last in stretches_of_steps(run.trajectory["step"]):
        width = t[last] - t[first]
        axes.add_patch(Rectangle((t[first], 0.0), width, 1.0, color=STEP_COLOURS[step], lw=0.0))
    axes.set_xlim(0.0, until or t[-1])
    axes.set_axis_off()


def _frame(axes: "Axes", run: DrawnRun, until: float | None) -> None:
    """Time axis, zero line, and a light line at each change of step."""
    t = run.trajectory["t"]
    end = until or float(t[-1])
    axes.set_xlim(0.0, end)
    axes.axhline(0.0, color=FAINT, lw=0.9, zorder=0.8)
    changes = [t[first] for _, first, _ in stretches_of_steps(run.trajectory["step"])[1:]]
    for time in changes[:60]:
        axes.axvline(time, color=MUTED, lw=0.7, ls=(0, (2, 3)), zorder=0.9)


def draw_states(
    axes: "Axes", run: DrawnRun, columns: tuple[str, ...], *, until: float | None = None
) -> list[str]:
    """Draw states over time.

    Parameters
    ----------
    axes : Axes
        Where.
    run : DrawnRun
        The run.
    columns : tuple of str
        Names of columns.
    until : float, optional
        End of the time axis in s; default the end of the run.

    Returns
    -------
    list of str
        Sentences on the value axis, if it is not linear.

    Examples
    --------
    >>> draw_states(axes, run, ("x0", "u0"))
    []
    """
    t = run.trajectory["t"]
    shown = t <= (until or t[-1])
    _frame(axes, run, until)
    step = run.trajectory["step"][shown]
    lines = {name: run.trajectory[name][shown] for name in columns}
    for name in CHART.intersection(columns):
        lines[name] = np.where(step == 0, np.nan, lines[name])
    for name, y in lines.items():
        axes.plot(*thinned(t[shown], y), color=COLUMN_COLOURS[name], label=LABELS.get(name, name))
    early = max(_largest(y[step <= 2]) for y in lines.values())
    return _limit(axes, lines, math.inf if columns == ("theta",) else MARGIN * early)


def draw_inputs(
    axes: "Axes", run: DrawnRun, columns: tuple[str, ...], *, until: float | None = None
) -> list[str]:
    """Draw inputs over time: their mean as a line, all that they do in between as a band.

    Parameters
    ----------
    axes : Axes
        Where.
    run : DrawnRun
        The run.
    columns : tuple of str
        "tau1", "tau2" or both.
    until : float, optional
        End of the time axis in s; default the end of the run.

    Returns
    -------
    list of str
        Sentences on the band, and on the value axis if it is not linear.

    Examples
    --------
    >>> draw_inputs(axes, run, ("tau1",))
    []
    """
    t = run.trajectory["t"]
    shown = t <= (until or t[-1])
    _frame(axes, run, until)
    lines = {name: run.trajectory[name][shown] for name in columns}
    notes = []
    for name, y in lines.items():
        middle, low, mean, high = band(t[shown], y)
        colour = COLUMN_COLOURS[name]
        if len(middle) < len(y):
            axes.fill_between(
                middle, low, high, fc=(*to_rgb(colour), 0.22), ec=(*to_rgb(colour), 0.5), lw=0.5
            )
            lasts = 1e3 * float(np.median(np.diff(middle)))
            notes = [f"Line: mean; band: range in {lasts:.0f} ms."]
        axes.plot(middle, mean, color=colour, lw=1.1, label=LABELS[name])
    return notes + _limit(axes, lines, INPUT_FRAME)


def has_inputs(run: DrawnRun) -> bool:
    """Whether a run has inputs τ; a robot that takes velocities has none.

    Parameters
    ----------
    run : DrawnRun
        The run.

    Returns
    -------
    bool
        True if there are any.

    Examples
    --------
    >>> has_inputs(run)
    True
    """
    return any(bool(np.isfinite(run.trajectory[name]).any()) for name in INPUTS)


def _largest(values: Array) -> float:
    return float(np.fmax.reduce(np.abs(values), initial=0.0))


def _limit(axes: "Axes", lines: dict[str, Array], frame: float) -> list[str]:
    """Limit the value axis: linear if all fits into the frame, else logarithmic beyond it."""
    largest = {name: _largest(y) for name, y in lines.items()}
    low = min(float(np.fmin.reduce(y)) for y in lines.values())
    high = max(float(np.fmax.reduce(y)) for y in lines.values())
    if not LEAVES_FRAME * frame < max(largest.values()) or frame == 0.0:
        margin = 0.06 * (high - low) or 0.5
        axes.set_ylim(min(low, 0.0) - margin, max(high, 0.0) + margin)
        return []
    low = 1.6 * low if low < -frame else -frame
    high = 1.6 * high if high > frame else frame
    decades = math.log10(max(-low, high) / frame)
    axes.set_yscale("symlog", linthresh=frame, linscale=max(1.0, 0.75 * decades))
    axes.set_ylim(low, high)
    outside = [*_outer_ticks(frame, high), *(-y for y in _outer_ticks(frame, -low))]
    axes.set_yticks([*_inner_ticks(frame), *outside])
    axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:,.6g}".replace("-", "−")))
    axes.set_yticks([], minor=True)
    for edge, end in ((frame, high), (-frame, low)):
        if abs(end) > frame:
            axes.axhspan(edge, end, color="#f3f1ea", zorder=0.1)
            axes.axhline(edge, color=MUTED, lw=0.7, zorder=0.7)
    reached = [
        f"|{LABELS.get(name, name)}| reaches {value:,.4g}."
        for name, value in largest.items()
        if value > frame
    ]
    return [f"Shaded: logarithmic beyond ±{frame:.3g}.", *reached]


def _inner_ticks(frame: float) -> list[float]:
    """Zero and one or two round values on either side of it, clear of the edges of the frame."""
    reach = 0.85 * frame
    step = next(y for y in ROUND if y >= 0.499 * reach)
    return [i * step for i in range(-int(reach / step), int(reach / step) + 1)]


def _outer_ticks(frame: float, end: float) -> list[float]:
    """At most two powers of ten beyond the frame, or else one round value."""
    fitting = [y for y in ROUND if 1.8 * frame <= y <= end]
    powers = [y for y in fitting if math.log10(y).is_integer() and y >= 2.5 * frame]
    return powers[:: -max(1, math.ceil(len(powers) / 2))] or fitting[-1:]


def plot(run: DrawnRun, path: Path | str | None = None) -> "Figure":
    """Draw one overview of a run: its path in the image, its states, its inputs or velocities.

    Parameters
    ----------
    run : DrawnRun
        The run.
    path : Path or str, optional
        A file to save it in; its ending says in which format.

    Returns
    -------
    Figure
        The figure.

    Examples
    --------
    >>> figure = plot(run, "run.png")
    >>> len(figure.axes)
    5
    """
    until = time_of_interest(run)
    with drawing():
        figure = new_figure(11.0, 5.8)
        draw_path(figure.add_axes((0.06, 0.09, 0.44, 0.74)), run)
        last = INPUTS if has_inputs(run) else ("v", "omega")
        panels = (("x0", "u0"), ("x1", "x2", "u1"), last)
        for i, columns in enumerate(panels):
            axes = figure.add_axes((0.57, 0.66 - 0.285 * i, 0.415, 0.225))
            draw = draw_inputs if columns == INPUTS else draw_states
            notes = draw(axes, run, columns, until=until)
            axes.tick_params(labelbottom=i == 2)
            _name_lines(axes, lift=0.02)
            said = " ".join(note for note in notes if not note.startswith("|"))
            axes.text(0.0, 1.03, said, transform=axes.transAxes, fontsize=7.0, color=MUTED)
        axes.set_xlabel("Time (s)")
        draw_step_strip(figure.add_axes((0.57, 0.945, 0.415, 0.014)), run, until=until)
        figure.text(0.06, 0.95, title_of(run), fontsize=12, weight="bold")
        figure.text(0.06, 0.908, run.outcome.sentence, fontsize=9, color=MUTED)
    if path is not None:
        save(figure, path)
    return figure
