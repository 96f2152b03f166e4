"""The simulated laboratory: what it shows is where the robot is, and time passes as it says."""

import ctypes.util
import math
import os
import subprocess
import sys

import msgspec
import numpy as np
import pytest

from parkproof.errors import InputError
from parkproof.lab.devices import Frame, Missing, RobotSilentError
from parkproof.lab.world import (
    CameraSettings,
    FloorSettings,
    PushSettings,
    RobotSettings,
    World,
    WorldSettings,
    random_world,
)
from parkproof.lab.world.lens import Lens
from parkproof.lab.world.opengl import load_mujoco
from parkproof.lab.world.pushes import Pushes
from parkproof.lab.world.random_world import TAG_PIXELS
from parkproof.lab.world.view import TagView

pyapriltags = pytest.importorskip("pyapriltags", reason="needs parkproof[lab]")
cv2 = pytest.importorskip("cv2", reason="needs parkproof[lab]")

CLEAN = CameraSettings(noise=0.0, blur=0.0)


@pytest.fixture(scope="module")
def detector() -> object:
    return pyapriltags.Detector(families="tag36h11", quad_decimate=1.0)


def frame_of(world: World) -> Frame:
    frame = world.camera.read(timeout=1.0)
    assert isinstance(frame, Frame)
    return frame


def drive(settings: WorldSettings, v: float, omega: float, duration: float) -> World:
    """Command a robot from rest for a while; the world is closed, its truth is kept."""
    with World(settings) as world:
        world.robot.send(v, omega)
        world.advance(duration)
        return world


def plain_world(**robot: object) -> WorldSettings:
    return WorldSettings(robot=RobotSettings(**robot), start=(0.0, 0.0, 0.0))  # type: ignore[arg-type]


# ------------------------------------------------------------------------------- what is seen


@pytest.mark.parametrize(
    "camera",
    [
        CameraSettings(height=1.6),
        CameraSettings(
            position=(0.5, -0.6), height=1.4, tilt_deg=30.0, roll_deg=70.0, pan_deg=40.0, aspect=1.2
        ),
        CameraSettings(
            position=(0.0, -0.5), height=1.3, tilt_deg=20.0, roll_deg=-110.0, aspect=0.8, k1=-0.15
        ),
        CameraSettings(height=1.5, focal_length=500.0, k1=0.1, colour=True, exposure=0.8),
    ],
    ids=["straight down", "tilted", "barrel", "pincushion, RGB"],
)
def test_tag_is_rendered_where_the_projection_says(
    detector: object, camera: CameraSettings
) -> None:
    camera = msgspec.structs.replace(camera, noise=0.0, blur=0.0)
    robot = RobotSettings(tag_id=42, tag_offset=(0.02, -0.015), tag_angle=0.7)
    errors = []
    with World(WorldSettings(camera=camera, robot=robot)) as world:
        for pose in ((0.1, 0.05, 0.3), (-0.12, 0.08, 2.0), (0.02, -0.1, -1.5), (-0.05, 0.0, -2.8)):
            world.place(pose)
            image = frame_of(world).image
            assert image.shape == ((480, 640, 3) if camera.colour else (480, 640))
            grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
            (tag,) = detector.detect(grey)  # type: ignore[attr-defined]
            assert tag.tag_id == 42
            # AprilTag's libraries put the centre of the first pixel at (0.5, 0.5).
            errors.append(tag.corners - 0.5 - np.array(world.view.corners(pose)))
    assert np.sqrt(np.mean(np.square(errors))) < 0.1
    assert np.abs(np.mean(errors, axis=(0, 1))).max() < 0.03


