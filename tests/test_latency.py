"""The delay from command to image, from synthetic data and from a robot that is turned for it."""

import json
import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
import pytest

from parkproof.cli import main
from parkproof.errors import InputError
from parkproof.lab.devices import RobotLimits, RobotSilentError
from parkproof.lab.latency import DelayOutcome, fit_delay
from parkproof.lab.measure_latency import Seen, measure_latency
from parkproof.lab.robot_simulator import UdpRobotSimulator

LIMITS = RobotLimits(speed=0.3, turn_rate=1.5, acceleration=1.0, turn_acceleration=6.0)
STEP = 5e-4


@dataclass
class Turntable:
    """A robot on the spot under a camera, in simulated time: it is robot, clock and camera."""

    delay: float = 0.1
    lag: float = 0.0
    gain: float = -0.9
    noise: float = 0.001
    dead_band: float = 0.0
    uneven: float = 0.0  # share by which left turns are faster, and right turns slower
    curve: float = 0.0  # how β varies with the heading
    jitter: float = 0.0
    rate: float = 30.0
    moves: bool = True
    answers: bool = True
    seen_until: float = math.inf
    ends: float = math.inf
    limits: RobotLimits = LIMITS
    t: float = 0.0
    told: list[float] = field(default_factory=list)
    angles: list[float] = field(default_factory=list)
    stopped: bool = False

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(5)
        self.under_way = deque([0.0] * round(self.delay / STEP))
        self.omega = self.lagged = self.angle = 0.0

    def now(self) -> float:
        return self.t

    def send(self, v: float, omega: float) -> None:
        if not self.answers and self.t > 3.0:
            raise RobotSilentError("udp://robot: the robot has not answered for 0.5 s")
        assert v == 0.0
        self.omega, self.stopped = omega, False
        self.told.append(omega)

    def stop(self) -> None:
        self.omega, self.stopped = 0.0, True

    def close(self) -> None:
        self.stop()

    def advance(self) -> None:
        self.under_way.append(self.omega)
        omega = self.under_way.popleft()
        omega = math.copysign(max(abs(omega) - self.dead_band, 0.0), omega)
        omega *= 1.0 + math.copysign(self.uneven, omega)
        share = 1.0 - math.exp(-STEP / self.lag) if self.lag else 1.0
        self.lagged += share * (omega - self.lagged)
        self.angle += self.lagged * STEP * self.moves
        self.angles.append(self.angle)
        self.t += STEP

    def seen(self) -> Iterator[Seen | None]:
        """Frames, and in between for every 10 ms without one that there is none."""
        next_frame = 1.0 / self.rate
        while self.t < self.ends:
            end = min(self.t + 0.01, next_frame)
            while self.t < end:
                self.advance()
            if end < next_frame:
                yield None
                continue
            psi = self.gain * self.angle + self.curve * self.angle**2
            psi += self.noise * float(self.random.standard_normal())
            t = self.t + self.jitter * float(self.random.uniform(-1.0, 1.0))
            visible = self.t < self.seen_until
            yield Seen(t, math.remainder(3.0 + psi, math.tau) if visible else None)
            next_frame += 1.0 / self.rate

    def measured(self, **settings: float):
        return measure_latency(self, self.seen(), clock=self, **settings)


# ------------------------------------------------------------------------------- what is found


@pytest.mark.parametrize(
    "settings",
    [
        {"delay": 0.03},
        {"delay": 0.066, "gain": -0.7},
        {"delay": 0.2, "gain": 1.3, "noise": 0.002},
        {"delay": 0.1, "lag": 0.05},
        {"delay": 0.066, "lag": 0.1, "noise": 0.002},
        {"delay": 0.15, "dead_band": 0.1, "gain": -1.3},
        {"delay": 0.08, "uneven": 0.15},
        {"delay": 0.08, "curve": 0.3, "jitter": 0.004},
        {"delay": 0.12, "lag": 0.06, "dead_band": 0.05, "uneven": 0.1, "curve": 0.2},
    ],
    ids=str,
)
def test_delay_and_lag_are_found_to_5_ms(settings):
    table = Turntable(**settings)
    fit = table.measured().fit
    assert fit.outcome is DelayOutcome.MEASURED
    assert fit.delay == pytest.approx(table.delay, abs=0.005)
    assert fit.total == pytest.approx(table.delay + table.lag, abs=0.003)
    assert fit.total_error < 0.005
    if not table.dead_band:
        assert fit.gain == pytest.approx(table.gain, rel=0.05)


