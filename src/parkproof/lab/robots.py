"""Robots of a laboratory: over UDP, or through a function that takes wheel speeds."""

import contextlib
from collections.abc import Callable
from urllib.parse import urlsplit

import msgspec
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.lab.devices import Robot, RobotLimits, RobotSilentError
from parkproof.lab.udp_link import UdpLink
from parkproof.model.drive import wheels_from_body
from parkproof.validate import positive

GENTLE = RobotLimits(speed=0.3, turn_rate=1.5, acceleration=1.0, turn_acceleration=6.0)
"""Limits that small laboratory robots keep."""


class WheelBase(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the driven wheels are.

    Parameters
    ----------
    wheel_radius : float
        r in m, positive.
    half_track : float
        R in m, half the distance between the driven wheels, positive.

    Raises
    ------
    InputError
        If a number is not positive.

    Examples
    --------
    >>> WheelBase(wheel_radius=0.03, half_track=0.08).half_track
    0.08
    """

    wheel_radius: float
    half_track: float

    def __post_init__(self) -> None:
        for name in ("wheel_radius", "half_track"):
            force_setattr(self, name, positive(name, getattr(self, name), example=0.05))


def open_robot(
    address: str,
    *,
    limits: RobotLimits = GENTLE,
    silence: float = 0.5,
    wheels: WheelBase | None = None,
) -> Robot:
    """Open a robot by its address, and see whether it answers.

    Parameters
    ----------
    address : str
        "udp://host:port": JSON datagrams, as `docs/lab-devices.md` describes them.
    limits : RobotLimits
        What it can do.
    silence : float
        `parkproof.lab.devices.RobotSilentError` is raised by ``send`` when commands were not
        acknowledged for this time, in s.
    wheels : WheelBase, optional
        If given, the robot takes the speeds of these wheels instead of v and ω.

    Returns
    -------
    Robot
        The robot. It is as good as its limits: wrap it in
        `parkproof.lab.watchdog.StoppingRobot` to have them kept.

    Raises
    ------
    InputError
        If the address is none, or nothing answers there.

    Examples
    --------
    >>> from parkproof.lab.robot_simulator import UdpRobotSimulator
    >>> with UdpRobotSimulator() as simulator:
    ...     robot = open_robot(simulator.address)
    ...     robot.send(0.1, 0.5)
    ...     robot.close()
    >>> open_robot("udp://robot")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: robot = udp://robot: ...
    """
    host, port = _host_and_port(address)
    rest = {"v": 0.0, "omega": 0.0} if wheels is None else {"left": 0.0, "right": 0.0}
    link = UdpLink(host, port, rest=rest, silence=silence)
    link.greet()
    if wheels is None:
        return UdpRobot(link, limits=limits)
    return WheelRobot(
        lambda left, right: link.send({"left": left, "right": right}),
        wheels=wheels,
        limits=limits,
        stop=link.stop,
        close=link.close,
    )


def _host_and_port(address: str) -> tuple[str, int]:
    """Split an address."""
    try:
        parts = urlsplit(address)
        scheme, host, port = parts.scheme, parts.hostname, parts.port
    except ValueError:  # a port that is no number, or beyond 65535; a bracket that is not closed
        scheme, host, port = "", None, None
    if scheme != "udp" or not host or not port:
        raise InputError(
            f"robot = {address}: must be udp://host:port with a port from 1 to 65535, or a file "
            "robot.toml; write for example udp://192.168.1.20:5005"
        )
    return host, port


class UdpRobot:
    """A robot that takes v and ω as JSON datagrams; `open_robot` makes it.

    Parameters
    ----------
    link : UdpLink
        The way to it.
    limits : RobotLimits
        What it can do.

    Examples
    --------
    >>> from parkproof.lab.robot_simulator import UdpRobotSimulator
    >>> with UdpRobotSimulator() as simulator:
    ...     robot = open_robot(simulator.address)
    ...     robot.limits.speed
    ...     robot.stop()
    ...     robot.close()
    0.3
    """

    def __init__(self, link: UdpLink, *, limits: RobotLimits) -> None:
        self._link = link
        self._limits = limits

    @property
    def limits(self) -> RobotLimits:
        """What it can do."""
        return self._limits

    def send(self, v: float, omega: float) -> None:
        """Drive at v in m/s and turn at ω in rad/s. Does not wait for the answer.

        Raises
        ------
        RobotSilentError
            If the robot has not acknowledged its commands for longer than allowed.
        """
        self._link.send({"v": v, "omega": omega})

    def stop(self) -> None:
        """Stand still: sent three times, and never raises."""
        self._link.stop()

    def close(self) -> None:
        """Stop, and give the socket back."""
        self._link.stop()
        self._link.close()


class WheelRobot:
    """A robot that takes the speeds of its wheels, from a function that sends them.

    Parameters
    ----------
    send_wheels : callable
        Called with (left, right) in rad/s, positive forwards.
    wheels : WheelBase
        Where the wheels are.
    limits : RobotLimits
        What it can do.
    stop : callable, optional
        Stops the robot at once, and does not raise. Else wheel speeds of 0 are sent.
    close : callable, optional
        Gives the robot back.

    Examples
    --------
    >>> base = WheelBase(wheel_radius=0.5, half_track=0.25)
    >>> robot = WheelRobot(lambda left, right: print(left, right), wheels=base, limits=GENTLE)
    >>> robot.send(1.0, 2.0)
    1.0 3.0
    >>> robot.close()
    0.0 0.0
    """

    def __init__(
        self,
        send_wheels: Callable[[float, float], None],
        *,
        wheels: WheelBase,
        limits: RobotLimits,
        stop: Callable[[], None] | None = None,
        close: Callable[[], None] | None = None,
    ) -> None:
        self._send_wheels = send_wheels
        self._wheels = wheels
        self._limits = limits
        self._stop = stop
        self._close = close

    @property
    def limits(self) -> RobotLimits:
        """What it can do."""
        return self._limits

    def send(self, v: float, omega: float) -> None:
        """Drive at v in m/s and turn at ω in rad/s; raises what the function raises."""
        right, left = wheels_from_body(v, omega, self._wheels.wheel_radius, self._wheels.half_track)
        self._send_wheels(left, right)

    def stop(self) -> None:
        """Stand still."""
        if self._stop is not None:
            self._stop()
        else:
            with contextlib.suppress(OSError, RobotSilentError):  # it may not hear this, either
                self._send_wheels(0.0, 0.0)

    def close(self) -> None:
        """Stop, and give the robot back."""
        self.stop()
        if self._close is not None:
            self._close()
