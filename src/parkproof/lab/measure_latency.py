"""Measuring the delay: turn the robot to and fro on the spot, and watch."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from parkproof.lab.devices import Camera, Clock, Frame, Missing, Robot, RobotSilentError
from parkproof.lab.latency import DelayFit, DelayOutcome, fit_delay
from parkproof.lab.watchdog import StoppingRobot
from parkproof.validate import positive

PERIOD = 0.02
"""Commands are sent this often, in s: not in step with frames, so that they tell more."""

BLIND = 1.0
"""If the tag was not seen for this time in s, the robot is stopped and the measurement ends."""

FASTEST_TURN = 0.8
"""Turn rate in rad/s, or half the limit if that is less, but out of the dead-band."""


class Seen(NamedTuple):
    """What one frame showed.

    Parameters
    ----------
    t : float
        Its time in s.
    heading : float or None
        The heading in the image in rad, or None if the tag was not seen.

    Examples
    --------
    >>> Seen(t=0.5, heading=None).heading is None
    True
    """

    t: float
    heading: float | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LatencyMeasurement:
    """A measured delay with what it was measured from.

    Parameters
    ----------
    fit : DelayFit
        The delay, or why there is none.
    commands : list of tuple of float
        (t, ω) as sent, in s and rad/s.
    seen : list of tuple of float
        (t, ψ) as seen, in s and rad.
    frames : int
        How many frames came.
    age : float
        How old frames were when they came, by their time stamps, in s: the median. What a command
        takes to be seen is this and the fitted delay together. NaN without frames.
    detail : str
        What the robot or the camera said at the end, if anything.

    Examples
    --------
    >>> fit = DelayFit(outcome=DelayOutcome.SILENT)
    >>> LatencyMeasurement(fit=fit, commands=[], seen=[], frames=0).detail
    ''
    """

    fit: DelayFit
    commands: list[tuple[float, float]]
    seen: list[tuple[float, float]]
    frames: int
    age: float = math.nan
    detail: str = ""


def watch(
    camera: Camera, heading: Callable[[Frame], float | None], *, wait: float = 0.01
) -> Iterator[Seen | None]:
    """What a camera shows, until it ends; None when no frame has come for a moment.

    Parameters
    ----------
    camera : Camera
        The camera.
    heading : callable
        Finds the heading in a frame, in rad; None if the tag is not seen.
    wait : float
        How long that moment is in s.

    Yields
    ------
    Seen or None
        For each frame.

    Examples
    --------
    >>> from parkproof.lab.footage import Footage
    >>> frames = iter([(0.0, np.zeros((48, 64), np.uint8))])
    >>> list(watch(Footage(frames, name="one"), lambda frame: 0.5))
    [Seen(t=0.0, heading=0.5)]
    """
    while (frame := camera.read(wait)) is not Missing.ENDED:
        yield Seen(frame.t, heading(frame)) if isinstance(frame, Frame) else None


def measure_latency(
    robot: Robot,
    seen: Iterable[tuple[float, float | None] | None],
    *,
    clock: Clock,
    duration: float = 20.0,
    angle: float = 0.3,
    seed: int = 0,
) -> LatencyMeasurement:
    """Turn the robot to and fro on the spot, and fit the delay to what was seen.

    Limits of the robot are kept. It does not begin before its heading was seen, and is stopped at
    the end, however that comes.

    Parameters
    ----------
    robot : Robot
        The robot.
    seen : iterable of tuple or None
        (t, ψ) of each frame as it comes, with None for ψ where the tag was not seen; None alone
        whenever no frame has come for a moment. `watch` makes it from a camera.
    clock : Clock
        The clock of these times.
    duration : float
        How long to turn, in s.
    angle : float
        How far to turn to either side, in rad.
    seed : int
        Of the times at which it turns back.

    Returns
    -------
    LatencyMeasurement
        The delay, or why it could not be measured.

    Raises
    ------
    InputError
        If the duration or the angle is not positive.

    Examples
    --------
    >>> from parkproof.lab.devices import WallClock
    >>> from parkproof.lab.robot_simulator import UdpRobotSimulator
    >>> from parkproof.lab.robots import open_robot
    >>> with UdpRobotSimulator() as simulator:
    ...     robot = open_robot(simulator.address)
    ...     done = measure_latency(robot, [(0.0, None)], clock=WallClock())
    ...     robot.close()
    >>> done.fit.outcome.sentence
    'the camera ended before enough was seen'
    """
    run = _Run(positive("duration", duration, example=20.0), _Turns(robot, angle=angle, seed=seed))
    safe = StoppingRobot(robot, clock=clock, timeout=None)
    try:
        for what in seen:
            now = clock.now()
            run.note(what, now)
            why = run.why_over(now)
            if why is not None:
                break
            if run.begun is not None and now >= run.next_command:
                safe.send(0.0, run.rate(now))
                run.sent(now, safe.sent[1])
        else:
            why = DelayOutcome.ENDED
    except RobotSilentError as error:
        return run.result(DelayOutcome.SILENT, detail=str(error))
    finally:
        safe.release()
    return run.result(why)


class _Turns:
    """Turn rates that change at random, and keep the robot within an angle of where it began."""

    def __init__(self, robot: Robot, *, angle: float, seed: int) -> None:
        self._angle = positive("angle", angle, example=0.3)
        self._random = np.random.default_rng(seed)
        limits = robot.limits
        slow = min(FASTEST_TURN, 0.5 * limits.turn_rate)
        self._rate = min(max(slow, 2.0 * limits.least_turn_rate), limits.turn_rate)
        self._level = 0.0
        self._until = -math.inf

    def rate(self, now: float, turned: float) -> float:
        """ω to ask for, when the robot has turned so far."""
        if now >= self._until:
            self._level = float(self._random.choice([-1.0, 0.0, 1.0], p=[0.4, 0.2, 0.4]))
            self._until = now + float(self._random.uniform(0.15, 0.45))
        if abs(turned) > 0.8 * self._angle:
            self._level = -math.copysign(1.0, turned)
        return self._rate * self._level


class _Run:
    """What was sent and seen so far."""

    def __init__(self, duration: float, turns: _Turns) -> None:
        self._duration = duration
        self._turns = turns
        self._ages: list[float] = []
        self._seen: list[tuple[float, float]] = []
        self._commands: list[tuple[float, float]] = []
        self._turned = 0.0
        self._told: list[float] = []  # turned as commanded, at each heading seen
        self._first: float | None = None
        self._last_seen = -math.inf
        self._noted = 0
        self.begun: float | None = None
        self.next_command = -math.inf

    def note(self, what: tuple[float, float | None] | None, now: float) -> None:
        """Take in a frame."""
        if what is None:
            return
        t, heading = what
        self._ages.append(now - t)
        if heading is not None and (not self._seen or t > self._seen[-1][0]):
            self._seen.append((t, heading))
            self._told.append(self._turned)

    def why_over(self, now: float) -> DelayOutcome | None:
        """Why the measurement is over, if it is."""
        if self._first is None:
            self._first = self._last_seen = now
        if len(self._seen) > self._noted:
            self._last_seen, self._noted = now, len(self._seen)
        if now - self._last_seen > BLIND:
            return DelayOutcome.NOT_SEEN
        if self.begun is None and self._seen:
            self.begun = now
        if self.begun is not None and now - self.begun > self._duration:
            return DelayOutcome.MEASURED
        return None

    def rate(self, now: float) -> float:
        """ω to ask for."""
        return self._turns.rate(now, self._turned - self._drift())

    def _drift(self) -> float:
        """By how much the robot has turned less than it was told, in commanded radians.

        Wheels differ, so that turns to and fro do not cancel. Which way the image turns is learnt
        from what was seen.
        """
        if len(self._told) < 60:
            return 0.0
        psi = np.unwrap([heading for _, heading in self._seen])
        told = np.asarray(self._told)
        steps, seen = told[15:] - told[:-15], psi[15:] - psi[:-15]
        gain = float(steps @ seen) / max(float(steps @ steps), 1e-12)
        if abs(gain) < 0.05:
            return 0.0
        recent = slice(-30, None)
        return float(np.mean(told[recent] - (psi[recent] - psi[0]) / gain))

    def sent(self, now: float, omega: float) -> None:
        """Note a command."""
        if self._commands:
            before, rate = self._commands[-1]
            self._turned += rate * (now - before)
        if not self._commands or now > self._commands[-1][0]:
            self._commands.append((now, omega))
        self.next_command = now + PERIOD

    def result(self, why: DelayOutcome, detail: str = "") -> LatencyMeasurement:
        """The fit, if there is enough for one."""
        fit = DelayFit(outcome=why, samples=len(self._seen))
        if why in {DelayOutcome.MEASURED, DelayOutcome.ENDED} and self._commands:
            fitted = fit_delay(*_columns(self._commands), *_columns(self._seen))
            if why is DelayOutcome.MEASURED or fitted.measured:
                fit = fitted
        return LatencyMeasurement(
            fit=fit,
            commands=self._commands,
            seen=self._seen,
            frames=len(self._ages),
            age=float(np.median(self._ages)) if self._ages else math.nan,
            detail=detail,
        )


def _columns(rows: list[tuple[float, float]]) -> tuple[list[float], list[float]]:
    return [t for t, _ in rows], [x for _, x in rows]
