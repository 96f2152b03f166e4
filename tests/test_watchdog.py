"""Limits kept whatever is asked, and a robot that is stopped whatever becomes of the program."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.errors import InputError
from parkproof.lab.devices import RobotLimits, RobotSilentError, WallClock
from parkproof.lab.limits import limited
from parkproof.lab.robot_simulator import DEAD_MAN, UdpRobotSimulator
from parkproof.lab.watchdog import StoppingRobot

LIMITS = RobotLimits(speed=0.5, turn_rate=2.0, acceleration=1.0, turn_acceleration=8.0)

any_number = st.floats(allow_nan=True, allow_infinity=True)
some_speed = st.floats(-3.0, 3.0)
limit = st.floats(1e-3, 1e3)
some_limits = st.builds(
    RobotLimits, speed=limit, turn_rate=limit, acceleration=limit, turn_acceleration=limit
)


# ------------------------------------------------------------------------------- limits


@given(any_number, any_number, any_number, any_number, any_number, some_limits)
def test_no_limit_of_speed_is_ever_exceeded(v, omega, before_v, before_omega, dt, limits):
    sent_v, sent_omega = limited(v, omega, before_v, before_omega, dt, limits)
    assert abs(sent_v) <= limits.speed
    assert abs(sent_omega) <= limits.turn_rate


@given(any_number, any_number, st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 10), some_limits)
def test_no_limit_of_acceleration_is_ever_exceeded(v, omega, share_v, share_omega, dt, limits):
    before_v, before_omega = share_v * limits.speed, share_omega * limits.turn_rate
    sent_v, sent_omega = limited(v, omega, before_v, before_omega, dt, limits)
    dt = max(dt, 0.0)
    assert abs(sent_v - before_v) <= limits.acceleration * dt + 1e-12 * limits.speed
    assert abs(sent_omega - before_omega) <= limits.turn_acceleration * dt + (
        1e-12 * limits.turn_rate
    )


@given(some_speed, some_speed, some_limits)
def test_too_fast_a_command_keeps_its_curvature(v, omega, limits):
    sent_v, sent_omega = limited(v, omega, 0.0, 0.0, 1e9, limits)
    assert sent_v * omega == pytest.approx(sent_omega * v, rel=1e-9, abs=1e-12)
    assert sent_v * v >= 0.0
    assert sent_omega * omega >= 0.0
    reached = max(abs(sent_v) / limits.speed, abs(sent_omega) / limits.turn_rate)
    assert (sent_v, sent_omega) == (v, omega) or reached == pytest.approx(1.0)


@given(some_speed, some_speed, st.floats(0.0, 1.0))
def test_starting_and_stopping_keep_the_curvature(v, omega, dt):
    started_v, started_omega = limited(v, omega, 0.0, 0.0, dt, LIMITS)
    assert started_v * omega == pytest.approx(started_omega * v, rel=1e-9, abs=1e-12)
    stopped_v, stopped_omega = limited(0.0, 0.0, started_v, started_omega, dt / 2, LIMITS)
    assert stopped_v * omega == pytest.approx(stopped_omega * v, rel=1e-9, abs=1e-9)


@given(some_speed, some_speed, some_speed, some_speed)
def test_a_command_that_may_be_sent_is_reached_as_soon_as_the_limits_allow(
    v, omega, before_v, before_omega
):
    wanted = limited(v, omega, 0.0, 0.0, 1e9, LIMITS)
    sent = limited(before_v, before_omega, 0.0, 0.0, 1e9, LIMITS)
    least = max(abs(wanted[0] - sent[0]) / 1.0, abs(wanted[1] - sent[1]) / 8.0)
    for _ in range(math.ceil(least / 0.05)):
        sent = limited(v, omega, *sent, 0.0501, LIMITS)
    assert sent == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize("asked", [(math.nan, 0.1), (0.1, math.nan), (math.inf, 0.1)])
def test_what_is_no_number_slows_the_robot_down_to_rest(asked):
    sent = (0.4, 1.0)
    for _ in range(50):
        sent = limited(*asked, *sent, 0.05, LIMITS)
    assert sent == (0.0, 0.0)


# ------------------------------------------------------------------------------- in one process


class Script:
    """A robot that notes what it is told, and fails when it is made to."""

    def __init__(self) -> None:
        self.told: list[tuple[float, float] | str] = []
        self.error: BaseException | None = None
        self.hangs = threading.Event()
        self.goes_on = threading.Event()

    limits = LIMITS

    def send(self, v: float, omega: float) -> None:
        if self.error is not None:
            raise self.error
        if self.hangs.is_set():
            self.goes_on.wait(5.0)
        self.told.append((v, omega))

    def stop(self) -> None:
        self.told.append("stop")

    def close(self) -> None:
        self.told.append("close")


class Hands:
    """A clock that is set by hand."""

    t = 10.0

    def now(self) -> float:
        return self.t


@pytest.fixture
def script() -> Iterator[Script]:
    robot = Script()
    yield robot
    robot.goes_on.set()


def wait_until(condition, timeout=30.0):
    end = time.monotonic() + timeout
    while not condition() and time.monotonic() < end:
        time.sleep(0.005)
    assert condition()


def test_speed_changes_by_no_more_than_the_limits_allow(script):
    clock = Hands()
    with StoppingRobot(script, clock=clock, timeout=None) as robot:
        for _ in range(10):
            robot.send(9.0, 0.0)
            clock.t += 0.03
        assert script.told[0] == pytest.approx((0.1, 0.0))  # as within the longest step
        assert script.told[4] == pytest.approx((0.1 + 4 * 0.03, 0.0))
        clock.t -= 5.0
        sent = robot.sent
        robot.send(0.0, 0.0)
        assert robot.sent == sent  # a clock that jumps back allows no change
        clock.t += 500.0
        robot.send(0.0, 0.0)
        assert robot.sent[0] == pytest.approx(sent[0] - 0.1)


def test_the_robot_is_stopped_when_no_command_comes(script):
    with StoppingRobot(script, clock=WallClock(), timeout=0.05) as robot:
        robot.send(0.4, 0.0)
        wait_until(lambda: robot.late_stops == 1)
        assert script.told[-1] == "stop"
        assert robot.sent == (0.0, 0.0)
        robot.send(0.4, 0.0)  # and goes on, from rest
        assert 0.0 < script.told[-1][0] <= 0.1
        wait_until(lambda: robot.late_stops == 2)


def test_a_robot_that_is_driven_or_at_rest_is_not_stopped(script):
    with StoppingRobot(script, clock=WallClock(), timeout=1.0) as robot:
        for _ in range(10):
            robot.send(0.4, 0.0)
            time.sleep(0.005)
    moving = len(script.told)
    assert script.told.count("stop") == 1  # at the end of the block
    with StoppingRobot(script, clock=WallClock(), timeout=0.02) as robot:
        robot.send(0.0, 0.0)
        time.sleep(0.1)
        assert "stop" not in script.told[moving:]


def test_a_robot_whose_command_hangs_is_stopped_all_the_same(script):
    script.hangs.set()
    with StoppingRobot(script, clock=WallClock(), timeout=0.05) as robot:
        driver = threading.Thread(target=robot.send, args=(0.4, 0.0))
        driver.start()
        wait_until(lambda: script.told == ["stop"])
        script.goes_on.set()
        driver.join()
        assert script.told[-2:] == [(pytest.approx(0.1), 0.0), "stop"]  # not left driving
        assert robot.sent == (0.0, 0.0)
        script.goes_on.clear()
        told, late = len(script.told), robot.late_stops
        driver = threading.Thread(target=robot.send, args=(0.4, 0.0))
        driver.start()
        wait_until(lambda: "stop" in script.told[told:])  # the next one that hangs as well
        script.goes_on.set()
        driver.join()
        assert robot.late_stops > late


def test_in_simulated_time_no_thread_interferes(script):
    with StoppingRobot(script, clock=Hands(), timeout=None) as robot:
        before = threading.active_count()
        robot.send(0.4, 0.0)
        assert threading.active_count() == before


def test_a_command_that_fails_stops_the_robot(script):
    with StoppingRobot(script, clock=WallClock()) as robot:
        script.error = RobotSilentError("no answer")
        with pytest.raises(RobotSilentError):
            robot.send(0.4, 0.0)
        assert script.told == ["stop"]
        assert robot.sent == (0.0, 0.0)


def test_leaving_the_block_stops_and_closes_and_gives_the_signals_back(script):
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    robot = StoppingRobot(script, clock=WallClock())
    with pytest.raises(ZeroDivisionError), robot:  # noqa: PT012
        assert signal.getsignal(signal.SIGTERM) not in before
        _ = 1 / 0
    assert script.told == ["stop", "close"]
    robot.close()
    assert script.told.count("close") == 1
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before
    robot.send(0.4, 0.0)
    assert script.told[-1] == "stop"


def test_a_robot_that_is_released_is_stopped_but_not_given_back(script):
    with StoppingRobot(script, clock=WallClock()) as robot:
        before = signal.getsignal(signal.SIGTERM)
        robot.send(0.4, 0.0)
        robot.release()
        assert script.told[-1] == "stop"
        assert signal.getsignal(signal.SIGTERM) is not before
    assert "close" not in script.told


def test_after_a_signal_the_robot_only_stands_still(script):
    heard = []
    before = signal.signal(signal.SIGTERM, lambda number, _: heard.append(number))
    try:
        with StoppingRobot(script, clock=WallClock()) as robot:
            robot.send(0.4, 0.0)
            signal.raise_signal(signal.SIGTERM)
            assert (heard, robot.stopped_by) == ([signal.SIGTERM], "SIGTERM")
            told = len(script.told)
            robot.send(0.4, 0.0)
            assert script.told[told:] == ["stop"]
    finally:
        signal.signal(signal.SIGTERM, before)


def test_a_signal_that_is_ignored_stays_ignored(script):
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with StoppingRobot(script, clock=WallClock()) as robot:
            signal.raise_signal(signal.SIGTERM)
            assert robot.stopped_by == ""
    finally:
        signal.signal(signal.SIGTERM, before)


def test_in_another_thread_signals_are_left_alone(script):
    before = signal.getsignal(signal.SIGINT)
    seen = []

    def drive() -> None:
        with StoppingRobot(script, clock=WallClock()):
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=drive)
    thread.start()
    thread.join()
    assert seen == [before]
    assert script.told == ["stop", "close"]


@pytest.mark.parametrize("changes", [{"timeout": 0.0}, {"timeout": math.nan}, {"longest_step": 0}])
def test_times_must_be_positive(script, changes):
    with pytest.raises(InputError, match="must be"):
        StoppingRobot(script, **({"clock": WallClock()} | changes))


# ------------------------------------------------------------------------------- real processes

DRIVER = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # whoever runs the tests may ignore them
signal.signal(signal.SIGTERM, signal.SIG_DFL)
for name in ("SIGHUP", "SIGQUIT", "SIGTSTP"):
    signal.signal(getattr(signal, name), signal.SIG_DFL)
from parkproof.lab.devices import WallClock
from parkproof.lab.robots import open_robot
from parkproof.lab.watchdog import StoppingRobot

address, end = sys.argv[1:]
robot = StoppingRobot(open_robot(address, silence=5.0), clock=WallClock(), timeout={timeout})

def drive():
    for k in range(10**6):
        robot.send(0.3, 0.5)
        if k == 40:
            print("driving", flush=True)
        if k == 50 and end == "exception":
            raise RuntimeError("a crash")
        if k == 50 and end == "exit":
            sys.exit(7)
        if k == 50 and end == "hang":
            time.sleep(1000.0)
        time.sleep(0.01)

if end == "no block":
    end = "exception"
    drive()
with robot:
    drive()
"""


