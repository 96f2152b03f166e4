"""A robot on loopback that speaks the UDP protocol: ``python -m parkproof.lab.robot_simulator``.

It moves as a unicycle does, exactly as commanded, and stops by itself when no command comes.
"""

import argparse
import contextlib
import math
import random
import socket
import threading
import time
from collections import deque
from collections.abc import Sequence
from types import TracebackType
from typing import NamedTuple, Self

import msgspec

from parkproof.errors import InputError
from parkproof.lab.robots import WheelBase
from parkproof.model.drive import body_from_wheels
from parkproof.validate import not_negative, positive

DEAD_MAN = 0.3
"""A robot stops by itself when no command came for this time, in s."""

LAST_PORT = 65535

SMALL_ROBOT = WheelBase(wheel_radius=0.03, half_track=0.08)
"""Wheels of the simulated robot, for those who command wheels."""


class Received(NamedTuple):
    """A command that the simulated robot has carried out.

    Parameters
    ----------
    t : float
        When it came, in s of the monotonic clock.
    v, omega : float
        What it asked for, in m/s and rad/s.

    Examples
    --------
    >>> Received(t=1.0, v=0.2, omega=0.0).v
    0.2
    """

    t: float
    v: float
    omega: float


class _Command(msgspec.Struct):
    """A datagram: v and omega, or left and right, and its number."""

    seq: int
    v: float | None = None
    omega: float | None = None
    left: float | None = None
    right: float | None = None


