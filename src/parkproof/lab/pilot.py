"""A law with what a real robot needs of it: limits, a dead-band, and rest on arrival.

The law asks for speeds; what is sent keeps every limit, and the law, which holds its speeds itself,
is told what is really driven, so that it does not wind up.
"""

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

from parkproof.bounds import Bounds
from parkproof.lab.arrival import Arrival, Resting
from parkproof.lab.devices import RobotLimits
from parkproof.lab.limits import limited
from parkproof.lab.predict import GoalPose, Motion
from parkproof.laws.controller import Controller, measured_pose
from parkproof.laws.gains import Gains, Switching

STAGE_SPEED, STAGE_GAIN, STAGE_NEAR = 0.5, 1.5, 0.05
"""A straight leg: its largest speed as a share of the limit, speed per distance left in 1/s, and
the distance in goal units at which it is done."""


class Asked(NamedTuple):
    """What is to be sent, and why.

    Attributes
    ----------
    v, omega : float
        In m/s and rad/s, within the limits.
    step : int
        Step of the law; −1 on a straight leg before it begins.
    parked : bool
        Whether the robot rests at the goal.
    """

    v: float
    omega: float
    step: int
    parked: bool


class Pulses:
    """Replaces speeds below a dead-band by pulses with the same mean.

    Examples
    --------
    >>> pulses = Pulses(0.02)
    >>> [pulses.shaped(0.005, 0.1) for _ in range(8)]
    [0.0, 0.02, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0]
    >>> pulses.shaped(0.3, 0.1)
    0.3
    """

    def __init__(self, least: float) -> None:
        self._least = least
        self._owed = 0.0

    def shaped(self, speed: float, dt: float) -> float:
        """The speed to send for ``dt`` s: itself, the least that moves the robot, or 0."""
        if abs(speed) >= self._least:
            self._owed = 0.0
            return speed
        self._owed += speed * dt
        pulse = self._least * dt
        if 2.0 * abs(self._owed) < pulse:
            return 0.0
        sent = math.copysign(self._least, self._owed)
        self._owed -= math.copysign(pulse, self._owed)
        return sent


@dataclass(frozen=True)
class Course:
    """How to park from where the robot is: a straight leg, then a law.

    Attributes
    ----------
    law : str
        Its name.
    gains : Gains
        Its gains, in goal units; with a direction of travel.
    switching : Switching
        When its steps end.
    stage : float
        Length of the straight leg before it in goal units, negative backwards; 0 for none.
    time : float
        How long parking took in the worst case foreseen, in s.
    """

    law: Literal["corrected", "homogeneous"]
    gains: Gains
    switching: Switching
    stage: float = 0.0
    time: float = math.nan


class Pilot:
    """Drives one course: asked with a pose, it answers what to send.

    Parameters
    ----------
    course : Course
        What to drive.
    bounds : Bounds
        Of the gain a, in goal units per tag side.
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
    >>> course = Course("corrected", Gains(direction="forward"), Switching())
    >>> limits = RobotLimits(speed=0.3, turn_rate=2.0, acceleration=1.0, turn_acceleration=8.0)
    >>> pilot = Pilot(course, Bounds(), limits, side=0.1, period=1 / 30,
    ...               arrival=Arrival(0.01, 0.01))
    >>> asked = pilot.step(0.0, 1 / 30, GoalPose(-3.0, 0.5, 0.2), beta=1.0, motion=Motion())
    >>> asked.step, 0.0 < asked.v < 0.04
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
            robot="velocity",
        )
        self._limits, self._side = limits, side
        self._resting = Resting(arrival)
        self._sent = (0.0, 0.0)
        self._stage = course.stage
        self._from: GoalPose | None = None

    def step(self, t: float, dt: float, pose: GoalPose, *, beta: float, motion: Motion) -> Asked:
        """What to send now.

        Parameters
        ----------
        t, dt : float
            Time, and time since the last call, in s.
        pose : GoalPose
            Where the robot will be when the command acts.
        beta : float
            Turn rate of the image heading per turn rate of the robot.
        motion : Motion
            How the robot answers to commands.

        Returns
        -------
        Asked
            What to send, before dead-band pulses.
        """
        if self._stage:
            return self._straight(dt, pose, motion)
        command = self._controller.step(measured_pose(t, *pose, beta=beta))
        if self._resting.update(command.step, pose):
            return self._send(dt, 0.0, 0.0, command.step, beta, motion, rest=True)
        v = command.speed * self._side
        return self._send(dt, v, command.turn_rate, command.step, beta, motion, rest=False)

    def rest(self) -> None:
        """Take the robot to have been stopped: speeds are built up again from rest."""
        self._sent = (0.0, 0.0)
        self._controller.hold_velocity(0.0, 0.0)

    def _straight(self, dt: float, pose: GoalPose, motion: Motion) -> Asked:
        """The leg before the law."""
        if self._from is None:
            self._from = pose
        left = abs(self._stage) - math.hypot(pose.x - self._from.x, pose.y - self._from.y)
        if left <= STAGE_NEAR:
            asked = self._send(dt, 0.0, 0.0, -1, 1.0, motion, rest=True)
            if self._sent == (0.0, 0.0):
                self._stage = 0.0
            return asked
        speed = min(STAGE_SPEED * self._limits.speed, STAGE_GAIN * left * self._side)
        v = math.copysign(speed, self._stage)
        return self._send(dt, v, 0.0, -1, 1.0, motion, rest=False)

    def _send(
        self,
        dt: float,
        v: float,
        omega: float,
        step: int,
        beta: float,
        motion: Motion,
        *,
        rest: bool,
    ) -> Asked:
        """Turn wanted speeds into a command within the limits, and tell the law what it gives."""
        wanted_v = v / motion.speed
        wanted = (wanted_v, (omega - motion.skew * wanted_v) / motion.turn)
        sent = limited(*wanted, *self._sent, dt, self._limits)
        self._sent = sent
        if rest or sent != wanted:
            driven = motion.turn * sent[1] + motion.skew * sent[0]
            self._controller.hold_velocity(motion.speed * sent[0] / self._side, driven * beta)
        return Asked(*sent, step, self._resting.parked)
