"""Weights of the Lyapunov functions, found by sampling; they are for balls to prove.

V of Step 2 has the paper's terms with weights k1, k2. One may add s1·y2²/2 + s2·ξ2²/2, with
y2 = ⌈x2⌋^(1/q) and the law's ξ2: the input still never makes V grow, as Theorem 1 asks, because
∂V/∂u1 has the sign of ξ2. For the published gains that shortens the bound of the time by a third,
and covers an uncertain b2 as well.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.proof.lyapunov import ChainLyapunov
from parkproof.proof.seek import seek
from parkproof.proof.states import SampledSphere
from parkproof.validate import increasing, positive


@dataclass(frozen=True)
class Weights:
    """Weights of V of Step 2, with six digits, and what they were found to give.

    Attributes
    ----------
    k, s : two floats each
        k1, k2 of the paper's terms and s1, s2 of the squares.
    rate : float
        Sampled c; not positive if no weights were found.
    sizes : four floats
        Sampled largest y1²/V, y2²/V, y3²/V and ξ2²/V; none if not sampled.

    Examples
    --------
    >>> Weights(k=(4.28, 311.0), s=(0.0, 0.0), rate=1.24).rate
    1.24
    """

    k: tuple[float, float]
    s: tuple[float, float]
    rate: float
    sizes: tuple[float, ...] = ()


def sphere_of(
    chain: ChainLyapunov, *, squares: bool = False, **ranges: Sequence[float]
) -> SampledSphere:
    """Sample the sphere of a chain for the ends of its uncertain gains.

    Parameters
    ----------
    chain : ChainLyapunov
        The law and the form of V.
    squares : bool
        Whether V holds squares.
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
    return SampledSphere(chain, list(itertools.product(*ends)), squares=squares)


def _step2(
    gains: Gains,
    b1: Sequence[float],
    b2: Sequence[float],
    start: Sequence[float] | None,
    *,
    varies: bool,
    squares: bool,
) -> tuple[list[float], float, tuple[float, ...]]:
    """k1, k2, with squares also s1, s2, of six digits, their rate and sizes."""
    import numpy as np

    if start is not None and len(start) != 3:
        raise InputError(
            f"start = {start}: must be three numbers, for x1, x2 and u1; "
            "write for example (1.0, 0.0, 0.0)"
        )
    chain = ChainLyapunov(
        gains=gains.l, q=gains.exponents[1], k=(1.0, 1.0), constant_alpha=not varies
    )
    sphere = sphere_of(chain, squares=squares, b1=b1, b2=b2)
    found = seek(sphere, start)
    k = [float(f"{weight:.6g}") for weight in 1.0 / found[1:3]]
    s = [float(f"{weight:.6g}") for weight in found[3:]]
    weights = np.array([1.0, *(1.0 / weight for weight in k), *s])
    return [*k, *s], -sphere.worst(weights), tuple(sphere.sizes(weights).tolist())


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
    (k1, k2), rate, _ = _step2(gains, b1, b2, start, varies=varies, squares=False)
    return (k1, k2), rate


def best_weights_with_squares(
    gains: Gains,
    *,
    b1: Sequence[float],
    b2: Sequence[float] = (1.0, 1.0),
    varies: bool,
    start: Sequence[float] | None = (1.0, 0.0, 0.0),
) -> Weights:
    """Seek the weights k1, k2, s1, s2 of Step 2; as `best_weights`, but for V with squares.

    Parameters
    ----------
    gains, b1, b2, varies, start
        As in `best_weights`.

    Returns
    -------
    Weights
        The weights, the rate and the sizes.

    Raises
    ------
    InputError
        As `best_weights`.

    Examples
    --------
    The published gains, for which the paper's V never decreases everywhere where b2 is uncertain:

    >>> best_weights_with_squares(Gains(), b1=(0.5, 1.5), b2=(0.8, 1.25), varies=False).rate > 0.9
    True
    """
    (k1, k2, s1, s2), rate, sizes = _step2(gains, b1, b2, start, varies=varies, squares=True)
    return Weights((k1, k2), (s1, s2), rate, sizes)


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
    import numpy as np

    if start is not None and len(start) != 2:
        raise InputError(
            f"start = {start}: must be two numbers, for x and u; write for example (1.0, 0.0)"
        )
    chain = ChainLyapunov(gains=k, q=q, k=(1.0,), constant_alpha=False)
    sphere = sphere_of(chain, a=a)
    k2 = float(f"{1.0 / seek(sphere, start)[1]:.6g}")
    return k2, -sphere.worst(np.array([1.0, 1.0 / k2]))
