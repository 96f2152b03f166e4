"""Seeks weights of V over a sampled sphere by linear programs.

A grid of weights and a program, which finds weights with V̇ < 0 at all sampled states wherever there
are any, say where to begin; further programs make the rate or the time better. States at which the
best weights do worse than at the sampled ones are added, until there are none.
"""

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

from parkproof.proof.states import SampledSphere
from parkproof.validate import finite

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ROUNDS = 12
"""Times that worse states are sought."""

STEPS = 30
"""Linear programs in a row."""

TRUST = (0.1, 10.0)
"""Largest change of a weight in a step."""

SHARES = (1e-3, 0.03, 0.3)
"""Sizes of the squares in V to begin with, for their mean size is that of V1 at 1."""

LEAST = 1e-6
"""Least such size of any term, for a step can multiply it only."""


class _Search:
    """What is made small over the sampled states, by the choice of (1, 1/k1, 1/k2, s1, s2)."""

    def __init__(self, sphere: SampledSphere, start: Sequence[float] | None) -> None:
        import numpy as np

        self.sphere, self.exponent = sphere, sphere.chain.exponent
        self.r, self.count = len(sphere.chain.gains), sphere.values.shape[1]
        signs = np.array(list(itertools.product((1.0, -1.0), repeat=self.r))).T
        self.start = np.empty((self.count, 0))
        if start is not None and any(start):
            box = np.array([[finite("start", size)] for size in start]) * signs
            self.start = np.concatenate(list(sphere.terms(box)[0]), axis=1)

    def merits(self, weights: "Array") -> "Array":
        """The logarithm of the time, or the worst ratio, for many weights: the less, the better."""
        import numpy as np

        worst = np.array([self.sphere.worst(row) for row in weights])
        if not self.start.size:
            return worst
        time = (1.0 - self.exponent) * np.log((weights @ self.start).max(axis=1))
        # Where V does not decrease there is no time, and the less it increases the better.
        return np.where(worst < 0.0, time - np.log(np.abs(worst) + 1e-300), 1e3 + worst)

    def begin(self) -> "Array":
        """Choose from the program's and a wide grid around weights that make V's terms alike."""
        import numpy as np

        size = self.sphere.values.mean(axis=(0, 2))
        alike = size[0] / size
        axes = np.outer(alike[1 : self.r], np.exp(np.linspace(-10.0, 10.0, 21)))
        shares = SHARES if self.count > self.r else (0.0,)
        squares = [alike[self.r :] * share for share in shares]
        grid = itertools.product(itertools.product([1.0], *axes), squares)
        solved = [np.maximum(found, LEAST * alike) for found in self.solve()]
        tried = np.array([*(np.append(*row) for row in grid), *solved])
        best: Array = tried[self.merits(tried).argmin()]
        return best

    def solve(self) -> "list[Array]":
        """Find weights with V̇ < 0 at all sampled states by the largest margin, if there are any."""
        import numpy as np
        from scipy.optimize import linprog

        rows = self.sphere.rates.transpose(0, 2, 1).reshape(-1, self.count)
        size = np.abs(rows).mean(axis=0)
        rows = rows / size
        rows /= np.abs(rows).max(axis=1, keepdims=True)
        found = linprog(
            np.append(np.zeros(self.count - 1), -1.0),
            A_ub=np.hstack([rows[:, 1:], np.ones((len(rows), 1))]),
            b_ub=-rows[:, 0],
            bounds=[(0.0, None)] * (self.count - 1) + [(None, 1.0)],
        )
        if found.x is None or found.x[-1] <= 0.0:
            return []
        return [np.append(1.0, found.x[:-1] * size[0] / size[1:])]

    def improve(self, weights: "Array") -> "Array":
        """Follow linear programs, in which tangents stand for the powers of V."""
        import numpy as np

        best = float(self.merits(weights[None])[0])
        shares = 0.5 ** np.arange(12)[:, None]
        for _ in range(STEPS):
            tried = weights + shares * (self.step(weights) - weights)
            merits = self.merits(tried)
            at = int(merits.argmin())
            if merits[at] > best - 1e-6:
                break
            weights, best = tried[at], float(merits[at])
        return weights

    def step(self, weights: "Array") -> "Array":
        """Solve one program: unknown are the weights' changes, the gain of the rate, and V."""
        import numpy as np
        from scipy.optimize import linprog

        a, c = self.exponent, -self.sphere.worst(weights)
        values = weights[:, None] * self.sphere.values
        value = values.sum(axis=1, keepdims=True)
        rows = weights[:, None] * self.sphere.rates / value**a + c * a * values / value
        rows = rows.transpose(0, 2, 1).reshape(-1, self.count)
        start = (weights[:, None] * self.start).T
        start = start / start.sum(axis=1).max(initial=1e-300)
        slack = np.zeros((len(rows) + len(start), 2))
        slack[: len(rows), 0], slack[len(rows) :, 1] = 1.0, -1.0
        both = np.vstack([rows, start])
        found = linprog(
            [0.0] * (self.count - 1) + [-1.0, (1.0 - a) * max(c, 0.0)],
            A_ub=np.hstack([both[:, 1:], slack]),
            b_ub=np.append(-rows[:, 0] - (1.0 - a) * c, -start[:, 0]),
            bounds=[TRUST] * (self.count - 1) + [(None, None), (0.0, None)],
        )
        if found.x is None:
            return weights
        changed: Array = weights * np.append(1.0, found.x[: self.count - 1])
        return changed


def seek(sphere: SampledSphere, start: Sequence[float] | None) -> "Array":
    """Seek the best weights over a sphere, to which the states are added that matter to them.

    Parameters
    ----------
    sphere : SampledSphere
        Sampled states of a chain of r integrators; changed.
    start : sequence of r floats, optional
        Largest absolute states at a start from which the time is made short. None, or all 0, makes
        the rate large.

    Returns
    -------
    array
        1, 1/k1, …, s1, ….

    Examples
    --------
    >>> from parkproof.proof.lyapunov import ChainLyapunov
    >>> sphere = SampledSphere(ChainLyapunov(gains=(1.5, 6.5), q=7 / 9, k=(1.0,)), [(1.0,)])
    >>> sphere.worst(seek(sphere, None)) < -1.5
    True
    """
    search = _Search(sphere, start)
    weights = search.begin()
    for _ in range(ROUNDS):
        weights = search.improve(weights)
        before, after = sphere.add_worse(weights)
        if after <= before + 2e-4 * abs(before):
            break
    return weights
