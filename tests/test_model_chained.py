"""The chained form (5), its chart, its extension (6) and the torque-level feed-forward."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.errors import InputError
from parkproof.model.camera import PinholeCamera
from parkproof.model.chained import (
    ChainedState,
    acceleration_for,
    body_inputs,
    chained_inputs,
    chained_rates,
    extension_rate,
    from_chained,
    image_acceleration_for,
    image_input_rates,
    input_rates,
    to_chained,
)
from parkproof.model.goal_frame import goal_homography
from parkproof.model.image_unicycle import image_gain_rates, image_of
from parkproof.model.unicycle import Pose, Velocity, unicycle_rates

numbers = st.floats(-100.0, 100.0)
headings = st.floats(-0.5 * math.pi, 0.5 * math.pi, exclude_min=True, exclude_max=True)
slopes = st.floats(-1.4, 1.4)
gains = st.floats(0.1, 10.0)
signs = st.sampled_from([-1.0, 1.0])


def near(values):
    return pytest.approx(values, rel=1e-9, abs=1e-9)


@given(numbers, numbers, headings, numbers, numbers)
def test_pose_round_trip_over_the_whole_chart(x, y, theta, v, omega):
    pose, velocity = from_chained(to_chained(Pose(x, y, theta), Velocity(v, omega)))
    assert pose == near((x, y, theta))
    assert velocity == near((v, omega))


@given(numbers, numbers, numbers, numbers, numbers)
def test_chained_round_trip(x0, x1, x2, u0, u1):
    state = ChainedState(x0, x1, x2, u0, u1)
    assert to_chained(*from_chained(state)) == near(tuple(state))


@given(slopes, numbers, numbers)
def test_input_map_is_the_papers(theta, v, omega):
    u0, u1 = chained_inputs(v, omega, math.tan(theta))
    assert (u0, u1) == near((v * math.cos(theta), omega / math.cos(theta) ** 2))
    assert body_inputs(u0, u1, math.tan(theta)) == near((v, omega))


@given(slopes, numbers, numbers, gains, gains)
def test_chained_rates_are_those_of_the_unicycle_under_unequal_gains(theta, v, omega, g0, g1):
    c, s = math.cos(theta), math.sin(theta)
    x_dot, y_dot, theta_dot = unicycle_rates(v, omega, c, s)
    u0, u1 = chained_inputs(v, omega, s / c)
    assert chained_rates(s / c, u0, u1, g0, g1, 1.0) == near(
        (g0 * x_dot, g1 * y_dot, theta_dot / c**2)
    )


@pytest.mark.parametrize("turns", [-2, -1, 0, 1, 3])
def test_whole_turns_do_not_matter(turns):
    state = to_chained(Pose(0.0, 0.0, 0.4 + 2 * math.pi * turns), Velocity(1.0, 0.0))
    assert state.x2 == near(math.tan(0.4))


@pytest.mark.parametrize("theta", [math.pi / 2, -math.pi / 2, 1.6, math.pi, -2.0, 8.0])
def test_headings_outside_the_chart_are_refused_with_the_remedy(theta):
    with pytest.raises(InputError, match=r'theta = .*±90°.*law = "corrected"'):
        to_chained(Pose(0.0, 0.0, theta), Velocity(0.0, 0.0))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", range(5))
def test_not_a_number_is_refused(bad, place):
    values = [0.1] * 5
    values[place] = bad
    with pytest.raises(InputError):
        to_chained(Pose(*values[:3]), Velocity(*values[3:]))
    with pytest.raises(InputError):
        from_chained(ChainedState(*values))


@given(numbers, gains, numbers)
def test_extension(tau, gamma, phi):
    assert extension_rate(tau, gamma, phi) == gamma * tau + phi


@given(numbers, numbers, st.floats(-5, 5), st.floats(-5, 5), st.floats(-1.3, 1.3), gains, signs)
def test_feed_forward_round_trips(tau1, tau2, v, omega, psi, size, sign):
    beta = sign * size
    wanted = image_acceleration_for(tau1, tau2, v, omega, psi, beta)
    assert image_input_rates(*wanted, v, omega, psi, beta, 0.0) == pytest.approx(
        (tau1, tau2), rel=1e-8, abs=1e-8 * (1 + omega * omega * size * size)
    )
    assert input_rates(*acceleration_for(tau1, tau2, v, omega, psi), v, omega, psi) == (
        pytest.approx((tau1, tau2), rel=1e-8, abs=1e-8 * (1 + omega * omega))
    )


def runge_kutta(rates, state, time, steps):
    h = time / steps
    for k in range(steps):
        t = k * h
        k1 = rates(t, state)
        k2 = rates(t + h / 2, [x + h / 2 * r for x, r in zip(state, k1, strict=True)])
        k3 = rates(t + h / 2, [x + h / 2 * r for x, r in zip(state, k2, strict=True)])
        k4 = rates(t + h, [x + h * r for x, r in zip(state, k3, strict=True)])
        state = [
            x + h / 6 * (a + 2 * b + 2 * c + d)
            for x, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)
        ]
    return state


def test_physical_robot_follows_the_wanted_input_rates():
    """D7: the integrated robot's u0 and u1 are the integrals of τ1 and τ2."""

    def rates(t, state):
        _, _, theta, v, omega = state
        moved = unicycle_rates(v, omega, math.cos(theta), math.sin(theta))
        return [*moved, *acceleration_for(1.0 - t, 3.0 * t * t - 2.0, v, omega, theta)]

    start = to_chained(Pose(0.0, 0.0, 0.3), Velocity(0.8, 0.9))
    end = runge_kutta(rates, [0.0, 0.0, 0.3, 0.8, 0.9], 1.5, 1500)
    state = to_chained(Pose(*end[:3]), Velocity(*end[3:]))
    assert state.u0 - start.u0 == near(1.5 - 1.5**2 / 2)
    assert state.u1 - start.u1 == near(1.5**3 - 2.0 * 1.5)
    # Without the feed-forward the same robot is far off.
    assert abs(state.x2) > 0.1
    assert end[3] != pytest.approx(0.8 + 1.5 - 1.5**2 / 2, abs=0.05)


