"""Theorem 1: from a nominal finite-time law to one that rejects gain errors and disturbances."""

import math
from collections.abc import Callable, Sequence

from parkproof.laws.chains import chain_error, surface_of
from parkproof.scalar import scalar, spow
from parkproof.validate import not_negative, positive


@scalar
def robust(nominal: float, phi: float, gamma_min: float) -> float:
    """Theorem 1's input, u = (ũ + φ̄·sign ũ)/γ_m.

    Parameters
    ----------
    nominal : float
        ũ, the law of the undisturbed chain.
    phi : float
        φ̄, the bound of the disturbance.
    gamma_min : float
        γ_m > 0, the lower bound of the input gain.

    Returns
    -------
    float
        The input u, with sign(0) = 0.

    Examples
    --------
    >>> robust(-2.0, 2.5, 1.0)
    -4.5
    """
    return (nominal + math.copysign(phi, nominal)) / gamma_min if nominal != 0.0 else 0.0


Search = tuple[float, float, float, float, float, float]
"""Where the end of an implicit step is sought: a lower and an upper distance from the surface, what
is left over of the step's equation at both, which of them moved last (−1, 1, at first 0), and the
distance to look at next."""

CLOSE = 3e-6
"""A search ends when less than this part of the free distance is left over: then the end is found
to 1e-5 of the move nine times in ten, and to 1e-4 in 99 of 100 cases."""

LOOKS = 6
"""A search ends after so many further looks at the latest; two or three are the rule."""


@scalar
def implicit_surface(
    u: float, power: float, offset: float, reach: float
) -> tuple[float, float, float]:
    """Surface of a channel, and how far a state is from it that its sign term takes with it.

    Parameters
    ----------
    u : float
        Measured last state of the chain.
    power, offset : float
        Of the channel's law at the predicted positions.
    reach : float
        κ·φ̄: how far the sign term moves u in one period.

    Returns
    -------
    tuple of 3 floats
        The surface, the side of u (1 above it, else −1), and |u − surface| − reach, but at least 0.

    Examples
    --------
    >>> implicit_surface(3.0, 1.0, -1.0, 0.5)
    (1.0, 1.0, 1.5)
    """
    surface = surface_of(power, offset)
    side = 1.0 if u > surface else -1.0
    return surface, side, max(abs(u - surface) - reach, 0.0)


@scalar
def implicit_excess(
    at: float,
    surface: float,
    side: float,
    distance: float,
    size: float,
    power: float,
    offset: float,
    outer: float,
) -> float:
    """What is left over of an implicit step's equation s + κ·gain·|⌈w⌋^power + offset|^outer = d.

    Parameters
    ----------
    at : float
        s, distance from the surface to w.
    surface, side, distance : float
        From `implicit_surface`; the last is d.
    size : float
        κ·gain.
    power, offset, outer : float
        Of the channel's law.

    Returns
    -------
    float
        Left-hand side less d; it increases with s.

    Examples
    --------
    >>> implicit_excess(2.0, 1.0, 1.0, 3.0, 0.1, 1.0, -1.0, 1.0)
    -0.8
    """
    error = chain_error(surface + side * at, power, offset)
    return at - distance + size * abs(spow(error, outer))


@scalar
def begun_search(distance: float, excess: float, outer: float) -> Search:
    """Begin a search with what is left over at the free distance itself.

    The next look is where the equation would hold if the nominal law went to zero at the surface
    like s^outer along its tangent; where that is beyond the surface, along its chord.

    Parameters
    ----------
    distance : float
        Free distance d > 0 from the surface.
    excess : float
        `implicit_excess` there.
    outer : float
        Of the channel's law.

    Returns
    -------
    tuple of 6 floats
        The search.

    Examples
    --------
    >>> begun_search(1.0, 0.5, 0.5)[-1]
    0.6
    """
    tangent = distance - excess * distance / (distance + outer * excess)
    chord = distance * distance / (distance + excess)
    return 0.0, distance, -distance, excess, 0.0, tangent if tangent > 0.0 else chord


@scalar
def narrowed_search(
    low: float,
    high: float,
    at_low: float,
    at_high: float,
    last: float,
    at: float,
    excess: float,
) -> Search:
    """Narrow a search by a look: one step of regula falsi in the Illinois form.

    Parameters
    ----------
    low, high, at_low, at_high, last, at : float
        The search.
    excess : float
        `implicit_excess` at ``at``.

    Returns
    -------
    tuple of 6 floats
        The narrower search.

    Examples
    --------
    >>> narrowed_search(0.0, 1.0, -1.0, 0.5, 0.0, 0.5, -0.25)
    (0.5, 1.0, -0.25, 0.5, -1.0, 0.6666666666666667)
    """
    above = excess > 0.0
    new_at_low = (0.5 * at_low if last > 0.0 else at_low) if above else excess
    new_at_high = excess if above else (0.5 * at_high if last < 0.0 else at_high)
    new_low = low if above else at
    new_high = at if above else high
    rise = new_at_high - new_at_low
    step = new_at_high * (new_high - new_low) / rise if rise > 0.0 else new_high - new_low
    return new_low, new_high, new_at_low, new_at_high, 1.0 if above else -1.0, new_high - step


