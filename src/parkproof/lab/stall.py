"""Whether the robot moves as it is told, and whether the picture moves at all.

A camera whose picture stands still, or commands that go to another robot, look as if the robot
rested where it is seen: all else is in order, and the law drives on, blind. So what was commanded
is compared with what was seen, over the last half second, and the last two where it drives slowly.
Motors that are wrong by a factor of two, dead-bands, and latencies that are wrong by 0.15 s pass.
"""

import math
from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

from parkproof.lab.devices import RobotLimits
from parkproof.lab.estimate import Sighting
from parkproof.lab.predict import CommandHistory
from parkproof.lab.safety import Alarm
from parkproof.lab.tag_square import Corners
from parkproof.model.unicycle import wrap_angle

WINDOWS = (0.5, 1.0, 2.0)
"""Times in s over which motion is compared."""

LEAST = 0.15
"""Motion that must be commanded, in s at full speed, before it is compared."""

SHARE = 0.15
"""Share of the commanded motion below which the seen one counts as none."""

PERSISTS = 0.2
"""For how long in s it must look so."""

STILL = 0.1
"""Motion in s at full speed that is commanded while the picture stays the same to the last bit."""

IDLE = 1.2
"""Multiple of the least speeds up to which commands may move nothing."""

GAP = 0.6
"""Time in s without a sighting after which all begins anew."""


class Step(NamedTuple):
    """What was told and seen between two sightings.

    Attributes
    ----------
    dt : float
        Time between them in s.
    told : two floats
        Integrals of the commands in force meanwhile.
    seen : two floats
        Way in m and angle in rad.
    """

    dt: float
    told: tuple[float, float]
    seen: tuple[float, float]


class StallWatch:
    """Compares what a robot that takes velocities was told with what was seen of it.

    Parameters
    ----------
    limits : RobotLimits
        What the robot can do.
    delay : float
        Time in s from sending a command until the robot moves so.

    Examples
    --------
    >>> limits = RobotLimits(speed=0.3, turn_rate=2.0, acceleration=1.0, turn_acceleration=8.0)
    >>> watch, history = StallWatch(limits, delay=0.05), CommandHistory()
    >>> history.add(0.0, 0.2, 0.0)
    >>> from parkproof.lab.predict import GoalPose
    >>> there = GoalPose(1.0, 0.0, 0.0)
    >>> for k in range(30):
    ...     corners = ((0.0, 0.1 * k), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0))  # noise
    ...     alarm = watch.of_sighting(Sighting(k / 30, there, 10.0, 1.0), corners, history)
    >>> alarm.sentence
    'the robot does not move as it is told'
    """

    def __init__(self, limits: RobotLimits, *, delay: float) -> None:
        self._limits, self._delay = limits, delay
        self._last: tuple[Sighting, Corners] | None = None
        self._steps: deque[Step] = deque()
        self._same: list[Step] = []
        self._since: float | None = None
        self._frozen = False

    def of_sighting(
        self, seen: Sighting, corners: Corners, history: CommandHistory
    ) -> Alarm | None:
        """Whether the robot moves as it was told.

        Parameters
        ----------
        seen : Sighting
            Where it is seen now.
        corners : tuple of four points
            Of its tag, px.
        history : CommandHistory
            What was sent.

        Returns
        -------
        Alarm or None
            None if it does, or was not told to move.
        """
        last, self._last = self._last, (seen, corners)
        if last is None or not 0.0 < seen.t - last[0].t <= GAP:
            self._begin()
            return None
        step = self._step(last[0], seen, history)
        if step is None:
            self._begin()
            return None
        self._steps.append(step)
        while sum(each.dt for each in self._steps) > WINDOWS[-1] + 1e-9:
            self._steps.popleft()
        same = corners == last[1]
        self._same = [*self._same, step] if same else []
        self._frozen = same and (self._frozen or self._told(self._same) >= STILL)
        if self._frozen:
            return Alarm.FROZEN
        if not any(self._stands(window) for window in WINDOWS):
            self._since = None
            return None
        self._since = seen.t if self._since is None else self._since
        return Alarm.STALLED if seen.t - self._since >= PERSISTS - 1e-9 else None

    def _begin(self) -> None:
        self._steps.clear()
        self._same, self._since, self._frozen = [], None, False

    def _step(self, before: Sighting, seen: Sighting, history: CommandHistory) -> Step | None:
        """What was told and seen between two sightings; None where nothing can be compared."""
        told = self._sent(history, before.t - self._delay, seen.t - self._delay)
        if told is None:
            return None
        turn = wrap_angle(seen.pose.theta - before.pose.theta)
        middle = before.pose.theta + 0.5 * turn
        along = (seen.pose.x - before.pose.x) * math.cos(middle) + (
            seen.pose.y - before.pose.y
        ) * math.sin(middle)
        moved = along / (0.5 * (before.a + seen.a)), turn / (0.5 * (before.beta + seen.beta))
        return Step(seen.t - before.t, told, moved)

    def _stands(self, window: float) -> bool:
        """Whether the robot hardly moved though it was told to, in the last so many seconds."""
        steps, left = [], window + 1e-9
        for step in reversed(self._steps):
            left -= step.dt
            if left < 0.0:
                break
            steps.append(step)
        told = self._told(steps)
        return told >= LEAST and self._moved(step.seen for step in steps) < SHARE * told

    def _moved(self, parts: Iterable[tuple[float, float]]) -> float:
        """Motion, as time at full speed in s."""
        way = angle = 0.0
        for more, turn in parts:
            way, angle = way + more, angle + turn
        return abs(way) / self._limits.speed + abs(angle) / self._limits.turn_rate

    def _sent(
        self, history: CommandHistory, start: float, end: float
    ) -> tuple[float, float] | None:
        """Integrals of the commands in force, without those that may move nothing."""
        limits = self._limits
        way = angle = 0.0
        for dt, v, omega in history.pieces(start, end):
            way += v * dt if abs(v) > IDLE * limits.least_speed else 0.0
            angle += omega * dt if abs(omega) > IDLE * limits.least_turn_rate else 0.0
        return way, angle

    def _told(self, steps: list[Step]) -> float:
        """Motion that was commanded, as time at full speed in s."""
        return self._moved(step.told for step in steps)


class AcceleratedStallWatch(StallWatch):
    """The same for a robot that takes accelerations: at least so much must they have moved it.

    Parameters
    ----------
    limits : RobotLimits
        What the robot can do.
    delay : float
        Time in s from sending a command until the robot accelerates so.
    motor_error : float
        By what share its accelerations may differ from those that it is sent.
    disturbance : two floats
        By how much besides, in m/s² and rad/s²: friction.
    """

    def __init__(
        self,
        limits: RobotLimits,
        *,
        delay: float,
        motor_error: float,
        disturbance: tuple[float, float],
    ) -> None:
        super().__init__(limits, delay=delay)
        self._least, self._disturbance = 1.0 - motor_error, disturbance

    def _sent(
        self, history: CommandHistory, start: float, end: float
    ) -> tuple[float, float] | None:
        """Integrals of the accelerations; None where it braked."""
        told = history.totals(start, end)
        return told if all(map(math.isfinite, told)) else None

    def _told(self, steps: list[Step]) -> float:
        """From rest, with the weakest motors and all friction."""
        time = sum(step.dt for step in steps)
        ways = []
        for i in (0, 1):
            gained = self._least * abs(sum(step.told[i] for step in steps))
            ways.append(0.5 * time * max(0.0, gained - self._disturbance[i] * time))
        return self._moved([(ways[0], ways[1])])
