"""The rate at which V falls with given gains of homogeneous control: found in floats and proved."""

import itertools
import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from parkproof.extras import require

Floats = NDArray[np.float64]
Three = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]
Interval = tuple[float, float]

H = np.diag([3.0, 2.0, 1.0])
"""Weights of (x1, x2, u1)."""

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Places of P11, P12, P13, P22, P23, P33."""


def proven_rate(
    ellipsoid: Six,
    feedback: Three,
    *,
    b1: Interval,
    b2: Interval = (1.0, 1.0),
    gamma: Interval = (1.0, 1.0),
    disturbance: float = 0.0,
) -> tuple[float, Interval] | None:
    """Prove how fast V falls with given gains.

    Parameters
    ----------
    ellipsoid : six floats
        P11, P12, P13, P22, P23, P33.
    feedback : three floats
        k.
    b1, b2, gamma : pairs of floats
        Intervals of the gains.
    disturbance : float
        Bound of |φ|.

    Returns
    -------
    tuple or None
        The rate β and the ρ at both ends of γ's interval (0 without disturbance); None if no
        positive rate was proved.

    Examples
    --------
    >>> P, k = (2.0, 1.5, 0.25, 2.0, 0.5, 0.25), (-8.0, -8.0, -4.0)
    >>> rate, rho = proven_rate(P, k, b1=(1.0, 1.0), disturbance=0.1)
    >>> 0.1 < rate < 0.4, proven_rate(P, k, b1=(1.0, 1.0), disturbance=9.0) is None
    (True, True)
    """
    require("flint", extra="proof", purpose="a proof")
    from parkproof.proof.checker.ellipsoid import Ellipsoid

    exact = Ellipsoid(ellipsoid, feedback)
    if not exact.sound():
        return None
    try:
        rates, rhos = _sought(ellipsoid, feedback, b1, b2, gamma, disturbance)
    except (OverflowError, np.linalg.LinAlgError):  # of numbers beyond all measure
        return None
    pair = (rhos[0], rhos[1])
    for loss in (1e-7, 1e-6, 1e-5, 1e-4):
        rate = digits(min(rates) * (1.0 - loss))
        if rate > 0.0 and exact.prove_rate(rate, pair, b1, b2, gamma, disturbance):
            return rate, pair
    return None


def _sought(
    ellipsoid: Six,
    feedback: Three,
    b1: Interval,
    b2: Interval,
    gamma: Interval,
    disturbance: float,
) -> tuple[list[float], list[float]]:
    """The largest rate, and its ρ, at each end of γ's interval, in floating point."""
    P = np.zeros((3, 3))
    for (i, j), value in zip(PAIRS, ellipsoid, strict=True):
        P[i, j] = P[j, i] = value
    root = np.linalg.inv(np.linalg.cholesky(H @ P + P @ H))
    rhos, rates = [], []
    for end in gamma:
        halves = []
        for first, second in itertools.product(b1, b2):
            loop = np.array([[0.0, first, 0.0], [0.0, 0.0, second], [0.0, 0.0, 0.0]])
            loop[2] = end * np.array(feedback)
            halves.append(P @ loop)
        reached = partial(_rate_of, P, root, halves, disturbance)
        rho = digits(math.exp(golden(reached, -25.0, 25.0, 50))) if disturbance else 0.0
        rates.append(reached(math.log(rho) if rho else 0.0))
        rhos.append(rho)
    return rates, rhos


def _rate_of(
    P: Floats, root: Floats, halves: Sequence[Floats], phi: float, log_rho: float
) -> float:
    """The largest β that M ≤ 0 allows where P(A + γbk) is one of the halves.

    The root is that of (HP + PH)⁻¹.
    """
    rho = math.exp(log_rho)
    pushed = phi**2 / rho * np.outer(P[2], P[2]) + rho * P if phi else np.zeros((3, 3))
    sums = (half + half.T + pushed for half in halves)
    return min(-float(np.linalg.eigvalsh(root @ total @ root.T)[-1]) for total in sums)


def golden(value: Callable[[float], float], low: float, high: float, steps: int) -> float:
    """Find where a function of one number is largest, by golden section.

    Parameters
    ----------
    value : callable
        The function, with one maximum in the interval.
    low, high : float
        The interval.
    steps : int
        Each shrinks it to 0.618 of its length.

    Returns
    -------
    float
        Near the maximum.

    Examples
    --------
    >>> round(golden(lambda x: -((x - 1.0) ** 2), 0.0, 5.0, 40), 6)
    1.0
    """
    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    left, right = high - ratio * (high - low), low + ratio * (high - low)
    at_left, at_right = value(left), value(right)
    for _ in range(steps):
        if at_left > at_right:
            high, right, at_right = right, left, at_left
            left = high - ratio * (high - low)
            at_left = value(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + ratio * (high - low)
            at_right = value(right)
    return left if at_left > at_right else right


def digits(value: float) -> float:
    """Round to eight significant digits.

    Parameters
    ----------
    value : float
        A number.

    Returns
    -------
    float
        The nearest float to its eight digits.

    Examples
    --------
    >>> digits(0.123456789)
    0.12345679
    """
    return float(f"{value:.8g}")