def test_errors_are_as_large_as_they_are_said_to_be():
    inside = 0
    for seed in range(10):
        table = Turntable(delay=0.02 + 0.01 * seed, noise=0.004, lag=0.05 * (seed % 3))
        fit = table.measured(duration=8.0, seed=seed).fit
        inside += abs(fit.total - table.delay - table.lag) <= fit.total_error
    assert inside >= 8


def test_the_same_seed_gives_the_same_commands():
    first, second, other = (Turntable().measured(duration=3.0, seed=s).commands for s in (1, 1, 2))
    assert first == second
    assert first != other


def test_commands_in_step_with_frames_will_do_too():
    t = np.arange(600) / 30.0
    random = np.random.default_rng(3)
    omega = np.repeat(random.choice([-0.6, 0.0, 0.6], 100), 6)
    turned = np.concatenate(([0.0], np.cumsum(omega[:-1]) / 30.0))
    psi = np.interp(t - 0.0712, t, turned, left=0.0) + 0.001 * random.standard_normal(t.size)
    fit = fit_delay(t, omega, t, psi)
    assert fit.measured
    assert fit.delay == pytest.approx(0.0712, abs=0.005)


def test_tags_seen_in_the_wrong_place_do_not_matter():
    table = Turntable(delay=0.08)
    done = table.measured()
    t, omega = zip(*done.commands, strict=True)
    s, psi = map(np.array, zip(*done.seen, strict=True))
    psi[::50] += 0.4
    assert fit_delay(t, omega, s, psi).delay == pytest.approx(0.08, abs=0.005)


# ------------------------------------------------------------------------------- how it is found


def test_the_robot_stays_near_where_it_began_and_within_its_limits():
    for uneven in (0.0, 0.2):
        table = Turntable(uneven=uneven, delay=0.15)
        assert table.measured(angle=0.3).fit.measured
        assert np.max(np.abs(table.angles)) < 0.6
        assert max(map(abs, table.told)) <= 0.5 * LIMITS.turn_rate + 1e-9
        assert np.max(np.abs(np.diff(table.told))) <= LIMITS.turn_acceleration * 0.04
        assert table.stopped


def test_a_dead_band_that_is_known_is_kept_out_of():
    limits = RobotLimits(
        speed=0.3, turn_rate=1.0, acceleration=1.0, turn_acceleration=20.0, least_turn_rate=0.45
    )
    table = Turntable(limits=limits)
    table.measured(duration=5.0)
    assert max(map(abs, table.told)) == pytest.approx(0.9)


# ------------------------------------------------------------------------------- what cannot be


def test_without_the_tag_the_robot_is_not_moved():
    table = Turntable(seen_until=0.0)
    done = table.measured()
    assert done.fit.outcome is DelayOutcome.NOT_SEEN
    assert (done.commands, table.told) == ([], [])
    assert table.t < 1.5
    assert done.frames > 20


def test_a_tag_that_is_lost_stops_the_robot():
    table = Turntable(seen_until=4.0)
    assert table.measured().fit.outcome is DelayOutcome.NOT_SEEN
    assert table.stopped
    assert table.t < 5.5


def test_a_robot_that_does_not_move_is_noticed():
    table = Turntable(moves=False)
    assert table.measured().fit.outcome is DelayOutcome.NOT_MOVING
    assert table.stopped


