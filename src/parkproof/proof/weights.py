"""Seeks the weights of the Lyapunov functions by sampling; what it finds is for balls to prove.

A grid of weights and a linear program, which finds weights with V̇ < 0 at all sampled states
wherever there are any, say where to begin; further programs make the rate or the time better.
States at which the best weights do worse than at the sampled ones are added, until there are none.
"""

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.proof.lyapunov import ChainLyapunov
from parkproof.proof.states import SampledSphere
from parkproof.validate import finite, increasing, positive

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


class _Search:
    """What is made small over the sampled states, by the choice of (1, 1/k1, 1/k2)."""

    def __init__(self, sphere: SampledSphere, start: Sequence[float] | None) -> None:
        import numpy as np

        self.sphere, self.r, self.exponent = sphere, len(sphere.chain.gains), sphere.chain.exponent
        signs = np.array(list(itertools.product((1.0, -1.0), repeat=self.r))).T
        self.start = np.empty((self.r, 0))
        if start is not None and any(start):
            box = np.array([[finite("start", size)] for size in start]) * signs
            self.start = np.concatenate(list(sphere.terms(box)[0]), axis=1)

    def merits(self, inverses: "Array") -> "Array":
        """The logarithm of the time, or the worst ratio, for many weights: the less, the better."""
        import numpy as np

        worst = np.array([self.sphere.worst(row) for row in inverses])
        if not self.start.size:
            return worst
        time = (1.0 - self.exponent) * np.log((inverses @ self.start).max(axis=1))
        # Where V does not decrease there is no time, and the less it increases the better.
        return np.where(worst < 0.0, time - np.log(np.abs(worst) + 1e-300), 1e3 + worst)

    def begin(self) -> "Array":
        """Choose from the program's and a wide grid around weights that make V's terms alike."""
        import numpy as np

        size = self.sphere.values.mean(axis=(0, 2))
        axes = np.outer(size[0] / size[1:], np.exp(np.linspace(-10.0, 10.0, 21)))
        tried = np.array([*itertools.product([1.0], *axes), *self.solve()])
        best: Array = tried[self.merits(tried).argmin()]
        return best

    def solve(self) -> "list[Array]":
        """Find weights with V̇ < 0 at all sampled states by the largest margin, if there are any."""
        import numpy as np
        from scipy.optimize import linprog

        rows = self.sphere.rates.transpose(0, 2, 1).reshape(-1, self.r)
        size = np.abs(rows).mean(axis=0)
        rows = rows / size
        rows /= np.abs(rows).max(axis=1, keepdims=True)
        found = linprog(
            np.append(np.zeros(self.r - 1), -1.0),
            A_ub=np.hstack([rows[:, 1:], np.ones((len(rows), 1))]),
            b_ub=-rows[:, 0],
            bounds=[(0.0, None)] * (self.r - 1) + [(None, 1.0)],
        )
        if found.x is None or found.x.min() <= 0.0:
            return []
        return [np.append(1.0, found.x[:-1] * size[0] / size[1:])]

    def improve(self, inverses: "Array") -> "Array":
        """Follow linear programs, in which tangents stand for the powers of V."""
        import numpy as np

        best = float(self.merits(inverses[None])[0])
        shares = 0.5 ** np.arange(12)[:, None]
        for _ in range(STEPS):
            tried = inverses + shares * (self.step(inverses) - inverses)
            merits = self.merits(tried)
            at = int(merits.argmin())
            if merits[at] > best - 1e-6:
                break
            inverses, best = tried[at], float(merits[at])
        return inverses

    def step(self, inverses: "Array") -> "Array":
        """Solve one program: unknown are the weights' changes, the gain of the rate, and V."""
        import numpy as np
        from scipy.optimize import linprog

        a, c = self.exponent, -self.sphere.worst(inverses)
        values = inverses[:, None] * self.sphere.values
        value = values.sum(axis=1, keepdims=True)
        rows = inverses[:, None] * self.sphere.rates / value**a + c * a * values / value
        rows = rows.transpose(0, 2, 1).reshape(-1, self.r)
        start = (inverses[:, None] * self.start).T
        start = start / start.sum(axis=1).max(initial=1e-300)
        slack = np.zeros((len(rows) + len(start), 2))
        slack[: len(rows), 0], slack[len(rows) :, 1] = 1.0, -1.0
        both = np.vstack([rows, start])
        found = linprog(
            [0.0] * (self.r - 1) + [-1.0, (1.0 - a) * max(c, 0.0)],
            A_ub=np.hstack([both[:, 1:], slack]),
            b_ub=np.append(-rows[:, 0] - (1.0 - a) * c, -start[:, 0]),
            bounds=[TRUST] * (self.r - 1) + [(None, None), (0.0, None)],
        )
        if found.x is None:
            return inverses
        changed: Array = inverses * np.append(1.0, found.x[: self.r - 1])
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
        1, 1/k1, ….

    Examples
    --------
    >>> sphere = SampledSphere(ChainLyapunov(gains=(1.5, 6.5), q=7 / 9, k=(1.0,)), [(1.0,)])
    >>> sphere.worst(seek(sphere, None)) < -1.5
    True
    """
    search = _Search(sphere, start)
    inverses = search.begin()
    for _ in range(ROUNDS):
        inverses = search.improve(inverses)
        before, after = sphere.add_worse(inverses)
        if after <= before + 2e-4 * abs(before):
            break
    return inverses


def sphere_of(chain: ChainLyapunov, **ranges: Sequence[float]) -> SampledSphere:
    """Sample the sphere of a chain for the ends of its uncertain gains.

    Parameters
    ----------
    chain : ChainLyapunov
        The law and the form of V.
    **ranges : two floats each
        Ranges of the gains, in their order, by name.

    Returns
    -------
    SampledSphere
        The states.

    Raises
    ------
    InputError
        If a range is crossed or not positive.

    Examples
    --------
    >>> chain = ChainLyapunov(gains=(1.5, 6.5), q=7 / 9, k=(1.0,))
    >>> sphere_of(chain, a=(0.5, 1.5)).corners
    [(0.5,), (1.5,)]
    """
    ends = []
    for name, pair in ranges.items():
        low, high = increasing(name, pair)
        ends.append(sorted({positive(f"{name}'s lower bound", low), high}))
    return SampledSphere(chain, list(itertools.product(*ends)))


def _rounded(sphere: SampledSphere, inverses: "Array") -> tuple[tuple[float, ...], float]:
    """Weights of six digits, and their rate."""
    import numpy as np

    k = tuple(float(f"{weight:.6g}") for weight in 1.0 / inverses[1:])
    return k, -sphere.worst(1.0 / np.array([1.0, *k]))


def best_weights(
    gains: Gains,
    *,
    b1: Sequence[float],
    b2: Sequence[float] = (1.0, 1.0),
    varies: bool,
    start: Sequence[float] | None = (1.0, 0.0, 0.0),
) -> tuple[tuple[float, float], float]:
    """Seek the weights k1, k2 of Step 2 with the shortest sampled bound of the settling time.

    Parameters
    ----------
    gains : Gains
        The law; q1 and l are used.
    b1, b2 : two floats
        Ranges of b1 = α2|u0| in ẋ1 = b1·x2 and of b2 in ẋ2 = b2·u1, which may vary in time.
    varies : bool
        Whether b1 may vary in time, too; otherwise it is an unknown constant.
    start : three floats, optional
        Largest |x1|, |x2|, |u1| at the start. None makes the rate large instead of the time short.

    Returns
    -------
    tuple
        (k1, k2), and the sampled rate c; not positive if no weights were found.

    Raises
    ------
    InputError
        If a range is crossed or not positive, or the start is not three finite numbers.

    Examples
    --------
    >>> (k1, k2), rate = best_weights(Gains(q1="13/15"), b1=(0.5, 1.5), varies=False)
    >>> rate > 1.75
    True
    """
    if start is not None and len(start) != 3:
        raise InputError(
            f"start = {start}: must be three numbers, for x1, x2 and u1; "
            "write for example (1.0, 0.0, 0.0)"
        )
    chain = ChainLyapunov(
        gains=gains.l, q=gains.exponents[1], k=(1.0, 1.0), constant_alpha=not varies
    )
    sphere = sphere_of(chain, b1=b1, b2=b2)
    (k1, k2), rate = _rounded(sphere, seek(sphere, start))
    return (k1, k2), rate


def best_weights_two_chain(
    *, k: Sequence[float], q: float, a: Sequence[float], start: Sequence[float] | None = None
) -> tuple[float, float]:
    """Seek the weight k2 of Step 3's V = x²/2 + I/k2, for ẋ = a·u, u̇ = τ̃ and an a that may vary.

    Parameters
    ----------
    k : two floats
        Gains k̃1, k̃3 of the law.
    q : float
        Exponent in (1/2, 1).
    a : two floats
        Range of a.
    start : two floats, optional
        Largest |x|, |u| at a start from which the time is made short. Default: the rate is made
        large.

    Returns
    -------
    tuple
        k2, and the sampled rate c; not positive if no weight was found.

    Raises
    ------
    InputError
        If a gain is not positive, q or the start is out of range, or the range is crossed.

    Examples
    --------
    >>> k2, rate = best_weights_two_chain(k=(1.5, 6.5), q=7 / 9, a=(0.5, 1.5))
    >>> rate > 0.5
    True
    """
    if start is not None and len(start) != 2:
        raise InputError(
            f"start = {start}: must be two numbers, for x and u; write for example (1.0, 0.0)"
        )
    chain = ChainLyapunov(gains=k, q=q, k=(1.0,), constant_alpha=False)
    sphere = sphere_of(chain, a=a)
    (k2,), rate = _rounded(sphere, seek(sphere, start))
    return k2, rate
