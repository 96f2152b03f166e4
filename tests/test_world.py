"""The simulated laboratory: what its camera shows is where its robot is, and it drives as told."""

import math

import numpy as np
import pytest

from parkproof.errors import InputError
from parkproof.lab.devices import Frame, Missing
from parkproof.lab.image_pose import image_pose
from parkproof.lab.simulated import shown_goal
from parkproof.lab.tag import Detection, TagDetector
from parkproof.lab.world.random_world import random_world
from parkproof.lab.world.settings import (
    Pushes,
    WorldCamera,
    WorldRobot,
    WorldSettings,
    read_world,
)
from parkproof.lab.world.world import World, image_error
from parkproof.model.homography import Homography
from parkproof.model.image_unicycle import image_of
from parkproof.model.unicycle import Pose, wrap_angle

PERFECT = WorldRobot(gains=(1.0, 1.0), dead_band=0.0)
QUIET = Pushes(rate=0.0)
CLEAR = {"noise": 0.0, "blur": 0.0, "latency": 0.0}
STRAIGHT = WorldCamera(
    position=(0.0, 0.0), tilt_deg=0.0, roll_deg=0.0, aspect=1.0, height=2.2, **CLEAR
)


def world(**changes) -> World:
    given = {"camera": STRAIGHT, "robot": PERFECT, "pushes": QUIET, "start": (0.0, 0.0, 0.0)}
    return World(WorldSettings(**(given | changes)))


def drive(there: World, v: float, omega: float, seconds: float) -> Pose:
    there.robot.send(v, omega)
    for _ in range(round(seconds * 30)):
        there.camera.read(1.0)
    return there.pose


@pytest.mark.parametrize("k1", [0.0, -0.15])
@pytest.mark.parametrize("angle", [0.0, 70.0])
def test_the_tag_is_seen_where_the_robot_is(k1, angle):
    camera = WorldCamera(
        tilt_deg=30.0, roll_deg=50.0, pan_deg=-20.0, aspect=1.2, focal_length=800.0,
        height=1.9, distortion=k1, position=(0.0, 0.0), **CLEAR,
    )  # fmt: skip
    robot = WorldRobot(tag_position=(0.02, -0.01), tag_angle_deg=angle)
    with world(camera=camera, robot=robot) as there:
        rng = np.random.default_rng(4)
        middle = there.to_pixels.inverse().project(320.0, 240.0)
        errors = []
        for _ in range(6):
            dx, dy = rng.uniform(-0.25, 0.25, 2)
            there.place(Pose(middle[0] + dx, middle[1] + dy, float(rng.uniform(-math.pi, math.pi))))
            found = TagDetector().find(there.picture(), 0)
            assert isinstance(found, Detection)
            shown = image_pose(found.homography, robot.mount)
            u, v = there.pixel(*there.pose[:2])
            errors.append(math.hypot(shown.u - u, shown.v - v))
            if not k1:
                psi = image_of(there.to_pixels, there.pose).pose.theta
                assert abs(wrap_angle(shown.psi - psi)) < math.radians(0.2)
        assert sum(errors) / len(errors) < (0.1 if not k1 else 0.5)
        assert image_error(there, there.pose, there.pose) == (0.0, 0.0)


def test_a_perfect_robot_drives_and_turns_as_it_is_told():
    with world() as there:
        pose = drive(there, 0.1, 0.0, 3.0)
        assert math.hypot(pose.x, pose.y) == pytest.approx(
            0.3, rel=0.08
        )  # its gears' friction holds it back
        assert abs(pose.y) < 0.005
        there.place(Pose(0.0, 0.0, 0.0))
        pose = drive(there, 0.0, 0.8, 3.0)
        assert pose.theta == pytest.approx(2.4, rel=0.06)
        assert math.hypot(pose.x, pose.y) < 0.01


def test_unequal_wheels_turn_a_robot_that_is_told_to_drive_straight():
    with world(robot=WorldRobot(gains=(0.8, 1.2), dead_band=0.0)) as there:
        pose = drive(there, 0.1, 0.0, 1.5)
        assert pose.theta == pytest.approx(0.1 * 0.4 / 0.16 * 1.5, rel=0.15)


