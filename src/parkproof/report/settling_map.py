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
from parkproof.report.measured import bounds_of, gains_of, switching_of
from parkproof.report.style import INK, MUTED, drawing, new_figure, save
from parkproof.scenario import RunSettings, Scenario, Start
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.stress import stress_truths

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

HEADINGS = (-25.0, 0.0, 25.0)
"""Headings of the map in degrees; none of them needs a turn."""


SHORTEST = 1.0
"""Simulated times in s below which no ratio is drawn."""


@dataclass(frozen=True)
class SettlingMap:
    """Times over a grid of starts at rest.

    Attributes
    ----------
    x, y : array
        Positions of the grid.
    headings : tuple of floats
        In degrees.
    proved, worst : array
        Bound and worst simulated time in s, by heading, y and x; NaN where there is none.
    truths : int
        Runs a start.

    Examples
    --------
    >>> list(SettlingMap.__dataclass_fields__)
    ['x', 'y', 'headings', 'proved', 'worst', 'truths']
    """

    x: "Array"
    y: "Array"
    headings: tuple[float, ...]
    proved: "Array"
    worst: "Array"
    truths: int


def settling_map(
    certificate: dict[str, Any],
    *,
    control_period: float,
    points: int = 9,
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
    points : int
        Along each axis.
    truths : int
        Runs a start, each with a truth of `stress_truths`.
    threads : int
        For the runs.

    Returns
    -------
    SettlingMap
        The map.
    """
    starts, claim = certificate["assumptions"]["starts"], certificate["claim"]
    x_range, y_range = (starts.get(a) or starts[b] for a, b in (("x", "x0"), ("y", "x1")))
    x, y = (np.linspace(low, high, points) for low, high in (x_range, y_range))
    shape = (len(HEADINGS), points, points)
    places = [(float(x[k]), float(y[j]), HEADINGS[i]) for i, j, k in np.ndindex(*shape)]
    proved = np.array([_bound(certificate, *place) for place in places]).reshape(shape)
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
            start=Start(pose=(px, py, math.radians(heading))),
            run=run,
        )
        for px, py, heading in places
        for truth in stress_truths(bounds, count=truths, seed=0)
    ]
    total = simulate_ensemble(trials, threads=threads)["total"]
    worst = total.reshape(*shape, truths).max(axis=-1)
    return SettlingMap(x, y, HEADINGS, proved, worst, truths)


def _bound(certificate: dict[str, Any], x: float, y: float, heading: float) -> float:
    """The proven time from one start: the certificate's links hold at every state."""
    law, known = Law.of(certificate["law"]), Uncertainty.of(certificate["assumptions"])
    links = links_of(certificate["law"], certificate["lyapunov"])
    slope = math.tan(math.radians(heading))
    point = {"x0": x, "x1": y, "x2": slope, "u0": 0.0, "u1": 0.0}
    starts = {name: (float(value), float(value)) for name, value in point.items()}
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
    extent = (found.x[0], found.x[-1], found.y[0], found.y[-1])
    with drawing():
        figure = new_figure(9.6, 8.2)
        figure.text(0.06, 0.965, "Settling time over starts at rest", fontsize=12, weight="bold")
        columns = len(found.headings)
        for i, (label, values, colours) in enumerate(rows):
            low, high = float(np.nanmin(values)), float(np.nanmax(values))
            for j, heading in enumerate(found.headings):
                box = (0.08 + 0.26 * j, 0.68 - 0.295 * i, 0.235, 0.22)
                axes = figure.add_axes(box)
                image = axes.imshow(
                    values[j], origin="lower", extent=extent, aspect="auto", cmap=colours,
                    vmin=low, vmax=high,
                )  # fmt: skip
                axes.grid(visible=False)
                if i == 0:
                    axes.set_title(f"heading {heading:+.0f}°", fontsize=9, color=INK)
                axes.tick_params(labelbottom=i == len(rows) - 1, labelleft=j == 0)
                if i == len(rows) - 1:
                    axes.set_xlabel("x_m (image units)")
                    axes.set_xticks(np.linspace(found.x[0], found.x[-1], 5)[[0, 2, 4]])
                if j == 0:
                    axes.set_ylabel("y_m (image units)")
            bar = figure.add_axes((0.08 + 0.26 * columns, 0.68 - 0.295 * i, 0.015, 0.22))
            figure.colorbar(image, cax=bar)
            bar.set_ylabel(label, color=MUTED, fontsize=9)
        save(figure, path)
