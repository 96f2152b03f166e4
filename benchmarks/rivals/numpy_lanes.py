"""NumPy, all trials side by side, a Python loop over the samples."""

from collections.abc import Callable

import law_arrays
import numpy as np
from law import NOTHING_YET
from work import Found, Work, found_from


def prepare(work: Work) -> Callable[[], Found]:
    """Lay the trials out with the lane last."""
    p, h, way = work.parameters, work.period, work.ways
    truth = np.ascontiguousarray(work.truths.T)

    def run() -> Found:
        state = list(work.starts.T.copy())
        step, ends = np.ones(len(way)), np.full((3, len(way)), -1.0)
        kept: tuple[np.ndarray, ...] = tuple(np.full(len(way), x) for x in NOTHING_YET[4:])
        for k in range(work.samples):
            t, before = k * h, step
            step = law_arrays.next_step(np, before, way, state, p)
            changed = np.flatnonzero(step != before)
            for j in changed:
                if step[j] > before[j]:
                    ends[int(before[j]) - 1, j] = t
                else:
                    ends[:, j] = -1.0
            tau = law_arrays.inputs(np, step, way, state, p)
            kept = law_arrays.metrics(np, t, kept, state, tau)
            rates = law_arrays.rates(np, t, state, tau, truth)
            state = [x + h * rate for x, rate in zip(state, rates, strict=True)]
        return found_from(np.array([step, *ends, *kept]).T, work)

    return run