def test_the_homography_is_that_of_the_plane_of_the_tag(detector: object) -> None:
    camera = msgspec.structs.replace(CLEAN, tilt_deg=25.0, position=(0.0, -0.7), height=1.6)
    with World(WorldSettings(camera=camera, start=(0.1, 0.1, 0.4))) as world:
        (tag,) = detector.detect(frame_of(world).image)  # type: ignore[attr-defined]
        shown = np.array(tag.homography) @ np.array([0.0, 0.0, 1.0])
        centre = shown[:2] / shown[2] - 0.5
        assert world.to_pixels.project(0.1, 0.1) == pytest.approx(centre, abs=0.1)
        # The tag's x axis points forward, its y axis to the right.
        ahead = np.array(tag.homography) @ np.array([1.0, 0.0, 1.0])
        forward = (0.1 + 0.05 * math.cos(0.4), 0.1 + 0.05 * math.sin(0.4))
        assert world.to_pixels.project(*forward) == pytest.approx(
            ahead[:2] / ahead[2] - 0.5, abs=0.2
        )


def test_the_window_around_the_robot_does_not_show() -> None:
    settings = random_world(4, hard=True)
    with World(settings) as world:
        positions = world._physics.state()
        frame_of(world)
        renderer = world._renderer
        assert renderer is not None
        piecewise, whole = renderer.picture(positions), renderer.whole_picture(positions)
        empty = renderer._floor
    assert np.abs(piecewise.astype(int) - whole).max() <= 4
    assert np.abs(empty.astype(int) - whole).max() > 50


def test_a_tag_is_in_view_just_when_its_square_is() -> None:
    view = TagView(WorldSettings(camera=CLEAN))
    half = 0.5 * view.width_across()
    assert view.holds((half - 0.051, 0.0, 0.0))
    assert not view.holds((half - 0.049, 0.0, 0.0))
    assert not view.holds((half - 0.051, 0.0, 0.0), margin=3.0)
    assert not view.holds((half - 0.051, 0.0, 0.0), plate=True)
    with World(WorldSettings(camera=CLEAN, start=(half, 0.0, 0.0))) as world:
        frame_of(world)
        assert not world.truth().in_view
        assert [truth.in_view for truth in world.history] == [False] * len(world.history)


def test_distortion_is_that_of_opencv() -> None:
    lens = Lens(image_size=(640, 480), focal_length=550.0, aspect=1.1, k1=-0.15)
    matrix = np.array([[550.0, 0.0, 319.5], [0.0, 605.0, 239.5], [0.0, 0.0, 1.0]])
    point = np.array([[[0.4, -0.3, 1.0]]])
    zero = np.zeros(3)
    expected, _ = cv2.projectPoints(point, zero, zero, matrix, np.array([-0.15, 0.0, 0.0, 0.0]))
    ideal = (319.5 + 550.0 * 0.4, 239.5 - 605.0 * 0.3)
    shown = lens.distort(*ideal)
    assert shown == pytest.approx(expected.ravel(), abs=1e-9)
    assert shown is not None
    assert lens.undistort(*shown) == pytest.approx(ideal, abs=1e-9)
    assert lens.distort(319.5 + 550.0 * 1.6, 239.5) is None


def test_exposure_blur_and_noise_are_those_asked_for() -> None:
    start = (-0.9, 0.0, 0.0)  # out of the corner that is looked at
    corner = np.s_[:200, -200:]

    def seen(**camera: float) -> np.ndarray:
        settings = WorldSettings(
            camera=msgspec.structs.replace(CLEAN, **camera), start=start, seed=1
        )
        with World(settings) as world:
            return frame_of(world).image[corner].astype(float)

    plain = seen()
    assert np.std(seen(noise=5.0) - plain) == pytest.approx(5.0, rel=0.05)
    assert np.mean(seen(exposure=0.5)) == pytest.approx(0.5 * np.mean(plain), rel=0.02)
    rough = [np.abs(np.diff(image)).mean() for image in (plain, seen(blur=2.0))]
    assert rough[1] < 0.7 * rough[0]


def test_an_open_shutter_blurs_only_what_moves() -> None:
    camera = msgspec.structs.replace(CLEAN, exposure_time=0.03)
    with World(WorldSettings(camera=camera, start=(0.0, 0.0, 0.0))) as world:
        frame = frame_of(world)
        still = frame.image
        world.robot.send(0.3, 0.0)
        world.advance(1.0)
        moving = frame_of(world)
    assert world.history[moving.number].t == moving.t

    def steepest(image: np.ndarray) -> int:
        return int(np.abs(np.diff(image.astype(int), axis=1)).max())

    assert steepest(moving.image) < 0.7 * steepest(still)


