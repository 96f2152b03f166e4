"""Drives a course with a robot that takes accelerations, and drives it in advance.

As `parkproof.lab.pilot`, but the law's speeds u0, u1 are measured, not kept: the motors' error is
its gain γ, and friction its disturbance φ. Once the robot has arrived it brakes, and rests.
"""

import math
from typing import NamedTuple

from parkproof.bounds import Bounds
from parkproof.lab.arrival import Arrival, Resting
from parkproof.lab.devices import RobotLimits
from parkproof.lab.limits import limited_acceleration
from parkproof.lab.pilot import STAGE_GAIN, STAGE_NEAR, STAGE_SPEED, Course
from parkproof.lab.plan import Task, rehearsed
from parkproof.lab.predict import GoalPose, Motion, Moving, advanced
from parkproof.laws.controller import Controller, measured_pose
from parkproof.model.unicycle import wrap_angle

FOLLOWING = 6.0
"""Rate in 1/s with which speeds are made those of a straight leg."""

STRAIGHT = 2.0
"""Rate in 1/s with which its heading is kept."""

SLOW = 0.05
"""Share of the limits of speed below which a robot may rest."""

HEADROOM = 0.8
"""Share of the limits of speed that is used: the rest is for what is not foreseen."""


class Thrust(NamedTuple):
    """What is to be sent, and why.

    Attributes
    ----------
    v_dot, omega_dot : float
        In m/s² and rad/s², within the limits.
    step : int
        Step of the law; −1 on a straight leg before it begins.
    parked : bool
        Whether the robot is to brake, and rest at the goal.
    tau : two floats
        The inputs of the law; 0 while it is not in force.
    """

    v_dot: float
    omega_dot: float
    step: int
    parked: bool
    tau: tuple[float, float] = (0.0, 0.0)


