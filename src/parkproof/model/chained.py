"""The chained form of the unicycle, equations (5) and (6) of the paper, and its chart.

State x0 = x, x1 = y, x2 = tan θ; inputs u0 = v cos θ, u1 = ω sec² θ. The same maps serve the
image of the robot (`parkproof.model.image_unicycle`), with the image heading ψ for θ and the image
turn rate w = βω for ω.
"""

import math
from typing import NamedTuple

from parkproof.errors import InputError
from parkproof.model.unicycle import Pose, Velocity, wrap_angle
from parkproof.scalar import arctan, cosine, scalar, sine, tangent
from parkproof.validate import finite


class ChainedState(NamedTuple):
    """State of the extended chained form (6).

    Parameters
    ----------
    x0, x1 : float
        Position along and across the goal's heading, in the unit of the frame.
    x2 : float
        tan θ.
    u0 : float
        v cos θ.
    u1 : float
        ω sec² θ.

    Examples
    --------
    >>> from parkproof.model.chained import ChainedState
    >>> ChainedState(-0.2, 0.3, -0.5, 5.6, 0.8).u0
    5.6
    """

    x0: float
    x1: float
    x2: float
    u0: float
    u1: float


@scalar
def chained_inputs(v: float, omega: float, x2: float) -> tuple[float, float]:
    """Map body velocity to the inputs of the chained form: u0 = v cos θ, u1 = ω sec² θ.

    Parameters
    ----------
    v, omega : float
        Forward speed and turn rate.
    x2 : float
        tan θ, so that cos θ = 1/√(1 + x2²).

    Returns
    -------
    tuple of float
        (u0, u1).

    Examples
    --------
    >>> from parkproof.model.chained import chained_inputs
    >>> chained_inputs(1.25, 0.64, 0.75)
    (1.0, 1.0)
    """
    secant_squared = 1.0 + x2 * x2
    return v / math.sqrt(secant_squared), omega * secant_squared


@scalar
def body_inputs(u0: float, u1: float, x2: float) -> tuple[float, float]:
    """Map the inputs of the chained form to body velocity: v = u0/cos θ, ω = u1 cos² θ.

    Parameters
    ----------
    u0, u1 : float
        Inputs of the chained form.
    x2 : float
        tan θ.

    Returns
    -------
    tuple of float
        (v, ω).

    Examples
    --------
    >>> from parkproof.model.chained import body_inputs
    >>> body_inputs(1.0, 1.0, 0.75)
    (1.25, 0.64)
    """
    secant_squared = 1.0 + x2 * x2
    return u0 * math.sqrt(secant_squared), u1 / secant_squared


@scalar
def chart_of(theta: float, v: float, omega: float) -> tuple[float, float, float]:
    """x2, u0 and u1 of a heading and velocities; no finite ones where |θ| ≥ 90°.

    Parameters
    ----------
    theta : float
        Heading in rad, in (−π, π].
    v, omega : float
        Forward speed, and turn rate of the heading.

    Returns
    -------
    tuple of float
        (x2, u0, u1): ±∞, NaN, NaN outside the chart, with the sign of θ.

    Examples
    --------
    >>> from parkproof.model.chained import chart_of
    >>> chart_of(0.0, 2.0, 1.0), chart_of(-2.0, 2.0, 1.0)
    ((0.0, 2.0, 1.0), (-inf, nan, nan))
    """
    inside = abs(theta) < 0.5 * math.pi
    x2 = tangent(theta) if inside else math.copysign(math.inf, theta)
    u0, u1 = chained_inputs(v, omega, x2)
    return x2, u0 if inside else math.nan, u1 if inside else math.nan


