"""Step 2 under implicit-Lyapunov homogeneous control, in exact rationals.

The chain is ẋ1 = b1·x2, ẋ2 = b2·u1, u̇1 = γτ + φ, or ẋ = Ax + b(γτ + φ) for x = (x1, x2, u1), with
b1, b2 and γ anywhere in an interval each at any time, and |φ| ≤ φ^M. With H = diag(3, 2, 1) and
D(λ) = diag(λ³, λ², λ), V > 0 solves z'Pz = 1 for z = D(1/V)x, and the law is τ = kz.

**V is well defined, and its sublevel sets are ellipsoids.** If P > 0 and HP + PH > 0, then for
x ≠ 0 and w = 1/V the number x'D(w)PD(w)x increases with w from 0 to infinity, as its derivative is
z'(HP + PH)z/w > 0. So V is unique; V ≤ v means x'D(1/v)PD(1/v)x ≤ 1, an ellipsoid; and on a box V
is largest at a vertex. On V ≤ v, x = D(v)y with y'Py ≤ 1, so that |x_i| ≤ v^(r_i)·√(P⁻¹)_ii for
r = (3, 2, 1). As z'Pz = 1 at every state, |τ| = |kz| ≤ √(kP⁻¹k') at every state.

**V falls at least at a rate β.** D(1/V)AD(V) = A/V and D(1/V)b = b/V, so that
ż = (Az + b(γkz + φ))/V − (V̇/V)Hz. Differentiating z'Pz = 1,

    V̇·z'(HP + PH)z = 2z'P(A + γbk)z + 2z'Pbφ,    2z'Pbφ ≤ (φ^M²/ρ)·(z'Pb)² + ρ·z'Pz

for every ρ > 0, the last because 2cφ ≤ (φ^M c)²/ρ + ρ and z'Pz = 1. Hence V̇ ≤ −β where

    M = P(A + γbk) + (A + γbk)'P + (φ^M²/ρ)Pbb'P + ρP + β(HP + PH) ≤ 0.

M is affine in (b1, b2, γ), and (φ^M²/ρ)Pbb'P + ρP is convex in ρ, as a matrix. So with a ρ for each
end of γ's interval, and the value between them in proportion where γ lies between, M is at most the
mean of what it is at the vertices: if it is ≤ 0 there, it is ≤ 0 on the box. The inequality holds
at each moment by itself, so the gains may vary in any manner; and it is V that falls, so V reaches
0 within V(x(0))/β.
"""

import itertools
import math
from collections.abc import Sequence
from fractions import Fraction

from flint import arb, fmpq, fmpq_mat

Exact = int | float | Fraction | fmpq
"""A number taken exactly as it is; a float means its binary value."""

Interval = tuple[Exact, Exact]
Rho = Exact | Interval
End = float | arb

DEGREES = (3, 2, 1)
"""Weights of (x1, x2, u1)."""

_SLACK = 1e-9
"""What a level is raised by, relatively, above what floating point found."""


def rational(value: Exact) -> fmpq:
    """Take a number exactly.

    Parameters
    ----------
    value : int, float, Fraction or fmpq
        The number.

    Returns
    -------
    fmpq
        The same number.

    Examples
    --------
    >>> rational(0.25)
    1/4
    """
    if isinstance(value, fmpq):
        return value
    ratio = Fraction(value)
    return fmpq(ratio.numerator, ratio.denominator)


def positive_definite(matrix: fmpq_mat) -> bool:
    """Whether a symmetric 3 × 3 matrix is positive definite, by its leading minors.

    Parameters
    ----------
    matrix : fmpq_mat
        The matrix.

    Returns
    -------
    bool
        Exactly whether.

    Examples
    --------
    >>> positive_definite(fmpq_mat(3, 3, [2, 1, 0, 1, 2, 0, 0, 0, 1]))
    True
    """
    return all(_minor(matrix, range(size)) > 0 for size in (1, 2, 3))


