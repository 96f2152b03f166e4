"""Theorem 1: from a nominal finite-time law to one that rejects gain errors and disturbances."""

from collections.abc import Callable, Sequence

from parkproof.laws.chains import surface_of
from parkproof.scalar import scalar, sign, spow
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
    return (nominal + phi * sign(nominal)) / gamma_min


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
    lies on the side of u, where the left-hand side is increasing, and is found by six steps of
    regula falsi (the Illinois form), typically to 1e-5 of the move and at worst to 1e-3.

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
    surface = surface_of(power, offset)
    side = 1.0 if u > surface else -1.0
    free = u - side * reach
    slides = abs(u - surface) <= reach
    size = kappa * gain
    low, high = surface, free
    at_low = side * (surface - free)
    at_high = size * abs(spow(spow(free, power) + offset, outer))
    last = 0.0
    for _ in range(6):
        rise = at_high - at_low
        middle = high - at_high * (high - low) / rise if rise > 0.0 else low
        value = side * (middle - free) + size * abs(spow(spow(middle, power) + offset, outer))
        above = value > 0.0
        at_low = (0.5 * at_low if last > 0.0 else at_low) if above else value
        at_high = value if above else (0.5 * at_high if last < 0.0 else at_high)
        low, high = low if above else middle, middle if above else high
        last = 1.0 if above else -1.0
    rise = at_high - at_low
    found = high - at_high * (high - low) / rise if rise > 0.0 else low
    return surface if slides else found


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
    return (end - u) / (period * gamma_max) if gain > 0.0 else 0.0


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
