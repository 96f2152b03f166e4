"""Settling times over starts: what is proved, the worst that was simulated, and their ratio."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from parkproof.proof.checker.balls import up
from parkproof.proof.checker.certificate import links_of
from parkproof.proof.checker.parts import GapError, Law, Uncertainty
from parkproof.proof.checker.whole_run import run_bounds
from parkproof.report.measured import bounds_of, gains_of, start_at, switching_of
from parkproof.report.style import INK, MUTED, drawing, new_figure, save
from parkproof.scenario import RunSettings, Scenario
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.stress import stress_truths

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

FULL_TURN = 2.0 * math.pi - 1e-3
"""Ranges of headings from this width on, in rad, have the same heading at both ends."""

SHORTEST = 1.0
"""Simulated times in s below which no ratio is drawn."""


@dataclass(frozen=True)
class SettlingMap:
    """Times over a grid of starts, all inside a certificate's box of starts.

    Attributes
    ----------
    x, y : array
        Positions of the grid; a single one where the box has no width.
    headings : tuple of floats
        In degrees.
    turns : tuple of bools
        Whether the law turns first, by heading.
    manner : str
        How the robot moves at the start: "at rest", unless the box excludes that.
    proved, worst : array
        Bound and worst simulated time in s, by heading, y and x; NaN where there is none.
    truths : int
        Runs a start.

    Examples
    --------
    >>> list(SettlingMap.__dataclass_fields__)
    ['x', 'y', 'headings', 'turns', 'manner', 'proved', 'worst', 'truths']
    """

    x: "Array"
    y: "Array"
    headings: tuple[float, ...]
    turns: tuple[bool, ...]
    manner: str
    proved: "Array"
    worst: "Array"
    truths: int


def headings_of(low: float, high: float, *, limit: float) -> list[float]:
    """Headings that show a range: its ends and middle, or more where some need a turn first.

    Parameters
    ----------
    low, high : float
        Ends of the range in rad.
    limit : float
        Heading in rad beyond which the law turns first.

    Returns
    -------
    list of float
        In rad, rising, none outside the range: one if it has no width, three if no heading needs a
        turn, else five, or four all around.

    Examples
    --------
    >>> headings_of(0.1, 0.1, limit=1.4), headings_of(-0.5, 0.5, limit=1.4)
    ([0.1], [-0.5, 0.0, 0.5])
    >>> headings_of(-3.0, 3.0, limit=0.5)
    [-3.0, -1.5, 0.0, 1.5, 3.0]
    >>> [round(angle, 4) for angle in headings_of(-3.1416, 3.1416, limit=0.5)]
    [-1.5708, 0.0, 1.5708, 3.1416]
    """
    if low == high:
        return [low]
    count = 5 if max(-low, high) > limit else 3
    inner = (low + (high - low) * i / (count - 1) for i in range(1, count - 1))
    spread = [low, *(min(max(heading, low), high) for heading in inner), high]
    return spread[1:] if high - low >= FULL_TURN else spread


def settling_map(
    certificate: dict[str, Any],
    *,
    control_period: float,
    points: int | None = None,
    truths: int = 8,
    threads: int = 2,
) -> SettlingMap:
    """Compute the map for a certificate's box of starts.

    Parameters
    ----------
    certificate : dict
        The certificate.
    control_period : float
        Of the simulated runs, in s.
    points : int, optional
        Along each axis; default 9, or 7 where there are more than three headings.
    truths : int
        Runs a start, each with a truth of `stress_truths`.
    threads : int
        For the runs.

    Returns
    -------
    SettlingMap
        The map.
    """
    box, claim = certificate["assumptions"]["starts"], certificate["claim"]
    across, along, steer, *moving = box
    turning, limit = _turning(box, steer, certificate["law"]["chart_limit"])
    side = points or (9 if len(turning) <= 3 else 7)
    x, y = (_spread(*box[name], points=side) for name in (across, along))
    still = {name: min(max(0.0, box[name][0]), box[name][1]) for name in moving}
    shape = (len(turning), len(y), len(x))
    places = [
        {across: float(x[k]), along: float(y[j]), steer: turning[i][0], **still}
        for i, j, k in np.ndindex(*shape)
    ]
    proved = np.array([_bound(certificate, place) for place in places]).reshape(shape)
    bounds = bounds_of(certificate)
    duration = float(f"{1.1 * claim['total_time'] + 2.0:.3g}")
    run = RunSettings(duration=duration, control_period=control_period, discretisation="implicit")
    trials = [
        Scenario(
            law=certificate["law"]["name"],
            bounds=bounds,
            gains=gains_of(certificate),
            switching=switching_of(certificate),
            truth=truth,
            start=start_at(place),
            run=run,
        )
        for place in places
        for truth in stress_truths(bounds, count=truths, seed=0)
    ]
    total = simulate_ensemble(trials, threads=threads)["total"]
    worst = total.reshape(*shape, truths).max(axis=-1)
    manner = ", ".join(f"{name} = {value:g}" for name, value in still.items())
    return SettlingMap(
        x=x,
        y=y,
        headings=tuple(math.degrees(heading) for _, heading in turning),
        turns=tuple(abs(heading) > limit for _, heading in turning),
        manner=f"with {manner}" if any(still.values()) else "at rest",
        proved=proved,
        worst=worst,
        truths=truths,
    )


def _spread(low: float, high: float, *, points: int) -> "Array":
    """Points of a range, its ends among them."""
    return np.linspace(low, high, points if high > low else 1)


def _turning(
    box: dict[str, Any], steer: str, chart_limit: float
) -> tuple[list[tuple[float, float]], float]:
    """The headings of a box: each as the box gives it and in rad; and where the law turns first."""
    low, high = box[steer]
    limit = math.radians(chart_limit)
    if steer == "theta":
        return [(heading, heading) for heading in headings_of(low, high, limit=limit)], limit
    # x2 is the tangent; rounding must not leave the box
    headings = headings_of(math.atan(low), math.atan(high), limit=limit)
    return [(min(max(math.tan(angle), low), high), angle) for angle in headings], limit


def _bound(certificate: dict[str, Any], place: dict[str, float]) -> float:
    """The proven time from one start of the box: the certificate's links hold there, too."""
    law, known = Law.of(certificate["law"]), Uncertainty.of(certificate["assumptions"])
    links = links_of(certificate["law"], certificate["lyapunov"])
    starts = {name: (value, value) for name, value in place.items()}
    try:
        return up(run_bounds(starts, law, known, links)[0].time)
    except GapError:
        return math.nan


