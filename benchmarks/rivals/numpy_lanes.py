"""NumPy, all trials side by side, a Python loop over the samples."""

from collections.abc import Callable

import law_arrays
import numpy as np
from work import Found, Work


def prepare(work: Work) -> Callable[[], Found]:
    """Lay the trials out with the lane last."""
    p, h, way = work.parameters, work.period, work.ways
    truth = np.ascontiguousarray(work.truths.T)

    def run() -> Found:
        state = list(work.starts.T.copy())
        step, ends = np.ones(len(way)), np.full((3, len(way)), -1.0)
        largest: tuple[np.ndarray, ...] = tuple(np.zeros((8, len(way))))
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
            largest = law_arrays.maxima(np, largest, state, tau)
            rates = law_arrays.rates(np, t, state, tau, truth)
            state = [x + h * rate for x, rate in zip(state, rates, strict=True)]
        maxima = np.array(largest).T
        maxima[:, 7] **= 0.5
        return Found(ends.T, maxima)

    return run