# ------------------------------------------------------------------------------- time


def test_frames_arrive_after_the_latency_and_several_are_on_their_way() -> None:
    camera = msgspec.structs.replace(CLEAN, latency=0.15)
    with World(WorldSettings(camera=camera)) as world:
        for number in range(5):
            frame = frame_of(world)
            assert (frame.number, frame.t) == (number, number / 30.0)
            assert world.clock.now() == pytest.approx(frame.t + 0.15, abs=1e-12)
        assert len(world.history) > 5


def test_no_frame_within_the_timeout_is_said_and_takes_just_that_long() -> None:
    camera = msgspec.structs.replace(CLEAN, latency=0.1)
    with World(WorldSettings(camera=camera)) as world:
        assert world.camera.read(timeout=0.04) is Missing.LATE
        assert world.clock.now() == 0.04
        assert world.camera.read(timeout=0.0) is Missing.LATE
        assert frame_of(world).number == 0


def test_the_newest_frame_is_read_when_several_wait() -> None:
    with World(WorldSettings(camera=CLEAN)) as world:
        world.advance(1.0)
        assert frame_of(world).number == 28  # taken at 0.933 s, here at 0.999 s
        assert world.clock.now() == 1.0
        assert frame_of(world).number == 29


def test_dropped_frames_leave_gaps_at_the_rate_asked_for() -> None:
    camera = msgspec.structs.replace(CLEAN, drop=0.3, image_size=(64, 64))
    with World(WorldSettings(camera=camera, seed=2)) as world:
        numbers = []
        while world.clock.now() < 10.0:
            numbers.append(frame_of(world).number)
        assert sorted(set(numbers)) == numbers
        share = 1.0 - len(numbers) / (numbers[-1] + 1)
        assert share == pytest.approx(0.3, abs=0.08)
        assert len(world.history) >= numbers[-1] + 1


def test_same_settings_give_the_same_frames_and_another_seed_others() -> None:
    def images(seed: int) -> list[np.ndarray]:
        settings = random_world(5, hard=True)
        settings = msgspec.structs.replace(settings, seed=seed)
        with World(settings) as world:
            world.robot.send(0.1, 0.5)
            return [frame_of(world).image for _ in range(4)]

    first, again, other = images(3), images(3), images(4)
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert not np.array_equal(first[-1], other[-1])


def test_placing_the_robot_shows_it_there_next_and_at_rest() -> None:
    with World(WorldSettings(camera=CLEAN)) as world:
        world.robot.send(0.2, 0.0)
        world.advance(0.5)
        world.place((0.1, -0.1, 3.0))
        placed = world.clock.now()
        frame = frame_of(world)
        assert frame.t > placed
        assert world.truth().pose == pytest.approx((0.1, -0.1, 3.0), abs=1e-4)
        assert world.truth().commanded_v == 0.0
        numbers = [truth.t for truth in world.history]
        assert numbers == sorted(set(numbers))


def test_a_closed_world_has_no_frames_and_its_robot_is_silent() -> None:
    with World(WorldSettings(camera=CLEAN)) as world:
        pass
    world.close()
    world.robot.stop()
    world.robot.close()
    world.camera.close()
    assert world.camera.read(timeout=1.0) is Missing.ENDED
    with pytest.raises(RobotSilentError, match="its world is closed"):
        world.robot.send(0.1, 0.0)
    with pytest.raises(InputError, match="the world is closed"):
        world.advance(1.0)


# ------------------------------------------------------------------------------- the robot


