"""What the reproduction found, as pictures: where the paper fails when run, and what mends it."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from parkproof.paper_example import BOUNDS, GAINS, WEIGHTS
from parkproof.proof.conditions import check_conditions
from parkproof.proof.gains import Step2Gains, Step3Gains
from parkproof.report.evidence import EXPONENTS, SMALL_GAINS, Evidence
from parkproof.report.style import (
    AMBER,
    BLUE,
    GREEN,
    INK,
    MUTED,
    VERMILION,
    drawing,
    new_figure,
    save,
    thinned,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from parkproof.report.style import Array

LAW_COLOURS = {"published": VERMILION, "corrected": BLUE}
DASHES = ("-", (0, (5, 2)), (0, (1.5, 1.5)))
"""Lines of the three tolerances."""


def _axes(figure: "Figure", panel: int, panels: int) -> "Axes":
    width = 0.86 / panels - 0.03
    axes: Axes = figure.add_axes((0.09 + panel * (width + 0.10), 0.145, width - 0.04, 0.735))
    return axes


def _redivergence(figure: "Figure", evidence: Evidence) -> None:
    axes = _axes(figure, 0, 1)
    for entry, dash in zip(evidence.redivergence, DASHES, strict=True):
        for law, run in entry.runs.items():
            t, step = run.trajectory["t"], run.trajectory["step"]
            start = int(np.argmax(step >= 3))
            size = np.maximum(np.abs(run.trajectory["x1"][start:]), 1e-9)
            seconds, size = thinned(t[start:] - t[start], size, points=1200)
            label = f"{law} law, Step 3 begun at {entry.tolerance:g}"
            axes.plot(seconds, size, color=LAW_COLOURS[law], ls=dash, label=label)
    axes.set(
        yscale="log",
        ylim=(1e-12, 1e2),
        xlim=(0.0, 3.5),
        xlabel="Time since Step 3 began (s)",
        ylabel="Lateral error |x1|",
        title="Step 3 as printed drives x1 away again, at every tolerance tried",
    )
    axes.legend(loc="lower right", ncols=2)


def _stopping(figure: "Figure", evidence: Evidence) -> None:
    axes = _axes(figure, 0, 1)
    for law in ("published", "corrected"):
        run = evidence.figures[law]
        t = run.trajectory["t"]
        late = t >= 28.0
        line = thinned(t[late], run.trajectory["x0"][late])
        axes.plot(*line, color=LAW_COLOURS[law], label=f"x0, {law} law")
        if (end := run.settling_time.steps["3"]) is not None:
            axes.axvline(end, color=MUTED, ls=(0, (2, 3)), lw=0.8)
            top = axes.get_xaxis_transform()
            axes.text(end + 0.1, 0.04, "Step 3 ends", color=MUTED, transform=top, fontsize=8)
    axes.set(
        xlim=(28.0, 35.0),
        xlabel="Time (s)",
        ylabel="The state x0",
        title="“Then stop”: with both inputs zero, the disturbance drives the robot away",
    )
    axes.legend(loc="upper left")


def _pushed(figure: "Figure", evidence: Evidence) -> None:
    axes = _axes(figure, 0, 1)
    for law, run in evidence.pushed.items():
        t = run.trajectory["t"]
        heading = np.degrees(run.trajectory["theta"])
        axes.plot(*thinned(t, heading), color=LAW_COLOURS[law], label=f"{law} law")
        if (end := run.settling_time.steps["1"]) is not None:
            axes.axvline(end, color=MUTED, ls=(0, (2, 3)), lw=0.8)
    axes.axhline(90.0, color=INK, lw=0.9)
    axes.text(0.05, 91.5, "90°: the chart ends", fontsize=8, color=INK)
    axes.set(
        xlim=(0.0, 4.5),
        ylim=(-60.0, 104.0),
        xlabel="Time (s); dotted: Step 1 ends",
        ylabel="Heading θ (degrees)",
        title="Step 1 with τ2 = 0 lets a constant push turn the robot to the chart's end",
    )
    axes.legend(loc="center", bbox_to_anchor=(0.6, 0.42))


def _conditions(figure: "Figure", evidence: Evidence) -> None:
    axes = _axes(figure, 0, 2)
    exponents = np.linspace(0.68, 0.99, 60)
    l1, l2, l3 = GAINS.l
    values = np.array(
        [
            [
                condition.value
                for condition in check_conditions(
                    Step2Gains(q1=q, l1=l1, l2=l2, l3=l3, k1=WEIGHTS.k[0], k2=WEIGHTS.k[1]),
                    alpha_max=BOUNDS.alpha_of(1)[1],
                )
            ]
            for q in exponents
        ]
    )
    for row, colour, name in zip(
        values.T, (BLUE, VERMILION, GREEN), ("15", "16", "17"), strict=True
    ):
        axes.plot(exponents, row, color=colour, label=f"({name})")
    axes.plot(exponents, _values19(exponents), color=AMBER, ls="--", label="(19), over q2")
    axes.axhspan(-10.0, 0.0, color="#eef5ee", zorder=0.1)
    axes.set_yscale("symlog", linthresh=1.0)
    axes.text(0.682, -0.6, "satisfied", color=GREEN, fontsize=8.5, va="center")
    axes.set(
        ylim=(-1.2, 1e4),
        xlim=(0.68, 0.99),
        xlabel="Exponent q1 (q2)",
        ylabel="Value; the paper asks for < 0",
        title="(15)-(17), (19) at the published gains",
    )
    axes.legend(loc="upper right")
    _decay(_axes(figure, 1, 2), evidence)


def _values19(exponents: "Array") -> list[float]:
    """(19) at the published gains, for each q2."""
    k1, k3 = GAINS.k
    return [
        check_conditions(
            Step3Gains(q2=q, k1_tilde=k1, k2_tilde=WEIGHTS.k_step3, k3_tilde=k3),
            alpha_max=BOUNDS.alpha_of(0)[1],
        )[1].value
        for q in exponents
    ]


def _decay(axes: "Axes", evidence: Evidence) -> None:
    places = np.arange(len(EXPONENTS))
    names = (("paper", "the paper's weights", VERMILION), ("other", "other weights", BLUE))
    for shift, (weights, label, colour) in zip((-0.2, 0.2), names, strict=True):
        ratios = [evidence.ratios[q1, weights] for q1 in EXPONENTS]
        bars = axes.bar(places + shift, ratios, 0.38, color=colour, label=label)
        texts = [f"{ratio:+.2g}".replace("-", "−") for ratio in ratios]
        axes.bar_label(bars, texts, padding=2, fontsize=8)
    axes.axhline(0.0, color=INK, lw=0.9)
    axes.set_yscale("symlog", linthresh=1.0)
    axes.set_xticks(places, EXPONENTS)
    axes.set(
        ylim=(-6.0, 120.0),
        xlabel="Exponent q1",
        ylabel="Largest V̇3/V3^α found (sampled)",
        title="V3 with other weights (sampled)",
    )
    axes.legend(loc="upper right")


def _gains(figure: "Figure", evidence: Evidence) -> None:
    axes = _axes(figure, 0, 2)
    passes = evidence.remark3.passes
    numbers = np.arange(1, len(passes) + 1)
    axes.plot(numbers, [p.l for p in passes], "o-", color=BLUE, label="l, as given")
    axes.plot(
        numbers, [p.bound for p in passes], "s--", color=VERMILION, label="l that it asks for"
    )
    axes.set(
        yscale="log",
        xticks=numbers,
        xlabel="Pass through Step a",
        title="Remark 3 asks for more at every pass",
    )
    axes.legend(loc="upper left")
    right = _axes(figure, 1, 2)
    rows = (
        ("(15)-(17),\nsharp form", evidence.sequential_small.gains.l3, VERMILION),
        ("published", GAINS.l[2], AMBER),
        (f"sampled,\nc = {-evidence.small_ratio:.2f}", SMALL_GAINS.l[2], BLUE),
    )
    bars = right.bar([r[0] for r in rows], [r[1] for r in rows], 0.6, color=[r[2] for r in rows])
    right.bar_label(bars, [f"{r[1]:.3g}" for r in rows], padding=2)
    right.set(yscale="log", ylim=(1.0, 2000.0), title="Control gain l3, q1 = 13/15")
    right.grid(visible=False, axis="x")


def _periods(figure: "Figure", evidence: Evidence) -> None:
    periods = sorted({period for period, _ in evidence.residuals})
    left, right = _axes(figure, 0, 2), _axes(figure, 1, 2)
    for form, colour, marker in (("explicit", VERMILION, "s--"), ("implicit", BLUE, "o-")):
        rows = [evidence.residuals[period, form] for period in periods]
        milliseconds = [1e3 * period for period in periods]
        left.plot(milliseconds, [r[0] for r in rows], marker, color=colour, label=form)
        right.plot(milliseconds, [r[1] for r in rows], marker, color=colour, label=form)
    for axes in (left, right):
        axes.set(xscale="log", yscale="log", xlabel="Control period (ms)")
        axes.set_xticks([1, 2, 5, 10, 20, 33], ["1", "2", "5", "10", "20", "33"])
        axes.set_xticks([], minor=True)
        axes.legend(loc="center right")
    left.set(title="Largest pose error while held", ylabel="max(|x0|, |x1|, |x2|), last 2 s")
    right.set(title="Chatter of τ2 while held", ylabel="Total variation per second")


FINDINGS: dict[str, tuple[str, Callable[["Figure", Evidence], None]]] = {
    "redivergence": ("Step 3 re-diverges", _redivergence),
    "stopping": ("“Then stop” does not hold", _stopping),
    "push": ("Step 1 leaves the heading alone", _pushed),
    "conditions": ("The published gains and weights", _conditions),
    "gains": ("The search of Remark 3, and how conservative the conditions are", _gains),
    "periods": ("How finely: explicit and implicit form", _periods),
}
"""Pictures of findings: file name → (heading, how it is drawn)."""


def draw_findings(evidence: Evidence, directory: Path) -> list[Path]:
    """Draw every finding as PNG and SVG.

    Parameters
    ----------
    evidence : Evidence
        From `parkproof.report.evidence.gather`.
    directory : Path
        Where the files go; it exists.

    Returns
    -------
    list of Path
        The files.

    Examples
    --------
    >>> draw_findings(evidence, directory)[0].name
    'redivergence.png'
    """
    files = []
    for name, (_, draw) in FINDINGS.items():
        with drawing():
            figure = new_figure(8.4, 4.2)
            draw(figure, evidence)
        for ending in ("png", "svg"):
            files.append(directory / f"{name}.{ending}")
            save(figure, files[-1])
    return files
