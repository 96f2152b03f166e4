"""The trade-offs of a design: proven time against input limit and against travel."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from parkproof.proof.candidates import Candidate
from parkproof.proof.design import Design
from parkproof.proof.limits import over_limits
from parkproof.report.style import AMBER, BLUE, GREEN, INK, MUTED, drawing, new_figure, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = {"homogeneous": BLUE, "corrected": GREEN}
NAMES = {"homogeneous": "homogeneous law", "corrected": "paper's Step 2, corrected law"}


def front(
    candidates: Sequence[Candidate], cost: Callable[[Candidate], float]
) -> list[tuple[float, float]]:
    """The candidates that no other beats in both time and cost.

    Parameters
    ----------
    candidates : sequence of Candidate
        All.
    cost : callable
        What is weighed against time.

    Returns
    -------
    list of pairs
        (cost, time), by rising cost and falling time.
    """
    best: list[tuple[float, float]] = []
    for price, time in sorted((cost(c), c.time) for c in candidates):
        if not best or time < best[-1][1]:
            best.append((price, time))
    return best


def draw_tradeoff(found: Design, path: Path | str) -> None:
    """Draw both trade-offs of a design.

    Parameters
    ----------
    found : Design
        The design with all candidates it looked at.
    path : Path or str
        The picture; its ending says in which format.
    """
    costs: tuple[tuple[str, str, Callable[[Candidate], float]], ...] = (
        ("Largest input |τ1|, |τ2|", "limits.tau", lambda c: max(c.tau)),
        ("Travel |x0| (image units)", "limits.view", lambda c: c.travel),
    )
    with drawing():
        figure = new_figure(9.6, 4.4)
        figure.text(0.07, 0.94, "What a shorter proven time costs", fontsize=12, weight="bold")
        figure.text(
            0.07,
            0.885,
            "Candidates that keep all other limits, with bounds that follow from proved links",
            fontsize=9,
            color=MUTED,
        )
        for i, (label, free, cost) in enumerate(costs):
            axes = figure.add_axes((0.07 + 0.48 * i, 0.13, 0.42, 0.66))
            _panel(axes, found, free, cost)
            axes.set(xlabel=label, ylabel="Proven total time (s)" if i == 0 else "")
            if i == 0:
                axes.legend(loc="upper right")
        save(figure, path)


def _panel(axes: "Axes", found: Design, free: str, cost: Callable[[Candidate], float]) -> None:
    """One trade-off: a cloud for each law, its front, and the chosen candidate."""
    chosen = found.chosen
    if chosen is None:
        return
    for law, colour in COLOURS.items():
        own = [
            c
            for c in found.looked_at
            if c.law == law and all(name.startswith(free) for name in over_limits(c, found.spec))
        ]
        if not own:
            continue
        axes.plot(
            [cost(c) for c in own], [c.time for c in own], ls="", marker=".", ms=2.5, color=colour,
            alpha=0.25, rasterized=True,
        )  # fmt: skip
        line = front(own, cost)
        axes.plot(
            [x for x, _ in line], [t for _, t in line], color=colour, lw=1.6, label=NAMES[law],
            drawstyle="steps-post",
        )  # fmt: skip
    axes.plot(
        cost(chosen), chosen.time, marker="*", ms=13, color=AMBER, mec=INK, ls="", label="chosen"
    )
    low, high = 0.3 * cost(chosen), 8.0 * cost(chosen)
    axes.set(xscale="log", xlim=(low, high), ylim=(0.0, 3.0 * chosen.time))
    ticks = [t * 10.0**n for n in range(-3, 6) for t in (1, 2, 5) if low <= t * 10.0**n <= high]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
