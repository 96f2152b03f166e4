"""Chooses a course before the robot moves: direction, speed and gains with which it stays in view.

Each course is driven in advance, by the same pilot, on the image unicycle with the least and the
greatest gain that are possible. The fastest one that stays in view and inside the chart is taken.
If there is none, courses with a straight leg first are tried; if there is none of those either, the
start is refused, before anything moves.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from msgspec.structs import replace as with_fields

from parkproof.bounds import Bounds
from parkproof.lab.arrival import HOLD, Arrival
from parkproof.lab.devices import RobotLimits
from parkproof.lab.pilot import Course, Pilot
from parkproof.lab.predict import GoalPose, Motion, advanced
from parkproof.lab.view import ImageView, Point
from parkproof.laws.gains import Gains, Switching
from parkproof.laws.time_scale import scaled_approach, scaled_pair

PACES, MORE_PACES = (1.0, 0.6), (1.0, 0.6, 0.35)
"""Time scales κ of Step 2 that are tried, and those that a thorough search tries."""

SLOPES, MORE_SLOPES = (2.0, 1.0, 0.5, 0.25, 0.15), (2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.15)
"""κ/c: how steeply the path crosses over; the steeper, the less travel, the flatter, the farther
from ±90°."""

STAGES = ((0.0,), (1.0, -1.0), (2.0, -2.0), (3.0, -3.0), (4.5, -4.5))
"""Straight legs in goal units, those tried later only if no shorter one does."""

MORE_STAGES = (*STAGES, (6.0, -6.0), (8.0, -8.0))
"""Those that a thorough search tries."""

HOLDING, RETURNING = 2.0, 1.0
"""Time scales of holding and turning, and of the return."""

STEEPEST, MORE_STEEP = math.radians(76.0), math.radians(82.0)
"""Headings beyond this are refused in the run-up and the approach: noise and unequal motors add
some degrees to what was foreseen, and nearer to 90° the course is given up (safety.STEEP). A
thorough search comes nearer."""

CRUISE = (0.2, 3.0)
"""Run-up speeds in goal units per s that are tried."""

LONGEST = 40.0
"""Courses that take longer, in s, are not tried further."""


@dataclass(frozen=True)
class Task:
    """What a course has to do.

    Attributes
    ----------
    view : ImageView
        What the camera sees.
    margin : float
        How far inside the border the tag must stay, in goal units.
    footprint : tuple of points
        Corners of the tag, as `parkproof.lab.view.tag_footprint` gives them.
    limits : RobotLimits
        What the robot can do.
    side : float
        Side of the tag in m.
    bounds : Bounds
        Of the gain a, in goal units per tag side, with the error of the motors.
    arrival : Arrival
        When the robot has arrived.
    tolerance : tuple of two floats
        Of Step 2 (|x1|, |x2|, |u1|) and of Step 3 (|x0|, |u0|), in goal units.
    law : "corrected" or "homogeneous"
        The law.
    gains : Gains, optional
        Gains that are given; only direction and straight leg are chosen then.
    thorough : bool
        Whether to try more speeds, slopes, legs and steeper courses: a few seconds, where there is
        no other.
    quickest : float
        Largest time scale κ of Step 2 that is tried.
    period : float
        Time between commands in s.
    drive : callable, optional
        How courses are driven in advance; default `driven_time`, for a robot that takes velocities.
    """

    view: ImageView
    margin: float
    footprint: tuple[Point, ...]
    limits: RobotLimits
    side: float
    bounds: Bounds
    arrival: Arrival
    tolerance: tuple[float, float]
    law: Literal["corrected", "homogeneous"] = "corrected"
    gains: Gains | None = None
    thorough: bool = False
    quickest: float = PACES[0]
    period: float = 1.0 / 30.0
    drive: "Drive | None" = None


Drive = Callable[[Task, Course, GoalPose, Motion, float, float], float | None]
"""Drives a course in advance from a pose, with a motion, a gain a, and at most so many seconds: the
time that it takes, or None."""


Move = Callable[[float, GoalPose], tuple[int, GoalPose]]
"""Takes the time in s and a pose; answers the step of the law, and the pose a period later."""


def rehearsed(task: Task, pose: GoalPose, longest: float, move: Move) -> float | None:
    """Go through a course in advance, and judge it.

    Parameters
    ----------
    task : Task
        What the course has to do.
    pose : GoalPose
        Where the robot stands.
    longest : float
        Time in s after which it is given up.
    move : callable
        Moves the robot on, as the pilot of the course drives it.

    Returns
    -------
    float or None
        How long it takes in s; None if it leaves the view or the chart, or takes too long.
    """
    room = task.view.room(task.footprint, *pose) - task.margin
    steepest = MORE_STEEP if task.thorough else STEEPEST
    t, turned = 0.0, False
    while t < longest:
        step, after = move(t, pose)
        if step == 0 and turned:
            return None  # it had to turn again
        turned = turned or step > 0
        if step in {1, 2} and abs(pose.theta) > steepest:
            return None
        if step == HOLD:
            return t
        pose = after
        clearance = task.view.room(task.footprint, *pose) - task.margin
        if clearance < min(0.0, room) - 1e-9:
            return None
        room = max(room, min(0.0, clearance))
        t += task.period
    return None


def driven_time(
    task: Task, course: Course, pose: GoalPose, motion: Motion, a: float, longest: float
) -> float | None:
    """Drive a course on the image unicycle with a constant gain a, and β = 1.

    Where the motors' gains are known already, only the rest is uncertain; that is for the task's
    bounds to say.

    Parameters
    ----------
    task : Task
        What the course has to do.
    course : Course
        The course.
    pose : GoalPose
        Where the robot stands.
    motion : Motion
        How the robot answers to commands.
    a : float
        Goal units per tag side.
    longest : float
        Time in s after which it is given up.

    Returns
    -------
    float or None
        How long it takes in s; None if it leaves the view or takes too long.
    """
    pilot = Pilot(
        course, task.bounds, task.limits, side=task.side, period=task.period, arrival=task.arrival
    )

    def move(t: float, pose: GoalPose) -> tuple[int, GoalPose]:
        asked = pilot.step(t, task.period, pose, beta=1.0, motion=motion)
        speed = a * motion.speed * asked.v / task.side
        turn = motion.turn * asked.omega + motion.skew * asked.v
        return asked.step, advanced(pose, task.period, speed, turn)

    return rehearsed(task, pose, longest, move)


def plan_course(task: Task, start: GoalPose, motion: Motion | None = None) -> Course | None:
    """The fastest course from a pose, or None if none stays in view.

    Parameters
    ----------
    task : Task
        What it has to do.
    start : GoalPose
        Where the robot stands.
    motion : Motion, optional
        How the robot answers to commands, as far as it is known.

    Returns
    -------
    Course or None
        The course.

    Examples
    --------
    >>> limits = RobotLimits(speed=0.3, turn_rate=2.0, acceleration=1.0, turn_acceleration=8.0)
    >>> task = Task(ImageView(((-8, -6), (8, -6), (8, 6), (-8, 6))), 0.1,
    ...             ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)), limits, 0.1,
    ...             Bounds(alpha=(0.8, 1.25)), Arrival(0.02, 0.01), (0.01, 0.01))
    >>> course = plan_course(task, GoalPose(-3.0, 1.0, 0.2))
    >>> course.time < 15.0
    True
    >>> narrow = ImageView(((-1.2, -1.2), (1.2, -1.2), (1.2, 1.2), (-1.2, 1.2)))
    >>> plan_course(replace(task, view=narrow), GoalPose(-0.2, 0.3, 1.5)) is None
    True
    """
    motion = motion or Motion()
    for stages in MORE_STAGES if task.thorough else STAGES:
        best: Course | None = None
        for course in _courses(task, stages):
            longest = best.time if best else LONGEST
            time = _worst_time(task, course, start, motion, longest)
            if time is not None and time < longest:
                best = replace(course, time=time)
        if best:
            return best
    return None


def _courses(task: Task, stages: Sequence[float]) -> Iterator[Course]:
    """All courses with these straight legs."""
    across, along = task.tolerance
    directions: tuple[Literal["forward", "backward"], ...] = ("forward", "backward")
    for stage in stages:
        for gains in [task.gains] if task.gains else _gains(task):
            switching = Switching(
                tolerance=(0.1 * gains.runup_speed, across, along),
                hysteresis=3.0,
                turn_tolerance=0.05,
                chart_limit=75.0,
            )
            for direction in directions:
                turned = with_fields(gains, direction=direction)
                yield Course(task.law, turned, switching, stage)


def _gains(task: Task) -> Iterator[Gains]:
    """The paper's Step 2 at several speeds and slopes, with fast holding."""
    base = Gains()
    more = task.thorough or task.quickest < PACES[0]
    paces = [pace for pace in (MORE_PACES if more else PACES) if pace <= task.quickest]
    for pace in paces:
        for slope in MORE_SLOPES if task.thorough else SLOPES:
            cruise = pace / slope
            if CRUISE[0] <= cruise <= CRUISE[1]:
                yield Gains(
                    l=scaled_approach(base.l, base.q1, speed=pace, cruise=cruise),
                    k=scaled_pair(base.k, base.q2, speed=RETURNING),
                    hold=scaled_pair(base.k, base.q2, speed=HOLDING),
                    lambda1=6.0,
                    runup_speed=cruise,
                )


def _worst_time(
    task: Task, course: Course, start: GoalPose, motion: Motion, longest: float
) -> float | None:
    """The time of a course with the least and the greatest gain, None if either leaves the view."""
    drive, worst = task.drive or driven_time, 0.0
    for a in task.bounds.alpha_of(0):
        time = drive(task, course, start, motion, a, longest)
        if time is None:
            return None
        worst = max(worst, time)
    return worst
