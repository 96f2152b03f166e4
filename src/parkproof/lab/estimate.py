"""From sightings of the tag to where the robot will be when the next command acts.

Positions and heading are differentiated robustly and exactly; the robot's answer to commands is
learnt; and the pose is carried over the latency, by time stamps, with the commands already sent.
"""

import math
from typing import NamedTuple

from parkproof.lab.differentiate import Differentiator
from parkproof.lab.identify import MotionEstimate
from parkproof.lab.predict import CommandHistory, GoalPose, Motion, Moving, predicted_pose
from parkproof.model.unicycle import wrap_angle

JERK, TURN_JERK = 200.0, 400.0
"""Bounds of the third derivatives for the differentiators, in goal units/s³ and rad/s³."""

LONGEST_GAP = 0.25
"""Gap between sightings in s after which derivatives and learning begin anew."""


class Sighting(NamedTuple):
    """The robot as one frame shows it, in goal units.

    Attributes
    ----------
    t : float
        Time of capture in s.
    pose : GoalPose
        In the goal's image frame.
    a : float
        Image speed per speed of the robot, goal units per m.
    beta : float
        Turn rate of the image heading per turn rate of the robot, positive.
    """

    t: float
    pose: GoalPose
    a: float
    beta: float


class Estimate(NamedTuple):
    """What is known after a sighting.

    Attributes
    ----------
    t : float
        Time of capture in s.
    pose : GoalPose
        Filtered, at that time.
    v, omega : float
        Image speed along the heading in goal units/s, and turn rate of the image heading in rad/s,
        at that time.
    ahead : GoalPose
        Predicted, at the time at which the next command acts.
    a, beta : float
        Gains of the sighting.
    motion : Motion
        How the robot answers to commands, as learnt so far.
    moving : Moving
        Of a robot that takes accelerations: how it moves, predicted at the time at which the next
        command acts (`parkproof.lab.observer`).
    """

    t: float
    pose: GoalPose
    v: float
    omega: float
    ahead: GoalPose
    a: float
    beta: float
    motion: Motion
    moving: Moving = Moving()


class Estimator:
    """Filter, differentiator and predictor.

    Parameters
    ----------
    delay : float
        Time in s from sending a command until the robot moves so.

    Examples
    --------
    >>> estimator, history = Estimator(delay=0.05), CommandHistory()
    >>> history.add(0.0, 0.1, 0.0)
    >>> for k in range(1, 31):
    ...     t = k / 30
    ...     pose = GoalPose(1.0 * max(0.0, t - 0.05), 0.0, 0.0)  # 10 units per m, at 0.1 m/s
    ...     found = estimator.update(Sighting(t, pose, a=10.0, beta=1.0), history, now=t + 0.1)
    >>> round(found.v, 3), round(found.ahead.x - found.pose.x, 3)
    (1.0, 0.15)
    """

    def __init__(self, *, delay: float) -> None:
        self._delay = delay
        self._x = Differentiator(bound=JERK)
        self._y = Differentiator(bound=JERK)
        self._theta = Differentiator(bound=TURN_JERK)
        self._learnt = MotionEstimate()
        self._last: Sighting | None = None
        self._unwrapped = 0.0

    @property
    def motion(self) -> Motion:
        """How the robot answers to commands, as learnt so far."""
        return self._learnt.motion

    def forget(self) -> None:
        """Begin derivatives anew with the next sighting; what was learnt of the robot stays."""
        self._last = None

    def update(self, seen: Sighting, history: CommandHistory, *, now: float) -> Estimate:
        """Take in a sighting.

        Parameters
        ----------
        seen : Sighting
            Newer than the last one.
        history : CommandHistory
            What was sent.
        now : float
            Time at which the next command will be sent, in s.

        Returns
        -------
        Estimate
            What is known now.
        """
        last = self._last
        if last is None or not 0.0 < seen.t - last.t <= LONGEST_GAP:
            for each in (self._x, self._y, self._theta):
                each.reset()
            self._unwrapped, dt = seen.pose.theta, 1.0
        else:
            dt = seen.t - last.t
            turn = wrap_angle(seen.pose.theta - last.pose.theta)
            self._unwrapped += turn
            self._learn(last, seen, turn, history)
        self._last = seen
        x, y = self._x.update(dt, seen.pose.x), self._y.update(dt, seen.pose.y)
        theta = self._theta.update(dt, self._unwrapped)
        pose = GoalPose(x.value, y.value, wrap_angle(theta.value))
        ahead, moving = self._ahead(pose, seen, history, now)
        v = x.rate * math.cos(theta.value) + y.rate * math.sin(theta.value)
        return Estimate(seen.t, pose, v, theta.rate, ahead, seen.a, seen.beta, self.motion, moving)

    def _ahead(
        self, pose: GoalPose, seen: Sighting, history: CommandHistory, now: float
    ) -> tuple[GoalPose, Moving]:
        """Pose when the next command acts, and how a robot that takes accelerations moves then."""
        ahead = predicted_pose(
            pose,
            history,
            start=seen.t - self._delay,
            end=now,
            a=seen.a,
            beta=seen.beta,
            motion=self.motion,
        )
        return ahead, Moving()

    def _learn(self, last: Sighting, seen: Sighting, turn: float, history: CommandHistory) -> None:
        """How the robot answered between two sightings."""
        middle = last.pose.theta + 0.5 * turn
        along = (seen.pose.x - last.pose.x) * math.cos(middle) + (
            seen.pose.y - last.pose.y
        ) * math.sin(middle)
        sent_way, sent_angle = history.totals(last.t - self._delay, seen.t - self._delay)
        self._learnt.update(
            way=along / (0.5 * (last.a + seen.a)),
            angle=turn / (0.5 * (last.beta + seen.beta)),
            sent_way=sent_way,
            sent_angle=sent_angle,
        )
