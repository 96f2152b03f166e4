"""The integrals in the Lyapunov functions, in closed form and enclosed.

    I(a, y; n) = ∫_a^y ⌈s − a⌋^(2−n) n|s|^(n−1) ds,
    J(a, y; n) = ∫_a^y |s − a|^(1−n) n|s|^(n−1) ds.

J(a, y) grows with y and falls with a, and I grows as either end moves away from the other: their
values at corners enclose them on boxes.
"""

import math

from flint import arb

from parkproof.proof.checker.balls import down, up

GRID = 2.0**30
"""Ends of integrals are moved outwards to multiples of 1/GRID, so that none lies just beside 0."""


def _down(x: arb) -> float:
    return (math.floor(down(x) * GRID) - 1.0) / GRID


def _up(x: arb) -> float:
    return (math.ceil(up(x) * GRID) + 1.0) / GRID


class Kernel:
    """Enclosures of I and J for one exponent n.

    Parameters
    ----------
    n : arb
        Exponent in (0, 1).

    Examples
    --------
    >>> kernel = Kernel(arb(9) / 11)
    >>> bool(kernel.j(arb(-1), arb(1)) > 0), bool(kernel.i(arb(-1), arb(1)) > 0)
    (True, True)
    """

    def __init__(self, n: arb) -> None:
        self._n = n
        self._known: dict[tuple[float, float, int], arb] = {}

    def j(self, a: arb, y: arb) -> arb:
        """Enclose J(a, y)."""
        low = self._value(_up(a), _down(y), 1)
        return low.union(self._value(_down(a), _up(y), 1))

    def i(self, a: arb, y: arb) -> arb:
        """Enclose I(a, y), which is not negative."""
        a_low, a_high, y_low, y_high = _down(a), _up(a), _down(y), _up(y)
        one, two = self._value(a_high, y_low, 2), self._value(a_low, y_high, 2)
        if y_low >= a_high or y_high <= a_low:
            return one.union(two)
        return arb(0).union(one.union(two).abs_upper())

    def _value(self, a: float, y: float, kind: int) -> arb:
        """J (kind 1) or I (kind 2) at exact ends; I as the integral of a signed power is even."""
        key = (a, y, kind)
        if key not in self._known:
            length = arb(y) - arb(a)
            value = arb(0)
            if y != a:
                value = self._n * self._mean(kind - self._n, arb(a) / length) * length**kind
            self._known[key] = value
        return self._known[key]

    def _mean(self, mu: arb, rho: arb) -> arb:
        """∫_0^1 t^mu |rho + t|^(n−1) dt, in closed form by 2F1."""
        n = self._n
        if rho > 0:
            series = (-1 / rho).hypgeom_2f1(1 - n, mu + 1, mu + 2, ab=True)
            return rho ** (n - 1) / (mu + 1) * series
        r = -rho
        if r >= 1:
            return r ** (n - 1) / (mu + 1) * (1 / r).hypgeom_2f1(1 - n, mu + 1, mu + 2)
        if r.is_zero():
            return 1 / (mu + n)
        beta = (mu + 1).gamma() * n.gamma() / (mu + 1 + n).gamma()
        rest = (1 - r).hypgeom_2f1(-mu, 1, n + 1, abc=True)
        return r ** (mu + n) * beta + (1 - r) ** n / n * rest
