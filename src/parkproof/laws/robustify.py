"""Theorem 1: from a nominal finite-time law to one that rejects gain errors and disturbances."""

from collections.abc import Callable, Sequence

from parkproof.scalar import clip, scalar, sign
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
def robust_implicit(
    nominal: float,
    surface: float,
    u: float,
    phi: float,
    gamma_min: float,
    gamma_max: float,
    period: float,
) -> float:
    """Theorem 1's input with the sign taken at the end of the period, so that it cannot chatter.

    The size (|ũ| + φ̄)/γ_m is that of `robust`; its sign is the implicit selection that brings u to
    the surface u* and no further, under the largest gain γ_M:
    u_in = clip((u* − u)/(h·γ_M), ±(|ũ| + φ̄)/γ_m).

    Parameters
    ----------
    nominal : float
        ũ at the predicted positions.
    surface : float
        u* at the predicted positions: where ũ changes sign.
    u : float
        The measured last state of the chain.
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
    >>> robust_implicit(-2.0, 0.0, 1.0, 2.5, 1.0, 2.0, 0.001)
    -4.5
    >>> robust_implicit(-0.1, 0.0, 0.002, 2.5, 1.0, 2.0, 0.001)
    -1.0
    """
    return clip((surface - u) / (period * gamma_max), (abs(nominal) + phi) / gamma_min)


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
