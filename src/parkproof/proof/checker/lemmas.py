"""What is proved of one chain: a rate, sizes on sublevel sets, and the times that follow.

With V̇ ≤ −c·V^((1+q)/2), Lemma 1 takes V from a level A to a level B in at most
2(A^((1−q)/2) − B^((1−q)/2))/(c(1−q)).

Ends of the gains suffice for the rate: V̇ is affine in each; for a constant b1, V = A/b1 + B and so
V^((1+q)/2) is convex in b1, and −V̇ − c·V^((1+q)/2) is concave.
"""

import itertools
from collections.abc import Sequence

from flint import arb

from parkproof.proof.checker.balls import (
    MAX_BOXES,
    Range,
    down,
    exact,
    largest,
    least,
    point_power,
    power,
    prove_on_surface,
    size,
    up,
    upper_bound,
)
from parkproof.proof.checker.chains import Chain


def prove_rate(chain: Chain, rate: float, gains: Sequence[Range]) -> int:
    """Prove V̇ < −rate·V^((1+q)/2) for all states but 0 and all gains of their ranges.

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        V and V̇.
    rate : float
        c > 0.
    gains : sequence of pairs
        Ranges of the gains of `value_and_rate`.

    Returns
    -------
    int
        Number of boxes looked at; 0 if it was not proved.

    Examples
    --------
    >>> from parkproof.proof.checker.chains import TwoChain
    >>> prove_rate(TwoChain("7/9", (1.5, 6.5), 2.6), 0.5, [(0.5, 1.5)]) > 0
    True
    """
    c, exponent = exact(rate), (1 + chain.q) / 2
    looked = 0
    for corner in itertools.product(*(sorted(set(pair)) for pair in gains)):
        ends = [exact(end) for end in corner]

        def falls(z: tuple[arb, ...], ends: list[arb] = ends) -> bool:
            value, slope = chain.value_and_rate(z, *ends)
            return bool(slope + c * point_power(value.upper(), exponent) < 0)

        boxes = prove_on_surface(chain.dimension, falls, budget=MAX_BOXES - looked)
        if boxes == 0:
            return 0
        looked += boxes
    return looked


def prove_sizes(chain: Chain, sizes: Sequence[float], b1: float = 1.0) -> int:
    """Prove y_i² ≤ sizes[i]·V for every coordinate, and ξ² ≤ sizes[−1]·V, at all states.

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        V.
    sizes : sequence of floats
        One for each coordinate, and one for ξ, of which the input is a power.
    b1 : float
        Gain, where V depends on it.

    Returns
    -------
    int
        Number of boxes looked at; 0 if it was not proved.

    Examples
    --------
    >>> from parkproof.proof.checker.chains import TwoChain
    >>> prove_sizes(TwoChain("7/9", (1.5, 6.5), 2.6), (2.1, 20.0, 20.0)) > 0
    True
    """
    factors, gain = [exact(number) for number in sizes], exact(b1)

    def within(z: tuple[arb, ...]) -> bool:
        y, xi = chain.coordinates(z)
        value = chain.value(y, gain).lower()
        return all(
            size(x).upper() ** 2 <= factor * value
            for x, factor in zip((*y, xi), factors, strict=True)
        )

    return prove_on_surface(chain.dimension, within)


def level_of(chain: Chain, box: Sequence[tuple[arb, arb]], b1: float = 1.0) -> arb:
    """A proven upper bound of V over a box of states.

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        V.
    box : sequence of pairs of arb
        Ranges of the states.
    b1 : float
        Gain, where V depends on it.

    Returns
    -------
    arb
        The bound.

    Examples
    --------
    >>> from parkproof.proof.checker.chains import TwoChain
    >>> chain = TwoChain("7/9", (1.5, 6.5), 2.6)
    >>> bool(level_of(chain, [(arb(-1), arb(1)), (arb(0), arb(0))]) < 1.7)
    True
    """
    gain = exact(b1)
    ends = [(down(low), up(high)) for low, high in box]

    def value(states: tuple[arb, ...]) -> arb:
        y = tuple(power(x, 1 / r) for x, r in zip(states, chain.degrees, strict=True))
        return chain.value(y, gain)

    return upper_bound(value, ends)


