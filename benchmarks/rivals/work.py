"""The work that every rival does: trials of one closed loop, and what is kept of each.

A trial is a start inside the chart under the corrected law in its explicit form, with α1, α2 and
four sines (γ1, γ2, φ1, φ2) of its own inside the paper's bounds, for 15 s at 1 ms. Kept are the
times at which Steps 1 to 3 ended, and 17 metrics.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from parkproof import Scenario, Start, section4
from parkproof.laws.corrected import better_direction
from parkproof.laws.parameters import LawParameters, law_parameters
from parkproof.model.signals import Sine
from parkproof.model.truth import Truth

DURATION = 15.0
LOW, HIGH = (-1.0, -0.5, -0.5, -1.0, -1.0), (1.0, 0.5, 0.5, 3.0, 1.0)
"""The box of starts: x0, x1, x2, u0, u1."""

METRICS = (
    "peak_tau1", "peak_tau2", "max_x0", "max_x1", "max_x2", "max_u0", "max_u1", "excursion",
    "rms_tau1", "rms_tau2", "total_variation_tau1", "total_variation_tau2", "path_length",
    "least_x0", "largest_x0", "max_speed", "max_turn_rate",
)  # fmt: skip
"""What is kept of a trial beside the ends of its steps, in the names of `simulate_ensemble`."""

Floats = NDArray[np.float64]


class Work(NamedTuple):
    """Trials, as scenarios for Parkproof and as arrays for its rivals.

    ``way`` is the direction of travel that the law chooses at the start; rivals do not choose it
    again where the law goes back to Step 1. A row of ``truths`` is α1, α2, and mean, amplitude,
    frequency and phase of γ1, γ2, φ1 and φ2.
    """

    scenarios: list[Scenario]
    parameters: LawParameters
    period: float
    samples: int
    starts: Floats
    ways: Floats
    truths: Floats

    def first(self, count: int) -> "Work":
        """The first so many trials."""
        return self._replace(
            scenarios=self.scenarios[:count],
            starts=self.starts[:count],
            ways=self.ways[:count],
            truths=self.truths[:count],
        )


class Found(NamedTuple):
    """When Steps 1 to 3 ended in s (−1 where they did not), and `METRICS`: a row a trial."""

    ends: Floats
    metrics: Floats


def scenario_of(start: Any, truth: Any) -> Scenario:
    """A trial as a scenario."""
    one, two, *waves = truth.tolist()
    sines = [
        Sine(mean=mean, amplitude=amplitude, omega=omega, phase=phase)
        for mean, amplitude, omega, phase in zip(*(waves[i::4] for i in range(4)), strict=True)
    ]
    return section4(
        "corrected",
        start=Start(state=tuple(start.tolist())),
        truth=Truth(alpha=(one, two), gamma=tuple(sines[:2]), disturbance=tuple(sines[2:])),
        duration=DURATION,
    )


def make_work(count: int) -> Work:
    """Draw trials, the same each time."""
    rng = np.random.default_rng(1)
    # a row a trial in one draw: the first trials do not depend on how many there are
    low = (*LOW, 0.5, 0.5, *(0.5,) * 4, *(0.0,) * 4)
    high = (*HIGH, 1.5, 1.5, *(2.0,) * 4, *(2.0 * math.pi,) * 4)
    starts, alphas, omegas, phases = np.split(rng.uniform(low, high, (count, 15)), (5, 7, 11), 1)
    starts, truths = starts.copy(), np.hstack([alphas, np.zeros((count, 16))])
    truths[:, 2::4], truths[:, 3::4] = (1.5, 1.5, 0.0, 0.0), (0.5, 0.5, 2.5, 2.5)
    truths[:, 4::4], truths[:, 5::4] = omegas, phases
    scenarios = [scenario_of(start, truth) for start, truth in zip(starts, truths, strict=True)]
    one = scenarios[0]
    p = law_parameters(
        bounds=one.bounds,
        gains=one.gains,
        switching=one.switching,
        control_period=one.run.control_period,
    )
    ways = [better_direction(*start[:4], p) for start in starts.tolist()]
    period, samples = one.run.control_period, one.run.samples
    return Work(scenarios, p, period, samples, starts, np.array(ways), truths)


def found_from(kept: Floats, work: Work) -> Found:
    """Take the roots and means of what is kept: a row a trial, as in `law.NOTHING_YET`."""
    metrics = kept[:, 4:21].copy()
    metrics[:, 8:10] /= work.samples
    metrics[:, 10:12] /= work.samples * work.period
    rooted = [7, 8, 9, 15]
    metrics[:, rooted] **= 0.5
    return Found(kept[:, 1:4], metrics)