@pytest.mark.parametrize(("v", "omega"), [(0.2, 0.0), (-0.1, 0.0), (0.0, 1.0), (0.2, 1.0)])
def test_a_robot_without_errors_does_what_it_is_told(v: float, omega: float) -> None:
    truth = drive(plain_world(), v, omega, 1.0).truth()
    assert (truth.v, truth.omega) == pytest.approx((v, omega), rel=0.01, abs=1e-3)
    # The path is the unicycle's, but for the time in which the servos rise.
    turned = omega * (1.0 - 0.05)
    assert truth.theta == pytest.approx(turned, abs=0.02)
    if omega == 0.0:
        assert truth.x == pytest.approx(v * (1.0 - 0.05), abs=0.004)
        assert abs(truth.y) < 1e-4


def test_servos_take_their_time() -> None:
    slow, quick = (
        drive(plain_world(servo_time=time), 0.2, 0.0, 0.1).truth().v for time in (0.3, 0.02)
    )
    assert slow < 0.5 * quick


def test_motor_gains_turn_a_straight_drive() -> None:
    truth = drive(plain_world(motor_gains=(0.7, 1.3)), 0.1, 0.0, 1.0).truth()
    assert truth.v == pytest.approx(0.1, rel=0.02)
    assert truth.omega == pytest.approx(0.1 * 0.6 / 0.15, rel=0.02)


def test_wheels_stand_in_the_dead_band_and_turn_as_told_above_it() -> None:
    settings = plain_world(dead_band=1.0, motor_gains=(0.8, 1.2))
    least = settings.robot.limits().least_speed
    assert least == pytest.approx(0.035 / 0.7)
    assert drive(settings, 0.028, 0.0, 0.5).truth().pose == pytest.approx((0, 0, 0), abs=1e-5)
    one_wheel = drive(settings, 0.032, 0.0, 1.0).truth()
    assert one_wheel.omega == pytest.approx(1.2 * 0.032 / 0.15, rel=0.05)
    both = drive(settings, least, 0.0, 1.0).truth()
    assert both.v == pytest.approx(least, rel=0.02)


def test_the_speed_of_wheels_is_limited() -> None:
    truth = drive(plain_world(wheel_speed_limit=9.0), 1.0, 0.0, 2.0).truth()
    assert truth.v == pytest.approx(9.0 * 0.035, rel=0.01)


def test_a_weak_motor_accelerates_slowly() -> None:
    weak, strong = (
        drive(plain_world(torque_limit=limit, servo_time=0.0), 0.3, 0.0, 0.2).truth().v
        for limit in (0.03, 0.3)
    )
    assert weak < 0.8 * strong


def test_the_robot_goes_on_with_its_last_command() -> None:
    with World(plain_world()) as world:
        world.robot.send(0.1, 0.0)
        world.advance(2.0)
        assert world.truth().v == pytest.approx(0.1, rel=0.01)
        world.robot.stop()
        world.advance(1.0)
        assert abs(world.truth().v) < 1e-6


def test_commands_that_are_no_numbers_are_refused() -> None:
    with World(plain_world()) as world, pytest.raises(InputError, match="omega = nan"):
        world.robot.send(0.1, math.nan)


# ------------------------------------------------------------------------------- pushes


def test_pushes_move_a_standing_robot_a_little_and_the_same_for_the_same_seed() -> None:
    def rest(force: float, seed: int) -> tuple[float, float, float]:
        settings = WorldSettings(
            pushes=PushSettings(force=force), start=(0.0, 0.0, 0.0), camera=CLEAN, seed=seed
        )
        return drive(settings, 0.0, 0.0, 10.0).truth().pose

    assert np.abs(rest(0.0, 0)).max() < 1e-6
    for seed in (0, 1):
        x, y, theta = rest(2.0, seed)
        assert 1e-5 < math.hypot(x, y) < 2e-3
        assert abs(theta) < math.radians(1.0)
    assert rest(2.0, 0) == rest(2.0, 0) != rest(2.0, 1)


def test_pushes_come_one_after_the_other_within_their_bounds() -> None:
    settings = PushSettings(force=3.0, duration=0.1, rate=2.0, lever=0.04)
    pushes, t, all_of_them = Pushes(settings, seed=7), 0.0, []
    while t < 200.0:
        push = pushes.next_after(t)
        assert push is not None
        assert push.start >= t
        size = math.hypot(push.force_x, push.force_y)
        assert 1.5 <= size <= 3.0
        assert abs(push.torque) <= 0.04 * size
        assert push.end - push.start == pytest.approx(0.1)
        t = push.end
        all_of_them.append(push)
    assert len(all_of_them) == pytest.approx(200.0 / 0.6, rel=0.2)


