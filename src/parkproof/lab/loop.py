"""The loop of the laboratory: a frame in, a command out, until the robot is parked and held."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import msgspec

from parkproof.errors import InputError
from parkproof.lab.accelerated_watchdog import stopping
from parkproof.lab.answer import Answer, Phase
from parkproof.lab.carry_out import carry_out
from parkproof.lab.devices import (
    AcceleratedRobot,
    Camera,
    Clock,
    Frame,
    Missing,
    Robot,
    RobotSilentError,
)
from parkproof.lab.entries import Event
from parkproof.lab.goal import Goal
from parkproof.lab.outcome import LabOutcome
from parkproof.lab.parker_for import commanded_by, parker_for
from parkproof.lab.record import Recorder
from parkproof.lab.safety import SafetyLimits
from parkproof.lab.settings import LabSettings
from parkproof.lab.summary import FrameCounts, Sample
from parkproof.lab.unseen import why_unseen

DEAD_MAN = 0.3
"""Time without a command in s after which a thread stops a real robot."""

PATIENCE = 1.5
"""How many frame periods the camera is waited for."""


@dataclass
class Finished:
    """A run at its end.

    Attributes
    ----------
    outcome : LabOutcome
        How it ended.
    ended, parked_at : float
        When it ended, and since when the robot was parked (None if it is not), on the loop's clock.
    began : float
        When it began.
    samples : list of Sample
        One for each frame in which the tag was seen.
    frames : FrameCounts
        How the frames fared.
    latencies : list of float
        From image in to command out, in s of the computer's own clock.
    events : list of Event
        What happened; times from the beginning.
    note : str
        What the robot said when it fell silent, why the run was given up or the camera ended, or
        what was seen in place of the robot's tag.
    stopped_by : str
        The signal that interrupted it, as in "SIGINT"; empty if none did.
    """

    outcome: LabOutcome = LabOutcome.STILL_MOVING
    began: float = 0.0
    ended: float = 0.0
    parked_at: float | None = None
    samples: list[Sample] = field(default_factory=list)
    frames: FrameCounts = field(default_factory=lambda: FrameCounts(seen=0))
    latencies: list[float] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    note: str = ""
    stopped_by: str = ""


Watch = Callable[[Frame | Missing, Answer], None]
"""Told of every frame with what it led to."""


def replay_settings(
    goal: Goal, robot: Robot | AcceleratedRobot, settings: LabSettings, safety: SafetyLimits
) -> dict[str, Any]:
    """All that a replay needs, in what JSON has.

    Parameters
    ----------
    goal, robot, settings, safety
        As `run_lab` takes them.

    Returns
    -------
    dict
        To be given to a `Recorder`.
    """
    return {
        "goal": msgspec.to_builtins(goal),
        "commanded_by": commanded_by(robot),
        "limits": msgspec.to_builtins(robot.limits),
        "settings": msgspec.to_builtins(settings),
        "safety": msgspec.to_builtins(safety),
    }


def run_lab(
    camera: Camera,
    robot: Robot | AcceleratedRobot,
    clock: Clock,
    goal: Goal,
    *,
    settings: LabSettings | None = None,
    safety: SafetyLimits | None = None,
    recorder: Recorder | None = None,
    watch: Watch = lambda *_: None,
    realtime: bool = True,
) -> Finished:
    """Park a robot, and hold it; whatever happens, it is stopped at the end.

    Parameters
    ----------
    camera, robot, clock
        The laboratory.
    goal : Goal
        Where to park.
    settings : LabSettings, optional
        Law, times and tolerances.
    safety : SafetyLimits, optional
        When something is wrong.
    recorder : Recorder, optional
        Records the run.
    watch : callable, optional
        Told of every frame with what it led to.
    realtime : bool
        Whether the clock goes on by itself: a thread then stops a robot that gets no command.

    Returns
    -------
    Finished
        The run.
    """
    settings, safety = settings or LabSettings(), safety or SafetyLimits()
    parker = parker_for(commanded_by(robot), goal, robot.limits, settings, safety)
    eye, watched = (camera, clock) if recorder is None else recorder.watch(camera, clock)
    run = _Run(settings, recorder, watch)
    with stopping(robot, clock=clock, timeout=DEAD_MAN if realtime else None) as safe:
        try:
            run.begin(watched.now())
            while run.outcome is None:
                reading = eye.read(min(PATIENCE * parker.period, safety.patience))
                now = watched.now()
                started = time.perf_counter()
                answer = parker.step(reading, now)
                answer = carry_out(safe, parker, answer)
                run.take(reading, now, answer, time.perf_counter() - started)
        except RobotSilentError as error:
            run.outcome, run.finished.note = LabOutcome.ROBOT_SILENT, str(error)
        except KeyboardInterrupt:
            run.outcome = LabOutcome.INTERRUPTED
    notes = []
    if run.outcome is LabOutcome.CAMERA_ENDED:
        notes.append(getattr(camera, "why_ended", ""))
    if run.outcome in {LabOutcome.CAMERA_ENDED, LabOutcome.NEVER_SEEN} and not run.finished.samples:
        notes.append(_why_unseen(run.last, goal) or run.alarm)
    run.finished.note = "; ".join(filter(None, notes)) or run.finished.note
    run.finished.stopped_by = safe.stopped_by
    return run.end()


def _why_unseen(frame: Frame | None, goal: Goal) -> str:
    """What the last frame shows in place of the robot; empty if it does show the robot."""
    if frame is None:
        return "the camera gave no picture; see that it is on and that no other program uses it"
    try:
        goal.check_picture(frame.image)
        return why_unseen(frame.image, goal.mount.tag_id, flipped=goal.flipped)
    except InputError as error:
        return str(error)


class _Run:
    """What becomes of a run, frame by frame."""

    def __init__(self, settings: LabSettings, recorder: Recorder | None, watch: Watch) -> None:
        self._settings, self._recorder, self._watch = settings, recorder, watch
        self.outcome: LabOutcome | None = None
        self.finished = Finished()
        self._seen = self._blind = self._missing = self._dropped = 0
        self.last: Frame | None = None
        self.alarm = ""
        self._courses = 0

    def begin(self, now: float) -> None:
        """Start the run's time."""
        self.finished.began = self.finished.ended = now

    def take(self, reading: Frame | Missing, now: float, answer: Answer, latency: float) -> None:
        """Keep what a frame led to, and judge whether the run is over."""
        run = self.finished
        run.ended = now
        self._count(reading, answer)
        self.alarm = "" if answer.alarm is None else answer.alarm.sentence
        if isinstance(reading, Frame):
            run.latencies.append(latency)
        if answer.estimate is not None:
            run.samples.append(_sample(answer, run.began))
        run.events += [
            msgspec.structs.replace(event, t=event.t - run.began) for event in answer.events
        ]
        self._courses += sum(event.name == "course" for event in answer.events)
        if self._recorder is not None:
            _record(self._recorder, reading, now, answer)
        self._watch(reading, answer)
        run.parked_at = (run.parked_at or now) if answer.phase is Phase.PARKED else None
        self.outcome = self._judged(reading, now, answer)

    def _count(self, reading: Frame | Missing, answer: Answer) -> None:
        if isinstance(reading, Missing):
            self._missing += 1
            return
        if self.last is not None:
            self._dropped += max(0, reading.number - self.last.number - 1)
        self.last = reading
        if answer.tag is None:
            self._blind += 1
        else:
            self._seen += 1

    def _judged(self, reading: Frame | Missing, now: float, answer: Answer) -> LabOutcome | None:
        """The outcome, or None while the run goes on."""
        run, settings = self.finished, self._settings
        if reading is Missing.ENDED:
            return LabOutcome.CAMERA_ENDED
        if answer.phase is Phase.REFUSED and (answer.v, answer.omega) == (0.0, 0.0):
            if not self._courses:
                return LabOutcome.REFUSED
            run.note = next(e.sentence for e in reversed(run.events) if e.name == "refused")
            return LabOutcome.GAVE_UP
        if run.parked_at is not None and now - run.parked_at >= settings.hold:
            return LabOutcome.PARKED
        if not run.samples and now - run.began >= min(settings.wait, settings.duration):
            return LabOutcome.NEVER_SEEN
        return LabOutcome.STILL_MOVING if now - run.began >= settings.duration else None

    def end(self) -> Finished:
        """The run at its end."""
        run = self.finished
        run.outcome = self.outcome or LabOutcome.INTERRUPTED
        run.frames = FrameCounts(
            seen=self._seen,
            without_tag=self._blind,
            missing=self._missing,
            dropped=self._dropped,
        )
        return run