def not_positive(matrix: fmpq_mat) -> bool:
    """Whether a symmetric 3 × 3 matrix is negative semidefinite, by all its principal minors.

    Parameters
    ----------
    matrix : fmpq_mat
        The matrix.

    Returns
    -------
    bool
        Exactly whether.

    Examples
    --------
    >>> not_positive(fmpq_mat(3, 3, [-1, 1, 0, 1, -1, 0, 0, 0, 0]))
    True
    """
    return all(
        _minor(-matrix, rows) >= 0
        for size in (1, 2, 3)
        for rows in itertools.combinations(range(3), size)
    )


def _minor(matrix: fmpq_mat, rows: Sequence[int]) -> fmpq:
    """The principal minor of some rows."""
    entries = [matrix[i, j] for i in rows for j in rows]
    return fmpq_mat(len(rows), len(rows), entries).det()


class Ellipsoid:
    """V and the law of Step 2, of the exact binary values of floats.

    Parameters
    ----------
    P : six floats
        P11, P12, P13, P22, P23, P33 of the symmetric matrix P.
    k : three floats
        The law's k.

    Examples
    --------
    >>> ellipsoid = Ellipsoid((2.0, 1.5, 0.25, 2.0, 0.5, 0.25), (-8.0, -8.0, -4.0))
    >>> ellipsoid.sound()
    True
    """

    def __init__(self, P: Sequence[float], k: Sequence[float]) -> None:
        p11, p12, p13, p22, p23, p33 = (rational(value) for value in P)
        self._P = fmpq_mat(3, 3, [p11, p12, p13, p12, p22, p23, p13, p23, p33])
        self._k = fmpq_mat(1, 3, [rational(value) for value in k])
        H = fmpq_mat(3, 3, [3, 0, 0, 0, 2, 0, 0, 0, 1])
        self._HP = H * self._P + self._P * H
        self._floats = [
            [float(Fraction(int(x.p), int(x.q))) for x in (self._P[i, j] for j in range(3))]
            for i in range(3)
        ]

    def sound(self) -> bool:
        """Whether V is well defined: P > 0 and HP + PH > 0.

        Returns
        -------
        bool
            Exactly whether.

        Examples
        --------
        >>> Ellipsoid((1.0, 2.0, 0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 0.0)).sound()
        False
        """
        return positive_definite(self._P) and positive_definite(self._HP)

    def prove_rate(
        self, rate: Exact, rho: Rho, b1: Interval, b2: Interval, gamma: Interval, phi: Exact
    ) -> bool:
        """Prove that V falls at least at a rate, whatever the gains do in their intervals.

        Parameters
        ----------
        rate : float
            β.
        rho : float or pair of floats
            ρ > 0 of the matrix inequality, one for both ends of γ's interval or one for each; any
            number where phi = 0.
        b1, b2, gamma : pairs of numbers
            Ends of the intervals of b1, b2 and γ.
        phi : float
            φ^M ≥ 0.

        Returns
        -------
        bool
            True if V̇ ≤ −β is proved.

        Examples
        --------
        >>> ellipsoid = Ellipsoid((2.0, 1.5, 0.25, 2.0, 0.5, 0.25), (-8.0, -8.0, -4.0))
        >>> one = (1.0, 1.0)
        >>> [ellipsoid.prove_rate(rate, 0.0, one, one, one, 0.0) for rate in (0.1, 1.0)]
        [True, False]
        """
        bound = rational(phi)
        weights = [rational(end) for end in (rho if isinstance(rho, tuple | list) else (rho, rho))]
        if not self.sound() or bound < 0 or (bound > 0 and min(weights) <= 0):
            return False
        fixed = rational(rate) * self._HP
        for at_gamma, weight in zip(gamma, weights, strict=True):
            added = fixed + self._pushed(bound, weight) if bound > 0 else fixed
            for vertex in itertools.product(map(rational, b1), map(rational, b2)):
                if not not_positive(added + self._flow(*vertex, rational(at_gamma))):
                    return False
        return True

    def _pushed(self, bound: fmpq, weight: fmpq) -> fmpq_mat:
        """(φ^M²/ρ)Pbb'P + ρP."""
        Pb = fmpq_mat(3, 1, [self._P[i, 2] for i in range(3)])
        return (bound * bound / weight) * (Pb * Pb.transpose()) + weight * self._P

    def _flow(self, b1: fmpq, b2: fmpq, gamma: fmpq) -> fmpq_mat:
        """P(A + γbk) + (A + γbk)'P."""
        k = self._k
        loop = fmpq_mat(
            3, 3, [0, b1, 0, 0, 0, b2, gamma * k[0, 0], gamma * k[0, 1], gamma * k[0, 2]]
        )
        half = self._P * loop
        return half + half.transpose()

    def level(self, box: Sequence[tuple[End, End]]) -> arb:
        """Give an upper bound of V over a box, which is reached at a vertex.

        Parameters
        ----------
        box : three pairs of floats or balls
            Lowest and highest x1, x2, u1.

        Returns
        -------
        arb
            A number that V nowhere exceeds on the box; infinite if V is not well defined.

        Examples
        --------
        >>> ellipsoid = Ellipsoid((1.0, 0.0, 0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 0.0))
        >>> round(float(ellipsoid.level([(-8.0, 8.0), (0.0, 0.0), (0.0, 0.0)])), 6)
        2.0
        """
        ends = [(arb(low).lower(), arb(high).upper()) for low, high in box]
        if all(end == 0 for pair in ends for end in pair):
            return arb(0)
        vertices = list(itertools.product(*ends))
        if not self.sound() or not all(end.is_finite() for pair in ends for end in pair):
            return arb("inf")
        found = max(self._value([float(x) for x in vertex]) for vertex in vertices)
        slack = _SLACK
        while True:
            level = arb(found * (1.0 + slack))
            if all(self._inside(vertex, level) for vertex in vertices):
                return level
            slack *= 4.0

    def _value(self, x: Sequence[float]) -> float:
        """V in floating point, by bisection of its logarithm."""
        low, high = -690.0, 690.0
        while high - low > 1e-12 * max(1.0, abs(low)):
            middle = 0.5 * (low + high)
            scale = math.exp(-middle) if middle > -230.0 else math.inf
            z = [xi * scale**degree if xi else 0.0 for xi, degree in zip(x, DEGREES, strict=True)]
            if max(map(abs, z)) > 1e100 or self._form(z) > 1.0:
                low = middle
            else:
                high = middle
        return math.exp(high)

    def _form(self, z: Sequence[float]) -> float:
        return sum(z[i] * self._floats[i][j] * z[j] for i in range(3) for j in range(3))

    def _inside(self, x: Sequence[arb], level: arb) -> bool:
        """Whether V ≤ level is proved at a point."""
        z = [xi / level**degree for xi, degree in zip(x, DEGREES, strict=True)]
        form = sum((z[i] * arb(self._P[i, j]) * z[j] for i in range(3) for j in range(3)), arb(0))
        return bool(form <= 1)

    def sizes(self, level: arb) -> tuple[arb, arb, arb]:
        """Give bounds of the states where V is at most a level.

        Parameters
        ----------
        level : arb
            The level, not negative.

        Returns
        -------
        tuple of 3 arb
            Bounds of |x1|, |x2|, |u1|.

        Examples
        --------
        >>> ellipsoid = Ellipsoid((1.0, 0.0, 0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 0.0))
        >>> [float(size) for size in ellipsoid.sizes(arb(2))]
        [8.0, 4.0, 2.0]
        """
        inverse = self._P.inv()
        one, two, three = (
            (arb(inverse[i, i]).sqrt() * level**degree).upper() for i, degree in enumerate(DEGREES)
        )
        return one, two, three

    def input_bound(self) -> arb:
        """Give a bound of |τ| at every state.

        Returns
        -------
        arb
            An upper bound of √(kP⁻¹k').

        Examples
        --------
        >>> float(Ellipsoid((1.0, 0.0, 0.0, 1.0, 0.0, 1.0), (0.0, 3.0, 4.0)).input_bound())
        5.0
        """
        square = (self._k * self._P.inv() * self._k.transpose())[0, 0]
        return arb(square).sqrt().upper()