@scalar
def chained_rates(
    x2: float, u0: float, u1: float, g0: float, g1: float, b2: float
) -> tuple[float, float, float]:
    """Rates of the chained form (5), with a gain b2: ẋ0 = g0 u0, ẋ1 = g1 x2 u0, ẋ2 = b2 u1.

    Parameters
    ----------
    x2, u0, u1 : float
        tan θ and the two inputs.
    g0, g1 : float
        Image gains: (α1, α2) under the paper's camera, (a, a) in the robot's own image.
    b2 : float
        Gain of u1; 1 in the paper.

    Returns
    -------
    tuple of float
        (ẋ0, ẋ1, ẋ2).

    Examples
    --------
    >>> from parkproof.model.chained import chained_rates
    >>> chained_rates(0.5, 2.0, 0.1, 1.5, 0.5, 1.0)
    (3.0, 0.5, 0.1)
    """
    return g0 * u0, g1 * x2 * u0, b2 * u1


@scalar
def extension_rate(tau: float, gamma: float, phi: float) -> float:
    """Rate of one input of the chained form, equation (6): u̇ = γτ + φ.

    Parameters
    ----------
    tau : float
        Control.
    gamma : float
        Input gain γ(t) > 0.
    phi : float
        Disturbance φ(t).

    Returns
    -------
    float
        u̇.

    Examples
    --------
    >>> from parkproof.model.chained import extension_rate
    >>> extension_rate(2.0, 1.5, -1.0)
    2.0
    """
    return gamma * tau + phi


@scalar
def image_acceleration_for(
    tau1: float, tau2: float, v: float, omega: float, psi: float, beta: float
) -> tuple[float, float]:
    """Acceleration that gives u̇0 = τ1, u̇1 = τ2 for inputs measured in the image.

    With u0 = v cos ψ, u1 = w sec² ψ and w = βω: v̇ = (τ1 + v w sin ψ)/cos ψ and
    ω̇ = (cos² ψ τ2 − 2w² tan ψ)/β. As β varies, u̇1 = τ2 + β̇ ω sec² ψ: that residue belongs to φ2.

    Parameters
    ----------
    tau1, tau2 : float
        Wanted u̇0 and u̇1.
    v, omega : float
        Forward speed in m/s and turn rate in rad/s, on the floor.
    psi : float
        Image heading in rad, |ψ| < π/2.
    beta : float
        Turn gain of the image, ψ̇ = βω, not 0.

    Returns
    -------
    tuple of float
        (v̇, ω̇) in m/s² and rad/s².

    Examples
    --------
    >>> from parkproof.model.chained import image_acceleration_for
    >>> image_acceleration_for(1.0, 2.0, 0.3, 0.4, 0.0, -0.5)
    (1.0, -4.0)
    """
    c = cosine(psi)
    s = sine(psi)
    w = beta * omega
    return (tau1 + v * w * s) / c, (c * c * tau2 - 2.0 * w * w * s / c) / beta


@scalar
def image_input_rates(
    v_dot: float,
    omega_dot: float,
    v: float,
    omega: float,
    psi: float,
    beta: float,
    beta_dot: float,
) -> tuple[float, float]:
    """Rates of u0 = v cos ψ and u1 = βω sec² ψ under an acceleration.

    u̇0 = v̇ cos ψ − v w sin ψ and u̇1 = (βω̇ + β̇ω) sec² ψ + 2w² tan ψ sec² ψ, with w = βω. With
    ``beta_dot = 0`` this is the inverse of `image_acceleration_for`.

    Parameters
    ----------
    v_dot, omega_dot : float
        Acceleration on the floor in m/s² and rad/s².
    v, omega : float
        Velocity on the floor in m/s and rad/s.
    psi : float
        Image heading in rad, |ψ| < π/2.
    beta, beta_dot : float
        Turn gain of the image and its rate (`parkproof.model.image_unicycle.image_gain_rates`).

    Returns
    -------
    tuple of float
        (u̇0, u̇1).

    Examples
    --------
    >>> from parkproof.model.chained import image_input_rates
    >>> image_input_rates(1.0, -4.0, 0.3, 0.4, 0.0, -0.5, 0.0)
    (1.0, 2.0)
    """
    c = cosine(psi)
    s = sine(psi)
    w = beta * omega
    w_dot = beta * omega_dot + beta_dot * omega
    return v_dot * c - v * w * s, (w_dot + 2.0 * w * w * s / c) / (c * c)


