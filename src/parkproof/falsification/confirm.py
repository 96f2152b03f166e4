"""What was found, carried out again: by the plain reference, and with finer sampling."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import msgspec

from parkproof.falsification.claims import size_in, sizes_of
from parkproof.falsification.search import Worst
from parkproof.scenario import MAX_SAMPLES
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import simulate

FINER = 10
"""By how much finer a run is sampled again, to tell what sampling does from what breaks a proof."""

NEAR = 1e-3
"""Relative difference up to which two ways of carrying out a run agree; a period always does."""


@dataclass(frozen=True, kw_only=True)
class Replayed:
    """A run of the lanes, carried out again by the plain reference.

    Attributes
    ----------
    worst : Worst
        What the lanes found.
    outcome : Outcome
        How the plain run ended.
    size : float
        What it came to.
    """

    worst: Worst
    outcome: Outcome
    size: float

    @property
    def same(self) -> bool:
        """Whether both ended alike, with nearly the same number."""
        period = self.worst.scenario.run.control_period
        near = math.isclose(self.size, self.worst.size, rel_tol=NEAR, abs_tol=1.001 * period)
        return self.outcome is self.worst.outcome and near


def replayed(worst: Worst) -> Replayed:
    """Carry out a run again by the plain reference.

    Parameters
    ----------
    worst : Worst
        The run.

    Returns
    -------
    Replayed
        Both, to be compared.

    Examples
    --------
    >>> from parkproof.report.measured import Proven
    >>> claim = Proven("total_time", 35.0, "total")
    >>> found = Worst(claim=claim, size=run.settling_time.total, outcome=run.outcome,
    ...               scenario=run.scenario)
    >>> replayed(found).same
    True
    """
    run = simulate(worst.scenario)
    return Replayed(worst=worst, outcome=run.outcome, size=size_in(worst.claim, run))


@dataclass(frozen=True, kw_only=True)
class Exceeded:
    """A run that goes beyond a bound, and what it comes to where it is sampled more finely.

    Attributes
    ----------
    worst : Worst
        The run.
    finer : float or None
        Its number then; None where it was not sampled more finely.
    """

    worst: Worst
    finer: float | None = None

    @property
    def holds_up(self) -> bool:
        """Whether the bound is exceeded for all that is known, and not by sampling alone."""
        return self.finer is None or self.finer > self.worst.claim.bound


def finer(broken: Sequence[Worst]) -> list[float | None]:
    """Carry out runs again, ten times as finely sampled.

    Parameters
    ----------
    broken : sequence of Worst
        Runs of one search.

    Returns
    -------
    list of float or None
        What each comes to; None where so many samples are too many.

    Examples
    --------
    >>> finer([])
    []
    """
    if not broken:
        return []
    run = broken[0].scenario.run
    if FINER * run.samples > MAX_SAMPLES:
        return [None for _ in broken]
    step = None if run.plant_step is None else run.plant_step / FINER
    fine = msgspec.structs.replace(
        run, control_period=run.control_period / FINER, plant_step=step, record_period=None
    )
    rows = simulate_ensemble(
        [msgspec.structs.replace(worst.scenario, run=fine) for worst in broken]
    )
    return [
        float(sizes_of([worst.claim], {name: row[i : i + 1] for name, row in rows.items()})[0, 0])
        for i, worst in enumerate(broken)
    ]