# ------------------------------------------------------------------------------- random worlds


@pytest.mark.parametrize("hard", [False, True])
def test_random_worlds_show_goal_and_starts(hard: bool) -> None:
    for seed in range(20):
        for start in range(3):
            settings = random_world(seed, start=start, hard=hard)
            view = TagView(settings)
            for pose in (settings.start, settings.goal):
                assert view.holds(pose, margin=10.0, plate=True)
                assert TAG_PIXELS[0] <= view.size(pose) <= TAG_PIXELS[1]
            camera = settings.camera
            assert camera.tilt_deg <= 35.0
            assert 0.8 <= camera.aspect <= 1.25
            assert camera.latency == (0.150 if hard else 0.066)


def test_a_camera_keeps_its_goal_for_every_start() -> None:
    worlds = [random_world(11, start=start) for start in range(3)]
    assert len({world.camera for world in worlds}) == len({world.goal for world in worlds}) == 1
    assert len({world.start for world in worlds}) == 3
    assert len({world.robot.motor_gains for world in worlds}) == 3
    assert random_world(11, start=2) == worlds[2]
    assert random_world(12).camera != worlds[0].camera


def test_a_random_world_can_be_written_and_read_back() -> None:
    settings = random_world(3, hard=True)
    assert msgspec.json.decode(msgspec.json.encode(settings), type=WorldSettings) == settings


def test_tags_of_random_worlds_are_found(detector: object) -> None:
    for seed in range(4):
        settings = random_world(seed)
        with World(settings) as world:
            for pose in (settings.goal, settings.start):
                world.place(pose)
                tags = detector.detect(frame_of(world).image)  # type: ignore[attr-defined]
                assert [tag.tag_id for tag in tags] == [settings.robot.tag_id]


# ------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("structure", "given", "sentence"),
    [
        (CameraSettings, {"drop": 1.0}, r"drop = 1: must be in \[0, 1\)"),
        (CameraSettings, {"noise": -1.0}, "noise = -1"),
        (CameraSettings, {"rate": 0.0}, r"rate = 0.0: must be in \[1, 1000\] frames/s"),
        (CameraSettings, {"exposure_time": 0.04}, "exposure_time = 0.04: must be shorter"),
        (CameraSettings, {"exposure_time": 0.03, "latency": 0.01}, "latency = 0.01: must be at"),
        (CameraSettings, {"image_size": (640, 10)}, r"image_size = \[640, 10\]"),
        (CameraSettings, {"image_size": (640.5, 480)}, "must be whole numbers"),
        (CameraSettings, {"tilt_deg": 89.0}, "tilt_deg = 89: a corner of the picture shows the h"),
        (CameraSettings, {"tilt_deg": 95.0}, "tilt"),
        (CameraSettings, {"k1": -0.5}, "k1 = -0.5: such a barrel does not fill the picture"),
        (RobotSettings, {"tag_id": 587}, "tag_id = 587: .* 0 to 586"),
        (RobotSettings, {"tag_id": 1.5}, "tag_id = 1.5: must be a whole number"),
        (RobotSettings, {"track": 0.05}, "track = 0.05: must be at least 1.5 times wheel_radius"),
        (RobotSettings, {"tag_height": 0.05}, "tag_height = 0.05: the tag must lie above the wh"),
        (RobotSettings, {"motor_gains": (0.5, 1.0)}, "must lie within gain_error = 0.3 of 1"),
        (RobotSettings, {"gain_error": 1.0}, r"gain_error = 1: must be in \[0, 1\)"),
        (RobotSettings, {"wheel_speed_limit": 1.0}, "wheel_speed_limit = 1: speed and turn_rate"),
        (RobotSettings, {"dead_band": 8.0}, "least_speed = 0.4: the dead-band must be below"),
        (RobotSettings, {"torque_limit": 0.005}, "torque_limit = 0.005: must be more than twice"),
        (PushSettings, {"force": -2.0}, "force = -2"),
        (FloorSettings, {"brightness": 300.0}, r"brightness = 300: must be in \[30, 225\]"),
        (WorldSettings, {"seed": -1}, "seed = -1: must be a whole number, not negative"),
        (WorldSettings, {"start": (0.0, math.nan, 0.0)}, "start = nan"),
        (WorldSettings, {"camera": CameraSettings(height=0.15)}, "height = 0.15: the camera must"),
    ],
)
def test_bad_settings_are_refused_in_a_line(
    structure: type, given: dict[str, object], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence) as caught:
        structure(**given)
    assert "\n" not in str(caught.value)


