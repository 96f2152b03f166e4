"""The overhead camera of a scenario: poses, gains and what it sees."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.model.image_unicycle import gains_under
from parkproof.model.overhead import HomographyTable, PinholeTable
from parkproof.model.truth import Truth
from parkproof.scenario import Robot, RunSettings, Scenario, Start
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import simulate

CAMERA = PinholeTable(
    height=3.0,
    focal_length=380.0,
    tilt_deg=20.0,
    roll_deg=20.0,
    aspect=1.1,
    unit=120.0,
    goal=(0.3, 0.2, 0.4),
)
KNOWN = Bounds(alpha=(0.4, 1.8))


def scenario(**changes):
    settings = {
        "law": "corrected",
        "bounds": KNOWN,
        "start": Start(floor_pose=(-0.9, 0.3, 0.2)),
        "robot": Robot(kind="velocity"),
        "camera": CAMERA,
        "run": RunSettings(duration=12.0, control_period=1 / 30, discretisation="implicit"),
    }
    return Scenario(**(settings | changes))


def test_the_goal_is_the_origin_with_heading_zero():
    assert CAMERA.view.image_pose(CAMERA.goal) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


@given(
    x=st.floats(-1.0, 1.0),
    y=st.floats(-0.7, 0.7),
    theta=st.floats(-3.1, 3.1),
    v=st.floats(-2.0, 2.0),
    omega=st.floats(-2.0, 2.0),
)
def test_gains_carry_a_robot_on_the_floor_to_its_image(x, y, theta, v, omega):
    view, dt = CAMERA.view, 1e-6
    before = view.image_pose((x, y, theta))
    moved = (x + dt * v * math.cos(theta), y + dt * v * math.sin(theta), theta + dt * omega)
    after = view.image_pose(moved)
    c, s = math.cos(before[2]), math.sin(before[2])
    a, beta = gains_under(view.from_goal.entries, before[0], before[1], c, s)
    assert (after[0] - before[0]) / dt == pytest.approx(a * v * c, abs=1e-4)
    assert (after[1] - before[1]) / dt == pytest.approx(a * v * s, abs=1e-4)
    turned = math.remainder(after[2] - before[2], 2.0 * math.pi)
    assert turned / dt == pytest.approx(beta * omega, abs=1e-4)
    bounds = view.bounds
    if view.sees(before[0], before[1]):
        assert bounds.a_min * 0.999 <= a <= bounds.a_max * 1.001


def test_the_picture_is_what_is_seen():
    view = CAMERA.view
    middle = [sum(c[i] for c in view.corners) / 4 for i in (0, 1)]
    assert view.sees(*middle)
    for x, y in view.corners:
        inside = (middle[0] + 0.99 * (x - middle[0]), middle[1] + 0.99 * (y - middle[1]))
        outside = (middle[0] + 1.01 * (x - middle[0]), middle[1] + 1.01 * (y - middle[1]))
        assert view.sees(*inside)
        assert not view.sees(*outside)


@pytest.mark.parametrize("roll", [0.0, 90.0, 180.0, -135.0])
def test_parking_does_not_depend_on_how_the_camera_is_turned(roll):
    from msgspec.structs import replace

    camera = replace(CAMERA, roll_deg=roll, tilt_deg=10.0, focal_length=250.0, unit=80.0)
    run = simulate(scenario(camera=camera, start=Start(pose=(-0.8, 0.4, 0.1))))
    assert run.outcome is Outcome.PARKED
    assert run.metrics.residual < 1e-3


def test_a_homography_and_the_camera_it_came_from_give_the_same_run():
    table = HomographyTable(
        matrix=CAMERA.view.to_pixels.entries, unit=CAMERA.unit, goal=CAMERA.goal
    )
    one, two = simulate(scenario()), simulate(scenario(camera=table))
    assert one.settling_time == two.settling_time
    assert one.metrics.final == pytest.approx(two.metrics.final, abs=1e-9)


def test_leaving_the_picture_ends_the_run():
    start = Start(floor_pose=(1.2, 0.1, 2.8))
    run = simulate(scenario(start=start))
    assert run.outcome is Outcome.OUT_OF_VIEW
    last = run.trajectory["xm"][-1], run.trajectory["ym"][-1]
    assert CAMERA.view.sees(*last)


def test_a_torque_commanded_robot_parks_under_a_tilted_camera():
    run = simulate(
        scenario(
            robot=Robot(kind="torque"),
            bounds=Bounds(alpha=(0.4, 1.8), gamma=(1.0, 1.5), disturbance=0.5),
            gains=Gains(runup_speed=0.5),
            run=RunSettings(duration=20.0, control_period=2e-3, discretisation="implicit"),
        )
    )
    assert run.outcome is Outcome.PARKED


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"truth": Truth(alpha=(1.0, 1.2), outside_bounds=True)}, "leave one of them out"),
        ({"bounds": Bounds(alpha=(0.9, 1.1))}, "ranges over"),
        (
            {"truth": Truth(b2=1.1), "bounds": Bounds(alpha=(0.4, 1.8), b2=(0.9, 1.1))},
            "truth.b2 is a gain of the paper's plant, and under a .camera. it follows",
        ),
        ({"start": Start(pose=(50.0, 0.0, 0.0))}, "outside the picture"),
        ({"camera": None}, "needs a .camera"),
    ],
)
def test_scenarios_that_contradict_their_camera_are_refused(changes, words):
    with pytest.raises(InputError, match=words):
        scenario(**changes)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"tilt_deg": 65.0, "roll_deg": 0.0, "goal": (0.0, 5.0, 0.0)}, "horizon"),
        ({"goal": (9.0, 0.0, 0.0)}, "outside the picture"),
        ({"unit": 0.0}, "unit"),
        ({"image_size": (0, 480)}, "image_size"),
        ({"height": -1.0}, "height"),
        ({"roll_deg": math.nan}, "roll_deg"),
    ],
)
def test_cameras_that_cannot_be_are_refused(changes, words):
    from msgspec.structs import replace

    with pytest.raises(InputError, match=words):
        replace(CAMERA, **changes)
