"""Whole runs in the simulated laboratory: from pixels to parked."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest

from parkproof.cli import main
from parkproof.errors import InputError
from parkproof.lab.devices import Frame, Missing, RobotLimits, RobotSilentError
from parkproof.lab.film import Film
from parkproof.lab.image_pose import TagMount
from parkproof.lab.loop import replay_settings, run_lab
from parkproof.lab.outcome import LabOutcome
from parkproof.lab.record import Recorder
from parkproof.lab.recording import RecordedCamera, Recording
from parkproof.lab.replay import replayed
from parkproof.lab.robot_simulator import UdpRobotSimulator
from parkproof.lab.safety import SafetyLimits
from parkproof.lab.settings import LabSettings
from parkproof.lab.simulated import floor_pose, run_simulated, shown_goal
from parkproof.lab.tag import TagDetector
from parkproof.lab.teach import teach
from parkproof.lab.worker import Worker
from parkproof.lab.world import RobotSettings, World, WorldSettings, random_world
from parkproof.lab.world.settings import example_world
from tag_pictures import picture, view

SHORT = LabSettings(hold=2.0, duration=60.0)


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """The results of the command, made once."""
    out = tmp_path_factory.mktemp("lab") / "run"
    assert main(["lab", "--out", str(out), "--set", "hold=1.0", "--check", "--quiet"]) == 0
    return out


def test_the_command_parks_from_pixels_and_leaves_all_it_promises(made):
    summary = json.loads((made / "summary.json").read_text())
    assert summary["outcome"] == "parked"
    assert summary["frames"]["out_of_view"] == 0
    assert summary["image_error"]["distance_px"] <= 1.0
    assert summary["image_error"]["heading_deg"] <= 1.0
    names = {path.name for path in made.iterdir()}
    assert {
        "goal.json", "overview.png", "run.mcap", "run.mp4", "strip.png", "trajectory.parquet"
    } <= names  # fmt: skip


def messages(path: Path, topic: str) -> list:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return list(reader.iter_decoded_messages(topics=[topic]))


def test_the_summary_holds_what_the_run_was_told(made):
    told = json.loads((made / "summary.json").read_text())["settings"]
    assert told["settings"]["hold"] == 1.0
    assert told["goal"]["picture"] == [640, 480]
    assert told["limits"]["speed"] > 0.0


def test_the_recording_holds_image_poses_and_the_date(made):
    found = messages(made / "run.mcap", "/robot/image_pose")
    goal = json.loads((made / "goal.json").read_text())
    *_, message, last = found[-1]
    assert last.pose.position.x == pytest.approx(goal["u"], abs=1.0)
    assert last.pose.position.y == pytest.approx(goal["v"], abs=1.0)
    assert abs(time.time() - 1e-9 * message.log_time) < 3600.0


def test_a_replay_gives_the_same_commands(made, capsys):
    assert replayed(made / "run.mcap").same
    assert main(["replay", str(made)]) == 0
    assert "are the same" in capsys.readouterr().out


def test_a_replay_with_other_settings_gives_other_commands(made, monkeypatch):
    monkeypatch.setattr("parkproof.lab.planning.TOLERANCE", 0.3)
    monkeypatch.setattr("parkproof.lab.plan.PACES", (0.5,))
    found = replayed(made / "run.mcap")
    assert not found.same
    assert "differ" in found.sentence


def test_a_distorting_lens_late_and_dropped_frames_and_unequal_motors_do_not_keep_it_from_parking():
    with World(random_world(1, hard=True)) as world:
        judged = run_simulated(world, shown_goal(world), settings=SHORT)
    assert judged.run.outcome is LabOutcome.PARKED
    assert judged.run.frames.dropped > 0
    assert judged.run.frames.out_of_view == 0
    assert judged.worst_image_error.distance <= 1.0
    assert judged.true_error.distance <= 0.01 * judged.floor_width / 1.5


def test_commands_stay_within_the_limits_of_a_weaker_robot():
    weak = RobotSettings(speed=0.12, turn_rate=0.8, acceleration=0.4, turn_acceleration=3.0)
    with World(WorldSettings(robot=weak)) as world:
        judged = run_simulated(world, shown_goal(world), settings=SHORT)
    assert judged.run.outcome is LabOutcome.PARKED
    assert max(abs(sample.v) for sample in judged.run.samples) <= 0.12
    assert max(abs(sample.omega) for sample in judged.run.samples) <= 0.8


class Noted:
    """The robot of a world, with what it is sent and when."""

    def __init__(self, world: World) -> None:
        self._robot, self._clock = world.robot, world.clock
        self.sent: list[tuple[float, float, float]] = []

    @property
    def limits(self) -> RobotLimits:
        return self._robot.limits

    def send(self, v: float, omega: float) -> None:
        self.sent.append((self._clock.now(), v, omega))
        self._robot.send(v, omega)

    def stop(self) -> None:
        self._robot.stop()

    def close(self) -> None:
        self._robot.close()


def test_what_a_weaker_robot_is_sent_changes_no_faster_than_it_can():
    weak = RobotSettings(speed=0.12, turn_rate=0.8, acceleration=0.4, turn_acceleration=3.0)
    with World(WorldSettings(robot=weak)) as world:
        goal, robot = shown_goal(world), Noted(world)
        run_lab(
            world.camera, robot, world.clock, goal,
            settings=LabSettings(duration=12.0), realtime=False,
        )  # fmt: skip
    assert len(robot.sent) > 300
    assert max(abs(v) for _, v, _ in robot.sent) == pytest.approx(0.12)
    assert max(abs(omega) for *_, omega in robot.sent) <= 0.8
    for (t, v, omega), (later, w, psi) in pairwise(robot.sent):
        assert abs(w - v) <= 0.4 * (later - t) + 1e-12
        assert abs(psi - omega) <= 3.0 * (later - t) + 1e-12


class Odd:
    """A camera that gives, now and then, what is no picture of the goal's size."""

    def __init__(self, world: World) -> None:
        self._eye, self._count = world.camera, 0

    def read(self, timeout: float):
        self._count += 1
        got = self._eye.read(timeout)
        small = np.zeros((24, 32), np.uint8)
        odd = (None, np.zeros(0), np.zeros((480, 640, 4), np.uint8), small)
        if isinstance(got, Missing) or self._count % 9:
            return got
        return replace(got, image=odd[self._count // 9 % 4])

    def close(self) -> None:
        self._eye.close()


def recorded(world: World, path: Path, camera=None, *, watch=lambda *_: None, duration=3.0):
    """A short run that is recorded as run.mcap, and the recorder."""
    settings, goal = LabSettings(duration=duration), shown_goal(world)
    known = replay_settings(goal, world.robot, settings, SafetyLimits())
    with Recorder(path / "run.mcap", settings=known, realtime=False) as recorder:
        found = run_lab(
            camera or world.camera, world.robot, world.clock, goal,
            settings=settings, recorder=recorder, watch=watch, realtime=False,
        )  # fmt: skip
    return found, recorder


def test_what_is_no_picture_neither_ends_a_run_nor_its_recording_nor_its_film(tmp_path):
    with World(WorldSettings()) as world:
        goal = shown_goal(world)
        with Film(tmp_path / "run.mp4", goal, 30.0, realtime=False) as film:
            found, _ = recorded(world, tmp_path, Odd(world), watch=film.add)
        film.write_strip(tmp_path / "strip.png")
    assert found.outcome is LabOutcome.STILL_MOVING
    assert found.frames.without_tag >= 8
    assert (tmp_path / "strip.png").exists()
    again = replayed(tmp_path / "run.mcap")
    assert again.same
    assert again.commands >= 90


def test_a_stop_that_nobody_asked_for_is_in_the_recording_and_replayed(tmp_path):
    def watch(_reading, answer) -> None:
        if round(30.0 * answer.t) % 25 == 0:
            signal.raise_signal(signal.SIGTSTP)

    before = signal.signal(signal.SIGTSTP, lambda *_: None)  # instead of being suspended
    try:
        with World(WorldSettings()) as world:
            found, _ = recorded(world, tmp_path, watch=watch)
    finally:
        signal.signal(signal.SIGTSTP, before)
    assert [event.name for event in found.events].count("halt") >= 3
    commands = Recording.open(tmp_path / "run.mcap").commands()
    changed = [each for each in commands if each.halted is not None and each.asked is not None]
    assert any(abs(each.v) < abs(each.asked[0]) for each in changed)
    assert replayed(tmp_path / "run.mcap").same


def test_a_replay_compares_up_to_a_picture_that_was_lost(tmp_path, monkeypatch):
    calls = []

    def do(worker, job, *, bulky=False):
        calls.append(bulky)
        return False if bulky and sum(calls) == 40 else done(worker, job, bulky=bulky)

    done = Worker.do
    monkeypatch.setattr(Worker, "do", do)
    with World(WorldSettings()) as world:
        _, recorder = recorded(world, tmp_path)
    assert recorder.lost == 1
    found = replayed(tmp_path / "run.mcap")
    assert (found.same, found.lost, found.first_different) == (False, True, None)
    assert 30 < found.commands < 50
    assert "then a picture was lost" in found.sentence


def test_a_recording_without_a_command_is_not_the_same(tmp_path):
    with World(WorldSettings()) as world:
        known = replay_settings(shown_goal(world), world.robot, LabSettings(), SafetyLimits())
    with Recorder(tmp_path / "run.mcap", settings=known):
        pass
    found = replayed(tmp_path / "run.mcap")
    assert not found.same
    assert "no command" in found.sentence


def test_a_recording_that_lacks_frames_is_not_the_same(made, monkeypatch):
    read = RecordedCamera.read

    def ends(camera, timeout):
        camera.count = getattr(camera, "count", 0) + 1
        return read(camera, timeout) if camera.count <= 50 else Missing.ENDED

    monkeypatch.setattr(RecordedCamera, "read", ends)
    found = replayed(made / "run.mcap")
    assert (found.same, found.commands) == (False, 50)
    assert "no more frames" in found.sentence


def test_a_real_run_has_the_error_that_was_seen_in_its_summary(made, tmp_path):
    folder = tmp_path / "frames"
    folder.mkdir()
    with World(example_world()) as world:
        world.place(world.settings.goal)
        frame = world.camera.read(1.0)
    assert isinstance(frame, Frame)
    for k in range(60):  # two seconds
        cv2.imwrite(str(folder / f"{k:03}.png"), frame.image)
    with UdpRobotSimulator() as simulator:
        arguments = ["--camera", str(folder), "--robot", simulator.address, "--no-video", "--quiet"]
        goal = ["--goal", str(made / "goal.json"), "--out", str(tmp_path / "run")]
        assert main(["lab", *arguments, *goal]) == 0
    error = json.loads((tmp_path / "run" / "summary.json").read_text())["image_error"]
    assert 0.0 <= error["distance_px"] < 1.0
    assert 0.0 <= error["heading_deg"] < 1.0


class Ends:
    """A camera that ends after some frames."""

    why_ended = "the cable was pulled"

    def __init__(self, world: World, frames: int) -> None:
        self._eye, self._left = world.camera, frames

    def read(self, timeout: float):
        self._left -= 1
        return self._eye.read(timeout) if self._left >= 0 else Missing.ENDED

    def close(self) -> None:
        self._eye.close()


class Silent:
    """A robot that stops answering after some commands."""

    def __init__(self, world: World, commands: int) -> None:
        self._robot, self._left = world.robot, commands
        self.stops = 0

    @property
    def limits(self) -> RobotLimits:
        return self._robot.limits

    def send(self, v: float, omega: float) -> None:
        self._left -= 1
        if self._left < 0:
            raise RobotSilentError("the robot at nowhere has not answered for 0.5 s")
        self._robot.send(v, omega)

    def stop(self) -> None:
        self.stops += 1
        self._robot.stop()

    def close(self) -> None:
        self.stop()


def test_a_camera_that_ends_and_a_robot_that_is_silent_end_the_run_with_the_robot_stopped():
    with World(WorldSettings()) as world:
        goal = shown_goal(world)
        eye, clock = Ends(world, 40), world.clock
        found = run_lab(eye, world.robot, clock, goal, settings=SHORT, realtime=False)
        assert found.outcome is LabOutcome.CAMERA_ENDED
        assert found.note == "the cable was pulled"
        assert world.truth()[6:8] == (0.0, 0.0)
        robot = Silent(world, 40)
        found = run_lab(world.camera, robot, clock, goal, settings=SHORT, realtime=False)
        assert found.outcome is LabOutcome.ROBOT_SILENT
        assert "0.5 s" in found.note
        assert robot.stops > 0
        assert world.truth()[6:8] == (0.0, 0.0)


class Shows:
    """A camera that shows one picture again and again."""

    def __init__(self, image: np.ndarray) -> None:
        self._image, self.number = image, 0

    def read(self, _timeout: float) -> Frame:
        self.number += 1
        return Frame(self._image, t=self.now(), number=self.number)

    def close(self) -> None:
        pass

    def now(self) -> float:
        return self.number / 30.0


STANDS = view((350.0, 260.0), 40.0)
ELSEWHERE = view((150.0, 160.0), 40.0)


@pytest.mark.parametrize(
    ("image", "says"),
    [
        (picture((3, STANDS), (12, ELSEWHERE)), "shows tags 3, 12, but not tag 7"),
        (picture(), "shows no tag"),
        (picture((7, STANDS), (7, ELSEWHERE)), "shows tag 7 more than once"),
        (picture((7, STANDS))[:, ::-1], "as in a mirror"),
        (np.zeros((240, 320), np.uint8), "320 × 240 pixels: the goal was taught with 640 × 480"),
    ],
)
def test_a_robot_that_is_never_seen_ends_the_run_soon_and_says_what_is_seen(image, says):
    goal = teach(Frame(picture((7, STANDS)), t=0.0, number=0), TagDetector(), TagMount(tag_id=7))
    robot, camera = Hears(), Shows(np.ascontiguousarray(image))
    found = run_lab(camera, robot, camera, goal, settings=LabSettings(wait=1.0), realtime=False)
    assert found.outcome is LabOutcome.NEVER_SEEN
    assert found.ended <= 1.1
    assert says in found.note
    assert robot.heard == {(0.0, 0.0)}


class Hears:
    """A robot that keeps what it is sent."""

    limits = RobotSettings().limits()

    def __init__(self) -> None:
        self.heard: set[tuple[float, float]] = set()

    def send(self, v: float, omega: float) -> None:
        self.heard.add((v, omega))

    def stop(self) -> None:
        self.send(0.0, 0.0)

    def close(self) -> None:
        self.stop()


def test_a_camera_that_ended_before_the_robot_was_seen_says_both():
    goal = teach(Frame(picture((7, STANDS)), t=0.0, number=0), TagDetector(), TagMount(tag_id=7))
    with World(WorldSettings()) as world:
        eye = Ends(world, 3)
        found = run_lab(eye, world.robot, world.clock, goal, settings=SHORT, realtime=False)
    assert found.note.startswith("the cable was pulled; the picture shows tag 0, but not tag 7")


def test_an_interrupted_run_stops_the_robot_and_keeps_what_there_is():
    with World(WorldSettings()) as world:
        goal = shown_goal(world)

        def watch(_reading, answer) -> None:
            if answer.t > 1.5:
                raise KeyboardInterrupt

        found = run_lab(
            world.camera, world.robot, world.clock, goal,
            settings=SHORT, watch=watch, realtime=False,
        )  # fmt: skip
        assert found.outcome is LabOutcome.INTERRUPTED
        assert len(found.samples) > 10
        assert world.truth()[6:8] == (0.0, 0.0)


def test_ctrl_c_keeps_what_there_is_of_a_run_and_says_so(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "parkproof", "lab", "--out", "out", "--set", "hold=500", "--set",
         "duration=1000", "--no-video"],
        cwd=tmp_path, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    deadline = time.monotonic() + 60.0
    while not list(tmp_path.glob(".out.new-*/run.mcap")) and time.monotonic() < deadline:
        time.sleep(0.1)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in said
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["outcome"] == "interrupted"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--camera", "0"], "--goal"),
        (["--seed", "1", "--world", "w.toml"], "--seed"),
        (["--start", "1"], "--seed"),
        (["--start", "1", "--world", "w.toml"], "--seed"),
        (["--world", "none.toml"], "none.toml"),
        (["--set", "hold=-1"], "hold"),
        (["--set", "rate=1e300"], "rate = 1e+300: must be in [1, 1000] frames/s"),
        (["--set", "delay=1e9"], "delay = 1000000000.0: must be in [0, 5] s"),
        (["--set", "law=homogeneous"], "gains"),
        (["--set", "nothing=1"], "nothing"),
    ],
)
def test_bad_input_is_one_sentence_and_leaves_nothing(arguments, says, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "parkproof", "lab", "--out", str(tmp_path / "out"), *arguments],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 2
    assert says in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def after(t: float, what: Callable[[], None]) -> Callable[..., Callable[..., None]]:
    """In place of what watches a run: does something once the run is so old."""
    done: list[float] = []

    def watch(_reading, answer) -> None:
        if answer.t > t and not done:
            done.append(answer.t)
            what()

    return lambda *_: watch


