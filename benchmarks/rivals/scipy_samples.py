"""SciPy: `solve_ivp` from sample to sample, the input held in between."""

from collections.abc import Callable
from typing import Any

import law
import numpy as np
from scipy.integrate import solve_ivp
from work import Found, Work, found_from


def prepare(work: Work) -> Callable[[], Found]:
    """Define a trial."""
    p, h = work.parameters, work.period

    def park(j: int) -> Any:
        way, truth = float(work.ways[j]), tuple(work.truths[j].tolist())

        def rates(t: float, y: Any, tau1: float, tau2: float) -> Any:
            _, _, x2, u0, u1 = y
            return law.rates(t, x2, u0, u1, tau1, tau2, truth)

        state, kept = work.starts[j], law.NOTHING_YET
        for k in range(work.samples):
            t = k * h
            tau1, tau2, kept = law.decide(t, way, *state.tolist(), kept, p)
            state = solve_ivp(rates, (t, t + h), state, args=(tau1, tau2)).y[:, -1]
        return kept

    def run() -> Found:
        last = np.array([park(j) for j in range(len(work.ways))])
        return found_from(last, work)

    return run