def test_a_robot_that_is_moved_by_something_else_is_noticed():
    random = np.random.default_rng(1)
    t = np.arange(0.0, 15.0, 1 / 30)
    omega = np.repeat(random.choice([-0.6, 0.6], t.size // 10 + 1), 10)[: t.size]
    psi = 0.3 * np.sin(1.3 * t) + 0.2 * np.sin(5.1 * t)
    assert fit_delay(t, omega, t, psi).outcome is DelayOutcome.UNCLEAR


def test_a_delay_beyond_the_search_is_not_given_as_one():
    table = Turntable(delay=0.3)
    done = table.measured()
    t, omega = zip(*done.commands, strict=True)
    s, psi = zip(*done.seen, strict=True)
    fit = fit_delay(t, omega, s, psi, longest_delay=0.1, longest_lag=0.05)
    assert fit.outcome is DelayOutcome.UNCLEAR


def test_a_robot_that_does_not_answer_is_stopped_and_named():
    table = Turntable(answers=False)
    done = table.measured()
    assert done.fit.outcome is DelayOutcome.SILENT
    assert done.detail == "udp://robot: the robot has not answered for 0.5 s"
    assert table.stopped


def test_a_camera_that_ends_early_is_said_or_does_not_matter():
    table = Turntable(ends=1.0)
    assert table.measured().fit.outcome is DelayOutcome.ENDED
    assert table.stopped
    assert Turntable(ends=15.0).measured().fit.measured


def test_a_robot_at_rest_tells_nothing():
    t = np.arange(0.0, 10.0, 1 / 30)
    assert fit_delay(t, 0.0 * t, t, t).outcome is DelayOutcome.NOT_TOLD
    assert fit_delay([], [], t, t).outcome is DelayOutcome.NOT_TOLD
    assert fit_delay(t, t, [], []).outcome is DelayOutcome.NOT_SEEN


T = [0.0, 1.0, 2.0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((T, T, T, [0.0]), r"pose_times and headings have shapes \(3,\) and \(1,\)"),
        (([T], [T], T, T), "command_times and commands have shapes"),
        ((T, [0.0, math.nan, 0.0], T, T), "command_times and commands must be finite"),
        ((T, T, [0.0, 2.0, 1.0], T), r"pose_times\[2\] = 1 follows 2: times must increase"),
        (([0.0, 0.0, 1.0], T, T, T), r"command_times\[1\] = 0 follows 0"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        fit_delay(*arguments)


@pytest.mark.parametrize("settings", [{"duration": 0.0}, {"angle": -1.0}, {"angle": math.nan}])
def test_settings_that_are_none_are_refused(settings):
    with pytest.raises(InputError, match="must be"):
        Turntable().measured(**settings)


# ------------------------------------------------------------------------------- the command


@pytest.fixture
def room(tmp_path) -> str:
    """Footage of a room without a robot."""
    for k in range(5):
        cv2.imwrite(str(tmp_path / f"{k}.png"), np.full((48, 64), 90, np.uint8))
    return str(tmp_path)


def test_the_command_says_what_a_camera_gives(room, capsys):
    assert main(["camera", "--source", room]) == 0
    printed = capsys.readouterr().out
    for text in ("64×48", "30.00"):
        assert text in printed
    assert main(["camera", "--source", room, "--json"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    assert (numbers["frames"], numbers["with_tag"], numbers["left_out"]) == (5, 0, 0)


def test_the_command_does_not_move_a_robot_that_the_camera_does_not_see(room, capsys):
    with UdpRobotSimulator() as simulator:
        arguments = ["--latency", "--source", room, "--robot", simulator.address, "--json"]
        assert main(["camera", *arguments]) == 1
        numbers = json.loads(capsys.readouterr().out)
        assert numbers["outcome"] == "ended"
        assert numbers["delay"] is None
        assert all((command.v, command.omega) == (0.0, 0.0) for command in simulator.received)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--latency", "--source", "0"], "--latency needs --source SOURCE and --robot ADDRESS"),
        (["--latency", "--robot", "udp://127.0.0.1:9"], "--latency needs --source SOURCE"),
        (["--source", "0", "--world", "world.toml"], "exclude each other"),
        (["--source", "0", "--robot", "udp://127.0.0.1:9"], "--robot is for --latency"),
        (["--source", "nowhere.mp4"], "source = nowhere.mp4: there is no such camera"),
        (["--latency", "--duration", "0"], "duration = 0.0: must be greater than 0"),
        (["--latency", "--angle-deg", "nan"], "angle_deg = nan: must be a finite number"),
    ],
)
def test_what_the_command_cannot_do_is_said_in_one_line(arguments, message, capsys):
    assert main(["camera", *arguments]) == 2
    errors = capsys.readouterr().err
    assert message in errors
    assert errors.count("\n") == 1


def test_the_command_says_when_the_robot_is_not_there(room, capsys):
    with UdpRobotSimulator() as simulator:
        address = simulator.address
    assert main(["camera", "--latency", "--source", room, "--robot", address]) == 2
    assert "has not answered for 0.5 s" in capsys.readouterr().err


def test_the_simulated_laboratory_is_measured_by_default(capsys):
    assert main(["camera", "--latency", "--json", "--duration", "6"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["outcome"] == "measured"
    assert numbers["age_of_frames"] == pytest.approx(0.066, abs=0.002)
    assert 0.0 < numbers["delay_and_lag"] < 0.1
    assert numbers["delay_and_lag_error"] < 0.005
    assert numbers["gain"] < 0.0  # seen from above