def _sample(answer: Answer, began: float) -> Sample:
    """The estimate of a frame with its command."""
    estimate = answer.estimate
    assert estimate is not None  # only then is it called
    x, y, theta = estimate.pose
    return Sample(
        t=answer.t - began,
        x0=x,
        x1=y,
        psi=theta,
        v=answer.v,
        omega=answer.omega,
        step=max(answer.step, 0),
        beta=estimate.beta,
        tau=answer.tau,
    )


def _record(recorder: Recorder, reading: Frame | Missing, now: float, answer: Answer) -> None:
    """Write down a frame and what it led to."""
    if isinstance(reading, Missing):
        recorder.missing(reading, now)
    else:
        recorder.frame(reading, now)
        estimate = answer.estimate
        recorder.measured(
            reading.t,
            image=answer.image,
            corners=None if answer.tag is None else answer.tag.corners,
            estimate=None if estimate is None else estimate.pose,
            prediction=None if estimate is None else estimate.ahead,
            predicted_for=None if estimate is None else now,
        )
    for event in answer.events:
        recorder.event(event.t, event.name, event.sentence, level=event.level)
    recorder.command(
        answer.t,
        answer.v,
        answer.omega,
        answer.step,
        accelerations=answer.accelerations,
        asked=answer.asked,
        halted=answer.halted,
    )
