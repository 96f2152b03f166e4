"""The unicycle (1) and angles."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.model.unicycle import Pose, unicycle_rates, wrap_angle

angles = st.floats(-1e6, 1e6)


@given(angles)
def test_wrap_angle_lands_in_the_interval_and_keeps_the_direction(angle):
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@given(st.floats(-math.pi, math.pi, exclude_min=True))
def test_wrap_angle_keeps_wrapped_angles(angle):
    assert wrap_angle(angle) == angle


@pytest.mark.parametrize("turns", range(-4, 5))
def test_half_turns_wrap_to_plus_pi(turns):
    assert abs(wrap_angle((2 * turns + 1) * math.pi)) == pytest.approx(math.pi)
    assert wrap_angle(-math.pi) == math.pi


@given(st.floats(-10, 10), st.floats(-10, 10), st.floats(-10, 10))
def test_unicycle_never_slides_sideways(v, omega, theta):
    c, s = math.cos(theta), math.sin(theta)
    x_dot, y_dot, theta_dot = unicycle_rates(v, omega, c, s)
    assert x_dot * s - y_dot * c == pytest.approx(0.0, abs=1e-12)
    assert x_dot * c + y_dot * s == pytest.approx(v, abs=1e-12)
    assert theta_dot == omega


def test_pose_is_a_plain_tuple():
    assert Pose(1.0, 2.0, 0.5) == (1.0, 2.0, 0.5)
