"""Courses: chosen before the robot moves, inside the view, within the limits."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.bounds import Bounds
from parkproof.lab.arrival import Arrival
from parkproof.lab.devices import RobotLimits
from parkproof.lab.image_pose import TagMount
from parkproof.lab.pilot import Course, Pilot, Pulses
from parkproof.lab.plan import Task, plan_course
from parkproof.lab.predict import GoalPose, Motion, advanced
from parkproof.lab.view import ImageView, tag_footprint
from parkproof.laws.time_scale import scaled_approach, scaled_pair

LIMITS = RobotLimits(speed=0.3, turn_rate=2.5, acceleration=1.0, turn_acceleration=10.0)
VIEW = ImageView(((-8.0, -6.0), (8.0, -6.0), (8.0, 6.0), (-8.0, 6.0)))
ARRIVAL = Arrival(0.015, 0.007)
TAG = tag_footprint(TagMount(), 1.0)
TASK = Task(VIEW, 0.1, TAG, LIMITS, 0.1, Bounds(alpha=(0.8, 1.25)), ARRIVAL, (0.01, 0.01))
PERIOD = 1 / 30


def driven(course: Course, start: GoalPose, *, a: float, seconds: float = 40.0) -> list:
    """Poses and commands along a course on an image unicycle with this gain."""
    pilot = Pilot(course, TASK.bounds, LIMITS, side=0.1, period=PERIOD, arrival=ARRIVAL)
    pose, found = start, []
    for k in range(round(seconds / PERIOD)):
        asked = pilot.step(k * PERIOD, PERIOD, pose, beta=1.0, motion=Motion())
        found.append((pose, asked))
        pose = advanced(pose, PERIOD, a * asked.v / 0.1, asked.omega)
    return found


STARTS = [
    GoalPose(-3.0, 1.0, 0.2),
    GoalPose(2.0, -2.5, 3.0),
    GoalPose(5.0, 3.0, -1.5),
    GoalPose(0.0, 4.0, 1.6),
]


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("a", [0.8, 1.0, 1.25])
def test_a_course_parks_inside_the_view_at_every_gain_in_its_bounds(start, a):
    course = plan_course(TASK, start)
    run = driven(course, start, a=a)
    assert run[-1][1].parked
    assert math.hypot(*run[-1][0][:2]) <= ARRIVAL.release * ARRIVAL.position
    assert min(VIEW.room(TAG, *pose) for pose, _ in run) > 0.05


@pytest.mark.parametrize("start", STARTS)
def test_commands_never_exceed_a_limit_of_speed_or_of_its_change(start):
    run = driven(plan_course(TASK, start), start, a=1.0)
    sent = [(asked.v, asked.omega) for _, asked in run]
    assert max(abs(v) for v, _ in sent) <= LIMITS.speed
    assert max(abs(omega) for _, omega in sent) <= LIMITS.turn_rate
    for (v, omega), (w, psi) in zip([(0.0, 0.0), *sent], sent, strict=False):
        assert abs(w - v) <= LIMITS.acceleration * PERIOD * (1 + 1e-9)
        assert abs(psi - omega) <= LIMITS.turn_acceleration * PERIOD * (1 + 1e-9)


def test_a_start_that_cannot_be_parked_inside_the_view_has_no_course():
    narrow = ImageView(((-1.2, -1.2), (1.2, -1.2), (1.2, 1.2), (-1.2, 1.2)))
    assert plan_course(replace(TASK, view=narrow), GoalPose(-0.2, 0.3, 1.5)) is None


def test_the_direction_is_the_one_that_stays_in_view():
    tight_ahead = ImageView(((-9.0, -6.0), (1.5, -6.0), (1.5, 6.0), (-9.0, 6.0)))
    course = plan_course(replace(TASK, view=tight_ahead), GoalPose(-0.2, 2.0, 0.0))
    tight_behind = ImageView(((-1.5, -6.0), (9.0, -6.0), (9.0, 6.0), (-1.5, 6.0)))
    other = plan_course(replace(TASK, view=tight_behind), GoalPose(0.2, 2.0, 0.0))
    assert (course.gains.direction, other.gains.direction) == ("backward", "forward")


def test_a_straight_leg_comes_first_where_no_course_begins_at_the_start():
    narrow = ImageView(((-2.2, -6.0), (2.2, -6.0), (2.2, 6.0), (-2.2, 6.0)))
    course = plan_course(replace(TASK, view=narrow), GoalPose(-1.0, 3.5, 1.5))
    assert course.stage < 0.0
    run = driven(course, GoalPose(-1.0, 3.5, 1.5), a=1.0)
    assert run[-1][1].parked
    assert min(narrow.room(TAG, *pose) for pose, _ in run) > 0.05
    assert run[0][1].step == -1


@given(speed=st.floats(0.3, 3.0), cruise=st.floats(0.3, 3.0))
def test_scaled_gains_follow_the_same_path_at_another_speed(speed, cruise):
    l1, l2, l3 = scaled_approach((2.0, 4.2, 21.0), "9/11", speed=speed, cruise=cruise)
    q = 9 / 11

    def tau(x1, x2, u1, gains):
        xi1 = math.copysign(abs(x2) ** (1 / q), x2) + gains[0] ** (1 / q) * x1
        e = 2 * q - 1
        xi2 = math.copysign(abs(u1) ** (1 / e), u1) + gains[1] ** (1 / e) * xi1
        return -gains[2] * math.copysign(abs(xi2) ** (3 * q - 2), xi2)

    state = (0.3, -0.4, 0.5)
    scaled = (0.3, -0.4 * speed / cruise, 0.5 * speed**2 / cruise)
    expected = tau(*state, (2.0, 4.2, 21.0)) * speed**3 / cruise
    assert tau(*scaled, (l1, l2, l3)) == pytest.approx(expected, rel=1e-9)


def test_scaled_pair_is_as_many_times_as_fast():
    k1, k3 = scaled_pair((1.5, 6.5), "7/9", speed=2.0)
    q = 7 / 9

    def tau(x, u, gains):
        xi = math.copysign(abs(u) ** (1 / q), u) + gains[0] ** (1 / q) * x
        return -gains[1] * math.copysign(abs(xi) ** (2 * q - 1), xi)

    assert tau(0.3, 2.0 * 0.4, (k1, k3)) == pytest.approx(4.0 * tau(0.3, 0.4, (1.5, 6.5)))


@given(
    speeds=st.lists(st.floats(-0.02, 0.02), min_size=200, max_size=200), least=st.floats(0.02, 0.05)
)
def test_pulses_have_the_mean_of_what_they_replace(speeds, least):
    pulses, dt = Pulses(least), 1 / 30
    sent = [pulses.shaped(speed, dt) for speed in speeds]
    wanted = [speed for speed in speeds if abs(speed) < least]
    assert all(value == 0.0 or abs(value) >= least * (1 - 1e-12) for value in sent)
    if len(wanted) == len(speeds):
        assert abs(sum(sent) - sum(speeds)) <= least