@scalar
def implicit_end(
    u: float,
    gain: float,
    power: float,
    offset: float,
    outer: float,
    reach: float,
    kappa: float,
) -> float:
    """Where u ends in one implicit Euler step of Theorem 1's loop, under the largest input gain.

    Solves w + κ·(gain·⌈⌈w⌋^power + offset⌋^outer + φ̄·Sgn) ∋ u with the set-valued sign of the
    same argument. If the sign term alone reaches the surface, w lies on it exactly. Otherwise w
    lies on the side of u, where the left-hand side is increasing, and is found by regula falsi.

    Parameters
    ----------
    u : float
        Measured last state of the chain.
    gain, power, offset, outer : float
        The channel's law at the predicted positions.
    reach : float
        κ·φ̄: how far the sign term moves u in one period.
    kappa : float
        κ = h·γ_M/γ_m.

    Returns
    -------
    float
        w.

    Examples
    --------
    >>> abs(implicit_end(0.004, 1.0, 1.0, 0.0, 0.5, 0.005, 0.002))
    0.0
    """
    surface, side, distance = implicit_surface(u, power, offset, reach)
    size = kappa * gain
    if distance <= 0.0:
        return surface
    excess = implicit_excess(distance, surface, side, distance, size, power, offset, outer)
    low, high, at_low, at_high, last, at = begun_search(distance, excess, outer)
    looks = 0
    while looks < LOOKS:
        excess = implicit_excess(at, surface, side, distance, size, power, offset, outer)
        low, high, at_low, at_high, last, at = narrowed_search(
            low, high, at_low, at_high, last, at, excess
        )
        looks = LOOKS if abs(excess) <= CLOSE * distance else looks + 1
    return surface + side * at


@scalar
def pull(u: float, end: float, gain: float, gamma_max: float, period: float) -> float:
    """Input that would bring u to a given end in one period under the largest input gain.

    Parameters
    ----------
    u, end : float
        Measured last state of a chain, and where it shall end.
    gain : float
        Gain of the channel's law, or a positive multiple of it; no control if it is 0.
    gamma_max : float
        γ_M.
    period : float
        Control period h in s.

    Returns
    -------
    float
        (end − u)/(h·γ_M).

    Examples
    --------
    >>> pull(1.0, 0.5, 21.0, 2.0, 0.25)
    -1.0
    """
    return (end - u) / (period * gamma_max) if gain > 0.0 else 0.0


@scalar
def robust_implicit(
    u: float,
    gain: float,
    power: float,
    offset: float,
    outer: float,
    phi: float,
    gamma_min: float,
    gamma_max: float,
    period: float,
) -> float:
    """Theorem 1's input by implicit Euler: its sign term does not chatter.

    The input is the one that would bring u to `implicit_end` under the largest gain γ_M:
    (w − u)/(h·γ_M).

    Parameters
    ----------
    u : float
        The measured last state of the chain.
    gain, power, offset, outer : float
        The channel's law at the predicted positions; no control if gain = 0.
    phi, gamma_min, gamma_max : float
        Bounds of disturbance and gain.
    period : float
        Control period h in s.

    Returns
    -------
    float
        The input, held for one period.

    Examples
    --------
    On the surface's side of the sign term's reach, u goes to the surface and no further:

    >>> robust_implicit(0.002, 1.0, 1.0, 0.0, 0.5, 2.5, 1.0, 2.0, 0.001)
    -1.0
    """
    kappa = period * gamma_max / gamma_min
    end = implicit_end(u, gain, power, offset, outer, kappa * phi, kappa)
    return pull(u, end, gain, gamma_max, period)


def robustify(
    law: Callable[[Sequence[float]], float], *, disturbance: float, gamma_min: float
) -> Callable[[Sequence[float]], float]:
    """Make a finite-time law of a chain robust (Theorem 1).

    For the chain ż_i = β_i z_{i+1}, ż_r = γ(t)u + φ(t) with γ ≥ γ_m and |φ| ≤ φ̄: if ũ stabilises
    the nominal chain with V̇ + cV^α ≤ 0, (∂V/∂z_r)·ũ ≤ 0, and ũ = 0 only where ∂V/∂z_r = 0, then
    the returned law stabilises the uncertain chain with the same V, c and α.

    Parameters
    ----------
    law : callable
        Takes the state (z_1, …, z_r) and returns ũ; any length r.
    disturbance : float
        φ̄ ≥ 0.
    gamma_min : float
        γ_m > 0.

    Returns
    -------
    callable
        Takes the state and returns u = (ũ + φ̄·sign ũ)/γ_m.

    Raises
    ------
    InputError
        If a bound is not finite, φ̄ is negative or γ_m not positive.

    Examples
    --------
    >>> from parkproof.laws.chains import power_integrator_law
    >>> law = robustify(power_integrator_law([1.0], q=1 / 3), disturbance=2.5, gamma_min=2.0)
    >>> law([8.0])
    -2.25
    """
    phi = not_negative("disturbance", disturbance)
    gain = positive("gamma_min", gamma_min)

    def robust_law(state: Sequence[float]) -> float:
        return robust(law(state), phi, gain)

    return robust_law