def driven(
    end: str, number: int | None = None, timeout: str = "20.0", dead_man: float = 60.0
) -> tuple[UdpRobotSimulator, int | None, str]:
    """Let a process drive the simulator, end it, and give (simulator, exit status, errors).

    Unless told else, the robot would go on for a minute by itself.
    """
    with UdpRobotSimulator(dead_man=dead_man) as simulator:
        command = [sys.executable, "-c", DRIVER.format(timeout=timeout), simulator.address, end]
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as program:
            assert program.stdout is not None
            assert program.stderr is not None
            try:
                assert program.stdout.readline() == "driving\n", program.stderr.read()
                if number is not None:
                    wait_until(lambda: simulator.velocity == (0.3, 0.5))
                    program.send_signal(number)
                    status = program.wait(30.0)
                elif end == "hang":
                    wait_until(lambda: simulator.velocity == (0.0, 0.0))
                    status = None
                else:
                    status = program.wait(30.0)
            finally:
                program.kill()
            errors = program.stderr.read()
        wait_until(lambda: simulator.velocity == (0.0, 0.0))
        return simulator, status, errors


def stopped_by_command(simulator: UdpRobotSimulator) -> bool:
    """Whether the last command was to stand still, and the dead-man had nothing to do."""
    last = simulator.received[-1]
    return simulator.dead_man_stops == 0 and (last.v, last.omega) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("number", "status"),
    [
        (signal.SIGINT, -signal.SIGINT),
        (signal.SIGTERM, 143),
        (signal.SIGHUP, 129),
        (signal.SIGQUIT, 131),
    ],
    ids=["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"],
)
def test_a_signal_stops_the_robot(number, status):
    simulator, ended, errors = driven("never", number)
    assert stopped_by_command(simulator)
    assert ended == status
    assert ("KeyboardInterrupt" in errors) == (number == signal.SIGINT)


