"""Robots over UDP and over wheels, with real sockets on loopback."""

import contextlib
import math
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import pytest

from parkproof.errors import InputError
from parkproof.lab.devices import Robot, RobotLimits, RobotSilentError
from parkproof.lab.robot_simulator import SMALL_ROBOT, UdpRobotSimulator
from parkproof.lab.robots import GENTLE, WheelBase, WheelRobot, open_robot
from parkproof.lab.udp_link import UdpLink


@pytest.fixture
def simulator() -> Iterator[UdpRobotSimulator]:
    with UdpRobotSimulator(dead_man=60.0) as there:
        yield there


@pytest.fixture
def opened() -> Iterator[Callable[..., Robot]]:
    """`open_robot`, closed again after the test."""
    with contextlib.ExitStack() as stack:

        def opening(*address: str, **settings: Any) -> Robot:
            robot = open_robot(*address, **settings)
            stack.callback(robot.close)
            return robot

        yield opening


@pytest.fixture
def careful() -> Iterator[UdpRobotSimulator]:
    """One that soon stops by itself."""
    with UdpRobotSimulator(dead_man=0.1) as there:
        yield there


def wait_until(condition, timeout=30.0):
    end = time.monotonic() + timeout
    while not condition() and time.monotonic() < end:
        time.sleep(0.005)
    assert condition()


def datagrams(simulator: UdpRobotSimulator):
    """A bare socket to the robot: what a lab's own program would send."""
    there = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    there.connect(("127.0.0.1", simulator.port))
    there.settimeout(30.0)
    return there


# ------------------------------------------------------------------------------- over UDP


def test_commands_arrive_as_they_were_sent(simulator, opened):
    robot = opened(simulator.address)
    robot.send(0.2, -0.7)
    wait_until(lambda: simulator.velocity == (0.2, -0.7))
    robot.close()
    wait_until(lambda: simulator.velocity == (0.0, 0.0))
    assert simulator.dead_man_stops == 0


def test_the_simulated_robot_drives_the_arc_that_was_commanded(simulator, opened):
    robot = opened(simulator.address)
    robot.send(0.3, 1.0)
    time.sleep(0.05)
    robot.send(0.3, 1.0)
    time.sleep(0.05)
    robot.close()
    wait_until(lambda: simulator.velocity == (0.0, 0.0))
    x, y, theta = simulator.pose
    assert theta >= 0.1
    assert x == pytest.approx(0.3 * math.sin(theta), abs=1e-12)
    assert y == pytest.approx(0.3 * (1.0 - math.cos(theta)), abs=1e-12)


def test_wheel_speeds_reach_a_robot_that_takes_them(simulator, opened):
    robot = opened(simulator.address, wheels=SMALL_ROBOT)
    robot.send(0.2, 0.5)
    wait_until(lambda: simulator.velocity != (0.0, 0.0))
    assert simulator.velocity == pytest.approx((0.2, 0.5))
    robot.close()
    wait_until(lambda: simulator.velocity == (0.0, 0.0))


def test_the_robot_stops_by_itself_when_no_command_comes(careful, opened):
    robot = opened(careful.address)
    robot.send(0.3, 0.0)
    wait_until(lambda: careful.dead_man_stops == 1)
    assert careful.velocity == (0.0, 0.0)
    assert careful.pose[0] == pytest.approx(0.3 * 0.1, abs=1e-9)


def test_a_robot_that_falls_silent_is_reported_and_told_to_stand_still(simulator, opened):
    robot = opened(simulator.address, silence=0.1)
    simulator.answers = False

    def drive():
        while True:
            robot.send(0.1, 0.0)
            time.sleep(0.01)

    with pytest.raises(RobotSilentError, match=r"udp://127.*has not answered for 0\.1 s"):
        drive()
    wait_until(lambda: simulator.velocity == (0.0, 0.0))
    assert simulator.dead_man_stops == 0


