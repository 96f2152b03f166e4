"""From a frame to a command: detection, estimation, law and safety, with nothing of any device.

A `Parker` is given frames and times, and answers commands. The same frames and times give the same
commands, so that a recorded run can be carried out again.
"""

import math
from collections import Counter
from dataclasses import dataclass, field

from parkproof.bounds import Bounds
from parkproof.lab.answer import Answer, Phase
from parkproof.lab.arrival import Arrival
from parkproof.lab.devices import Frame, Missing, RobotLimits
from parkproof.lab.entries import STEP_NAMES, Event
from parkproof.lab.estimate import Estimate, Estimator
from parkproof.lab.frame_rate import FrameRate
from parkproof.lab.goal import Goal
from parkproof.lab.image_pose import ImagePose
from parkproof.lab.pilot import Course
from parkproof.lab.plan import Drive
from parkproof.lab.planning import Planner
from parkproof.lab.predict import CommandHistory
from parkproof.lab.safety import Alarm, Guard, SafetyLimits
from parkproof.lab.settings import LabSettings
from parkproof.lab.stall import StallWatch
from parkproof.lab.tracker import TagTracker
from parkproof.lab.view import ImageView

AT_MOST = {Alarm.BORDER: 8, Alarm.STEEP: 8, Alarm.STALLED: 3, Alarm.FROZEN: 3}
"""So many alarms of a kind end a run: what comes back so often is not overcome by driving on."""

AT_ONCE = (Alarm.STALLED, Alarm.FROZEN)
"""Alarms that have waited long enough before they are raised."""


@dataclass
class _Memory:
    """What a parker remembers from frame to frame."""

    phase: Phase = Phase.WAITING
    alarm: Alarm | None = None
    course: Course | None = None
    sent: tuple[float, float] = (0.0, 0.0)
    called: float | None = None
    seen: float = -math.inf
    right: int = 0
    step: int = -1
    accelerations: tuple[float, float] | None = None
    tau: tuple[float, float] = (math.nan, math.nan)
    alarms: Counter[Alarm] = field(default_factory=Counter)
    rate_told: bool = False
    events: list[Event] = field(default_factory=list)


