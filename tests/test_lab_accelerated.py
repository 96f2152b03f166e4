"""Robots that take accelerations, as those whose motors are commanded by torque do."""

import json
import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.cli import main
from parkproof.lab.accelerated_parker import AcceleratedParker
from parkproof.lab.accelerated_watchdog import StoppingAcceleratedRobot
from parkproof.lab.answer import Phase
from parkproof.lab.devices import Frame, Missing, WallClock
from parkproof.lab.estimate import Sighting
from parkproof.lab.limits import limited_acceleration
from parkproof.lab.loop import run_lab
from parkproof.lab.observer import AcceleratedEstimator
from parkproof.lab.outcome import LabOutcome
from parkproof.lab.parker_for import commanded_by
from parkproof.lab.predict import CommandHistory, GoalPose, advanced
from parkproof.lab.replay import replayed
from parkproof.lab.safety import Alarm
from parkproof.lab.settings import LabSettings
from parkproof.lab.simulated import run_simulated, shown_goal
from parkproof.lab.world import PushSettings, RobotSettings, World, WorldSettings, random_world
from parkproof.lab.world.inertia import nominal_drive
from parkproof.results import read_trajectory
from test_lab_safety import BLANK, LIMITS, RATE, goal, noisy, picture
from test_watchdog import Hands, some_limits, wait_until

TORQUE = RobotSettings(commanded_by="torque")
UNEQUAL = RobotSettings(commanded_by="torque", motor_gains=(0.8, 1.25))
any_number = st.floats(allow_nan=True, allow_infinity=True)

# ------------------------------------------------------------------------------- limits


@given(any_number, any_number, any_number, any_number, any_number, some_limits)
def test_no_limit_of_acceleration_is_ever_exceeded(v_dot, omega_dot, v, omega, dt, limits):
    sent = limited_acceleration(v_dot, omega_dot, v, omega, dt, limits, gain=1.3)
    assert abs(sent[0]) <= limits.acceleration
    assert abs(sent[1]) <= limits.turn_acceleration


@given(any_number, any_number, st.floats(-1, 1), st.floats(-1, 1), st.floats(0.7, 1.3), some_limits)
def test_speeds_within_their_limits_stay_there_whatever_is_asked(
    v_dot, omega_dot, share, turn_share, true, limits
):
    v, omega = share * limits.speed, turn_share * limits.turn_rate
    sent = limited_acceleration(v_dot, omega_dot, v, omega, 0.03, limits, gain=1.3)
    assert abs(v + true * 0.03 * sent[0]) <= limits.speed * (1 + 1e-12)
    assert abs(omega + true * 0.03 * sent[1]) <= limits.turn_rate * (1 + 1e-12)


@given(st.floats(1.01, 5.0), any_number)
def test_a_robot_that_is_too_fast_is_slowed_down(share, v_dot):
    assert limited_acceleration(v_dot, 0.0, share * LIMITS.speed, 0.0, 0.03, LIMITS)[0] < 0.0
    assert limited_acceleration(v_dot, 0.0, -share * LIMITS.speed, 0.0, 0.03, LIMITS)[0] > 0.0


class Script:
    """A robot that notes what it is told."""

    limits = LIMITS

    def __init__(self) -> None:
        self.told: list[tuple[float, float] | str] = []

    def accelerate(self, v_dot: float, omega_dot: float) -> None:
        self.told.append((v_dot, omega_dot))

    def stop(self) -> None:
        self.told.append("stop")

    def close(self) -> None:
        self.told.append("close")


def test_the_watchdog_cuts_accelerations_and_brakes_at_what_is_no_number():
    script = Script()
    with StoppingAcceleratedRobot(script, clock=Hands(), timeout=None) as robot:
        robot.accelerate(5.0, -50.0)
        robot.accelerate(math.nan, 0.0)
    assert script.told == [(1.0, -8.0), "stop", "stop", "close"]


def test_a_robot_that_coasts_is_braked_when_no_command_comes():
    script = Script()
    with StoppingAcceleratedRobot(script, clock=WallClock(), timeout=0.05) as robot:
        robot.accelerate(0.0, 0.0)  # it may be fast all the same
        wait_until(lambda: robot.late_stops == 1)
        assert script.told[-1] == "stop"


def test_a_robot_is_known_by_what_it_takes():
    with World(WorldSettings()) as one, World(WorldSettings(robot=TORQUE)) as other:
        assert commanded_by(one.robot) == "velocity"
        assert commanded_by(other.robot) == "torque"
    assert commanded_by(Script()) == "torque"


# ------------------------------------------------------------------------------- the world


def test_without_friction_the_robot_accelerates_as_it_is_told():
    robot = RobotSettings(commanded_by="torque", friction_torque=0.0, servo_time=0.0)
    for told in ((0.4, 0.0), (0.0, 2.0)):
        with World(WorldSettings(robot=robot)) as world:
            world.robot.accelerate(*told)
            world.advance(0.5)
            assert world.truth()[4:6] == pytest.approx((0.5 * told[0], 0.5 * told[1]), abs=0.02)


