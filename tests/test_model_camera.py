"""The ceiling camera (2)-(4), homographies, and pinhole cameras."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from parkproof.errors import InputError
from parkproof.model.camera import CeilingCamera, PinholeCamera
from parkproof.model.homography import Homography, homography_jacobian, project_point
from parkproof.model.unicycle import unicycle_rates

positions = st.floats(-5.0, 5.0)
angles = st.floats(-math.pi, math.pi)
scales = st.floats(0.1, 500.0)
pairs = st.tuples(positions, positions)
ceiling_cameras = st.builds(
    CeilingCamera,
    alpha=st.tuples(scales, scales),
    theta0=angles,
    centre=pairs,
    image_origin=st.tuples(st.floats(-500.0, 500.0), st.floats(-500.0, 500.0)),
)
pinhole_cameras = st.builds(
    PinholeCamera,
    position=pairs,
    height=st.floats(1.0, 6.0),
    focal_length=st.floats(300.0, 1500.0),
    image_size=st.just((640, 480)),
    tilt=st.floats(-1.0, 1.0),
    roll=angles,
    pan=angles,
    aspect=st.floats(0.7, 1.4),
    skew=st.floats(-30.0, 30.0),
    principal_point=st.none() | st.tuples(st.floats(250.0, 390.0), st.floats(180.0, 300.0)),
)
DOWN = {"position": (0.0, 0.0), "height": 3.0, "focal_length": 600.0, "image_size": (641, 481)}


def near(values, rel=1e-7, scale=1.0):
    return pytest.approx(values, rel=rel, abs=rel * scale)


@given(ceiling_cameras, positions, positions)
def test_ceiling_round_trip_and_homography_agree(camera, x, y):
    image = camera.project(x, y)
    assert camera.unproject(*image) == near((x, y), scale=1e3)
    assert camera.homography().project(x, y) == near(image, scale=1e3)
    assert camera.homography().determinant == near(camera.alpha[0] * camera.alpha[1])


@given(ceiling_cameras, positions, positions, angles, positions, positions)
def test_ceiling_kinematics_are_the_derivative_of_the_projection(camera, x, y, theta, v, omega):
    h = 1e-3
    c, s = math.cos(theta), math.sin(theta)
    x_dot, y_dot, theta_dot = unicycle_rates(v, omega, c, s)
    ahead = camera.project(x + h * x_dot, y + h * y_dot)
    behind = camera.project(x - h * x_dot, y - h * y_dot)
    moved = tuple((p - q) / (2 * h) for p, q in zip(ahead, behind, strict=True))
    assert camera.rates(v, omega, theta) == near((*moved, theta_dot), scale=1e3)


def test_ceiling_camera_by_hand():
    camera = CeilingCamera(
        alpha=(2.0, 3.0), theta0=math.pi / 2, centre=(1.0, 1.0), image_origin=(10.0, 20.0)
    )
    assert camera.project(1.0, 3.0) == near((14.0, 20.0))
    assert camera.project(2.0, 1.0) == near((10.0, 17.0))


@pytest.mark.parametrize(
    ("given_values", "name"),
    [
        ({"alpha": (0.0, 1.0)}, "alpha"),
        ({"alpha": (1.0, -1.0)}, "alpha"),
        ({"alpha": (1.0, math.nan)}, "alpha"),
        ({"alpha": (1.0,)}, "alpha"),
        ({"alpha": (1.0, 1.0), "theta0": math.inf}, "theta0"),
        ({"alpha": (1.0, 1.0), "centre": (0.0, math.nan)}, "centre"),
        ({"alpha": (1.0, 1.0), "image_origin": (0.0, 0.0, 0.0)}, "image_origin"),
    ],
)
def test_impossible_ceiling_cameras_are_refused_by_name(given_values, name):
    with pytest.raises(InputError, match=f"^{name}"):
        CeilingCamera(**given_values)


@given(pinhole_cameras, st.floats(0.0, 0.5), st.floats(0.0, 640.0), st.floats(0.0, 480.0))
def test_pinhole_round_trip_in_the_picture(camera, plane_height, u, v):
    to_pixels = camera.homography(plane_height)
    to_floor = to_pixels.inverse()
    assume(to_floor.depth(u, v) > 0.02)
    x, y = to_floor.project(u, v)
    assert to_pixels.depth(x, y) == near(1.0 / to_floor.depth(u, v))
    assert to_pixels.project(x, y) == near((u, v), scale=1e2)
    again = to_floor.inverse().project(x, y)
    assert again == near((u, v), scale=1e2)


@given(pinhole_cameras, st.floats(0.0, 0.5))
def test_a_camera_above_the_floor_shows_it_mirrored(camera, plane_height):
    """v points down: the determinant is −f_x f_y times the height over the plane."""
    expected = -(camera.focal_length**2) * camera.aspect * (camera.height - plane_height)
    assert camera.homography(plane_height).determinant == near(expected)


@given(pinhole_cameras, positions, positions, st.floats(0.0, 0.5))
def test_pinhole_agrees_with_rotation_matrices(camera, x, y, z):
    """Against the textbook chain K·R·(p − C), written with elementary rotations."""

    def turn(axis, angle):
        c, s = math.cos(angle), math.sin(angle)
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        matrix = [[float(r == k) for k in range(3)] for r in range(3)]
        matrix[i][i] = matrix[j][j] = c
        matrix[i][j], matrix[j][i] = -s, s
        return matrix

    def apply(matrix, vector):
        return [sum(p * q for p, q in zip(row, vector, strict=True)) for row in matrix]

    ray = [x - camera.position[0], y - camera.position[1], z - camera.height]
    ray = apply(turn(2, -camera.pan), ray)
    ray = apply(turn(0, -camera.tilt), ray)
    ray = [ray[0], -ray[1], -ray[2]]  # half a turn about u: looking down
    ray = apply(turn(2, -camera.roll), ray)
    assume(ray[2] > 0.05)
    u0, v0 = camera.principal_point or (319.5, 239.5)
    f = camera.focal_length
    u = (f * ray[0] + camera.skew * ray[1]) / ray[2] + u0
    v = f * camera.aspect * ray[1] / ray[2] + v0
    to_pixels = camera.homography(z)
    assert to_pixels.project(x, y) == near((u, v), scale=1e5)
    assert to_pixels.depth(x, y) == near(ray[2], scale=10.0)


def test_pinhole_directions():
    middle = (320.0, 240.0)
    assert PinholeCamera(**DOWN).homography().project(0.0, 0.0) == near(middle)
    tilted = PinholeCamera(**DOWN, tilt=math.pi / 4).homography()
    assert tilted.project(0.0, 3.0) == near(middle)
    panned = PinholeCamera(**DOWN, tilt=math.pi / 4, pan=math.pi / 2).homography()
    assert panned.project(-3.0, 0.0) == near(middle)
    rolled = PinholeCamera(**DOWN, roll=math.pi / 2).homography()  # u now runs along −y
    assert rolled.project(0.0, -1.0) == near((520.0, 240.0))


def test_corners_go_round_the_picture():
    assert PinholeCamera(**DOWN).corners() == (
        (-0.5, -0.5), (640.5, -0.5), (640.5, 480.5), (-0.5, 480.5),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"height": 0.0}, "height"),
        ({"focal_length": -600.0}, "focal_length"),
        ({"aspect": math.nan}, "aspect"),
        ({"tilt": 1.6}, r"tilt .*\|tilt\| < 90°"),
        ({"roll": math.inf}, "roll"),
        ({"skew": math.nan}, "skew"),
        ({"image_size": (0, 480)}, "image_size"),
        ({"image_size": (640,)}, "image_size"),
        ({"position": (0.0, math.nan)}, "position"),
        ({"principal_point": (320.0,)}, "principal_point"),
    ],
)
def test_impossible_pinhole_cameras_are_refused_by_name(changed, message):
    with pytest.raises(InputError, match=f"^{message}"):
        PinholeCamera(**(DOWN | changed))


@pytest.mark.parametrize("plane_height", [3.0, 3.5])
def test_a_camera_on_or_below_the_plane_is_refused(plane_height):
    with pytest.raises(InputError, match="above the tag's plane"):
        PinholeCamera(**DOWN).homography(plane_height)


def test_points_behind_the_camera_are_refused():
    with pytest.raises(InputError, match="behind the camera"):
        PinholeCamera(**DOWN, tilt=1.2).homography().project(0.0, -3.0)


@pytest.mark.parametrize(
    "entries",
    [
        (1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 0.0, 0.0, 1.0),
        (0.0,) * 9,
        (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, math.nan),
        (1.0, 0.0, 0.0, 1.0),
        (1e200, 0.0, 0.0, 0.0, 1e200, 0.0, 0.0, 1e200, 1e200),
    ],
)
def test_matrices_that_are_no_homography_are_refused(entries):
    with pytest.raises(InputError, match=r"^homography"):
        Homography(entries)


def test_points_that_are_not_numbers_are_refused():
    identity = Homography((1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
    with pytest.raises(InputError):
        identity.project(math.nan, 0.0)
    with pytest.raises(InputError):
        CeilingCamera(alpha=(1.0, 1.0)).unproject(0.0, math.inf)


small = st.floats(-0.3, 0.3)
homographies = st.tuples(*[small] * 8).map(
    lambda d: Homography((1 + d[0], d[1], d[2], d[3], 1 + d[4], d[5], d[6], d[7], 1.0))
)
units = st.floats(-1.0, 1.0)


@given(homographies, units, units)
def test_jacobian_is_the_derivative(homography, x, y):
    h = 1e-5
    p, q = homography.project(x + h, y), homography.project(x - h, y)
    r, s = homography.project(x, y + h), homography.project(x, y - h)
    by_x = [(b - a) / (2 * h) for a, b in zip(q, p, strict=True)]
    by_y = [(b - a) / (2 * h) for a, b in zip(s, r, strict=True)]
    expected = (by_x[0], by_y[0], by_x[1], by_y[1])
    jacobian = homography_jacobian(*homography.entries, x, y)
    assert jacobian == near(expected, rel=1e-6)
    j00, j01, j10, j11 = jacobian
    _, _, w = project_point(*homography.entries, x, y)
    assert j00 * j11 - j01 * j10 == near(homography.determinant / w**3, rel=1e-9)


@given(homographies, units, units, angles, units, units)
def test_lines_stay_lines(homography, x, y, direction, s, t):
    c, n = math.cos(direction), math.sin(direction)
    points = [(x + k * c, y + k * n) for k in (0.0, 0.1 * s, 0.1 * t)]
    assume(all(homography.depth(*p) > 0.1 for p in points))
    (x0, y0), (x1, y1), (x2, y2) = (homography.project(*p) for p in points)
    assert (x1 - x0) * (y2 - y0) == near((y1 - y0) * (x2 - x0), rel=1e-9)


@given(homographies, homographies, st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
def test_composition_and_inverse(outer, inner, x, y):
    assume(outer.depth(*inner.project(x, y)) > 0.1)
    both = outer @ inner
    assert both.project(x, y) == near(outer.project(*inner.project(x, y)))
    assert both.determinant == near(outer.determinant * inner.determinant)
    assert inner.inverse().project(*inner.project(x, y)) == near((x, y))
