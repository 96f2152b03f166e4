"""Parkproof: an ensemble in compiled lanes, one thread, all of its metrics."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
from work import METRICS, Found, Work

from parkproof.simulation.ensemble import simulate_trials
from parkproof.simulation.lanes import kernel
from parkproof.simulation.trials import Precision, trials_of


@contextmanager
def kernels(**kind: Any) -> Iterator[None]:
    """Have ensembles carried out by kernels that are no choice of a user's, such as by Euler."""
    usual = kernel.kernel_of
    kernel.kernel_of = partial(usual, **kind)
    try:
        yield
    finally:
        kernel.kernel_of = usual


def prepare(
    work: Work, *, euler: bool = False, precision: Precision = "double"
) -> Callable[[], Found]:
    """Lay the trials out, as for the rivals; the first call compiles.

    ``euler`` takes the plant by Euler's method, as most rivals have it.
    """
    shared, trials = work.scenarios[0], trials_of(work.scenarios)

    def run() -> Found:
        with kernels(euler=euler):
            rows = simulate_trials(shared, trials, precision=precision)
        ends = np.array([rows[f"end{i}"] for i in (1, 2, 3)]).T
        return Found(np.nan_to_num(ends, nan=-1.0), np.array([rows[name] for name in METRICS]).T)

    return run
