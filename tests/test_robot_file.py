"""A robot from a file: its limits and wheels reach what is sent."""

import json
from pathlib import Path

import cv2
import pytest

from parkproof.cli import main
from parkproof.lab.devices import Frame
from parkproof.lab.image_pose import TagMount
from parkproof.lab.recording import Recording
from parkproof.lab.robot_file import read_robot, robot_named
from parkproof.lab.robot_simulator import UdpRobotSimulator
from parkproof.lab.robots import GENTLE, WheelBase
from parkproof.lab.tag import TagDetector
from parkproof.lab.teach import teach
from parkproof.scenario_file import template
from tag_pictures import picture, view

LIMITS = """[limits]
speed = 0.12
turn_rate = 0.8
acceleration = 0.4
turn_acceleration = 3.0
"""


def written(folder: Path, address: str, rest: str) -> Path:
    path = folder / "robot.toml"
    path.write_text(f'address = "{address}"\n{rest}', encoding="utf-8")
    return path


def test_the_file_to_start_from_describes_a_robot(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_text(template("robot").replace("# [w", "[w").replace("# wheel", "wheel")
                    .replace("# half", "half"), encoding="utf-8")  # fmt: skip
    known = read_robot(path)
    assert known.limits == GENTLE
    assert known.wheels is not None
    assert known.wheels.half_track == 0.075


def test_wheels_of_the_file_are_sent_their_speeds(tmp_path):
    wheels = "[wheels]\nwheel_radius = 0.5\nhalf_track = 0.25\n"
    twice = WheelBase(wheel_radius=1.0, half_track=0.25)
    with UdpRobotSimulator(dead_man=60.0, wheels=twice) as simulator:
        robot = robot_named(str(written(tmp_path, simulator.address, LIMITS + wheels))).open()
        robot.send(0.1, 0.2)
        robot.close()
        simulator.wait_for(5)
        moved = [(each.v, each.omega) for each in simulator.received if each.v]
    assert robot.limits.speed == 0.12
    assert moved == [pytest.approx((0.2, 0.4))]


def test_the_command_records_the_limits_of_the_file(tmp_path, monkeypatch):
    monkeypatch.setattr("parkproof.report.lab.lab_pictures", lambda *_: None)
    shown = picture((7, view((350.0, 260.0), 40.0)))
    goal = teach(Frame(shown, t=0.0, number=0), TagDetector(), TagMount(tag_id=7))
    goal.write(tmp_path / "goal.json")
    (tmp_path / "frames").mkdir()
    for k in range(3):
        cv2.imwrite(str(tmp_path / "frames" / f"{k}.png"), shown)
    with UdpRobotSimulator() as simulator:
        robot = written(tmp_path, simulator.address, LIMITS)
        call = ["--goal", str(tmp_path / "goal.json"), "--camera", str(tmp_path / "frames")]
        out = ["--out", str(tmp_path / "out"), "--no-video", "--quiet"]
        assert main(["lab", *call, "--robot", str(robot), *out]) == 0
    known = Recording.open(tmp_path / "out" / "run.mcap").settings
    assert known["limits"]["turn_rate"] == 0.8
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["outcome"] == "camera ended"


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("[limits]\nspeed = -0.3\nturn_rate = 1\nacceleration = 1\nturn_acceleration = 1\n",
         "speed = -0.3: must be greater than 0"),
        ("[limits]\nspeed = nan\nturn_rate = 1\nacceleration = 1\nturn_acceleration = 1\n",
         "speed = nan: must be a finite number"),
        ("[wheels]\nwheel_radius = 0.0\nhalf_track = 0.1\n", "wheel_radius = 0.0: must be greater"),
        ("[wheels]\nradius = 0.1\n", "radius"),
        ("limits = 3\n", "limits"),
    ],
)  # fmt: skip
def test_a_file_that_is_wrong_is_refused_in_one_line(content, says, tmp_path, capsys):
    path = written(tmp_path, "udp://127.0.0.1:9", content)
    assert main(["camera", "--latency", "--source", str(tmp_path), "--robot", str(path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert says in said


def test_a_file_that_is_not_there_says_how_to_write_one(capsys, tmp_path):
    path = tmp_path / "robot.toml"
    call = ["--latency", "--source", str(tmp_path), "--robot", str(path)]
    assert main(["camera", *call]) == 2
    assert "parkproof init --kind robot" in capsys.readouterr().err
