"""How finely a run has to be computed: plant step, control period, form of the law.

Prints the tables of docs/numerics.md. Run it from the repository root::

    python benchmarks/convergence.py
"""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
from msgspec.structs import replace

from parkproof import Run, Square, Switching, Truth, section4, simulate

SINES = section4().truth
SQUARES = Truth(
    gamma=(
        Square(mean=1.5, amplitude=0.5, omega=2.0),
        Square(mean=1.5, amplitude=0.5, omega=3.0, phase=1.0),
    ),
    disturbance=(
        Square(amplitude=2.5, omega=3.0),
        Square(amplitude=2.5, omega=2.0, phase=0.5),
    ),
)
SIGNALS = {"sine": SINES, "square": SQUARES}
PLANT_STEPS = (10e-3, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)
FINEST = 2e-5
PERIODS = (1e-3, 2e-3, 5e-3, 10e-3, 20e-3, 33e-3)
STATES = ("x0", "x1", "x2", "u0", "u1")
HELD_FOR = 2.0
"""Seconds at the end of a run over which chatter is taken; the residual is, too."""


def run_with_plant_step(truth: Truth, step: float) -> Run:
    """Section 4 with one control period of 10 ms throughout, so that only the plant step varies."""
    scenario = section4("corrected", truth=truth, discretisation="implicit", control_period=10e-3)
    return simulate(replace(scenario, run=replace(scenario.run, plant_step=step, duration=12.0)))


def largest_difference(run: Run, finest: Run, *, until: float) -> float:
    """Largest difference of any state up to a time, or to where only one of the runs is a step on.

    A step may end one sample later in one run than in the other; from there on they differ because
    the law differs.
    """
    ours, theirs = run.trajectory, finest.trajectory
    count = round(until / run.scenario.run.control_period) + 1
    apart = np.flatnonzero(ours["step"][:count] != theirs["step"][:count])
    count = int(apart[0]) if len(apart) else count
    return max(float(np.max(np.abs(ours[n][:count] - theirs[n][:count]))) for n in STATES)


def samples_apart(run: Run, finest: Run) -> int:
    """Largest difference in the ends of steps, in control periods."""
    ends = zip(run.settling_time.steps.values(), finest.settling_time.steps.values(), strict=True)
    period = run.scenario.run.control_period
    return max(round(abs((ours or 0.0) - (theirs or 0.0)) / period) for ours, theirs in ends)


def plant_step_rows() -> Iterator[Sequence[str]]:
    """Error of each plant step against the finest one."""
    for name, truth in SIGNALS.items():
        finest = run_with_plant_step(truth, FINEST)
        for step in (*PLANT_STEPS, FINEST):
            run = run_with_plant_step(truth, step)
            yield (
                name,
                f"{1e3 * step:g}",
                f"{largest_difference(run, finest, until=3.0):.1e}",
                str(samples_apart(run, finest)),
                f"{run.metrics.residual:.2e}",
            )


def period_rows() -> Iterator[Sequence[str]]:
    """Residual and chatter while held, in both forms, over control periods."""
    for (name, truth), period in product(SIGNALS.items(), PERIODS):
        cells = [name, f"{1e3 * period:g}"]
        for form in ("explicit", "implicit"):
            scenario = section4(
                "corrected",
                truth=truth,
                control_period=period,
                discretisation=form,
                switching=Switching(tolerance=(0.02, 0.05, 0.05)),
                duration=12.0,
            )
            run = simulate(scenario)
            late = run.trajectory["t"] >= run.ended - HELD_FOR
            chatter = float(np.sum(np.abs(np.diff(run.trajectory["tau2"][late])))) / HELD_FOR
            cells += [f"{run.metrics.residual:.1e}", f"{chatter:.3g}", run.outcome.value]
        yield cells


def print_table(head: Sequence[str], rows: Iterator[Sequence[str]]) -> None:
    """Print a table in Markdown, a row as soon as it is known."""
    print("| " + " | ".join(head) + " |")
    print("|" + " --- |" * len(head))
    for row in rows:
        print("| " + " | ".join(row) + " |", flush=True)


def main() -> None:
    """Print both tables."""
    print_table(
        ("signals", "plant step, ms", "largest error to 3 s", "steps end, samples off", "residual"),
        plant_step_rows(),
    )
    print()
    explicit, implicit = (
        [f"{form}: {what}" for what in ("residual", "chatter of τ2, 1/s", "outcome")]
        for form in ("explicit", "implicit")
    )
    print_table(("signals", "period, ms", *explicit, *implicit), period_rows())


if __name__ == "__main__":
    main()
