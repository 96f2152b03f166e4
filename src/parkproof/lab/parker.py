"""From a frame to a command: detection, estimation, law and safety, with nothing of any device.

A `Parker` is given frames and times, and answers commands. The same frames and times give the same
commands, so that a recorded run can be carried out again.
"""

import enum
import math
from dataclasses import dataclass, field

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.lab.devices import Frame, Missing, RobotLimits
from parkproof.lab.entries import STEP_NAMES, Event
from parkproof.lab.estimate import Estimate, Estimator, Sighting
from parkproof.lab.goal import Goal
from parkproof.lab.image_pose import ImagePose as PixelPose
from parkproof.lab.image_pose import expected, image_pose
from parkproof.lab.limits import limited
from parkproof.lab.pilot import Arrival, Course, Pilot, Pulses
from parkproof.lab.plan import PACES, Drive, Task, plan_course
from parkproof.lab.predict import CommandHistory, GoalPose
from parkproof.lab.safety import Alarm, Guard, SafetyLimits
from parkproof.lab.settings import LabSettings
from parkproof.lab.tag import Detection, TagDetector, Unseen
from parkproof.lab.view import ImageView, tag_footprint
from parkproof.model.homography import Homography

ROOM = 0.12
"""How far the tag stays inside the border in a course, in goal units."""

TRIED = ((1.0, ROOM, False), (0.2, ROOM, False), (0.0, 0.02, True))
"""Shares of the gains' uncertainty, room at the border, and whether to search thoroughly, for the
courses that are tried in turn."""

TOLERANCE = 0.6
"""Tolerances of Steps 2 and 3, as a share of that of arrival."""

PLANS = 8
"""Courses that are begun at most: after so many alarms at the border, the run is given up."""

WHOLE_EVERY = 150
"""Every so many frames the whole picture is searched, for a second tag of the same id."""

FREE_TURN = 0.1
"""Share of the speed limit above which small turn rates need no pulses: the wheels turn anyway."""


class Phase(enum.Enum):
    """What the parker is doing.

    Examples
    --------
    >>> Phase.PARKED.sentence
    'parked'
    """

    WAITING = "waiting for the tag"
    DRIVING = "driving"
    STOPPED = "stopped"
    PARKED = "parked"
    REFUSED = "no course from here stays inside the picture"

    @property
    def sentence(self) -> str:
        """In words."""
        return self.value


@dataclass(frozen=True)
class Answer:
    """What a frame led to.

    Attributes
    ----------
    t : float
        Time of the command in s.
    v, omega : float
        The command, in m/s and rad/s.
    step : int
        Step of the law; see `parkproof.lab.entries.STEP_NAMES`; −1 on a straight leg.
    phase : Phase
        What the parker is doing.
    alarm : Alarm or None
        Why it is stopped.
    estimate : Estimate or None
        What is known, if the tag was seen.
    tag : Detection or None
        The tag, if it was seen.
    events : tuple of Event
        What happened.
    foreseen : float
        How long the course that is driven takes at most, as foreseen, in s.
    accelerations : two floats or None
        For a robot that takes them: v̇ in m/s² and ω̇ in rad/s² to send, or None to brake. v and
        omega are then the speeds that it is taken to have, 0 while it brakes.
    """

    t: float
    v: float
    omega: float
    step: int
    phase: Phase
    alarm: Alarm | None = None
    estimate: Estimate | None = None
    tag: Detection | None = None
    events: tuple[Event, ...] = ()
    foreseen: float = math.nan
    accelerations: tuple[float, float] | None = None


@dataclass
class _Memory:
    """What a parker remembers from frame to frame."""

    phase: Phase = Phase.WAITING
    alarm: Alarm | None = None
    pilot: Pilot | None = None
    course: Course | None = None
    sent: tuple[float, float] = (0.0, 0.0)
    called: float | None = None
    seen: float = -math.inf
    near: PixelPose | None = None
    frames: int = 0
    right: int = 0
    step: int = -1
    plans: int = 0
    events: list[Event] = field(default_factory=list)