@pytest.fixture
def undrawn(monkeypatch):
    """Leave out the drawing of overviews, which takes longest."""
    monkeypatch.setattr("parkproof.report.lab.lab_pictures", lambda *_: None)


def raise_(error: BaseException) -> None:
    raise error


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(("name", "status"), [("SIGTERM", 143), ("SIGHUP", 129)])
def test_a_request_to_end_and_a_closed_terminal_have_their_own_status(
    name, status, tmp_path, monkeypatch
):
    stop = after(1.0, lambda: os.kill(os.getpid(), getattr(signal, name)))
    monkeypatch.setattr("parkproof.cli.lab_results.LabResults._watch", stop)
    out = tmp_path / "out"
    assert main(["lab", "--out", str(out), "--no-video", "--no-recording", "--quiet"]) == status
    assert json.loads((out / "summary.json").read_text())["outcome"] == "interrupted"


def test_a_run_that_breaks_off_leaves_its_recording_and_says_where(tmp_path, monkeypatch, capsys):
    out = tmp_path / "out"
    for error in (RuntimeError("a fault in a driver"), InputError("out of the camera's reach")):
        broken = after(1.0, lambda error=error: raise_(error))
        monkeypatch.setattr("parkproof.cli.lab_results.LabResults._watch", broken)
        call = ["lab", "--out", str(out), "--no-video", "--quiet"]
        if isinstance(error, InputError):
            assert main(call) == 2
            assert "out-broken-off-2: run.mcap" in capsys.readouterr().err
        else:
            with pytest.raises(RuntimeError):
                main(call)
    assert not out.exists()
    recording = tmp_path / "out-broken-off" / "run.mcap"
    assert Recording.open(recording).whole
    assert replayed(recording).same
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "out-broken-off",
        "out-broken-off-2",
    ]


