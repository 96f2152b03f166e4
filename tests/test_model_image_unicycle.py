"""The image of a unicycle is a unicycle: checked against finite differences."""

import itertools
import math
import random

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from parkproof.errors import InputError
from parkproof.model.camera import CeilingCamera, PinholeCamera
from parkproof.model.goal_frame import gain_bounds, goal_homography, goal_similarity
from parkproof.model.homography import Homography
from parkproof.model.image_unicycle import image_gain_rates, image_gains, image_of
from parkproof.model.unicycle import Pose, unicycle_rates, wrap_angle

small = st.floats(-0.3, 0.3)
signs = st.sampled_from([-1.0, 1.0])
homographies = st.tuples(*[small] * 8, signs).map(
    lambda d: Homography(
        (1 + d[0], d[1], d[2], d[8] * d[3], d[8] * (1 + d[4]), d[5], d[6], d[7], 1.0)
    )
)
angles = st.floats(-math.pi, math.pi)
units = st.floats(-1.0, 1.0)
cameras = st.builds(
    PinholeCamera,
    position=st.tuples(units, units),
    height=st.floats(1.5, 4.0),
    focal_length=st.floats(500.0, 1000.0),
    image_size=st.just((640, 480)),
    tilt=st.floats(-0.7, 0.7),
    roll=angles,
    pan=angles,
    aspect=st.floats(0.8, 1.2),
    skew=st.floats(-20.0, 20.0),
)
pixels = st.tuples(st.floats(0.0, 639.0), st.floats(0.0, 479.0))


def near(values, rel=1e-6, scale=1.0):
    return pytest.approx(values, rel=rel, abs=rel * scale)


def pose_after(pose, v, omega, t):
    """Constant speed and turn rate for a time t, exactly."""
    x, y, theta = pose
    half = 0.5 * omega * t
    chord = v * t * (math.sin(half) / half if half else 1.0)
    return Pose(
        x + chord * math.cos(theta + half), y + chord * math.sin(theta + half), theta + 2 * half
    )


def check_lemma(homography, pose, v, omega):
    h = 1e-4
    image = image_of(homography, pose)
    ahead = image_of(homography, pose_after(pose, v, omega, h))
    behind = image_of(homography, pose_after(pose, v, omega, -h))
    psi = image.pose.theta
    expected = unicycle_rates(image.a * v, image.beta * omega, math.cos(psi), math.sin(psi))
    measured = (
        (ahead.pose.x - behind.pose.x) / (2 * h),
        (ahead.pose.y - behind.pose.y) / (2 * h),
        wrap_angle(ahead.pose.theta - behind.pose.theta) / (2 * h),
    )
    assert measured == near(expected, scale=1.0 + image.a)

    to_floor = homography.inverse().entries
    here = (image.pose.x, image.pose.y, math.cos(psi), math.sin(psi))
    assert image_gains(*to_floor, *here) == near((image.a, image.beta), rel=1e-8)
    a_dot, beta_dot = image_gain_rates(*to_floor, *here, v, omega)
    assert a_dot == near((ahead.a - behind.a) / (2 * h), scale=1.0 + image.a)
    assert beta_dot == near((ahead.beta - behind.beta) / (2 * h), scale=1.0 + abs(image.beta))


@given(homographies, units, units, angles, units, units)
def test_lemma_on_random_homographies(homography, x, y, theta, v, omega):
    assume(homography.depth(x, y) > 0.3 and abs(homography.determinant) > 0.2)
    check_lemma(homography, Pose(x, y, theta), v, omega)


@given(cameras, st.floats(0.0, 0.4), pixels, angles, units, units)
def test_lemma_under_pinhole_cameras(camera, plane_height, pixel, theta, v, omega):
    homography = camera.homography(plane_height)
    x, y = homography.inverse().project(*pixel)
    check_lemma(homography, Pose(x, y, theta), v, omega)


@given(cameras, pixels, angles)
def test_inverse_homography_gives_the_floor_pose_and_inverse_gains(camera, pixel, psi):
    homography = camera.homography()
    floor = image_of(homography.inverse(), Pose(*pixel, psi))
    image = image_of(homography, floor.pose)
    assert (image.pose.x, image.pose.y) == near(pixel, scale=100.0)
    assert wrap_angle(image.pose.theta - psi) == pytest.approx(0.0, abs=1e-9)
    assert (image.a * floor.a, image.beta * floor.beta) == near((1.0, 1.0), rel=1e-9)


@given(angles, st.floats(0.1, 10.0), st.floats(0.1, 10.0), units, units, angles)
def test_ceiling_camera_is_the_special_case(theta, alpha1, alpha2, x, y, theta0):
    """β and a depend on the heading alone; tan ψ = (α2/α1) tan(θ − θ0)."""
    camera = CeilingCamera(alpha=(alpha1, alpha2), theta0=theta0)
    image = image_of(camera.homography(), Pose(x, y, theta))
    c, s = alpha1 * math.cos(theta - theta0), alpha2 * math.sin(theta - theta0)
    assert image.a == near(math.sqrt(c * c + s * s))
    assert wrap_angle(image.pose.theta - math.atan2(s, c)) == pytest.approx(0.0, abs=1e-9)
    assert image.beta == near(alpha1 * alpha2 / image.a**2)