def test_a_program_that_is_suspended_stops_the_robot_first_and_may_go_on():
    with UdpRobotSimulator(dead_man=60.0) as simulator:
        command = [sys.executable, "-c", DRIVER.format(timeout="20.0"), simulator.address, "never"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
            assert program.stdout is not None
            try:
                assert program.stdout.readline() == "driving\n"
                wait_until(lambda: simulator.velocity == (0.3, 0.5))
                program.send_signal(signal.SIGTSTP)
                _, status = os.waitpid(program.pid, os.WUNTRACED)
                assert os.WIFSTOPPED(status)
                wait_until(lambda: simulator.velocity == (0.0, 0.0))
                assert stopped_by_command(simulator)
                program.send_signal(signal.SIGCONT)
                wait_until(lambda: simulator.velocity == (0.3, 0.5))
            finally:
                program.kill()


def test_what_stopped_the_robot_unasked_is_told_once_with_its_time(script):
    clock = Hands()
    with StoppingRobot(script, clock=clock, timeout=0.05) as robot:
        robot.send(0.4, 0.0)
        assert robot.take_halt() is None
        wait_until(lambda: robot.late_stops == 1)
        clock.t += 1.0
        assert robot.take_halt() == 10.0
        assert robot.take_halt() is None


@pytest.mark.parametrize(("end", "status"), [("exception", 1), ("exit", 7), ("no block", 1)])
def test_a_crash_or_an_end_stops_the_robot(end, status):
    simulator, ended, errors = driven(end)
    assert stopped_by_command(simulator)
    assert ended == status
    assert ("a crash" in errors) == (end != "exit")


def test_a_program_that_hangs_has_its_robot_stopped():
    simulator, _, _ = driven("hang", timeout="0.15")
    assert stopped_by_command(simulator)


def test_after_a_kill_the_robot_stops_by_itself_within_its_time():
    simulator, ended, _ = driven("never", signal.SIGKILL, dead_man=DEAD_MAN)
    assert ended == -signal.SIGKILL
    assert simulator.dead_man_stops == 1
    last = simulator.received[-1]
    assert (last.v, last.omega) == (0.3, 0.5)
    # The turn that it made since each command, the last one for the dead-man's time, and no more.
    told = list(simulator.received)
    times = [command.t for command in told] + [told[-1].t + DEAD_MAN]
    turn = sum(c.omega * (b - a) for c, a, b in zip(told, times, times[1:], strict=False))
    assert simulator.pose[2] == pytest.approx(turn, abs=1e-9)