def test_gains_of_the_motors_and_friction_come_on_top():
    with World(WorldSettings(robot=UNEQUAL)) as world:
        world.robot.accelerate(0.4, 0.0)
        world.advance(0.5)
        truth = world.truth()
    assert 0.1 < truth.v < 0.2
    assert truth.omega > 0.3  # the right motor is stronger


def test_the_brake_stops_the_robot_within_a_tenth_of_a_second_and_holds_it():
    pushes = PushSettings(force=2.0, rate=2.0)
    with World(WorldSettings(robot=TORQUE, pushes=pushes)) as world:
        world.robot.accelerate(0.6, 2.0)
        world.advance(0.5)
        assert world.truth().v > 0.15
        world.robot.stop()
        world.advance(0.1)
        there = world.truth()
        world.advance(3.0)
        assert math.dist(there.pose[:2], world.truth().pose[:2]) < 1e-3
        assert world.truth()[4:6] == pytest.approx((0.0, 0.0), abs=1e-3)


def test_nominal_inertia_is_that_of_the_described_robot():
    drive = nominal_drive(RobotSettings(mass=2.0))
    assert drive.mass > 2.0
    assert drive.mass == pytest.approx(nominal_drive(RobotSettings(mass=1.0)).mass + 1.0)


# ------------------------------------------------------------------------------- estimation


def seen_motion(own: float, turn: float, cross: float, friction: float):
    """A made-up robot driven to and fro; what the estimator finds, and the truth, at the end."""
    delay, dt, parts = 0.05, 1 / 30, 20
    estimator, history = AcceleratedEstimator(delay=delay), CommandHistory()
    rng = np.random.default_rng(0)
    pose, v, omega = GoalPose(0.0, 0.0, 0.0), 0.0, 0.0
    errors = []
    for k in range(1, 301):
        t = k * dt
        told = 0.5 * math.cos(2.0 * t), 3.0 * math.cos(3.1 * t)
        for i in range(parts):
            now = t - dt + dt * i / parts
            sent = next(((a, b) for _, a, b in history.pieces(now - delay, now - delay + 1e-9)))
            v += dt / parts * (own * sent[0] - friction * math.tanh(v / 1e-3))
            omega += dt / parts * (turn * sent[1] + cross * sent[0])
            pose = advanced(pose, dt / parts, 10.0 * v, omega)
        noisy = GoalPose(*(x + 1e-3 * rng.normal() for x in pose))
        found = estimator.update(Sighting(t, noisy, a=10.0, beta=1.0), history, now=t)
        history.add(t, *told)
        if k > 150:
            errors.append((estimator.moving.v - v, estimator.moving.omega - omega))
    return estimator.moving, np.std(errors, axis=0), found


def test_speeds_and_gains_of_the_motors_are_found():
    moving, errors, _ = seen_motion(own=0.8, turn=1.2, cross=1.5, friction=0.1)
    assert errors[0] < 0.006
    assert errors[1] < 0.06
    assert moving.along.own == pytest.approx(0.8, abs=0.08)
    assert moving.turning.own == pytest.approx(1.2, abs=0.08)
    assert moving.turning.cross == pytest.approx(1.5, abs=0.5)


def test_while_it_brakes_the_robot_is_taken_to_stand():
    estimator, history = AcceleratedEstimator(delay=0.05), CommandHistory()
    history.add(0.0, 1.0, 0.0)
    for k in range(1, 11):
        t = k / 30
        way = 10.0 * 0.5 * max(0.0, t - 0.05) ** 2
        seen = Sighting(t, GoalPose(way, 0.0, 0.0), a=10.0, beta=1.0)
        moving = estimator.update(seen, history, now=t + 0.07).moving
    assert moving.v == pytest.approx(t + 0.07, abs=0.02)  # then, as it will be
    history.add(t, math.nan, math.nan)
    later = seen._replace(t=t + 0.1)
    found = estimator.update(later, history, now=t + 0.17)
    assert found.moving.v == 0.0
    assert found.ahead == pytest.approx(found.pose)


# ------------------------------------------------------------------------------- safety


@pytest.fixture
def driving():
    """A parker that drives, and what shows it pictures."""
    parker, k = AcceleratedParker(goal(), LIMITS), 0

    def see(image, frames: int = 1):
        nonlocal k
        for _ in range(frames):
            k += 1
            now = k / RATE
            lost = isinstance(image, Missing)
            reading = image if lost else Frame(image, t=now - 0.066, number=k)
            answer = parker.step(reading, now)
        return answer

    answer = see(picture((150, 150)), 8)
    assert answer.phase is Phase.DRIVING
    assert answer.accelerations not in {None, (0.0, 0.0)}
    return see


