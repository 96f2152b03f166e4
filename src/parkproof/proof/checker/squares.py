"""V of Step 2 with two squares added, enclosed.

    V = V1 + I(−L1·y1, y2; q)/k1 + I(−L2·ξ1, y3; 2q − 1)/k2 + s1·y2²/2 + s2·ξ2²/2.

The first three terms are those of `ThreeChain`, and s1, s2 ≥ 0. With y2 = ⌈x2⌋^(1/q) and
y3 = ⌈u1⌋^(1/(2q−1)),

    d(y2²/2)/dt = ⌈y2⌋^(2−q)·b2·u1/q,
    d(ξ2²/2)/dt = ξ2·L2·(|y2|^(1−q)·b2·u1/q + L1·b1·x2) − l3·|y3|^(2−2q)·|ξ2|^(3q−1)/(2q − 1).

V stays continuously differentiable, of degree 2 and positive; V's dependence on b1 is the same, and
V̇ stays affine in b1 and b2. ∂(ξ2²/2)/∂u1 = ξ2·|y3|^(2−2q)/(2q − 1) has the sign of ξ2 or is 0, so
that ∂V/∂u1 still has the sign of ξ2 and Theorem 1 holds.
"""

from typing import Any

from flint import arb

from parkproof.proof.checker.balls import exact, power, size
from parkproof.proof.checker.chains import Box, ThreeChain


class ThreeChainWithSquares(ThreeChain):
    """Enclosures of V and V̇ of Step 2 on boxes of (y1, ξ1/L1, ξ2/(L1 L2)).

    Parameters
    ----------
    q, l, k, w
        As in `ThreeChain`.
    s : sequence of 2 floats
        Weights s1, s2 of the squares, not negative.

    Examples
    --------
    >>> loop = ThreeChainWithSquares("9/11", (2.0, 4.2, 21.0), (5.27, 584.0), None, (0.02, 4e-5))
    >>> value, rate = loop.value_and_rate((arb(1), arb("0.3"), arb("-0.2")), arb("0.5"), arb(1))
    >>> bool(value > 1), bool(rate < -1)
    (True, True)
    """

    def __init__(self, q: str, l: Any, k: Any, w: float | None, s: Any) -> None:  # noqa: E741
        super().__init__(q, l, k, w)
        self._s1, self._s2 = (exact(weight) for weight in s)

    def value(self, y: Box, b1: arb) -> arb:
        """Enclose V at (y1, y2, y3)."""
        xi2 = y[2] + self._L2 * (y[1] + self._L1 * y[0])
        return super().value(y, b1) + self._squares(y[1], xi2)

    def value_and_rate(self, z: Box, b1: arb, b2: arb) -> tuple[arb, arb]:
        """Enclose V and V̇ on a box of (y1, ξ1/L1, ξ2/(L1 L2))."""
        q, e, y, xi2 = self.q, self.degrees[2], *self.coordinates(z)
        x2, u1 = power(y[1], q), power(y[2], e)
        _, rate = super().value_and_rate(z, b1, b2)
        stretch = power(size(y[1]), 1 - q) * b2 * u1 / q
        falls = self.input_gain * power(size(y[2]), 1 - e) * power(size(xi2), 3 * q - 1) / e
        rate += self._s1 * power(y[1], 2 - q) * b2 * u1 / q
        rate += self._s2 * (xi2 * self._L2 * (stretch + self._L1 * b1 * x2) - falls)
        # ξ2 is given by the box: sums of the y's would enclose it less tightly.
        return super().value(y, b1) + self._squares(y[1], xi2), rate

    def _squares(self, y2: arb, xi2: arb) -> arb:
        return (self._s1 * size(y2) ** 2 + self._s2 * size(xi2) ** 2) / 2