def test_a_barrel_as_strong_as_the_sentence_says_is_taken() -> None:
    with pytest.raises(InputError) as caught:
        CameraSettings(k1=-0.5)
    suggested = float(str(caught.value).split("write k1 = ")[1].split()[0])
    assert CameraSettings(k1=suggested).k1 == suggested


def test_settings_of_a_file_are_read_and_unknown_keys_refused() -> None:
    text = "[camera]\ntilt_deg = 12.0\nimage_size = [320, 240]\n[robot]\nmotor_gains = [0.8, 1.1]"
    settings = msgspec.toml.decode(text, type=WorldSettings)
    assert settings.camera.image_size == (320, 240)
    assert settings.robot.motor_gains == (0.8, 1.1)
    with pytest.raises(msgspec.ValidationError, match="unknown field `zoom`"):
        msgspec.toml.decode("[camera]\nzoom = 2.0", type=WorldSettings)


def test_a_missing_osmesa_is_named_with_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    monkeypatch.setattr(ctypes.util, "find_library", lambda _: None)
    with pytest.raises(InputError, match="libOSMesa is not installed; on Debian run: apt-get i"):
        load_mujoco()


@pytest.mark.skipif(sys.platform != "linux", reason="these kinds of rendering are Linux's")
@pytest.mark.parametrize(
    ("backend", "sentence"),
    [
        ("nonsense", "MuJoCo does not load with MUJOCO_GL=nonsense"),
        ("disable", "MuJoCo cannot render with MUJOCO_GL=disable on this machine"),
    ],
)
def test_a_backend_that_is_set_is_respected(backend: str, sentence: str) -> None:
    code = (
        "from parkproof.errors import InputError\n"
        "from parkproof.lab.world.world import World, WorldSettings\n"
        "try:\n    World(WorldSettings()).camera.read(1.0)\n"
        "except InputError as error:\n    print(error)"
    )
    environment = os.environ | {"MUJOCO_GL": backend}
    run = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert run.stdout.startswith(sentence)
    assert run.stdout.count("\n") == 1


def test_a_world_that_cannot_be_simulated_is_refused():
    with pytest.raises(InputError, match=r"cannot be simulated: .* mass and inertia"):
        World(WorldSettings(robot=RobotSettings(wheel_radius=1e-9, wheel_speed_limit=1e12)))
    with pytest.raises(InputError, match=r"blur = 1000000000\.0: must be in \[0, 50\] px"):
        CameraSettings(blur=1e9)
    with pytest.raises(InputError, match=r"rate = 1e\+300: must be in \[0\.001, 1000\] pushes/s"):
        PushSettings(rate=1e300)
    with pytest.raises(InputError, match=r"goal = 1e\+300: must be in \[-1000, 1000\] m and rad"):
        WorldSettings(goal=(1e300, 0.0, 0.0))
    with pytest.raises(InputError, match=r"mass = 1000000000000\.0: must be in \[0\.01, 1000\] kg"):
        RobotSettings(mass=1e12)
    with pytest.raises(InputError, match=r"rate = 1000000000\.0: must be in \[1, 1000\]"):
        CameraSettings(rate=1e9)
    with pytest.raises(InputError, match=r"latency = 1000\.0: must be in \[0, 5\] s"):
        CameraSettings(latency=1000.0)
