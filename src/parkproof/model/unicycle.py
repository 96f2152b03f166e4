"""The unicycle: the wheeled robot seen as a point with a heading, equation (1) of the paper."""

import math
from typing import NamedTuple

from parkproof.scalar import scalar


class Pose(NamedTuple):
    """Position and heading, on the floor or in an image.

    Parameters
    ----------
    x, y : float
        Position, in m on the floor, in the unit of the frame in an image.
    theta : float
        Heading in rad, from the x axis towards the y axis.

    Examples
    --------
    >>> from parkproof.model.unicycle import Pose
    >>> Pose(1.0, 0.5, theta=0.2).theta
    0.2
    """

    x: float
    y: float
    theta: float


class Velocity(NamedTuple):
    """Velocity of a unicycle.

    Parameters
    ----------
    v : float
        Forward speed in m/s; negative in reverse.
    omega : float
        Turn rate in rad/s.

    Examples
    --------
    >>> from parkproof.model.unicycle import Velocity
    >>> Velocity(v=0.3, omega=-0.1)
    Velocity(v=0.3, omega=-0.1)
    """

    v: float
    omega: float


@scalar
def unicycle_rates(v: float, omega: float, c: float, s: float) -> tuple[float, float, float]:
    """Rates of position and heading, equation (1): ẋ = v cos θ, ẏ = v sin θ, θ̇ = ω.

    Parameters
    ----------
    v : float
        Forward speed in m/s.
    omega : float
        Turn rate in rad/s.
    c, s : float
        cos θ and sin θ.

    Returns
    -------
    tuple of float
        (ẋ, ẏ, θ̇) in m/s, m/s, rad/s.

    Examples
    --------
    >>> from parkproof.model.unicycle import unicycle_rates
    >>> unicycle_rates(2.0, 0.5, 0.6, 0.8)
    (1.2, 1.6, 0.5)
    """
    return v * c, v * s, omega


def headings_to_check(low: float, high: float) -> tuple[float, ...]:
    """Headings at which a range of them is checked: its ends and, as a turn has all, between.

    Parameters
    ----------
    low, high : float
        The range in rad.

    Returns
    -------
    tuple of float
        The ends, and headings a radian apart.

    Examples
    --------
    >>> headings_to_check(-2.0, 1.5)
    (-2.0, 1.5, -1.0, 0.0, 1.0)
    """
    between = min(math.ceil(high - low), 7)
    return low, high, *(low + i for i in range(1, between))


@scalar
def wrap_angle(angle: float) -> float:
    """Angle in (−π, π] that differs from the given one by whole turns.

    Parameters
    ----------
    angle : float
        Any finite angle in rad.

    Returns
    -------
    float
        The wrapped angle in rad.

    Examples
    --------
    >>> import math
    >>> from parkproof.model.unicycle import wrap_angle
    >>> wrap_angle(-math.pi) == wrap_angle(math.pi) == math.pi
    True
    >>> round(wrap_angle(7.0), 4)
    0.7168
    """
    turned = angle + 2.0 * math.pi * math.floor((math.pi - angle) / (2.0 * math.pi))
    wrapped = angle if -math.pi < angle <= math.pi else turned
    # Rounding of many turns can leave the interval by an ulp of the angle given.
    return math.pi if wrapped <= -math.pi else min(wrapped, math.pi)