class Parker:
    """Parks a robot as it was shown.

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
    ) -> None:
        self._goal, self._limits = goal, limits
        self._settings, self._safety = settings or LabSettings(), safety or SafetyLimits()
        self._detector = TagDetector()
        self._history = CommandHistory()
        self._estimator = self._new_estimator()
        self._view = ImageView(tuple(goal.corners()))
        self._guard = Guard(self._safety, limits, self._view, mount=goal.mount)
        self._arrival = Arrival(self._settings.position_px / goal.unit, self._settings.heading)
        at_goal = image_pose(Homography(goal.homography), goal.mount)
        self._gains = at_goal.a_min / goal.unit, at_goal.a_max / goal.unit
        self._scale = 1.0
        self._pulses = Pulses(limits.least_speed), Pulses(limits.least_turn_rate)
        self._now = _Memory()

    @property
    def course(self) -> Course | None:
        """The course that is driven."""
        return self._now.course

    @property
    def history(self) -> CommandHistory:
        """The commands that were sent."""
        return self._history

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
        tag, seen, alarm = self._look(reading, now)
        estimate = None
        if seen is not None:
            estimate = self._estimator.update(seen, self._history, now=now)
            memory.seen = now
        v, omega = self._decide(estimate, alarm, now, dt)
        memory.sent = (v, omega)
        self._remember(now)
        return Answer(
            now,
            v,
            omega,
            memory.step,
            memory.phase,
            memory.alarm,
            estimate,
            tag,
            tuple(memory.events),
            math.nan if memory.course is None else memory.course.time,
            self._accelerations,
        )

    def _new_estimator(self) -> Estimator:
        return Estimator(delay=self._settings.delay)

    @property
    def _accelerations(self) -> tuple[float, float] | None:
        """What is sent to a robot that takes accelerations."""
        return None

    def _remember(self, now: float) -> None:
        """Keep what is sent, for the prediction."""
        self._history.add(now, *self._now.sent)

    def _look(
        self, reading: Frame | Missing, now: float
    ) -> tuple[Detection | None, Sighting | None, Alarm | None]:
        """The robot in a frame, or what is wrong with it."""
        memory, goal = self._now, self._goal
        if isinstance(reading, Missing):
            return None, None, Alarm.NO_FRAME
        if alarm := self._guard.of_frame(reading, now):
            return None, None, alarm
        memory.frames += 1
        near = None
        if memory.near is not None and memory.frames % WHOLE_EVERY:
            near = expected(memory.near, goal.mount)
        try:
            goal.check_picture(reading.image)
            found = self._detector.find(
                reading.image, goal.mount.tag_id, near=near, flipped=goal.flipped
            )
        except InputError:
            return None, None, Alarm.OTHER_PICTURE
        if isinstance(found, Unseen):
            memory.near = None
            return None, None, Alarm.TWO_TAGS if found is Unseen.TWICE else Alarm.TAG_LOST
        shown = image_pose(found.homography, goal.mount)
        memory.near = shown
        low, high = self._gains
        self._scale = shown.a_max / goal.unit
        self._gains = min(low, shown.a_min / goal.unit), max(high, shown.a_max / goal.unit)
        pose, a, beta = goal.to_image(shown)
        seen = Sighting(
            reading.t - self._settings.stamp_delay, GoalPose(*pose), a / goal.mount.side, beta
        )
        if alarm := self._guard.of_sighting(seen):
            return found, None, alarm
        return found, seen, None

    def _decide(
        self,
        estimate: Estimate | None,
        alarm: Alarm | None,
        now: float,
        dt: float,
    ) -> tuple[float, float]:
        """The command, by what the parker is doing."""
        memory = self._now
        memory.right = memory.right + 1 if alarm is None else 0
        if alarm is not None:
            carried = alarm is Alarm.JUMP and self._guard.carried
            if carried:
                self._estimator.forget()
            elif now - memory.seen <= self._safety.patience:
                return self._held()
            self._stop(alarm, now)
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

    def _held(self) -> tuple[float, float]:
        """What is sent while it is not yet clear that something is wrong."""
        return self._now.sent

    def _slowed(self, dt: float) -> tuple[float, float]:
        """What is sent to stop."""
        return limited(0.0, 0.0, *self._now.sent, dt, self._limits)

    def _stands(self, _estimate: Estimate) -> bool:
        """Whether the robot stands still."""
        return self._now.sent == (0.0, 0.0)

    def _drive(self, estimate: Estimate, now: float, dt: float) -> tuple[float, float]:
        """The command of the course, unless it leads out of the picture."""
        memory = self._now
        assert memory.pilot is not None  # a course was begun
        asked = memory.pilot.step(
            now, dt, estimate.ahead, beta=estimate.beta, motion=estimate.motion
        )
        self._in_step(asked.step, now)
        if alarm := self._guard.of_motion(estimate, asked.v, asked.omega, scale=self._scale):
            self._stop(alarm, now)
            return self._slowed(dt)
        self._arrived(asked.parked, now)
        return self._shaped(asked.v, asked.omega, dt)

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

    def _shaped(self, v: float, omega: float, dt: float) -> tuple[float, float]:
        """Pulses in place of what is below the robot's dead-band, within all limits."""
        shaped_v, shaped_omega = self._pulses[0].shaped(v, dt), omega
        if abs(shaped_v) < FREE_TURN * self._limits.speed:
            shaped_omega = self._pulses[1].shaped(omega, dt)
        return limited(shaped_v, shaped_omega, *self._now.sent, dt, self._limits)

    def _begin(self, estimate: Estimate, now: float) -> None:
        """Choose a course from where the robot stands."""
        memory = self._now
        first = memory.course is None
        course = None
        if memory.plans < PLANS:
            course = self._planned(estimate, first=first)
        memory.plans += 1
        if course is None:
            memory.phase, memory.alarm = Phase.REFUSED, None
            self._tell(now, "refused", Phase.REFUSED.sentence, level=2)
            return
        memory.course, memory.phase, memory.alarm = course, Phase.DRIVING, None
        self._take_pilot(course)
        way = "backward" if course.gains.direction == "backward" else "forward"
        leg = f" after a straight leg of {course.stage:g} tag sides" if course.stage else ""
        self._tell(
            now, "course", f"a course {way}{leg}, foreseen to take {course.time:.1f} s at most"
        )

    def _take_pilot(self, course: Course) -> None:
        """Have a course driven from now on."""
        self._now.pilot = Pilot(
            course,
            self._bounds(self._settings.motor_error, 1.0),
            self._limits,
            side=self._goal.mount.side,
            period=1.0 / self._settings.rate,
            arrival=self._arrival,
        )

    def _planned(self, estimate: Estimate, *, first: bool) -> Course | None:
        """A course for all gains that are possible; failing that, for those that are likely.

        What then is not as foreseen, the guard at the border notices: it stops the robot, and
        another course is chosen from there.
        """
        footprint = tag_footprint(self._goal.mount, self._gains[1])
        error = self._settings.motor_error if first else 0.5 * self._settings.motor_error
        for share, room, thorough in TRIED:
            task = Task(
                view=self._view,
                margin=room,
                footprint=footprint,
                limits=self._limits,
                side=self._goal.mount.side,
                bounds=self._bounds(error, share),
                arrival=self._arrival,
                tolerance=(TOLERANCE * self._arrival.position,) * 2,
                law=self._settings.law,
                gains=self._settings.gains,
                thorough=thorough,
                quickest=self._quickest,
                drive=self._in_advance,
            )
            course = plan_course(task, estimate.pose, estimate.motion)
            if course is not None:
                return course
        return None

    _in_advance: Drive | None = None
    _quickest = PACES[0]

    def _bounds(self, error: float, share: float) -> Bounds:
        """Bounds of a in goal units per tag side, from frames seen, with the motors' error.

        Parameters
        ----------
        error : float
            Of the motors.
        share : float
            Of the whole uncertainty that is allowed for; with 0 only its middle is.
        """
        low, high = self._gains[0] * (1.0 - error), self._gains[1] * (1.0 + error)
        middle = 0.5 * (self._gains[0] + self._gains[1])
        return Bounds(alpha=(middle - share * (middle - low), middle + share * (high - middle)))

    def _stop(self, alarm: Alarm, now: float) -> None:
        """Slow down, and say why."""
        memory = self._now
        if memory.phase is Phase.REFUSED:
            return
        if memory.alarm is not alarm:
            self._tell(now, alarm.name.lower(), f"{alarm.sentence}: stopped", level=1)
        memory.alarm = alarm
        memory.right = 0
        if memory.phase is not Phase.WAITING:
            memory.phase = Phase.STOPPED

    def _parked_sentence(self) -> str:
        return "parked" if self._now.phase is Phase.PARKED else "moved off the goal: correcting"

    def _tell(self, t: float, name: str, sentence: str, *, level: int = 0) -> None:
        self._now.events.append(Event(t=t, name=name, sentence=sentence, level=level))
