"""Step 0: turning on the spot until the heading is straight, before the chart is entered.

Outside the chart the inputs act on v and ω themselves: v̇ = γ1 τ1 + φ1, ω̇ = γ2 τ2 + φ2.
"""

from parkproof.laws.chains import one_chain, two_chain, two_chain_surface
from parkproof.laws.parameters import LawParameters
from parkproof.scalar import scalar


@scalar
def turn_nominal(
    theta: float, v: float, omega: float, p: LawParameters
) -> tuple[float, float, float, float]:
    """Nominal inputs while turning: v to zero as in Step 1, (θ, ω) to zero as in Step 3.

    Parameters
    ----------
    theta : float
        Heading in rad, in (−π, π].
    v, omega : float
        Speed and turn rate.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    tuple of 4 floats
        τ̃1, v*, τ̃2, ω*.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> tau1, v_surface, tau2, _ = turn_nominal(0.0, 8.0, 1.0, default_parameters())
    >>> tau1, v_surface, tau2
    (-2.0, 0.0, -6.5)
    """
    return (
        one_chain(v, p.lambda1, p.q0),
        0.0,
        two_chain(theta, omega, p.H1, p.hold3, p.inv_q2, p.r2),
        two_chain_surface(theta, p.hold1, p.q2),
    )


@scalar
def turned(theta: float, v: float, omega: float, p: LawParameters) -> bool:
    """Whether the turn is done: heading, turn rate and speed inside their tolerance.

    Parameters
    ----------
    theta, v, omega : float
        Heading, speed, turn rate.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    bool
        True once all three are inside.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> turned(0.01, 0.0, 0.0, default_parameters())
    True
    """
    speeds = max(abs(v) - p.band1, abs(omega) - p.band2)
    return max(abs(theta), speeds) <= p.turn_tolerance
