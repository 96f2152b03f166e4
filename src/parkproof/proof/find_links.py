"""Finds what a certificate proposes of each chain: weights, rates and sizes, by sampling.

Nothing here is trusted: `parkproof.proof.checker` proves or refuses what is found.
"""

import itertools
from collections.abc import Sequence
from typing import Any

from parkproof.laws.gains import Gains
from parkproof.proof.checker.balls import Range, exact
from parkproof.proof.checker.chains import Chain, TwoChain
from parkproof.proof.checker.lemmas import prove_rate, prove_sizes
from parkproof.proof.checker.squares import ThreeChainWithSquares
from parkproof.proof.weights import best_weights_two_chain, best_weights_with_squares
from parkproof.validate import Ratio

SHARES = (0.97, 0.9, 0.75, 0.5)
"""Shares of a sampled rate that are tried in turn: the nearer to 1, the more boxes."""

SLACKS = (1.02, 1.1, 1.3)
"""Multiples of sampled sizes that are tried in turn."""


def surface_points(dimension: int, count: int) -> list[tuple[float, ...]]:
    """Points on the faces z_i = 1 of a cube.

    Parameters
    ----------
    dimension : int
        Of the space.
    count : int
        Points along an edge.

    Returns
    -------
    list of tuples
        The points.

    Examples
    --------
    >>> len(surface_points(2, 5))
    10
    """
    edge = [-1.0 + 2.0 * i / (count - 1) for i in range(count)]
    return [
        (*sides[:face], 1.0, *sides[face:])
        for face in range(dimension)
        for sides in itertools.product(edge, repeat=dimension - 1)
    ]


def sampled_sizes(chain: Chain, *, count: int) -> list[float]:
    """The largest y_i²/V and ξ²/V at sampled points.

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        V.
    count : int
        Points along an edge of the cube.

    Returns
    -------
    list of floats
        One for each coordinate, and one for ξ.

    Examples
    --------
    >>> sizes = sampled_sizes(TwoChain("7/9", (1.5, 6.5), 2.6), count=41)
    >>> round(sizes[0], 2)
    2.0
    """
    found = [0.0] * (chain.dimension + 1)
    one = exact(1)
    for point in surface_points(chain.dimension, count):
        y, xi = chain.coordinates(tuple(exact(x) for x in point))
        value = float(chain.value(y, one).mid())
        found = [max(a, float(x.mid()) ** 2 / value) for a, x in zip(found, (*y, xi), strict=True)]
    return found


def proved_sizes(chain: Chain, *, count: int) -> list[float] | None:
    """Sizes of sublevel sets, sampled, given some slack, and proved.

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        V.
    count : int
        Points along an edge of the cube.

    Returns
    -------
    list of floats or None
        The sizes; None if none was proved.

    Examples
    --------
    >>> len(proved_sizes(TwoChain("7/9", (1.5, 6.5), 2.6), count=41))
    3
    """
    sampled = sampled_sizes(chain, count=count)
    for slack in SLACKS:
        sizes = [float(f"{slack * size:.6g}") for size in sampled]
        if prove_sizes(chain, sizes) > 0:
            return sizes
    return None


def proved_rate(chain: Chain, gains: Sequence[Range], sampled: float) -> float | None:
    """The largest share of a sampled rate that is proved.

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        V and V̇.
    gains : sequence of pairs
        Ranges of the gains.
    sampled : float
        What sampling left possible.

    Returns
    -------
    float or None
        c; None if none was proved.

    Examples
    --------
    >>> proved_rate(TwoChain("7/9", (1.5, 6.5), 2.6), [(0.5, 1.5)], -1.0) is None
    True
    """
    if sampled <= 0.0:
        return None
    for share in SHARES:
        rate = float(f"{share * sampled:.6g}")
        if prove_rate(chain, rate, gains) > 0:
            return rate
    return None


def two_chain_link(q: str, k: tuple[float, float], gains: Range) -> dict[str, Any] | None:
    """Find and prove the Lyapunov function of a two-chain.

    Parameters
    ----------
    q : str
        q2 as a ratio.
    k : pair of floats
        Gains k̃1, k̃3.
    gains : pair of floats
        Range of b in ẋ = b·u.

    Returns
    -------
    dict or None
        Weight k2, rate and sizes; None if V falls for no weight tried.

    Examples
    --------
    >>> two_chain_link("7/9", (1.5, 6.5), (0.5, 1.5))["rate"] > 1.0
    True
    """
    found, sampled = best_weights_two_chain(k=k, q=Ratio(q, "q2"), a=gains, start=(1.0, 0.0))
    weight = float(f"{found:.6g}")
    chain = TwoChain(q, k, weight)
    rate = proved_rate(chain, [gains], sampled)
    sizes = proved_sizes(chain, count=201)
    if rate is None or sizes is None:
        return None
    return {"k2": weight, "rate": rate, "sizes": sizes}


def sampled_approach_link(
    gains: Gains, ranges: Sequence[Range], *, start: Sequence[float] = (1.0, 0.0, 0.0)
) -> dict[str, Any] | None:
    """What `approach_link` would find at best, by sampling alone; for comparisons, never a proof.

    Parameters
    ----------
    gains, ranges, start
        As in `approach_link`.

    Returns
    -------
    dict or None
        Weights, rate and sizes as they would be tried first; None if V falls for no weights tried.

    Examples
    --------
    >>> link = sampled_approach_link(Gains(q1="13/15"), [(0.5, 1.5), (1.0, 1.0)])
    >>> link["rate"] > 1.5
    True
    """
    found = best_weights_with_squares(gains, b1=ranges[0], b2=ranges[1], varies=True, start=start)
    if not found.rate > 0.0:
        return None
    return {
        "k": list(found.k),
        "s": list(found.s),
        "rate": SHARES[0] * found.rate,
        "sizes": [SLACKS[0] * size for size in found.sizes],
    }


def approach_link(
    gains: Gains, ranges: Sequence[Range], *, start: Sequence[float] = (1.0, 0.0, 0.0)
) -> dict[str, Any] | None:
    """Find and prove the Lyapunov function of Step 2, for gains that vary in time.

    Parameters
    ----------
    gains : Gains
        q1 and l are used.
    ranges : two pairs
        Ranges of b1 and b2.
    start : three floats
        |x1|, |x2| and |u1| from which the time is made short.

    Returns
    -------
    dict or None
        Weights, rate and sizes; None if V falls for no weights tried.

    Examples
    --------
    >>> approach_link(Gains(q1="13/15", l=(1.0, 1.0, 1.0)), [(0.25, 1.5), (1.0, 1.0)]) is None
    True
    """
    b1, b2 = ranges
    found = best_weights_with_squares(gains, b1=b1, b2=b2, varies=True, start=start)
    if found.rate <= 0.0:
        return None
    chain = ThreeChainWithSquares(str(gains.exponents[1]), gains.l, found.k, 1.0, found.s)
    rate = proved_rate(chain, ranges, found.rate)
    sizes = proved_sizes(chain, count=33) if rate is not None else None
    if rate is None or sizes is None:
        return None
    return {"k": list(found.k), "s": list(found.s), "rate": rate, "sizes": sizes}