@pytest.mark.parametrize("what", [BLANK, Missing.LATE])
def test_when_nothing_is_seen_it_is_not_accelerated_and_then_brakes(driving, what):
    assert driving(what).accelerations == (0.0, 0.0)
    answer = driving(what, 7)
    assert (answer.accelerations, answer.v, answer.omega) == (None, 0.0, 0.0)
    assert answer.phase is Phase.STOPPED


def test_a_robot_that_accelerates_and_is_not_seen_to_move_is_braked(driving):
    answers = [driving(noisy(seed)) for seed in range(45)]
    assert Alarm.STALLED in {answer.alarm for answer in answers}
    assert (answers[-1].accelerations, answers[-1].phase) == (None, Phase.STOPPED)


def test_it_goes_on_when_the_tag_is_back(driving):
    driving(BLANK, 20)
    answer = driving(picture((150, 150)), 12)
    assert answer.phase is Phase.DRIVING
    assert answer.accelerations is not None


# ------------------------------------------------------------------------------- whole runs


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The results of the command, made once, with unequal motors."""
    place = tmp_path_factory.mktemp("accelerated")
    world = place / "world.toml"
    world.write_text('[robot]\ncommanded_by = "torque"\nmotor_gains = [0.8, 1.25]\n')
    out = place / "run"
    options = ["--set", "hold=1.0", "--no-video", "--check", "--quiet"]
    assert main(["lab", "--world", str(world), "--out", str(out), *options]) == 0
    return out


def test_the_command_parks_a_robot_that_takes_accelerations(made):
    summary = json.loads((made / "summary.json").read_text())
    assert summary["outcome"] == "parked"
    assert summary["frames"]["out_of_view"] == 0
    assert summary["image_error"]["distance_px"] <= 1.0
    assert summary["image_error"]["heading_deg"] <= 1.0


def test_the_inputs_of_the_law_are_kept(made):
    summary = json.loads((made / "summary.json").read_text())
    assert min(summary["peak_tau"]) > 0.0
    inputs = read_trajectory(made / "trajectory.parquet")
    assert np.all(np.isfinite(inputs["tau1"]))


def test_a_replay_gives_the_same_accelerations(made):
    found = replayed(made / "run.mcap")
    assert found.same
    assert found.commands > 100


def test_other_tools_find_the_accelerations_in_the_recording(made):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with (made / "run.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        messages = reader.iter_decoded_messages(topics=["/robot/cmd_accel"])
        found = [decoded.accel.linear.x for *_, decoded in messages]
    assert len(found) > 50
    assert max(found) == 1.0  # the run-up


def test_a_replay_that_keeps_more_room_gives_other_accelerations(made, monkeypatch):
    monkeypatch.setattr("parkproof.lab.accelerated_pilot.HEADROOM", 0.3)
    assert not replayed(made / "run.mcap").same


def test_speeds_and_accelerations_stay_within_the_limits_of_a_weaker_robot():
    weak = msgspec.structs.replace(
        UNEQUAL, speed=0.15, turn_rate=1.0, acceleration=0.5, turn_acceleration=5.0
    )
    with World(WorldSettings(robot=weak)) as world:
        told = []
        judged = run_simulated(
            world,
            shown_goal(world),
            settings=LabSettings(hold=1.0),
            watch=lambda _, answer: told.append(answer.accelerations),
        )
        truths = world.history
    assert judged.run.outcome is LabOutcome.PARKED
    assert max(abs(truth.v) for truth in truths) <= 0.15
    assert max(abs(truth.omega) for truth in truths) <= 1.0
    assert max(abs(each[0]) for each in told if each) <= 0.5
    assert max(abs(each[1]) for each in told if each) <= 5.0


def test_late_and_dropped_frames_and_pushes_do_not_keep_it_from_parking():
    world = random_world(2, hard=True)
    robot = msgspec.structs.replace(world.robot, commanded_by="torque")
    with World(msgspec.structs.replace(world, robot=robot)) as there:
        judged = run_simulated(there, shown_goal(there), settings=LabSettings(hold=1.0))
    assert judged.run.outcome is LabOutcome.PARKED
    assert judged.run.frames.dropped > 0
    assert judged.image_error.distance <= 1.0
    assert judged.image_error.heading_deg <= 1.0


def test_an_interrupted_run_leaves_the_robot_braked():
    with World(WorldSettings(robot=TORQUE)) as world:
        there = shown_goal(world)

        def watch(_reading, answer) -> None:
            if answer.t > 1.5:
                raise KeyboardInterrupt

        found = run_lab(world.camera, world.robot, world.clock, there, watch=watch, realtime=False)
        assert found.outcome is LabOutcome.INTERRUPTED
        assert world.truth().v > 0.05  # it was driving
        world.advance(0.2)
        assert world.truth()[4:6] == pytest.approx((0.0, 0.0), abs=1e-3)
