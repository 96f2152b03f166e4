"""Step 0: turning on the spot until the heading is straight, before the chart is entered.

Outside the chart the inputs act on v and ω themselves: v̇ = γ1 τ1 + φ1, ω̇ = γ2 τ2 + φ2.
"""

from parkproof.laws.chains import ChannelLaw, one_chain, two_chain
from parkproof.laws.parameters import LawParameters
from parkproof.scalar import scalar


@scalar
def turn_channels(theta: float, p: LawParameters) -> tuple[ChannelLaw, ChannelLaw]:
    """Laws of both channels while turning: v to zero as in Step 1, (θ, ω) as (x0, u0) in Step 3.

    Parameters
    ----------
    theta : float
        Heading in rad, in (−π, π].
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    two tuples of 4 floats
        The laws of v̇ and ω̇.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> from parkproof.laws.chains import nominal_input
    >>> one, two = turn_channels(0.0, default_parameters())
    >>> nominal_input(8.0, *one), nominal_input(1.0, *two)
    (-2.0, -6.5)
    """
    return one_chain(0.0, p.lambda1, p.q0), two_chain(theta, p.H1, p.hold3, p.inv_q2, p.r2)


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
