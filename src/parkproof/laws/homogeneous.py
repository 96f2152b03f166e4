"""The corrected controller with implicit-Lyapunov homogeneous control in Step 2.

In Step 2, τ2 = k1·z1 + k2·z2 + k3·z3 with z = (s·x1/V³, x2/V², u1/V), s the direction of travel,
and V as in `parkproof.laws.ellipsoid`. As z'Pz = 1, |τ2| never exceeds √(kP⁻¹k'). P and k are
designed for the gains' intervals and the disturbance, so Theorem 1 is not applied. Every other step
is the corrected law's; on the return it holds the heading and never steers.
"""

import math

from parkproof.laws.chains import ChannelLaw
from parkproof.laws.corrected import corrected_channels
from parkproof.laws.parameters import LawParameters
from parkproof.scalar import scalar, spow

STEPS = 10
"""Steps of Newton's method; 7 reach rounding where P is well conditioned, as from a design."""

NARROWEST = 0.33
"""V is at most 1/NARROWEST times the largest of its values for single states."""


@scalar
def level_at(x1: float, x2: float, u1: float, p: LawParameters) -> float:
    """V at a state, but at least V_min.

    Newton's method for g(w)^(1/4) = 1, nearly a straight line, from the largest V that one of the
    states would have alone; a step that leaves what is known to enclose the solution is replaced by
    halving that on a logarithmic scale.

    Parameters
    ----------
    x1, x2, u1 : float
        State, x1 times the direction of travel.
    p : LawParameters
        Gains.

    Returns
    -------
    float
        V.

    Examples
    --------
    >>> from parkproof.laws import homogeneous_parameters
    >>> p = homogeneous_parameters()
    >>> one, two = level_at(0.1, -0.2, 0.3, p), level_at(0.8, -0.8, 0.6, p)
    >>> round(two / one, 12)
    2.0
    """
    first = spow(math.sqrt(p.P11) * abs(x1), 1.0 / 3.0)
    second = math.sqrt(math.sqrt(p.P22) * abs(x2))
    alone = max(first, second, math.sqrt(p.P33) * abs(u1))
    # a smaller V is below V_min whatever its exact value
    size = max(alone, NARROWEST * p.level_min)
    z3 = u1 / size
    z2 = x2 / (size * size)
    z1 = x1 / (size * size * size)
    c6 = p.P11 * z1 * z1
    c5 = 2.0 * p.P12 * z1 * z2
    c4 = p.P22 * z2 * z2 + 2.0 * p.P13 * z1 * z3
    c3 = 2.0 * p.P23 * z2 * z3
    c2 = p.P33 * z3 * z3 + 1e-200  # never 0, not even at the goal; as a single it is, and then
    # w is found by halving alone
    low, high, w = NARROWEST, p.widest, 1.0
    for _ in range(STEPS):
        square = w * w
        g = square * (c2 + w * (c3 + w * (c4 + w * (c5 + w * c6))))
        slope = square * (
            2.0 * c2 + w * (3.0 * c3 + w * (4.0 * c4 + w * (5.0 * c5 + w * 6.0 * c6)))
        )
        low = w if g <= 1.0 else low
        high = high if g <= 1.0 else w
        newton = w + 4.0 * w * (1.0 / math.sqrt(math.sqrt(g)) - 1.0) * g / slope
        w = newton if newton >= low and newton <= high else math.sqrt(low * high)
    return max(size / w, p.level_min)


@scalar
def homogeneous_channels(
    step: float,
    way: float,
    x0: float,
    x1: float,
    x2: float,
    u0: float,
    p: LawParameters,
) -> tuple[ChannelLaw, ChannelLaw]:
    """Laws of both channels in Steps 1 to 4, but for τ2 in Step 2.

    Parameters
    ----------
    step, way : float
        Step in force and direction of travel.
    x0, x1, x2, u0 : float
        State.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    two tuples of 4 floats
        The laws of τ̃1 and τ̃2; gain 0 in Step 2, where `homogeneous_direct` is the input.

    Examples
    --------
    >>> from parkproof.laws import homogeneous_parameters
    >>> p = homogeneous_parameters()
    >>> [homogeneous_channels(step, 1.0, 0.0, 0.1, 0.2, 0.5, p)[1][0] for step in (1.0, 2.0, 3.0)]
    [6.5, 0.0, 6.5]
    """
    # the corrected law in Step 4 is that of Step 3 without steering
    unsteered = 4.0 if step == 3.0 else step
    first, second = corrected_channels(unsteered, way, x0, x1, x2, u0, p)
    nothing = (0.0, 1.0, 0.0, 1.0)
    return first, nothing if step == 2.0 else second


@scalar
def homogeneous_direct(
    step: float, way: float, x1: float, x2: float, u1: float, p: LawParameters
) -> float:
    """Input τ2 of Step 2, and 0 in every other step.

    Parameters
    ----------
    step, way : float
        Step in force and direction of travel.
    x1, x2, u1 : float
        State.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    float
        τ2.

    Examples
    --------
    The input does not depend on how far along its curve a state is:

    >>> from parkproof.laws import homogeneous_parameters
    >>> p = homogeneous_parameters()
    >>> states = (0.1, 0.2, 0.3), (0.8, 0.8, 0.6)
    >>> near, far = (homogeneous_direct(2.0, 1.0, *state, p) for state in states)
    >>> round(near - far, 12)
    0.0
    """
    sided = way * x1
    level = level_at(sided, x2, u1, p)
    tau = ((p.feedback1 * sided / level + p.feedback2 * x2) / level + p.feedback3 * u1) / level
    return tau if step == 2.0 else 0.0
