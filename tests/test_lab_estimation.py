"""Differentiator, predictor and what is learnt of the robot's motion."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.lab.differentiate import Differentiator
from parkproof.lab.estimate import Estimator, Sighting
from parkproof.lab.identify import MotionEstimate
from parkproof.lab.predict import CommandHistory, GoalPose, Motion, advanced, predicted_pose


@given(
    c0=st.floats(-3.0, 3.0),
    c1=st.floats(-3.0, 3.0),
    c2=st.floats(-3.0, 3.0),
    dt=st.floats(0.005, 0.07),
)
def test_polynomials_of_degree_two_are_differentiated_exactly(c0, c1, c2, dt):
    differentiator, t = Differentiator(bound=400.0), 0.0
    for _ in range(round(6.0 / dt)):
        t += dt
        found = differentiator.update(dt, c0 + c1 * t + 0.5 * c2 * t * t)
    assert found.rate == pytest.approx(c1 + c2 * t, abs=1e-6)
    assert found.acceleration == pytest.approx(c2, abs=1e-5)


def test_a_constant_signal_makes_no_chatter():
    differentiator = Differentiator(bound=100.0)
    rates = [differentiator.update(1 / 30, 2.5).rate for _ in range(100)]
    assert max(abs(rate) for rate in rates[50:]) < 1e-9


def test_the_error_of_the_rate_grows_with_noise_as_its_power_two_thirds():
    errors = []
    for size in (1e-4, 8e-4):
        rng = np.random.default_rng(1)
        differentiator, worst = Differentiator(bound=20.0), 0.0
        for k in range(1, 4001):
            t = 0.005 * k
            found = differentiator.update(0.005, math.sin(t) + size * rng.uniform(-1, 1))
            if k > 1000:
                worst = max(worst, abs(found.rate - math.cos(t)))
        errors.append(worst)
    # bounds with constants of order 1: L^(1/3) ε^(2/3)
    for size, error in zip((1e-4, 8e-4), errors, strict=True):
        assert error < 4.0 * 20.0 ** (1 / 3) * size ** (2 / 3)
    assert errors[0] < errors[1]


@given(
    v=st.floats(-1.0, 1.0), omega=st.floats(-3.0, 3.0), dt=st.floats(0.01, 1.0), parts=st.just(200)
)
def test_an_arc_is_the_limit_of_many_small_steps(v, omega, dt, parts):
    exact = advanced(GoalPose(0.1, -0.2, 0.3), dt, v, omega)
    x, y, theta = 0.1, -0.2, 0.3
    for _ in range(parts):
        middle = theta + 0.5 * omega * dt / parts
        x += v * dt / parts * math.cos(middle)
        y += v * dt / parts * math.sin(middle)
        theta += omega * dt / parts
    assert exact.x == pytest.approx(x, abs=1e-4)
    assert exact.y == pytest.approx(y, abs=1e-4)
    assert math.remainder(exact.theta - theta, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_prediction_is_where_the_robot_comes_to_under_the_commands_that_were_sent():
    history, motion = CommandHistory(), Motion(speed=0.8, turn=1.1, skew=0.5)
    for t, v, omega in ((0.0, 0.2, 0.0), (0.05, 0.1, 1.0), (0.12, -0.1, -0.5)):
        history.add(t, v, omega)
    pose = GoalPose(1.0, 2.0, 3.0)
    found = predicted_pose(pose, history, start=0.02, end=0.2, a=10.0, beta=0.9, motion=motion)
    for dt, v, omega in ((0.03, 0.2, 0.0), (0.07, 0.1, 1.0), (0.08, -0.1, -0.5)):
        pose = advanced(pose, dt, 10.0 * 0.8 * v, 0.9 * (1.1 * omega + 0.5 * v))
    assert found == pytest.approx(pose)


def test_before_the_first_command_the_robot_stands_still():
    history = CommandHistory()
    history.add(1.0, 0.5, 0.0)
    assert history.totals(0.0, 1.0) == (0.0, 0.0)
    assert history.totals(0.0, 1.5) == (0.25, 0.0)


def test_gains_and_skew_of_unequal_wheels_are_learnt():
    rng, estimate = np.random.default_rng(3), MotionEstimate()
    left, right, track = 0.75, 1.2, 0.16
    for _ in range(90):
        v, omega = rng.uniform(-0.01, 0.01), rng.uniform(-0.05, 0.05)
        rims = left * (v - 0.5 * track * omega), right * (v + 0.5 * track * omega)
        estimate.update(
            way=0.5 * (rims[0] + rims[1]),
            angle=(rims[1] - rims[0]) / track + 0.001 * rng.standard_normal(),
            sent_way=v,
            sent_angle=omega,
        )
    motion = estimate.motion
    assert motion.turn == pytest.approx(0.5 * (left + right), abs=0.05)
    assert motion.skew == pytest.approx((right - left) / track, abs=0.3)


def test_nothing_is_learnt_at_rest_or_from_what_is_no_number():
    estimate = MotionEstimate()
    estimate.update(way=1.0, angle=1.0, sent_way=0.0, sent_angle=0.0)
    estimate.update(way=math.nan, angle=0.0, sent_way=0.1, sent_angle=0.1)
    assert estimate.motion == Motion()


def test_headings_are_followed_across_half_a_turn():
    estimator, history = Estimator(delay=0.0), CommandHistory()
    history.add(0.0, 0.0, 2.0)
    for k in range(1, 121):
        t = k / 30
        theta = math.remainder(2.0 + 2.0 * t, 2 * math.pi)
        seen = Sighting(t, GoalPose(0.0, 0.0, theta), a=10.0, beta=1.0)
        found = estimator.update(seen, history, now=t + 0.066)
    assert found.omega == pytest.approx(2.0, abs=1e-6)
    assert math.remainder(found.ahead.theta - found.pose.theta - 2.0 * 0.066, 2 * math.pi) == (
        pytest.approx(0.0, abs=1e-6)
    )


def test_a_gap_begins_derivatives_anew():
    estimator, history = Estimator(delay=0.0), CommandHistory()
    for k in range(30):
        estimator.update(Sighting(k / 30, GoalPose(k / 30, 0, 0), 10.0, 1.0), history, now=k / 30)
    found = estimator.update(Sighting(3.0, GoalPose(-5.0, 0, 0), 10.0, 1.0), history, now=3.0)
    assert (found.v, found.pose.x) == (0.0, -5.0)
