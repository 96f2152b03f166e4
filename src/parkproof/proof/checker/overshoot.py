"""Whether the first state of a chain of two comes back to 0 without passing it.

ẋ = b·u with 0 < b ≤ b^max, u̇ = τ̃ under the paper's law, with y = ⌈u⌋^(1/q), ξ = y + K1·x and, by
Theorem 1, −sign(ξ)·u̇ ≥ k̃3·|ξ|^(2q−1).

Where x > 0 and y = −K·x with K > K1, ξ = −(K − K1)·x < 0, so u̇ ≥ k̃3·((K − K1)·x)^(2q−1), and

    d(y + K·x)/dt = |y|^(1−q)·u̇/q + K·b·u
                  ≥ x^q·(K^(1−q)·k̃3·(K − K1)^(2q−1)/q − b^max·K^(1+q)) > 0

if k̃3·(K − K1)^(2q−1) > q·b^max·K^(2q). Then no motion leaves {x ≥ 0, y ≥ −K·x} but to rest: where
x = 0 and u > 0, x grows. K = 2q·K1 makes the condition weakest. A motion with x < 0 and u ≥ 0 keeps
u ≥ 0 until x = 0, as u = 0 means ξ < 0 and u̇ > 0 there, and x does not fall until then. So from
u ≥ 0 on, x ≥ min(x(0), 0), and by symmetry x ≤ max(x(0), 0) from u ≤ 0 on.
"""

from flint import arb

from parkproof.proof.checker.balls import largest, least
from parkproof.proof.checker.chains import Chain, TwoChain
from parkproof.proof.checker.links import Interval


def never_passes_zero(chain: Chain, highest: arb) -> bool:
    """Whether from u ≥ 0 on, x ≥ min(x(0), 0) is proved of a chain of two, and its mirror image.

    Parameters
    ----------
    chain : Chain
        The chain; for one of three nothing is proved.
    highest : arb
        b^max.

    Returns
    -------
    bool
        Whether K = 2q·K1 fulfils the condition.

    Examples
    --------
    >>> never_passes_zero(TwoChain("7/9", (1.5, 6.5), 2.6), arb("1.5"))
    True
    >>> never_passes_zero(TwoChain("7/9", (1.5, 2.5), 2.6), arb("1.5"))
    False
    """
    if not isinstance(chain, TwoChain):
        return False
    q, line = chain.q, chain.line
    steeper = 2 * q * line
    pushed = chain.input_gain * (steeper - line) ** chain.input_power
    return bool(pushed > q * highest * steeper ** (2 * q))


def reached(
    chain: Chain, highest: arb, far: arb, x: Interval, u: Interval, *, rest: arb
) -> Interval:
    """Range of the first state of a chain on its way to 0.

    Parameters
    ----------
    chain : Chain
        The chain.
    highest : arb
        b^max.
    far : arb
        Bound of |x| from V.
    x, u : tuples of 2 arb
        The start.
    rest : arb
        |x| that counts as rest: the range holds it, as room for what sampling leaves.

    Returns
    -------
    tuple of 2 arb
        The range.

    Examples
    --------
    >>> chain, ahead = TwoChain("7/9", (1.5, 6.5), 2.6), (arb("0.2"), arb(1))
    >>> low, high = reached(chain, arb("1.5"), arb(3), (arb(1), arb(2)), ahead, rest=arb("0.5"))
    >>> float(low), float(high)
    (-0.5, 3.0)
    """
    low, high, rest = least(-far, x[0]), largest(far, x[1]), least(far, rest)
    if never_passes_zero(chain, highest):
        if u[0] >= 0:
            low = least(-rest, x[0])
        if u[1] <= 0:
            high = largest(rest, x[1])
    return low, high