class UdpRobotSimulator:
    """A unicycle behind a UDP socket, in a thread.

    Parameters
    ----------
    port : int
        Where to listen; 0 for a free port.
    host : str
        The address to listen on; loopback unless told else.
    dead_man : float
        It stops by itself when no command came for this time, in s.
    wheels : WheelBase
        What "left" and "right" turn.
    loss : float
        Share of datagrams lost on the way to it, drawn at random.
    seed : int
        Of these draws.

    Raises
    ------
    InputError
        If the port cannot be used, or a number is none.

    Attributes
    ----------
    answers : bool
        Set to False, it carries out commands but acknowledges none.
    dead_man_stops : int
        How often it has stopped by itself.

    Examples
    --------
    >>> from parkproof.lab.robots import open_robot
    >>> with UdpRobotSimulator() as simulator:
    ...     robot = open_robot(simulator.address)
    ...     robot.send(0.2, 0.0)
    ...     robot.close()
    ...     (simulator.wait_for(5), simulator.received[0].v, simulator.velocity)
    (True, 0.0, (0.0, 0.0))
    """

    def __init__(
        self,
        port: int = 0,
        *,
        host: str = "127.0.0.1",
        dead_man: float = DEAD_MAN,
        wheels: WheelBase = SMALL_ROBOT,
        loss: float = 0.0,
        seed: int = 0,
    ) -> None:
        self.answers = True
        self.dead_man_stops = 0
        self.received: deque[Received] = deque(maxlen=100_000)
        self._dead_man = positive("dead_man", dead_man, example=DEAD_MAN)
        self._wheels = wheels
        self._loss = not_negative("loss", loss)
        self._random = random.Random(seed)
        self._change = threading.Condition()
        self._pose = (0.0, 0.0, 0.0)
        self._velocity = (0.0, 0.0)
        self._time = time.monotonic()
        self._heard = -math.inf
        self._number = 0
        self._closed = False
        if not 0 <= port <= LAST_PORT:  # a library would take it modulo 65536
            raise InputError(
                f"port = {port}: cannot listen there: ports end at {LAST_PORT}; write 0 for a "
                "free port"
            )
        try:
            family, kind, protocol, _, place = socket.getaddrinfo(
                host, port, type=socket.SOCK_DGRAM
            )[0]
            with contextlib.ExitStack() as stack:
                self._socket = stack.enter_context(socket.socket(family, kind, protocol))
                self._socket.bind(place)
                stack.pop_all()
        except OSError as error:
            raise InputError(
                f"port = {port}: cannot listen on {host}: {error}; write 0 for a free port"
            ) from error
        self._socket.settimeout(0.05)
        self._port: int = self._socket.getsockname()[1]
        self._host = host
        self._thread = threading.Thread(target=self._listen, name="robot simulator", daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """Where it listens."""
        return self._port

    @property
    def address(self) -> str:
        """What `parkproof.lab.robots.open_robot` takes."""
        return f"udp://{f'[{self._host}]' if ':' in self._host else self._host}:{self._port}"

    @property
    def pose(self) -> tuple[float, float, float]:
        """(x, y, θ) now, in m and rad, not wrapped; it began at (0, 0, 0)."""
        with self._change:
            self._advance(time.monotonic())
            return self._pose

    @property
    def velocity(self) -> tuple[float, float]:
        """(v, ω) now, in m/s and rad/s."""
        with self._change:
            self._advance(time.monotonic())
            return self._velocity

    def wait_for(self, number: int, timeout: float = 5.0) -> bool:
        """Wait until so many commands were carried out; whether they were within the time, in s."""
        with self._change:
            return self._change.wait_for(lambda: len(self.received) >= number, timeout)

    def close(self) -> None:
        """Stop listening. May be called twice."""
        self._closed = True
        self._thread.join()
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _listen(self) -> None:
        while not self._closed:
            try:
                data, sender = self._socket.recvfrom(4096)
            except OSError:  # nothing came; or whoever sent something does not listen any more
                with self._change:
                    self._advance(time.monotonic())
                continue
            if self._random.random() < self._loss:
                continue
            number = self._obey(data)
            if number is not None and self.answers:
                with contextlib.suppress(OSError):
                    self._socket.sendto(msgspec.json.encode({"ack": number}), sender)

    def _obey(self, data: bytes) -> int | None:
        """Carry out a datagram; its number, or None if it is no command or an old one."""
        try:
            command = msgspec.json.decode(data, type=_Command)
        except (msgspec.DecodeError, UnicodeDecodeError):
            return None
        if command.v is not None and command.omega is not None:
            v, omega = command.v, command.omega
        elif command.left is not None and command.right is not None:
            base = self._wheels
            v, omega = body_from_wheels(
                command.right, command.left, base.wheel_radius, base.half_track
            )
        else:
            return None
        if not (math.isfinite(v) and math.isfinite(omega)):
            return None
        now = time.monotonic()
        with self._change:
            self._advance(now)
            # Datagrams may overtake one another. After a pause the sender may be another one.
            if command.seq <= self._number and now - self._heard <= self._dead_man:
                return None
            self._number, self._heard, self._velocity = command.seq, now, (v, omega)
            self.received.append(Received(now, v, omega))
            self._change.notify_all()
        return command.seq

    def _advance(self, now: float) -> None:
        """Move on to a time, and stop when the last command is too old."""
        if self._velocity != (0.0, 0.0) and now > self._heard + self._dead_man:
            self._move(self._heard + self._dead_man - self._time)
            self._time, self._velocity = self._heard + self._dead_man, (0.0, 0.0)
            self.dead_man_stops += 1
        self._move(now - self._time)
        self._time = now

    def _move(self, dt: float) -> None:
        """Drive an arc of a circle."""
        (x, y, theta), (v, omega) = self._pose, self._velocity
        half = 0.5 * omega * dt
        chord = v * dt * (math.sin(half) / half if half else 1.0)
        self._pose = (
            x + chord * math.cos(theta + half),
            y + chord * math.sin(theta + half),
            theta + omega * dt,
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the simulated robot until it is interrupted; prints its address, then what it is told.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the program's name; default what this process was given.

    Returns
    -------
    int
        Exit status.

    Examples
    --------
    >>> main(["--seconds", "0"])
    udp://127.0.0.1:...
    0
    """
    parser = argparse.ArgumentParser(
        prog="python -m parkproof.lab.robot_simulator",
        description="A simulated robot that takes commands over UDP, for trying things out.",
    )
    parser.add_argument("--port", type=int, default=0, help="where to listen; 0 for a free port")
    parser.add_argument(
        "--dead-man",
        type=float,
        default=DEAD_MAN,
        help="it stops by itself when no command came for this time, in s",
    )
    parser.add_argument(
        "--seconds", type=float, default=math.inf, help="end after this time; default never"
    )
    given = parser.parse_args(arguments)
    try:
        simulator = UdpRobotSimulator(given.port, dead_man=given.dead_man)
    except InputError as error:
        parser.error(str(error))
    end = time.monotonic() + given.seconds
    told = (0.0, 0.0)
    with simulator, contextlib.suppress(KeyboardInterrupt):
        print(simulator.address, flush=True)
        while time.monotonic() < end:
            time.sleep(0.02)
            now = simulator.velocity
            if now != told:
                x, y, theta = simulator.pose
                print(
                    f"v = {now[0]:+.3f} m/s, omega = {now[1]:+.3f} rad/s at "
                    f"x = {x:.3f} m, y = {y:.3f} m, theta = {theta:.3f} rad",
                    flush=True,
                )
                told = now
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