def test_a_robot_that_is_back_is_driven_on(simulator, opened):
    robot = opened(simulator.address, silence=0.05)
    simulator.answers = False
    for _ in range(3):
        robot.send(0.1, 0.0)
        time.sleep(0.02)
    with pytest.raises(RobotSilentError):
        robot.send(0.1, 0.0)
    simulator.answers = True
    robot.stop()
    time.sleep(0.05)
    robot.send(0.2, 0.0)
    wait_until(lambda: simulator.velocity == (0.2, 0.0))


def test_lost_datagrams_are_no_silence(opened):
    with UdpRobotSimulator(loss=0.3, seed=3) as simulator:
        robot = opened(simulator.address)
        for k in range(60):
            robot.send(0.1, 0.001 * k)
            time.sleep(0.002)
        robot.close()
        wait_until(lambda: simulator.velocity == (0.0, 0.0))
        assert 20 < len(simulator.received) < 64


def test_one_lost_datagram_before_a_long_pause_is_no_silence(simulator, opened):
    robot = opened(simulator.address, silence=0.05)
    simulator.answers = False
    robot.send(0.1, 0.0)
    time.sleep(0.1)
    simulator.answers = True
    robot.send(0.2, 0.0)
    wait_until(lambda: simulator.velocity == (0.2, 0.0))
    robot.send(0.1, 0.0)


@pytest.mark.parametrize("asked", [(math.nan, 0.1), (0.1, math.inf)])
def test_what_is_no_number_is_sent_as_standing_still(simulator, asked, opened):
    robot = opened(simulator.address)
    robot.send(0.1, 0.1)
    wait_until(lambda: simulator.velocity == (0.1, 0.1))
    robot.send(*asked)
    wait_until(lambda: simulator.velocity == (0.0, 0.0))
    assert simulator.dead_man_stops == 0


def test_stopping_never_raises_even_when_nothing_is_there(simulator, opened):
    robot = opened(simulator.address)
    simulator.close()
    for _ in range(3):
        robot.stop()
    robot.close()
    robot.stop()
    robot.close()


# ------------------------------------------------------------------------------- the protocol


def test_a_command_that_was_overtaken_is_ignored(simulator):
    there = datagrams(simulator)
    there.send(b'{"v": 0.0, "omega": 0.0, "seq": 8}')
    assert there.recv(100) == b'{"ack":8}'
    there.send(b'{"v": 0.3, "omega": 0.0, "seq": 7}')
    there.send(b'{"v": 0.1, "omega": 0.0, "seq": 9}')
    assert there.recv(100) == b'{"ack":9}'
    assert [received.v for received in simulator.received] == [0.0, 0.1]
    there.close()


def test_after_a_pause_another_program_may_count_from_one(careful):
    there = datagrams(careful)
    there.send(b'{"v": 0.1, "omega": 0.0, "seq": 1000}')
    there.recv(100)
    wait_until(lambda: careful.dead_man_stops == 1)
    there.send(b'{"v": 0.2, "omega": 0.0, "seq": 1}')
    assert there.recv(100) == b'{"ack":1}'
    there.close()


@pytest.mark.parametrize(
    "junk",
    [
        b"", b"\xff\xfe", b"[]", b"{}", b'{"seq": 1}', b'{"v": 1, "seq": 1}',
        b'{"v": "fast", "omega": 0, "seq": 1}', b'{"v": 1e999, "omega": 0, "seq": 1}',
        b'{"v": 1, "omega": null, "seq": 1}', b'{"v": 1, "omega": 0}',
    ],
)  # fmt: skip
def test_what_is_no_command_is_neither_carried_out_nor_acknowledged(simulator, junk):
    there = datagrams(simulator)
    there.send(junk)
    there.send(b'{"left": 0, "right": 0, "seq": 2}')
    assert there.recv(100) == b'{"ack":2}'
    assert len(simulator.received) == 1
    there.close()


def test_answers_that_make_no_sense_do_not_count():
    robot = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    robot.bind(("127.0.0.1", 0))
    robot.settimeout(30.0)
    link = UdpLink("127.0.0.1", robot.getsockname()[1], rest={"v": 0.0}, silence=0.05)
    link.send({"v": 1.0})
    data, sender = robot.recvfrom(1000)
    assert msgspec.json.decode(data) == {"v": 1.0, "seq": 1}
    for answer in (b"", b"ack", b'{"ack": 99}', b'{"ack": -1}', b'{"ack": "1"}'):
        robot.sendto(answer, sender)
    link.send({"v": 1.0})
    time.sleep(0.06)
    with pytest.raises(RobotSilentError):
        link.send({"v": 1.0})
    robot.close()
    link.close()


