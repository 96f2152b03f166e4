"""numba, one trial after the other, with the mathematics library's power and sine."""

from collections.abc import Callable

import law
import numba
import numpy as np
from work import Found, Work

# numpy's error model and fastmath are to the rival's advantage
OPTIONS = {"error_model": "numpy", "fastmath": True}


@numba.njit(**OPTIONS)
def park(starts, ways, truths, p, h, samples, ends, maxima):
    """Carry the trials out."""
    for j in range(starts.shape[0]):
        x0, x1, x2 = starts[j, 0], starts[j, 1], starts[j, 2]
        u0, u1 = starts[j, 3], starts[j, 4]
        kept, truth = law.NOTHING_YET, truths[j]
        for k in range(samples):
            x0, x1, x2, u0, u1, kept = law.euler_period(
                k * h, h, ways[j], x0, x1, x2, u0, u1, kept, truth, p
            )
        for i in range(3):
            ends[j, i] = kept[1 + i]
        for i in range(8):
            maxima[j, i] = kept[4 + i]


def prepare(work: Work) -> Callable[[], Found]:
    """Compile."""
    count = len(work.ways)

    def run() -> Found:
        found = Found(np.empty((count, 3)), np.empty((count, 8)))
        park(
            work.starts, work.ways, work.truths, work.parameters, work.period, work.samples, *found
        )
        found.maxima[:, 7] **= 0.5
        return found

    return run
