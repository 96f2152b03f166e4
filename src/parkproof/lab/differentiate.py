"""A robust exact differentiator for sampled, noisy signals, in implicit form.

Levant's differentiator of order 2 (Int. J. Control 76, 2003) in the proper implicit discretisation
(Seeber, arXiv 2404.02770): the sign is taken at the end of the step, so that it does not chatter,
and the outputs are combinations of the states with which polynomials of degree 2 have no bias.
"""

import math
from typing import NamedTuple

from parkproof.validate import positive

GAINS = (2.0, 2.12, 1.1)
"""Of the non-recursive form, for the orders 0, 1 and 2 (Levant 2003)."""

NEWTON_STEPS = 12
"""Steps for the root of a cubic that is convex and increases: from above, none goes too far."""


class Derivatives(NamedTuple):
    """A signal and its first two derivatives.

    Attributes
    ----------
    value, rate, acceleration : float
        In the signal's unit, and per s and s².
    """

    value: float
    rate: float
    acceleration: float


def _root(a: float, b: float, c: float, d: float) -> float:
    """The root r ≥ 0 of r³ + a r² + b r = d − c, for positive a, b and d > c."""
    rest = d - c
    r = min(rest / b, math.sqrt(rest / a), math.cbrt(rest))  # each term alone gives an upper bound
    for _ in range(NEWTON_STEPS):
        r -= (((r + a) * r + b) * r - rest) / ((3.0 * r + 2.0 * a) * r + b)
    return max(r, 0.0)


class Differentiator:
    """Value, rate and acceleration of a signal whose third derivative is bounded.

    Without noise they are exact after a finite time; with noise of size ε the rate errs by at most
    about L^(1/3)·ε^(2/3).

    Parameters
    ----------
    bound : float
        L, bound of the third derivative.

    Examples
    --------
    >>> d = Differentiator(bound=50.0)
    >>> for k in range(200):
    ...     found = d.update(0.01, 0.5 * (0.01 * k) ** 2)
    >>> round(found.rate, 9), round(found.acceleration, 6)
    (1.99, 1.0)
    """

    def __init__(self, *, bound: float) -> None:
        self._bound = positive("bound", bound, example=50.0)
        self._states: tuple[float, float, float] | None = None

    def reset(self) -> None:
        """Forget everything: the next sample is the first."""
        self._states = None

    def update(self, dt: float, sample: float) -> Derivatives:
        """Take a sample.

        Parameters
        ----------
        dt : float
            Time in s since the last one, positive; ignored at the first.
        sample : float
            The signal.

        Returns
        -------
        Derivatives
            At the time of the sample.
        """
        if self._states is None:
            self._states = (sample, 0.0, 0.0)
            return Derivatives(*self._states)
        z0, z1, z2 = self._states
        k0, k1, k2 = GAINS
        one = math.cbrt(self._bound)
        slide = dt**3 * k2 * self._bound
        error = z0 + dt * (z1 + dt * z2) - sample
        if abs(error) <= slide:
            r, sign = 0.0, error / slide
        else:
            sign = math.copysign(1.0, error)
            r = _root(dt * k0 * one, dt * dt * k1 * one * one, slide, abs(error))
        z2 -= dt * k2 * self._bound * sign
        z1 += dt * (z2 - k1 * one * one * math.copysign(r, error))
        z0 += dt * (z1 - k0 * one * math.copysign(r * r, error))
        self._states = (z0, z1, z2)
        return Derivatives(z0, z1 + 0.5 * dt * z2, z2)
