"""Lyapunov functions of the paper's laws for chains of two and three integrators, enclosed.

Three (Step 2): ẋ1 = b1·x2, ẋ2 = b2·u1, u̇1 = τ̃, τ̃ = −l3⌈ξ2⌋^(3q−2), in the linearising coordinates
y1 = x1, y2 = ⌈x2⌋^(1/q), y3 = ⌈u1⌋^(1/(2q−1)), with ξ1 = y2 + L1·y1, ξ2 = y3 + L2·ξ1, and

    V = V1 + I(−L1·y1, y2; q)/k1 + I(−L2·ξ1, y3; 2q − 1)/k2.

Two (Step 3, holding, turning): ẋ = b·u, u̇ = τ̃, τ̃ = −k̃3⌈ξ⌋^(2q−1), y1 = x, y2 = ⌈u⌋^(1/q),
ξ = y2 + K1·y1, and V = V1 + I(−K1·y1, y2; q)/k2.

V1 = w·y1²/2, or y1²/(2·b1) where b1 is constant. V has degree 2 and V̇ degree 1 + q under the
dilation that multiplies every y by the same number, so what holds on a surface that every orbit
meets holds everywhere but at 0.
"""

from typing import Any

from flint import arb

from parkproof.proof.checker.balls import exact, power, size
from parkproof.proof.checker.kernels import Kernel

Box = tuple[arb, ...]


class ThreeChain:
    """Enclosures of V and V̇ of Step 2 on boxes of (y1, ξ1/L1, ξ2/(L1 L2)).

    Parameters
    ----------
    q : str
        q1 as a ratio.
    l : sequence of 3 floats
        Gains.
    k : sequence of 2 floats
        Weights k1, k2.
    w : float or None
        Weight of V1; None for V1 = y1²/(2·b1).

    Attributes
    ----------
    dimension : int
        3.
    q : arb
        Exponent; V̇ has degree 1 + q.
    degrees : tuple of arb
        Degrees of x1, x2, u1: |x| = |y|^degree.
    input_gain, input_power : arb
        |τ̃| = input_gain·|ξ2|^input_power.

    Examples
    --------
    >>> loop = ThreeChain("9/11", (2.0, 4.2, 21.0), (4.28, 311.0), None)
    >>> value, rate = loop.value_and_rate((arb(1), arb("0.3"), arb("-0.2")), arb("0.5"), arb(1))
    >>> round(float(value.mid()), 4), round(float(rate.mid()), 4)
    (1.0489, -2.8863)
    """

    dimension = 3

    def __init__(self, q: str, l: Any, k: Any, w: float | None) -> None:  # noqa: E741
        self.q = exact(q)
        e = 2 * self.q - 1
        l1, l2, l3 = (exact(gain) for gain in l)
        self.degrees = (arb(1), self.q, e)
        self.input_gain, self.input_power = l3, 3 * self.q - 2
        self._k1, self._k2 = (exact(weight) for weight in k)
        self._w = None if w is None else exact(w)
        self._L1, self._L2 = l1 ** (1 / self.q), l2 ** (1 / e)
        self._one, self._two = Kernel(self.q), Kernel(e)

    def coordinates(self, z: Box) -> tuple[tuple[arb, arb, arb], arb]:
        """Enclose (y1, y2, y3) and ξ2 on a box of (y1, ξ1/L1, ξ2/(L1 L2))."""
        y1, xi1, xi2 = z[0], z[1] * self._L1, z[2] * self._L1 * self._L2
        return (y1, xi1 - self._L1 * y1, xi2 - self._L2 * xi1), xi2

    def value(self, y: Box, b1: arb) -> arb:
        """Enclose V at (y1, y2, y3)."""
        xi1 = y[1] + self._L1 * y[0]
        first = y[0] * y[0] / (2 * b1) if self._w is None else self._w * y[0] * y[0] / 2
        one = self._one.i(-self._L1 * y[0], y[1])
        return first + one / self._k1 + self._two.i(-self._L2 * xi1, y[2]) / self._k2

    def value_and_rate(self, z: Box, b1: arb, b2: arb) -> tuple[arb, arb]:
        """Enclose V and V̇ on a box of (y1, ξ1/L1, ξ2/(L1 L2))."""
        q, L1, L2 = self.q, self._L1, self._L2
        (y1, y2, y3), xi2 = self.coordinates(z)
        xi1 = z[1] * L1
        x2, u1 = power(y2, q), power(y3, self.degrees[2])
        j1, j2 = self._one.j(-L1 * y1, y2), self._two.j(-L2 * xi1, y3)
        first = y1 * x2 if self._w is None else self._w * b1 * y1 * x2
        second = power(xi1, 2 - q) * b2 * u1 + b1 * (2 - q) * L1 * j1 * x2
        drift = power(size(y2), 1 - q) * b2 * u1 / q + b1 * L1 * x2
        third = (3 - 2 * q) * L2 * j2 * drift - self.input_gain * power(size(xi2), 1 + q)
        rate = first + second / self._k1 + third / self._k2
        return self.value((y1, y2, y3), b1), rate


class TwoChain:
    """Enclosures of V and V̇ of Step 3 and of holding, on boxes of (y1, ξ/K1).

    Parameters
    ----------
    q : str
        q2 as a ratio.
    k : sequence of 2 floats
        Gains k̃1, k̃3.
    k2 : float
        Weight; that of V1 is w = 1.

    Attributes
    ----------
    dimension : int
        2.
    q, degrees, input_gain, input_power
        As in `ThreeChain`.
    line : arb
        K1.

    Examples
    --------
    >>> loop = TwoChain("7/9", (1.5, 6.5), 2.6)
    >>> value, rate = loop.value_and_rate((arb(1), arb("0.3")), arb(1))
    >>> bool(value > 0), bool(rate < 0)
    (True, True)
    """

    dimension = 2

    def __init__(self, q: str, k: Any, k2: float) -> None:
        self.q = exact(q)
        k1, k3 = (exact(gain) for gain in k)
        self.degrees = (arb(1), self.q)
        self.input_gain, self.input_power = k3, 2 * self.q - 1
        self._k2 = exact(k2)
        self.line = k1 ** (1 / self.q)
        self._kernel = Kernel(self.q)

    def coordinates(self, z: Box) -> tuple[tuple[arb, arb], arb]:
        """Enclose (y1, y2) and ξ on a box of (y1, ξ/K1)."""
        xi = z[1] * self.line
        return (z[0], xi - self.line * z[0]), xi

    def value(self, y: Box, _: arb) -> arb:
        """Enclose V at (y1, y2); it does not depend on the gain."""
        return y[0] * y[0] / 2 + self._kernel.i(-self.line * y[0], y[1]) / self._k2

    def value_and_rate(self, z: Box, b: arb) -> tuple[arb, arb]:
        """Enclose V and V̇ on a box of (y1, ξ/K1)."""
        q, (y1, y2), xi = self.q, *self.coordinates(z)
        u = power(y2, q)
        inner = (2 - q) * self.line * b * u * self._kernel.j(-self.line * y1, y2)
        rate = b * y1 * u + (inner - self.input_gain * power(size(xi), 1 + q)) / self._k2
        return self.value((y1, y2), b), rate


Chain = ThreeChain | TwoChain