class AcceleratedPilot:
    """Drives one course: asked with a pose and speeds, it answers what to send.

    Parameters
    ----------
    course : Course
        What to drive.
    bounds : Bounds
        Of a, in goal units per tag side; of the gain γ and the disturbance φ of u̇, in tag sides and
        rad.
    limits : RobotLimits
        What the robot can do.
    side : float
        Side of the tag in m: the law's speeds are in tag sides per s.
    period : float
        Time between calls in s.
    arrival : Arrival
        When to rest.

    Examples
    --------
    >>> from parkproof.laws.gains import Gains, Switching
    >>> course = Course("corrected", Gains(direction="forward"), Switching())
    >>> limits = RobotLimits(speed=0.3, turn_rate=2.0, acceleration=1.0, turn_acceleration=8.0)
    >>> pilot = AcceleratedPilot(course, Bounds(gamma=(0.7, 1.3)), limits, side=0.1, period=1 / 30,
    ...                          arrival=Arrival(0.01, 0.01))
    >>> asked = pilot.step(0.0, GoalPose(-3.0, 0.5, 0.2), Moving(), beta=1.0)
    >>> asked.step, 0.0 < asked.v_dot < 1.0
    (1, True)
    """

    def __init__(
        self,
        course: Course,
        bounds: Bounds,
        limits: RobotLimits,
        *,
        side: float,
        period: float,
        arrival: Arrival,
    ) -> None:
        self._controller = Controller(
            law=course.law,
            bounds=bounds,
            gains=course.gains,
            switching=course.switching,
            control_period=period,
            discretisation="implicit",
            robot="torque",
        )
        self._limits, self._side, self._period = limits, side, period
        self._resting = Resting(arrival)
        self._most = max(bounds.gamma_of(0)[1], bounds.gamma_of(1)[1])
        self._friction = bounds.disturbance_of(0) * side
        self._stage = course.stage
        self._from: GoalPose | None = None

    def step(self, t: float, pose: GoalPose, moving: Moving, *, beta: float) -> Thrust:
        """What to send now.

        Parameters
        ----------
        t : float
            Time in s.
        pose : GoalPose
            Where the robot will be when the command acts.
        moving : Moving
            How it will move then, and how it answers to what is sent.
        beta : float
            Turn rate of the image heading per turn rate of the robot.

        Returns
        -------
        Thrust
            What to send.
        """
        v, omega, *_ = moving
        if self._stage:
            return self._straight(pose, moving, beta)
        command = self._controller.step(
            measured_pose(t, *pose, v=v / self._side, omega=beta * omega, beta=beta)
        )
        slow = abs(v) <= SLOW * self._limits.speed and abs(omega) <= SLOW * self._limits.turn_rate
        if self._resting.update(command.step, pose, slow=slow):
            return Thrust(0.0, 0.0, command.step, True)
        asked = command.acceleration * self._side, command.turn_acceleration
        sent = self._cut(*asked, moving)
        return Thrust(*sent, command.step, False, (command.tau1, command.tau2))

    def _cut(self, v_dot: float, omega_dot: float, moving: Moving) -> tuple[float, float]:
        """What may be sent of an acceleration, whatever is asked."""
        wanted = limited_acceleration(
            v_dot, omega_dot, moving.v, moving.omega, self._period, self._limits, share=HEADROOM
        )
        along, turning = moving.along, moving.turning
        even = along.own * turning.own - along.cross * turning.cross
        first, _ = self._within(
            (turning.own * wanted[0] - along.cross * wanted[1]) / even, 0.0, moving
        )
        # what the motors then make of it beside is taken off, not what they would of more
        return self._within(first, (wanted[1] - turning.cross * first) / turning.own, moving)

    def _within(self, v_dot: float, omega_dot: float, moving: Moving) -> tuple[float, float]:
        """What may be sent, with motors that give more than they are told."""
        return limited_acceleration(
            v_dot,
            omega_dot,
            moving.v,
            moving.omega,
            self._period,
            self._limits,
            gain=self._most,
            share=HEADROOM,
        )

    def _straight(self, pose: GoalPose, moving: Moving, beta: float) -> Thrust:
        """The leg before the law."""
        v, omega, *_ = moving
        if self._from is None:
            self._from = pose
        left = abs(self._stage) - math.hypot(pose.x - self._from.x, pose.y - self._from.y)
        speed = 0.0
        if left > STAGE_NEAR:
            speed = min(STAGE_SPEED * self._limits.speed, STAGE_GAIN * left * self._side)
        elif abs(v) <= SLOW * self._limits.speed:
            self._stage = 0.0
        more = math.copysign(speed, self._stage) - v
        push = FOLLOWING * more
        if speed > 0.0 and abs(v) <= SLOW * self._limits.speed:  # against friction
            push += math.copysign(self._friction, more)
        off = wrap_angle(pose.theta - self._from.theta) / beta
        sent = self._cut(push, -FOLLOWING * (omega + STRAIGHT * off), moving)
        return Thrust(*sent, -1, False)


def accelerated_time(
    task: Task, course: Course, pose: GoalPose, _motion: Motion, a: float, longest: float
) -> float | None:
    """Drive a course in advance with a robot that takes accelerations.

    On the image unicycle with a constant gain a, β = 1, and accelerations as they are sent.

    Parameters
    ----------
    task : Task
        What the course has to do.
    course : Course
        The course.
    pose : GoalPose
        Where the robot stands.
    a : float
        Goal units per tag side.
    longest : float
        Time in s after which it is given up.

    Returns
    -------
    float or None
        How long it takes in s; None if it leaves the view or takes too long.
    """
    pilot = AcceleratedPilot(
        course, task.bounds, task.limits, side=task.side, period=task.period, arrival=task.arrival
    )
    v = omega = 0.0

    def move(t: float, pose: GoalPose) -> tuple[int, GoalPose]:
        nonlocal v, omega
        asked = pilot.step(t, pose, Moving(v, omega), beta=1.0)
        before = v, omega
        v, omega = v + task.period * asked.v_dot, omega + task.period * asked.omega_dot
        speed, turn = 0.5 * a * (before[0] + v) / task.side, 0.5 * (before[1] + omega)
        return asked.step, advanced(pose, task.period, speed, turn)

    return rehearsed(task, pose, longest, move)