def test_below_its_dead_band_a_robot_does_not_move():
    with world(robot=WorldRobot(gains=(1.0, 1.0), dead_band=0.01)) as there:
        still = drive(there, 0.009, 0.0, 1.0)
        assert math.hypot(still.x, still.y) < 1e-3
        assert drive(there, 0.02, 0.0, 1.0).x > 0.01


def test_a_parked_robot_withstands_pushes_within_the_bound_and_not_far_beyond():
    moved = []
    for force in (1.0, 8.0):
        with world(pushes=Pushes(force=force, rate=2.0)) as there:
            pose = drive(there, 0.0, 0.0, 5.0)
            moved.append(math.hypot(pose.x, pose.y))
    assert moved[0] < 1e-3 < moved[1]


def test_frames_arrive_after_the_latency_and_in_order():
    with world(camera=WorldCamera(**{**CLEAR, "latency": 0.15})) as there:
        frames = [there.camera.read(1.0) for _ in range(10)]
        assert [frame.number for frame in frames] == list(range(10))
        assert there.now - frames[-1].t == pytest.approx(0.15, abs=0.0021)


def test_dropped_frames_never_arrive_and_are_late_in_time():
    camera = WorldCamera(drops=0.4, **CLEAR)
    with world(camera=camera) as there:
        got = [there.camera.read(0.05) for _ in range(60)]
        frames = [frame for frame in got if isinstance(frame, Frame)]
        assert Missing.LATE in got
        assert frames[-1].number + 1 > 1.3 * len(frames)


def test_the_same_settings_give_the_same_frames_and_another_seed_others():
    def last(seed: int):
        there = random_world(3)
        with World(
            WorldSettings(camera=there.camera, robot=there.robot, start=there.start, seed=seed)
        ) as made:
            made.robot.send(0.1, 0.3)
            return [made.camera.read(1.0) for _ in range(5)][-1].image

    assert np.array_equal(last(1), last(1))
    assert not np.array_equal(last(1), last(2))


@pytest.mark.parametrize("hard", [False, True])
def test_random_laboratories_show_goal_and_start_whole_and_of_the_right_size(hard):
    for seed in range(40, 60):
        settings = random_world(seed, hard=hard)
        camera = settings.camera
        assert abs(camera.tilt_deg) <= 35.0
        assert 0.8 <= camera.aspect <= 1.25
        to_pixels: Homography = camera.pinhole.homography(0.1)
        for place in (settings.goal, settings.start):
            size = image_of(to_pixels, Pose(*place)).a * settings.robot.tag_side
            assert 20.0 <= size <= 60.0
        assert (camera.latency, camera.drops) == ((0.15, 0.1) if hard else (0.066, 0.0))
    with World(random_world(41, hard=hard)) as there:
        assert shown_goal(there).picture == (640, 480)
        assert there.tag_in_view(Pose(*there.settings.start))
        assert not there.tag_in_view(Pose(50.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("table", "changes", "named"),
    [
        (WorldCamera, {"height": -1.0}, "height"),
        (WorldCamera, {"drops": 1.0}, "drops"),
        (WorldCamera, {"noise": float("nan")}, "noise"),
        (WorldCamera, {"focal_length": 300.0, "distortion": -0.3}, "fold"),
        (WorldRobot, {"gains": (0.0, 1.0)}, "gains"),
        (WorldRobot, {"tag_id": 587}, "tag_id"),
        (WorldRobot, {"lag": 0.0}, "lag"),
        (Pushes, {"force": -1.0}, "force"),
        (WorldSettings, {"start": (0.0, math.inf, 0.0)}, "start"),
    ],
)
def test_impossible_laboratories_are_refused_by_name(table, changes, named):
    with pytest.raises(InputError, match=named):
        table(**changes)


def test_a_file_describes_a_laboratory(tmp_path):
    path = tmp_path / "world.toml"
    path.write_text("seed = 3\n[camera]\nheight = 2.0\n[robot]\ngains = [0.9, 1.1]\n")
    found = read_world(path)
    assert (found.seed, found.camera.height, found.robot.gains) == (3, 2.0, (0.9, 1.1))
    path.write_text("[camera]\nheigth = 2.0\n")
    with pytest.raises(InputError, match="height"):
        read_world(path)
