"""Whole runs in the simulated laboratory: from pixels to parked."""

import json
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest

from parkproof.cli import main
from parkproof.lab.devices import Frame, Missing, RobotLimits, RobotSilentError
from parkproof.lab.film import Film
from parkproof.lab.loop import LabOutcome, replay_settings, run_lab
from parkproof.lab.record import Recorder
from parkproof.lab.recording import RecordedCamera, Recording
from parkproof.lab.replay import replayed
from parkproof.lab.robot_simulator import UdpRobotSimulator
from parkproof.lab.safety import SafetyLimits
from parkproof.lab.settings import LabSettings
from parkproof.lab.simulated import run_simulated, shown_goal
from parkproof.lab.worker import Worker
from parkproof.lab.world import RobotSettings, World, WorldSettings, random_world
from parkproof.lab.world.settings import example_world

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
        assert world.truth()[6:8] == (0.0, 0.0)
        robot = Silent(world, 40)
        found = run_lab(world.camera, robot, clock, goal, settings=SHORT, realtime=False)
        assert found.outcome is LabOutcome.ROBOT_SILENT
        assert "0.5 s" in found.note
        assert robot.stops > 0
        assert world.truth()[6:8] == (0.0, 0.0)


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
        (["--world", "none.toml"], "none.toml"),
        (["--set", "hold=-1"], "hold"),
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


def test_a_replay_of_what_is_no_recording_is_refused(tmp_path, capsys):
    path = tmp_path / "run.mcap"
    path.write_bytes(b"not a recording")
    assert main(["replay", str(path)]) == 2
    assert "MCAP" in capsys.readouterr().err