@pytest.mark.usefixtures("undrawn")
def test_a_run_is_judged_by_the_goal_that_was_given(tmp_path):
    world = WorldSettings(start=(-0.2, -0.2, 0.5), goal=(0.2, 0.1, 0.0))
    other = (0.1, -0.15, 0.7)
    with World(msgspec.structs.replace(world, goal=other)) as there:
        goal = shown_goal(there)
        assert floor_pose(there, goal) == pytest.approx(other, abs=2e-3)
    goal.write(tmp_path / "goal.json")
    (tmp_path / "w.toml").write_text("start = [-0.2, -0.2, 0.5]\ngoal = [0.2, 0.1, 0.0]\n")
    call = ["--world", str(tmp_path / "w.toml"), "--goal", str(tmp_path / "goal.json")]
    out = ["--out", str(tmp_path / "out"), "--no-video", "--no-recording", "--quiet"]
    assert main(["lab", *call, *out, "--set", "duration=0.2"]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    wanted = math.dist(world.start[:2], other[:2])
    assert summary["true_error"]["distance_m"] == pytest.approx(wanted, abs=2e-3)


@pytest.mark.usefixtures("undrawn")
def test_a_real_laboratory_tells_the_error_in_the_picture_and_why_its_camera_ended(tmp_path):
    shown = picture((7, STANDS))
    goal = teach(Frame(shown, t=0.0, number=0), TagDetector(), TagMount(tag_id=7))
    goal.write(tmp_path / "goal.json")
    frames = tmp_path / "frames"
    frames.mkdir()
    for k in range(15):
        cv2.imwrite(str(frames / f"{k:03d}.png"), picture((7, STANDS), seed=k))
    with UdpRobotSimulator() as robot:
        call = ["--goal", str(tmp_path / "goal.json"), "--camera", str(frames)]
        out = ["--out", str(tmp_path / "out"), "--no-video", "--quiet"]
        assert main(["lab", *call, "--robot", robot.address, *out]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["outcome"] == "camera ended"
    assert summary["notes"] == [f"{frames} has ended after 15 frames"]
    assert summary["image_error"]["distance_px"] < 0.5
    assert summary["true_error"] is None


def test_a_replay_of_what_is_no_recording_is_refused(tmp_path, capsys):
    path = tmp_path / "run.mcap"
    path.write_bytes(b"not a recording")
    assert main(["replay", str(path)]) == 2
    assert "MCAP" in capsys.readouterr().err
