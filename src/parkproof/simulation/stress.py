"""Truths that strain a law within its bounds: ends, adversaries, sines and square waves, seeded."""

import random
from collections.abc import Sequence

from parkproof.bounds import Bounds
from parkproof.model.signals import Adversary, Constant, Signal, Sine, Square
from parkproof.model.truth import Truth


def _between(low: float, high: float, draw: random.Random) -> Signal:
    """A gain within its bounds: an end, the adversary's, or one that moves between the ends."""
    mean, amplitude = 0.5 * (low + high), 0.5 * (high - low)
    if amplitude == 0.0:
        return Constant(low)
    kind = draw.choice(("low", "high", "adversary", "sine", "square"))
    if kind == "adversary":
        return Adversary()
    if kind in ("low", "high"):
        return Constant(low if kind == "low" else high)
    wave = Sine if kind == "sine" else Square
    omega, phase = 10.0 ** draw.uniform(-0.5, 1.7), draw.uniform(0.0, 6.28)
    # a hair inside, so that rounding does not leave the bounds
    return wave(mean=mean, amplitude=amplitude * (1.0 - 1e-12), omega=omega, phase=phase)


def _push(largest: float, draw: random.Random) -> Signal:
    """A disturbance of the largest size allowed."""
    if largest == 0.0:
        return Constant(0.0)
    kind = draw.choice(("adversary", "adversary", "constant", "sine", "square"))
    if kind == "adversary":
        return Adversary()
    if kind == "constant":
        return Constant(draw.choice((-largest, largest)))
    wave = Sine if kind == "sine" else Square
    omega, phase = 10.0 ** draw.uniform(-0.5, 1.7), draw.uniform(0.0, 6.28)
    return wave(amplitude=largest, omega=omega, phase=phase)


def stress_truths(bounds: Bounds, *, count: int, seed: int) -> Sequence[Truth]:
    """Draw truths within bounds, most of them at the bounds.

    Parameters
    ----------
    bounds : Bounds
        What is allowed.
    count : int
        How many.
    seed : int
        The same seed gives the same truths; each depends on the seed and its own number only.

    Returns
    -------
    sequence of Truth
        The truths.

    Examples
    --------
    >>> one, two = stress_truths(Bounds(alpha=(0.5, 1.5), b2=(0.8, 1.2)), count=2, seed=0)
    >>> one != two
    True
    >>> one.check(Bounds(alpha=(0.5, 1.5), b2=(0.8, 1.2)))
    """
    truths = []
    for i in range(count):
        draw = random.Random(f"{seed}:{i}")
        one, two = (_between(*bounds.gamma_of(j), draw) for j in range(2))
        push1, push2 = (_push(bounds.disturbance_of(j), draw) for j in range(2))
        along, across = (_between(*bounds.alpha_of(j), draw) for j in range(2))
        truths.append(
            Truth(
                alpha=(along, across),
                gamma=(one, two),
                disturbance=(push1, push2),
                b2=_between(*bounds.b2, draw),
            )
        )
    return truths