def test_robot_under_a_tilted_camera_follows_up_to_the_residue():
    """In the image u̇0 = τ1 exactly and u̇1 = τ2 + β̇ω sec² ψ, with ȧ in neither."""
    camera = PinholeCamera(
        position=(0.2, -1.5), height=2.5, tilt=0.6, roll=0.1, pan=0.2, skew=3.0,
        focal_length=600.0, aspect=1.1, image_size=(640, 480),
    )  # fmt: skip
    to_goal = goal_homography(camera.homography(0.1), Pose(0.1, 0.3, 0.4), unit=40.0)
    to_floor = to_goal.inverse().entries

    def inputs(state):
        x, y, theta, v, omega = state[:5]
        image = image_of(to_goal, Pose(x, y, theta))
        return image, chained_inputs(v, image.beta * omega, math.tan(image.pose.theta))

    def rates(t, state):
        theta, v, omega = state[2:5]
        (X, Y, psi), _, beta = inputs(state)[0]
        c, s = math.cos(psi), math.sin(psi)
        _, beta_dot = image_gain_rates(*to_floor, X, Y, c, s, v, omega)
        wanted = image_acceleration_for(0.3 - t, 0.5 - 2.0 * t, v, omega, psi, beta)
        moved = unicycle_rates(v, omega, math.cos(theta), math.sin(theta))
        return [*moved, *wanted, beta_dot * omega / (c * c)]

    start = [-0.2, 0.1, 0.2, 0.5, 0.6, 0.0]
    end = runge_kutta(rates, start, 0.8, 400)
    (image0, (u00, u10)), (image1, (u01, u11)) = inputs(start), inputs(end)
    assert u01 - u00 == near(0.3 * 0.8 - 0.8**2 / 2)
    assert u11 - u10 - end[5] == near(0.5 * 0.8 - 0.8**2)
    assert abs(end[5]) > 1e-3  # the residue is there,
    assert abs(image1.a - image0.a) > 0.1  # and so is the change of a
