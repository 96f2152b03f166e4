"""What may be sent at most: limits of speed and of its change, whatever is asked."""

import math

from parkproof.lab.devices import RobotLimits


def limited(
    v: float,
    omega: float,
    previous_v: float,
    previous_omega: float,
    dt: float,
    limits: RobotLimits,
) -> tuple[float, float]:
    """The command nearest to what is asked that a robot may be sent.

    Above a limit of speed, v and ω are scaled together, so that the robot drives the same path
    more slowly. Then the command goes from the previous one straight towards that, as far as both
    limits of acceleration allow: starting from rest and stopping keep the path's curvature, too.

    Parameters
    ----------
    v, omega : float
        What is asked, in m/s and rad/s. If one of them is not finite, to stand still.
    previous_v, previous_omega : float
        What was sent before. Taken into the limits of speed first; what is not finite counts as 0.
    dt : float
        Time since then in s. What is not positive allows no change.
    limits : RobotLimits
        What the robot can do.

    Returns
    -------
    tuple of float
        (v, ω) to be sent: within all limits, for every input.

    Examples
    --------
    >>> limits = RobotLimits(speed=0.5, turn_rate=2.0, acceleration=1.0, turn_acceleration=8.0)
    >>> limited(1.0, 1.0, 0.5, 0.5, 10.0, limits)  # twice too fast: the same circle
    (0.5, 0.5)
    >>> limited(0.4, 0.8, 0.0, 0.0, 0.1, limits)  # from rest: along the same circle
    (0.1, 0.2)
    >>> limited(float("nan"), 0.8, 0.5, 1.0, 0.25, limits)  # to rest, along the same circle
    (0.25, 0.5)
    """
    if not (math.isfinite(v) and math.isfinite(omega)):
        v, omega = 0.0, 0.0
    before_v = _within(previous_v, -limits.speed, limits.speed)
    before_omega = _within(previous_omega, -limits.turn_rate, limits.turn_rate)
    step = dt if dt > 0.0 and math.isfinite(dt) else 0.0

    scale = min(_share(v, limits.speed), _share(omega, limits.turn_rate))
    v, omega = scale * v, scale * omega
    change, turn_change = v - before_v, omega - before_omega
    most, most_turn = limits.acceleration * step, limits.turn_acceleration * step
    part = min(_share(change, most), _share(turn_change, most_turn))
    if part < 1.0:
        v, omega = before_v + part * change, before_omega + part * turn_change
    return (  # what rounding adds is taken off again
        _within(v, max(before_v - most, -limits.speed), min(before_v + most, limits.speed)),
        _within(
            omega,
            max(before_omega - most_turn, -limits.turn_rate),
            min(before_omega + most_turn, limits.turn_rate),
        ),
    )


def limited_acceleration(
    v_dot: float,
    omega_dot: float,
    v: float,
    omega: float,
    dt: float,
    limits: RobotLimits,
    *,
    gain: float = 1.0,
    share: float = 1.0,
) -> tuple[float, float]:
    """The acceleration nearest to what is asked that a robot may be sent.

    Within the limits of acceleration; and such that after it the limits of speed hold. A robot that
    is already too fast is slowed down.

    Parameters
    ----------
    v_dot, omega_dot : float
        What is asked, in m/s² and rad/s². If one of them is not finite, to slow down to rest.
    v, omega : float
        How fast the robot is, in m/s and rad/s. What is not finite counts as 0.
    dt : float
        How long the acceleration will act in s. What is not positive counts as very short.
    limits : RobotLimits
        What the robot can do.
    gain : float
        By what factor the robot may accelerate more than it is told, at least 1.
    share : float
        Share of the limits of speed that is used.

    Returns
    -------
    tuple of float
        (v̇, ω̇) to be sent: within the limits of acceleration, for every input.

    Examples
    --------
    >>> limits = RobotLimits(speed=0.5, turn_rate=2.0, acceleration=1.0, turn_acceleration=8.0)
    >>> limited_acceleration(3.0, -3.0, 0.0, 0.0, 0.1, limits)
    (1.0, -3.0)
    >>> limited_acceleration(1.0, 1.0, 0.5, 2.0, 0.125, limits)  # as fast as allowed
    (0.0, 0.0)
    >>> limited_acceleration(1.0, 0.0, 0.625, 0.0, 0.25, limits)  # too fast
    (-0.5, 0.0)
    """
    v, omega = (x if math.isfinite(x) else 0.0 for x in (v, omega))
    time = gain * max(dt, 1e-3) if math.isfinite(dt) else gain
    if not (math.isfinite(v_dot) and math.isfinite(omega_dot)):
        v_dot, omega_dot = -v / time, -omega / time
    return (
        _kept(v_dot, v, time, share * limits.speed, limits.acceleration),
        _kept(omega_dot, omega, time, share * limits.turn_rate, limits.turn_acceleration),
    )


def _kept(rate: float, speed: float, time: float, limit: float, most: float) -> float:
    """A rate within its limit, with which a speed stays within its own for a time."""
    high = _within((limit - speed) / time, -most, most)
    low = _within((-limit - speed) / time, -most, most)
    return _within(rate, low, high)


def _share(value: float, limit: float) -> float:
    """How much of a value a limit leaves, at most all."""
    return limit / abs(value) if abs(value) > limit else 1.0


def _within(value: float, low: float, high: float) -> float:
    """The number of an interval nearest to a value; the nearest to 0 if it is none."""
    return min(max(value if math.isfinite(value) else 0.0, low), high)
