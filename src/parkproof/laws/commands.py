"""What robots of each kind are sent: accelerations, or velocities that the controller keeps.

A velocity-commanded robot has its last states in the controller: u0 and u1 while a law runs in the
chart, v and ω while it turns.
"""

import math

from parkproof.model.chained import body_inputs, chained_inputs, image_acceleration_for
from parkproof.scalar import scalar

Kept = tuple[float, float, float, float, float]
"""What the controller of a velocity-commanded robot keeps: u0 and u1 as they were last integrated
and 1, or v and ω and 0; then v and the image's ω as they were last sent."""


@scalar
def acceleration_command(
    turning: bool, tau1: float, tau2: float, theta: float, v: float, omega: float, beta: float
) -> tuple[float, float]:
    """Accelerations for a torque-commanded robot, with the quadratic terms (D7) fed forward.

    Parameters
    ----------
    turning : bool
        Whether the step in force is 0, in which the inputs act on v and ω themselves.
    tau1, tau2 : float
        Inputs of the law.
    theta : float
        Measured heading in the image, |θ| < π/2 unless the robot turns.
    v, omega : float
        Measured speed, and turn rate of the heading in the image.
    beta : float
        Measured gain β, not 0.

    Returns
    -------
    tuple of 2 floats
        (v̇, ω̇) of the robot.

    Examples
    --------
    >>> acceleration_command(True, 1.0, 2.0, 3.0, 0.0, 0.0, -0.5)
    (1.0, -4.0)
    """
    return (
        (tau1, tau2 / beta)
        if turning
        else image_acceleration_for(tau1, tau2, v, omega / beta, theta, beta)
    )


@scalar
def kept_velocity(
    first: float, second: float, in_chart: float, v: float, omega: float, x2: float
) -> tuple[float, float, float, float]:
    """Give the velocities of a velocity-commanded robot at a heading.

    Parameters
    ----------
    first, second, in_chart, v, omega : float
        What is kept: `Kept`.
    x2 : float
        Measured tangent of the heading, infinite outside the chart.

    Returns
    -------
    tuple of 4 floats
        (u0, u1, v, ω); u0 and u1 are NaN outside the chart, and what was kept in it then means
        nothing.

    Examples
    --------
    >>> kept_velocity(1.0, 1.0, 1.0, 9.0, 9.0, 0.75)
    (1.0, 1.0, 1.25, 0.64)
    >>> kept_velocity(1.0, 1.0, 1.0, 9.0, 8.0, float("inf"))
    (nan, nan, 9.0, 8.0)
    """
    inside = abs(x2) < math.inf
    charted = in_chart > 0.0
    v_kept, omega_kept = body_inputs(first, second, x2)
    u0_made, u1_made = chained_inputs(first, second, x2)
    u0 = first if charted else u0_made
    u1 = second if charted else u1_made
    v_here = v_kept if inside else v
    omega_here = omega_kept if inside else omega
    return (
        u0 if inside else math.nan,
        u1 if inside else math.nan,
        v_here if charted else first,
        omega_here if charted else second,
    )


@scalar
def velocity_command(
    turning: bool,
    tau1: float,
    tau2: float,
    v: float,
    omega: float,
    x2: float,
    u0: float,
    u1: float,
    h: float,
) -> Kept:
    """Velocities for a velocity-commanded robot: the inputs integrated over a period.

    Parameters
    ----------
    turning : bool
        Whether the step in force is 0.
    tau1, tau2 : float
        Inputs of the law.
    v, omega : float
        Velocities kept so far, while the robot turns.
    x2 : float
        Measured tangent of the heading, otherwise.
    u0, u1 : float
        Inputs of the chained form kept so far, otherwise.
    h : float
        Period in s.

    Returns
    -------
    tuple of 5 floats
        To be kept (`Kept`); its last two numbers are to be sent.

    Examples
    --------
    >>> velocity_command(False, 2.0, 0.0, 0.0, 0.0, 0.75, 0.8, 1.0, 0.1)
    (1.0, 1.0, 1.0, 1.25, 0.64)
    """
    first = (v if turning else u0) + h * tau1
    second = (omega if turning else u1) + h * tau2
    v_charted, omega_charted = body_inputs(first, second, x2)
    return (
        first,
        second,
        0.0 if turning else 1.0,
        first if turning else v_charted,
        second if turning else omega_charted,
    )
