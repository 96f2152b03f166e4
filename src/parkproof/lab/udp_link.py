"""JSON datagrams to a robot, each acknowledged: `docs/lab-devices.md` describes the protocol."""

import contextlib
import itertools
import math
import socket
import time
from collections import deque

import msgspec

from parkproof.errors import InputError
from parkproof.lab.devices import RobotSilentError
from parkproof.validate import positive

STOPS = 3
"""How often a command to stand still is sent: a datagram may be lost."""

BETWEEN_STOPS = 0.005
"""Time in s between them: what loses one datagram loses those right behind it, too."""


class Acknowledgement(msgspec.Struct):
    """What a robot answers.

    Parameters
    ----------
    ack : int
        The number of the command that it carries out.

    Examples
    --------
    >>> msgspec.json.decode(b'{"ack": 7}', type=Acknowledgement).ack
    7
    """

    ack: int


class UdpLink:
    """Sends commands, counts them, and listens for the acknowledgements without waiting.

    Parameters
    ----------
    host : str
        Name or address of the robot.
    port : int
        Where it listens.
    rest : dict of str to float
        The command to stand still.
    silence : float
        The robot counts as silent when commands were not acknowledged for this time, in s.

    Raises
    ------
    InputError
        If there is no such host, or the time is not positive.

    Examples
    --------
    >>> link = UdpLink("127.0.0.1", 9, rest={"v": 0.0, "omega": 0.0})
    >>> link.send({"v": 0.1, "omega": 0.0})  # nothing answers there, but it may be only late
    >>> link.stop()
    >>> link.close()
    """

    def __init__(
        self, host: str, port: int, *, rest: dict[str, float], silence: float = 0.5
    ) -> None:
        self.name = f"udp://{f'[{host}]' if ':' in host else host}:{port}"
        self._silence = positive("silence", silence, example=0.5)
        self._rest = rest
        self._numbers = itertools.count(1)
        self._last = 0
        self._waiting: deque[tuple[int, float]] = deque()
        self._refusal = ""
        try:
            family, kind, protocol, _, place = socket.getaddrinfo(
                host, port, type=socket.SOCK_DGRAM
            )[0]
            with contextlib.ExitStack() as stack:
                self._socket = stack.enter_context(socket.socket(family, kind, protocol))
                self._socket.connect(place)
                stack.pop_all()
        except (OSError, UnicodeError) as error:
            why = error.strerror if isinstance(error, OSError) else "no name of a host"
            raise InputError(
                f"{self.name}: cannot be reached: {why}; write the address of the robot, for "
                "example udp://192.168.1.20:5005"
            ) from error
        self._socket.setblocking(False)

    def greet(self) -> None:
        """Tell the robot to stand still until it answers.

        Raises
        ------
        InputError
            If it has not answered when it counts as silent.
        """
        end = time.monotonic() + self._silence
        while time.monotonic() < end:
            self._transmit(self._rest)
            time.sleep(0.01)
            if self._hear():
                return
        self.close()
        raise InputError(f"{self._silent()}; switch the robot on, or write its right address")

    def send(self, command: dict[str, float]) -> None:
        """Send a command.

        Raises
        ------
        RobotSilentError
            If earlier commands were not acknowledged for longer than allowed. The robot has then
            been told to stand still instead, and may be asked again.
        """
        self._hear()
        now = time.monotonic()
        # One command alone may have been lost.
        if len(self._waiting) > 1 and now - self._waiting[0][1] > self._silence:
            self._transmit(self._rest)
            raise RobotSilentError(self._silent())
        if not all(math.isfinite(value) for value in command.values()):
            command = self._rest
        self._waiting.append((self._transmit(command), now))

    def stop(self) -> None:
        """Tell the robot to stand still, several times. Does not raise.

        May be called from another thread, and from within `send` when a signal arrives there.
        """
        for repeat in range(STOPS):
            if repeat:
                time.sleep(BETWEEN_STOPS)
            self._transmit(self._rest)

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()

    def _transmit(self, command: dict[str, float]) -> int:
        """Send a datagram; if that fails, it counts as one that was lost."""
        number = self._last = next(self._numbers)
        try:
            self._socket.send(msgspec.json.encode(command | {"seq": number}))
        except OSError as error:
            self._refusal = error.strerror or str(error)
        return number

    def _hear(self) -> bool:
        """Take all acknowledgements that have come; whether there was one."""
        heard = False
        while True:
            try:
                answer = msgspec.json.decode(self._socket.recv(4096), type=Acknowledgement)
            except BlockingIOError:
                return heard
            except msgspec.DecodeError:
                continue
            except OSError as error:
                self._refusal = error.strerror or str(error)
                if not isinstance(error, ConnectionError):  # of an earlier datagram: look further
                    return heard
                continue
            if 0 < answer.ack <= self._last:
                heard, self._refusal = True, ""
                with contextlib.suppress(IndexError):
                    while self._waiting[0][0] <= answer.ack:
                        self._waiting.popleft()

    def _silent(self) -> str:
        why = f" ({self._refusal})" if self._refusal else ""
        return f"{self.name}: the robot has not answered for {self._silence:g} s{why}"