def draw_settling_map(found: SettlingMap, path: Path | str) -> None:
    """Draw the map: a row each for bound, worst run and ratio, a column for each heading.

    Parameters
    ----------
    found : SettlingMap
        The map.
    path : Path or str
        The picture; its ending says in which format.
    """
    # where a robot is at once at rest there is nothing to compare
    ratio = np.where(found.worst > SHORTEST, found.proved / found.worst, np.nan)
    rows = (
        ("Proved bound (s)", found.proved, "viridis"),
        (f"Worst of {found.truths} runs (s)", found.worst, "viridis"),
        ("Bound over worst run", ratio, "cividis"),
    )
    columns = len(found.headings)
    panel = 2.26 if columns <= 3 else 1.75
    width = LEFT + columns * (panel + BETWEEN) + RIGHT
    with drawing():
        figure = new_figure(width, HEIGHT)
        for place, text, style in (
            (HEIGHT - 0.33, f"Settling time over starts {found.manner}", {"weight": "bold"}),
            (HEIGHT - 0.58, _remark(found, ratio), {"size": 9.0, "color": MUTED}),
        ):
            figure.text(0.2 / width, place / HEIGHT, text, **({"size": 12.0} | style))
        for i, (label, values, colours) in enumerate(rows):
            low, high, beyond = _colours(values)
            bottom = HEIGHT - 2.77 - (TALL + BETWEEN) * i
            for j in range(columns):
                left = LEFT + j * (panel + BETWEEN)
                axes = _axes(figure, (left, bottom, panel, TALL))
                image = axes.imshow(
                    values[j], origin="lower", extent=_extent(found), aspect="auto", cmap=colours,
                    vmin=low, vmax=high,
                )  # fmt: skip
                _label(axes, found, j, first=i == 0, last=i == len(rows) - 1)
            bar = _axes(figure, (LEFT + columns * (panel + BETWEEN), bottom, 0.15, TALL))
            figure.colorbar(image, cax=bar, extend="max" if beyond else "neither")
            bar.set_ylabel(label, color=MUTED, fontsize=9)
        save(figure, path)


LEFT, RIGHT, BETWEEN, TALL, HEIGHT = 0.75, 0.85, 0.2, 1.85, 7.4
"""Margins, gap, height of a panel and of the picture, in inches."""


def _remark(found: SettlingMap, ratio: "Array") -> str:
    """What a reader must know of blank cells, or that all cells are certified starts."""
    if np.isnan(found.worst).any():
        return "Blank: a run had not parked when it ended"
    if np.isnan(ratio).any():
        return f"Blank: no run took longer than {SHORTEST:g} s"
    return "Each cell is a start that the certificate covers"


def _colours(values: "Array") -> tuple[float, float, bool]:
    """Ends of a colour scale, and whether few values beside the goal lie beyond it."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0, 1.0, False
    low, usual, high = (float(end) for end in np.percentile(known, (0.0, 97.0, 100.0)))
    beyond = high > low + 2.0 * (usual - low)
    return low, usual if beyond and usual > low else high, beyond and usual > low


def _axes(figure: "Figure", inches: tuple[float, float, float, float]) -> "Axes":
    """Axes at left, bottom, width and height in inches."""
    width, height = figure.get_size_inches()
    left, bottom, across, tall = inches
    return figure.add_axes((left / width, bottom / height, across / width, tall / height))


def _extent(found: SettlingMap) -> tuple[float, float, float, float]:
    """Ends of the picture: starts lie in the middle of their cells."""
    ends = []
    for values in (found.x, found.y):
        half = 0.5 * float(values[1] - values[0]) if len(values) > 1 else 0.05
        ends += [float(values[0]) - half, float(values[-1]) + half]
    return ends[0], ends[1], ends[2], ends[3]


def _label(axes: "Axes", found: SettlingMap, column: int, *, first: bool, last: bool) -> None:
    """Titles above the first row, positions below the last and left of the first column."""
    axes.grid(visible=False)
    for set_ticks, values in ((axes.set_xticks, found.x), (axes.set_yticks, found.y)):
        ticks = np.linspace(values[0], values[-1], 3 if len(values) > 1 else 1)
        set_ticks(ticks, [_number(tick) for tick in ticks])
    axes.tick_params(labelbottom=last, labelleft=column == 0)
    if first:
        angle = round(found.headings[column], 1)
        heading = f"heading {_number(angle, sign='+' if angle else '')}°"
        title = f"{heading}, turns first" if found.turns[column] else heading
        axes.set_title(title, fontsize=9, color=INK)
    if last:
        axes.set_xlabel("x_m (image units)")
    if column == 0:
        axes.set_ylabel("y_m (image units)")


def _number(value: float, *, sign: str = "") -> str:
    """A number with the minus that matplotlib writes, and none before 0."""
    return f"{value + 0.0:{sign}.3g}".replace("-", "−")
