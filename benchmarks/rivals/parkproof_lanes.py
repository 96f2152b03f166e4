"""Parkproof: an ensemble in compiled lanes, one thread, all of its metrics."""

from collections.abc import Callable

import numpy as np
from work import Found, Work

from parkproof.simulation.ensemble import simulate_trials
from parkproof.simulation.trials import trials_of

MAXIMA = (
    "peak_tau1", "peak_tau2", "max_x0", "max_x1", "max_x2", "max_u0", "max_u1", "excursion",
)  # fmt: skip


def prepare(work: Work) -> Callable[[], Found]:
    """Lay the trials out, as for the rivals; the first call compiles."""
    shared, trials = work.scenarios[0], trials_of(work.scenarios)

    def run() -> Found:
        rows = simulate_trials(shared, trials)
        ends = np.array([rows[f"end{i}"] for i in (1, 2, 3)]).T
        return Found(np.nan_to_num(ends, nan=-1.0), np.array([rows[name] for name in MAXIMA]).T)

    return run
