"""V of implicit-Lyapunov homogeneous control: which P define it, and how small it is followed.

With r = (3, 2, 1) for (x1, x2, u1), V > 0 solves z'Pz = 1 for z_i = x_i/V^(r_i). In w = 1/V that is
a polynomial of degree 6, g(w) = 1. It increases if P and HP + PH are positive definite,
H = diag(r), since w·g'(w) = z'(HP + PH)z.
"""

from collections.abc import Sequence

from parkproof.errors import InputError
from parkproof.validate import finite


def checked_ellipsoid(values: Sequence[float]) -> tuple[float, ...]:
    """Check that six numbers define V.

    Parameters
    ----------
    values : six floats
        P11, P12, P13, P22, P23, P33.

    Returns
    -------
    tuple of 6 floats
        The same numbers.

    Raises
    ------
    InputError
        If P or HP + PH is not positive definite.

    Examples
    --------
    >>> checked_ellipsoid((1, 0, 0, 1, 0, 1))
    (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    """
    p11, p12, p13, p22, p23, p33 = numbers = tuple(finite("ellipsoid", x) for x in values)
    weighted = (6.0 * p11, 5.0 * p12, 4.0 * p13, 4.0 * p22, 3.0 * p23, 2.0 * p33)
    for name, matrix in (("P", numbers), ("HP + PH with H = diag(3, 2, 1)", weighted)):
        if not _positive_definite(*matrix):
            raise InputError(
                f"ellipsoid = {list(numbers)}: the matrix {name} is not positive definite, so that "
                "V is not defined; write P11, P12, P13, P22, P23, P33 of a matrix P for which both "
                "P and HP + PH are, such as the one that a design gives"
            )
    return numbers


def _positive_definite(a: float, b: float, c: float, d: float, e: float, f: float) -> bool:
    """Whether the symmetric matrix of these six numbers is positive definite, by its minors."""
    two = a * d - b * b
    three = f * two - a * e * e + 2.0 * b * c * e - d * c * c
    return a > 0.0 and two > 0.0 and three > 0.0


def widest(ellipsoid: Sequence[float]) -> float:
    """Give how far V may lie below the largest of its values for single states, as a factor.

    With x_i alone, V^(r_i) = √P_ii·|x_i|; with other states beside it, at least |x_i|/√(P⁻¹)_ii.

    Parameters
    ----------
    ellipsoid : six floats
        P11, P12, P13, P22, P23, P33.

    Returns
    -------
    float
        At least 1, with a hundredth to spare for rounding.

    Examples
    --------
    >>> widest((1.0, 0.0, 0.0, 1.0, 0.0, 1.0))
    1.01
    """
    p11, p12, p13, p22, p23, p33 = ellipsoid
    minors = (p22 * p33 - p23 * p23, p11 * p33 - p13 * p13, p11 * p22 - p12 * p12)
    determinant = p11 * minors[0] - p12 * (p12 * p33 - p13 * p23) + p13 * (p12 * p23 - p13 * p22)
    factors = (p * minor / determinant for p, minor in zip((p11, p22, p33), minors, strict=True))
    powers = (1.0 / 6.0, 1.0 / 4.0, 1.0 / 2.0)
    largest: float = max(max(x, 1.0) ** power for x, power in zip(factors, powers, strict=True))
    return 1.01 * largest


def lowest_level(
    feedback: Sequence[float], gamma_max: float, period: float, lookahead: float
) -> float:
    """Give the level V_min below which V is not followed, as samples come too seldom.

    With V held at V_min the law is linear in the state. Over a period, γ times it carries u1 to
    (1 − γ·c)·u1 plus terms in the positions, c = h·|k3|/V_min. It then neither overshoots nor
    chatters for any γ ≤ γ^M where γ^M·c ≤ 1, half of the value at which u1 becomes unstable. If the
    positions are predicted, x2 + h·u1 adds h·k2/V_min² to k3/V_min; with
    V_min = h·(γ^M·|k3| + |k2/k3|) still 1 − (|k2/k3|·h/V_min)² ≤ 1.

    Parameters
    ----------
    feedback : three floats
        k, all negative.
    gamma_max : float
        γ^M of the second channel.
    period : float
        h in s.
    lookahead : float
        How far positions are predicted: h in the implicit form, else 0.

    Returns
    -------
    float
        V_min.

    Examples
    --------
    >>> lowest_level((-8.0, -8.0, -4.0), 2.0, 0.01, 0.0)
    0.08
    """
    _, k2, k3 = feedback
    return period * gamma_max * abs(k3) + lookahead * abs(k2 / k3)