@given(cameras, pixels, angles, st.floats(5.0, 100.0), pixels, angles)
def test_goal_frame(camera, goal_pixel, goal_theta, unit, pixel, theta):
    to_pixels = camera.homography()
    goal = Pose(*to_pixels.inverse().project(*goal_pixel), goal_theta)
    to_goal = goal_homography(to_pixels, goal, unit)
    assert image_of(to_goal, goal).pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-7)

    robot = Pose(*to_pixels.inverse().project(*pixel), theta)
    seen, shown = image_of(to_pixels, robot), image_of(to_goal, robot)
    assert shown.beta == near(-seen.beta)  # a camera above, v down: mirrored
    assert shown.beta > 0.0
    assert shown.a == near(seen.a / unit)
    distance = math.dist(pixel, goal_pixel) / unit
    assert math.hypot(shown.pose.x, shown.pose.y) == near(distance, scale=100.0)


def test_goal_frame_of_an_unmirrored_image_is_not_flipped():
    camera = CeilingCamera(alpha=(2.0, 2.0)).homography()
    to_goal = goal_homography(camera, Pose(1.0, 1.0, math.pi / 2), unit=2.0)
    assert to_goal.project(1.0, 2.0) == near((1.0, 0.0))
    assert to_goal.project(0.0, 1.0) == near((0.0, 1.0))


def test_a_goal_behind_the_camera_is_refused():
    camera = PinholeCamera(
        position=(0.0, 0.0), height=3.0, focal_length=600.0, image_size=(640, 480), tilt=1.2
    )
    with pytest.raises(InputError, match="behind the camera"):
        goal_homography(camera.homography(), Pose(0.0, -5.0, 0.0), unit=40.0)


@pytest.mark.parametrize("unit", [0.0, -1.0, math.nan])
def test_impossible_units_are_refused(unit):
    with pytest.raises(InputError, match=r"^unit"):
        goal_similarity(Pose(0.0, 0.0, 0.0), unit, mirrored=False)


@pytest.mark.parametrize("place", range(3))
def test_poses_that_are_not_numbers_are_refused(place):
    values = [0.0, 0.0, 0.0]
    values[place] = math.nan
    with pytest.raises(InputError):
        goal_similarity(Pose(*values), 40.0, mirrored=False)
    with pytest.raises(InputError):
        image_of(CeilingCamera(alpha=(1.0, 1.0)).homography(), Pose(*values))


@given(cameras, st.integers(0, 10**6))
def test_gain_bounds_hold_inside_the_picture(camera, seed):
    homography = camera.homography()
    bounds = gain_bounds(homography, camera.corners())
    to_floor = homography.inverse().entries
    draw = random.Random(seed)
    for _ in range(40):
        psi = draw.uniform(-math.pi, math.pi)
        here = (draw.uniform(0.0, 639.0), draw.uniform(0.0, 479.0), math.cos(psi), math.sin(psi))
        a, beta = image_gains(*to_floor, *here)
        assert bounds.a_min * (1 - 1e-4) <= a <= bounds.a_max * (1 + 1e-4)
        assert beta < 0.0
        assert bounds.beta_min * (1 + 1e-4) <= beta <= bounds.beta_max * (1 - 1e-4)


@given(cameras, st.integers(0, 10**6))
def test_gains_are_monotone_along_the_heading(camera, seed):
    """Why the extremes lie on the border."""
    to_floor = camera.homography().inverse()
    draw = random.Random(seed)
    psi = draw.uniform(-math.pi, math.pi)
    c, s = math.cos(psi), math.sin(psi)
    along = [
        image_gains(*to_floor.entries, 320.0 + t * c, 240.0 + t * s, c, s)
        for t in (-200.0, -100.0, 0.0, 100.0, 200.0)
    ]
    for gains in zip(*along, strict=True):
        steps = [q - p for p, q in itertools.pairwise(gains)]
        tiny = 1e-9 * abs(gains[0])
        assert all(d >= -tiny for d in steps) or all(d <= tiny for d in steps)


def test_gain_bounds_of_a_ceiling_camera_are_its_scales():
    bounds = gain_bounds(
        CeilingCamera(alpha=(1.5, 0.5), theta0=0.3).homography(), ((0, 0), (1, 0), (0, 1))
    )
    assert bounds == near((0.5, 1.5, 1 / 3, 3.0), rel=1e-9)


def test_a_region_that_reaches_the_horizon_is_refused():
    camera = PinholeCamera(
        position=(0.0, 0.0), height=3.0, focal_length=400.0, image_size=(640, 480), tilt=1.3
    )
    with pytest.raises(InputError, match="horizon"):
        gain_bounds(camera.homography(), camera.corners())


@pytest.mark.parametrize(("corners", "samples"), [(((0, 0), (1, 0)), 8), (((0, 0),) * 3, 0)])
def test_no_region_is_refused(corners, samples):
    with pytest.raises(InputError, match="corners"):
        gain_bounds(CeilingCamera(alpha=(1.0, 1.0)).homography(), corners, samples)