# ------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    "address",
    ["", "robot", "udp://", "udp://robot", "udp://:5005", "udp://robot:0", "udp://robot:70000",
     "udp://robot:port", "tcp://robot:5005", "udp://[::1:5005"],
)  # fmt: skip
def test_an_address_that_is_none_says_how_to_write_one(address):
    with pytest.raises(InputError, match=r"robot = .*udp://host:port.*write for example"):
        open_robot(address)


def test_nothing_that_answers_is_said_when_it_is_opened():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as deaf:
        deaf.bind(("127.0.0.1", 0))
        address = f"udp://127.0.0.1:{deaf.getsockname()[1]}"
        with pytest.raises(InputError, match=r"has not answered for 0\.05 s.*switch the robot on"):
            open_robot(address, silence=0.05)


def test_a_port_where_nothing_listens_is_said_with_its_cause():
    with UdpRobotSimulator() as simulator:
        address = simulator.address
    with pytest.raises(InputError, match=r"has not answered.*refused"):
        open_robot(address, silence=0.05)


def test_a_silence_of_no_time_is_refused():
    with pytest.raises(InputError, match="silence = 0"):
        open_robot("udp://127.0.0.1:9", silence=0.0)


def test_a_port_in_use_is_refused(simulator):
    with pytest.raises(InputError, match=f"port = {simulator.port}: cannot listen"):
        UdpRobotSimulator(simulator.port)


@pytest.mark.parametrize("numbers", [(0.0, 0.1), (0.1, -1.0), (math.nan, 0.1)])
def test_wheels_without_size_are_refused(numbers):
    with pytest.raises(InputError, match=r"wheel_radius|half_track"):
        WheelBase(wheel_radius=numbers[0], half_track=numbers[1])


# ------------------------------------------------------------------------------- over wheels


def test_a_wheel_robot_sends_what_gives_the_asked_velocity():
    sent = []
    base = WheelBase(wheel_radius=0.5, half_track=0.25)
    limits = RobotLimits(speed=2.0, turn_rate=3.0, acceleration=1.0, turn_acceleration=1.0)
    robot = WheelRobot(lambda left, right: sent.append((left, right)), wheels=base, limits=limits)
    robot.send(1.0, 2.0)
    robot.close()
    assert sent == [(1.0, 3.0), (0.0, 0.0)]
    assert robot.limits is limits


@pytest.mark.parametrize("error", [OSError("unplugged"), RobotSilentError("no answer")])
def test_stopping_a_wheel_robot_does_not_raise(error):
    def broken(*_: float) -> None:
        raise error

    robot = WheelRobot(broken, wheels=WheelBase(wheel_radius=0.1, half_track=0.1), limits=GENTLE)
    robot.stop()
    with pytest.raises(type(error)):
        robot.send(0.1, 0.0)


# ------------------------------------------------------------------------------- as a program


def test_the_simulator_runs_as_a_program_and_says_where_it_listens(opened):
    # As with -m, but Ctrl-C works even if whoever runs the tests ignores it.
    code = (
        "import runpy, signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "runpy.run_module('parkproof.lab.robot_simulator', run_name='__main__')"
    )
    command = [sys.executable, "-c", code, "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        try:
            assert program.stdout is not None
            address = program.stdout.readline().strip()
            robot = opened(address, silence=20.0)
            robot.send(0.2, 0.0)
            assert program.stdout.readline().startswith("v = +0.200 m/s")
            robot.close()
            program.send_signal(signal.SIGINT)
            assert program.wait(30.0) == 0
        finally:
            program.kill()


def test_the_simulator_as_a_program_refuses_a_bad_port_in_one_line():
    command = [sys.executable, "-m", "parkproof.lab.robot_simulator", "--port", "99999"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 2
    assert "port = 99999: cannot listen" in done.stderr
    assert "Traceback" not in done.stderr
