"""numba, one trial after the other, with the mathematics library's power and sine."""

from collections.abc import Callable

import law
import numba
import numpy as np
from work import Found, Work, found_from

# numpy's error model and fastmath are to the rival's advantage
OPTIONS = {"error_model": "numpy", "fastmath": True}


@numba.njit(**OPTIONS)
def park(starts, ways, truths, p, h, samples, out):
    """Carry the trials out."""
    for j in range(starts.shape[0]):
        x0, x1, x2 = starts[j, 0], starts[j, 1], starts[j, 2]
        u0, u1 = starts[j, 3], starts[j, 4]
        kept, truth = law.NOTHING_YET, truths[j]
        for k in range(samples):
            x0, x1, x2, u0, u1, kept = law.euler_period(
                k * h, h, ways[j], x0, x1, x2, u0, u1, kept, truth, p
            )
        for i in range(len(kept)):
            out[j, i] = kept[i]


def prepare(work: Work) -> Callable[[], Found]:
    """Compile."""
    count = len(work.ways)

    def run() -> Found:
        out = np.empty((count, len(law.NOTHING_YET)))
        park(work.starts, work.ways, work.truths, work.parameters, work.period, work.samples, out)
        return found_from(out, work)

    return run