class Parker:
    """Parks a robot as it was shown: what all kinds of robot have in common.

    `parkproof.lab.velocity_parker` and `parkproof.lab.accelerated_parker` hold the rest.

    Parameters
    ----------
    goal : Goal
        Where to park.
    limits : RobotLimits
        What the robot can do.
    settings : LabSettings, optional
        Law, times and tolerances.
    safety : SafetyLimits, optional
        When something is wrong.
    drive : callable
        How courses are driven in advance.
    quickest : float
        Largest time scale of Step 2.

    Attributes
    ----------
    course : Course or None
        The course that is driven.
    """

    def __init__(
        self,
        goal: Goal,
        limits: RobotLimits,
        settings: LabSettings | None = None,
        safety: SafetyLimits | None = None,
        *,
        drive: Drive,
        quickest: float,
    ) -> None:
        self._goal, self._limits = goal, limits
        self._settings, self._safety = settings or LabSettings(), safety or SafetyLimits()
        self._history = CommandHistory()
        self._estimator = self._new_estimator()
        view = ImageView(tuple(goal.corners()))
        self._guard = Guard(self._safety, limits, view, mount=goal.mount)
        self._tracker = TagTracker(
            goal, self._guard, self._new_stall_watch(), stamp_delay=self._settings.stamp_delay
        )
        self._arrival = Arrival(self._settings.position_px / goal.unit, self._settings.heading)
        self._planner = Planner(
            view,
            goal.mount,
            limits,
            arrival=self._arrival,
            settings=self._settings,
            drive=drive,
            quickest=quickest,
        )
        self._frames = FrameRate(self._settings.rate)
        self._now = _Memory()

    @property
    def course(self) -> Course | None:
        """The course that is driven."""
        return self._now.course

    @property
    def history(self) -> CommandHistory:
        """The commands that were sent."""
        return self._history

    @property
    def period(self) -> float:
        """Time between frames in s: as it is set, unless the frames show another."""
        return self._frames.period

    def step(self, reading: Frame | Missing, now: float) -> Answer:
        """Take a frame, or the news that there is none, and answer a command.

        Parameters
        ----------
        reading : Frame or Missing
            What the camera gave.
        now : float
            Time in s.

        Returns
        -------
        Answer
            With the command to send at once.
        """
        memory = self._now
        if memory.called is None:
            memory.called, memory.seen = now - 1.0 / self._settings.rate, now
        dt = max(now - memory.called, 0.0)
        memory.called, memory.events = now, []
        look = self._tracker.look(reading, now, self._history)
        if isinstance(reading, Frame) and look.alarm is not Alarm.CLOCK:
            self._timed(reading, now)
        estimate = None
        if look.seen is not None:
            estimate = self._estimator.update(look.seen, self._history, now=now)
            memory.seen = now
        memory.sent = self._decide(estimate, look.alarm, now, dt)
        self._remember(now)
        return Answer(
            now,
            *memory.sent,
            memory.step,
            memory.phase,
            memory.alarm,
            estimate,
            look.tag,
            tuple(memory.events),
            math.nan if memory.course is None else memory.course.time,
            memory.accelerations,
            None if look.shown is None else self._recorded(look.shown),
            memory.tau,
        )

    def carried_out(self, sent: tuple[float, float] | None, *, halted: float | None = None) -> None:
        """Learn what was sent instead of the last answer.

        Parameters
        ----------
        sent : two floats or None
            What the robot was sent at the time of the answer: v in m/s and ω in rad/s. For one
            that takes accelerations: v̇ in m/s² and ω̇ in rad/s², or None where it was told to
            brake.
        halted : float, optional
            When the robot was stopped since the command before, in s.
        """
        raise NotImplementedError

    def _new_estimator(self) -> Estimator:
        raise NotImplementedError

    def _new_stall_watch(self) -> StallWatch:
        raise NotImplementedError

    def _remember(self, now: float) -> None:
        """Keep what is sent, for the prediction."""
        raise NotImplementedError

    def _held(self) -> tuple[float, float]:
        """What is sent while it is not yet clear that something is wrong."""
        raise NotImplementedError

    def _slowed(self, dt: float) -> tuple[float, float]:
        """What is sent to stop."""
        raise NotImplementedError

    def _stands(self, estimate: Estimate) -> bool:
        """Whether the robot stands still."""
        raise NotImplementedError

    def _drive(self, estimate: Estimate, now: float, dt: float) -> tuple[float, float]:
        """The command of the course, unless it leads out of the picture."""
        raise NotImplementedError

    def _take_pilot(self, course: Course) -> None:
        """Have a course driven from now on."""
        raise NotImplementedError

    def _recorded(self, shown: ImagePose) -> tuple[float, float, float, float, float]:
        """An image pose with a in px/m."""
        return shown.u, shown.v, shown.psi, shown.beta, shown.a / self._goal.mount.side

    def _timed(self, frame: Frame, now: float) -> None:
        """Keep the rate of the frames, and tell of one that is not as it was set."""
        self._frames.take(frame.t, frame.number)
        other = self._frames.other
        if other is not None and not self._now.rate_told:
            self._now.rate_told = True
            expected = self._settings.rate
            self._tell(
                now,
                "rate",
                f"the camera gives {other:.3g} frames per s, and {expected:g} were expected; "
                f"write rate={other:.3g}",
                level=1,
            )

    def _decide(
        self,
        estimate: Estimate | None,
        alarm: Alarm | None,
        now: float,
        dt: float,
    ) -> tuple[float, float]:
        """The command, by what the parker is doing."""
        memory = self._now
        waited = now - memory.seen <= self._safety.patience
        if alarm is None:
            memory.right += 1
        elif not (waited and alarm is Alarm.NO_FRAME):  # a slow camera is late between its frames
            memory.right = 0
        if alarm is not None:
            if alarm is Alarm.JUMP and self._guard.carried:
                self._estimator.forget()
                self._stop(alarm, now)
            elif not waited or alarm in AT_ONCE:
                self._stop(alarm, now)
            elif memory.phase is not Phase.STOPPED:
                return self._held()
        elif (
            memory.phase in {Phase.WAITING, Phase.STOPPED}
            and memory.right >= self._safety.recovery
            and estimate is not None
            and self._stands(estimate)
        ):
            self._begin(estimate, now)
        if estimate is not None and memory.phase in {Phase.DRIVING, Phase.PARKED}:
            return self._drive(estimate, now, dt)
        return self._slowed(dt)

    def _in_step(self, step: int, now: float) -> None:
        """Keep the step that the law is in."""
        if step != self._now.step and step >= 0:
            self._tell(now, "step", f"step: {STEP_NAMES[step]}")
        self._now.step = step

    def _arrived(self, parked: bool, now: float) -> None:
        """Keep whether the robot is parked."""
        if parked != (self._now.phase is Phase.PARKED):
            self._now.phase = Phase.PARKED if parked else Phase.DRIVING
            self._tell(now, "parked" if parked else "moved", self._parked_sentence())

    def _begin(self, estimate: Estimate, now: float) -> None:
        """Choose a course from where the robot stands."""
        memory = self._now
        for alarm, most in AT_MOST.items():
            if memory.alarms[alarm] >= most:
                self._refuse(f"{alarm.sentence}, {most} times: given up", now)
                return
        course = self._planner.course(
            estimate,
            self._bounds,
            scale=self._tracker.gains.a[1],
            period=self.period,
            first=memory.course is None,
        )
        if course is None:
            self._refuse(Phase.REFUSED.sentence, now)
            return
        memory.course, memory.phase, memory.alarm = course, Phase.DRIVING, None
        self._take_pilot(course)
        way = "backward" if course.gains.direction == "backward" else "forward"
        leg = f" after a straight leg of {course.stage:g} tag sides" if course.stage else ""
        self._tell(
            now, "course", f"a course {way}{leg}, foreseen to take {course.time:.1f} s at most"
        )

    def _refuse(self, sentence: str, now: float) -> None:
        """Drive no more, and say why."""
        self._now.phase, self._now.alarm = Phase.REFUSED, None
        self._tell(now, "refused", sentence, level=2)

    def _bounds(self, error: float, share: float, middle: float = 0.5) -> Bounds:
        """Bounds of a in goal units per tag side, from frames seen, with the motors' error.

        Parameters
        ----------
        error : float
            Of the motors.
        share : float
            Of the whole uncertainty that is allowed for; with 0 only its middle is.
        middle : float
            Where the middle lies between the least and the greatest gain seen.
        """
        seen = self._tracker.gains.a
        low, high = seen[0] * (1.0 - error), seen[1] * (1.0 + error)
        middle = (1.0 - middle) * seen[0] + middle * seen[1]
        return Bounds(alpha=(middle - share * (middle - low), middle + share * (high - middle)))

    def _stop(self, alarm: Alarm, now: float) -> None:
        """Slow down, and say why."""
        memory = self._now
        if memory.phase is Phase.REFUSED:
            return
        if memory.alarm is not alarm:
            self._tell(now, alarm.name.lower(), f"{alarm.sentence}: stopped", level=1)
            memory.alarms[alarm] += 1
        memory.alarm = alarm
        memory.right = 0
        if memory.phase is not Phase.WAITING:
            memory.phase = Phase.STOPPED

    def _parked_sentence(self) -> str:
        return "parked" if self._now.phase is Phase.PARKED else "moved off the goal: correcting"

    def _tell(self, t: float, name: str, sentence: str, *, level: int = 0) -> None:
        self._now.events.append(Event(t=t, name=name, sentence=sentence, level=level))