def seconds(chain: Chain, rate: float, start: arb, end: arb) -> arb:
    """An upper bound of the time that V needs from one level to another.

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        The chain.
    rate : float
        A proved c.
    start, end : arb
        Levels; end may be 0.

    Returns
    -------
    arb
        The time in s.

    Examples
    --------
    >>> from parkproof.proof.checker.chains import TwoChain
    >>> chain = TwoChain("7/9", (1.5, 6.5), 2.6)
    >>> bool(seconds(chain, 0.5, arb(1), arb(0)) < 18.01)
    True
    """
    half = (1 - chain.q) / 2
    fall = point_power(start.upper(), half) - point_power(end.lower(), half)
    return largest(arb(0), fall / (half * exact(rate)))


def state_bounds(chain: Chain, sizes: Sequence[float], level: arb) -> list[arb]:
    """Upper bounds of the absolute states where V is at most a level.

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        The chain.
    sizes : sequence of floats
        Proved sizes.
    level : arb
        Level of V.

    Returns
    -------
    list of arb
        One for each state.

    Examples
    --------
    >>> from parkproof.proof.checker.chains import TwoChain
    >>> chain = TwoChain("7/9", (1.5, 6.5), 2.6)
    >>> [bool(bound < 5) for bound in state_bounds(chain, (2.1, 20.0, 20.0), arb(1))]
    [True, True]
    """
    top = level.upper()
    return [
        point_power((exact(factor) * top).upper(), r / 2).upper()
        for factor, r in zip(sizes, chain.degrees, strict=False)
    ]


def input_bound(chain: Chain, sizes: Sequence[float], level: arb) -> arb:
    """Upper bound of |τ̃| where V is at most a level.

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        The chain.
    sizes : sequence of floats
        Proved sizes; the last is that of ξ.
    level : arb
        Level of V.

    Returns
    -------
    arb
        The bound.

    Examples
    --------
    >>> from parkproof.proof.checker.chains import TwoChain
    >>> chain = TwoChain("7/9", (1.5, 6.5), 2.6)
    >>> bool(input_bound(chain, (2.1, 20.0, 20.0), arb(1)) < 15)
    True
    """
    top = (exact(sizes[-1]) * level.upper()).upper()
    return (chain.input_gain * point_power(top, chain.input_power / 2)).upper()


def inner_level(chain: Chain, sizes: Sequence[float], tolerance: arb) -> arb:
    """A level of V below which every state is within a tolerance.

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        The chain.
    sizes : sequence of floats
        Proved sizes.
    tolerance : arb
        Bound of the absolute states.

    Returns
    -------
    arb
        The level.

    Examples
    --------
    >>> from parkproof.proof.checker.chains import TwoChain
    >>> chain = TwoChain("7/9", (1.5, 6.5), 2.6)
    >>> bool(inner_level(chain, (2.1, 20.0, 20.0), arb("0.1")) > 0)
    True
    """
    edge = tolerance.lower()
    levels = [
        (point_power(edge, 2 / r) / exact(factor)).lower()
        for factor, r in zip(sizes, chain.degrees, strict=False)
    ]
    return least(*levels)


def first_integral(chain: Chain, sizes: Sequence[float], rate: float, level: arb) -> arb:
    """Upper bound of ∫|first state| dt from a level of V on, to 0.

    |y1| ≤ (sizes[0]·V)^(1/2) and dt ≤ −dV/(c·V^((1+q)/2)) give sizes[0]^(1/2)·V^(1−q/2)/(c(1−q/2)).

    Parameters
    ----------
    chain : ThreeChain or TwoChain
        The chain.
    sizes : sequence of floats
        Proved sizes.
    rate : float
        A proved c.
    level : arb
        Level of V at the start.

    Returns
    -------
    arb
        The bound.

    Examples
    --------
    >>> from parkproof.proof.checker.chains import TwoChain
    >>> chain = TwoChain("7/9", (1.5, 6.5), 2.6)
    >>> bool(first_integral(chain, (2.1, 20.0, 20.0), 0.5, arb(1)) < 5)
    True
    """
    power_of_level = 1 - chain.q / 2
    top = exact(sizes[0]).sqrt() * point_power(level.upper(), power_of_level)
    return (top / (exact(rate) * power_of_level)).upper()