@scalar
def acceleration_for(
    tau1: float, tau2: float, v: float, omega: float, theta: float
) -> tuple[float, float]:
    """Acceleration that gives u̇0 = τ1, u̇1 = τ2: the feed-forward the paper leaves out.

    v̇ = (τ1 + vω sin θ)/cos θ, ω̇ = cos² θ τ2 − 2ω² tan θ: `image_acceleration_for` with β = 1.

    Parameters
    ----------
    tau1, tau2 : float
        Wanted u̇0 and u̇1.
    v, omega : float
        Forward speed in m/s and turn rate in rad/s.
    theta : float
        Heading in rad, |θ| < π/2.

    Returns
    -------
    tuple of float
        (v̇, ω̇) in m/s² and rad/s².

    Examples
    --------
    >>> from parkproof.model.chained import acceleration_for
    >>> acceleration_for(1.0, 2.0, 0.3, 0.4, 0.0)
    (1.0, 2.0)
    """
    return image_acceleration_for(tau1, tau2, v, omega, theta, 1.0)


@scalar
def input_rates(
    v_dot: float, omega_dot: float, v: float, omega: float, theta: float
) -> tuple[float, float]:
    """Rates of u0 = v cos θ and u1 = ω sec² θ: the inverse of `acceleration_for`.

    Parameters
    ----------
    v_dot, omega_dot : float
        Acceleration in m/s² and rad/s².
    v, omega : float
        Velocity in m/s and rad/s.
    theta : float
        Heading in rad, |θ| < π/2.

    Returns
    -------
    tuple of float
        (u̇0, u̇1).

    Examples
    --------
    >>> from parkproof.model.chained import input_rates
    >>> input_rates(1.0, 2.0, 0.3, 0.4, 0.0)
    (1.0, 2.0)
    """
    return image_input_rates(v_dot, omega_dot, v, omega, theta, 1.0, 0.0)


def to_chained(pose: Pose, velocity: Velocity) -> ChainedState:
    """Chained state of a pose and a velocity.

    Parameters
    ----------
    pose : Pose
        Position and heading, |heading| < 90° after whole turns are taken off.
    velocity : Velocity
        Forward speed and turn rate.

    Returns
    -------
    ChainedState
        (x, y, tan θ, v cos θ, ω sec² θ).

    Raises
    ------
    InputError
        If a number is not finite, or the heading is outside the chart |θ| < 90°.

    Examples
    --------
    >>> from parkproof.model.chained import to_chained
    >>> from parkproof.model.unicycle import Pose, Velocity
    >>> to_chained(Pose(1.0, 2.0, 0.0), Velocity(0.5, 0.1))
    ChainedState(x0=1.0, x1=2.0, x2=0.0, u0=0.5, u1=0.1)
    """
    x, y, theta = (finite(name, value) for name, value in pose._asdict().items())
    v, omega = (finite(name, value) for name, value in velocity._asdict().items())
    theta = wrap_angle(theta)
    if not abs(theta) < 0.5 * math.pi:
        raise InputError(
            f"theta = {pose.theta:.6g} rad ({math.degrees(theta):.6g}°): the chained form needs "
            'a heading within ±90° of the goal\'s; turn the robot first, write law = "corrected"'
        )
    x2 = math.tan(theta)
    u0, u1 = chained_inputs(v, omega, x2)
    return ChainedState(x, y, x2, u0, u1)


def from_chained(state: ChainedState) -> tuple[Pose, Velocity]:
    """Pose and velocity of a chained state: the inverse of `to_chained`.

    Parameters
    ----------
    state : ChainedState
        Any finite state.

    Returns
    -------
    tuple of Pose and Velocity
        The heading lies within ±π/2.

    Raises
    ------
    InputError
        If a number is not finite.

    Examples
    --------
    >>> from parkproof.model.chained import ChainedState, from_chained
    >>> pose, velocity = from_chained(ChainedState(1.0, 2.0, 0.75, 1.0, 1.0))
    >>> velocity
    Velocity(v=1.25, omega=0.64)
    """
    x0, x1, x2, u0, u1 = (finite(name, value) for name, value in state._asdict().items())
    return Pose(x0, x1, arctan(x2)), Velocity(*body_inputs(u0, u1, x2))
