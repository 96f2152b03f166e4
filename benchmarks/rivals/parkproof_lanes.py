"""Parkproof: an ensemble in compiled lanes, one thread, all of its metrics."""

from collections.abc import Callable

import numpy as np
from work import Found, Work

from parkproof import simulate_ensemble

MAXIMA = (
    "peak_tau1", "peak_tau2", "max_x0", "max_x1", "max_x2", "max_u0", "max_u1", "excursion",
)  # fmt: skip


def prepare(work: Work) -> Callable[[], Found]:
    """Nothing to prepare: the first call compiles."""

    def run() -> Found:
        rows = simulate_ensemble(work.scenarios)
        ends = np.array([rows[f"end{i}"] for i in (1, 2, 3)]).T
        return Found(np.nan_to_num(ends, nan=-1.0), np.array([rows[name] for name in MAXIMA]).T)

    return run
