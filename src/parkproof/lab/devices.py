"""What a laboratory implements: a camera, a robot and a clock. A few lines each.

The loop asks the camera for a frame, the laws for a command, and the robot to carry it out. Times
are seconds on one clock: the time of capture of a frame is on the clock that `Clock.now` reads.
"""

import enum
import time
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import msgspec
import numpy as np
from msgspec.structs import force_setattr
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.validate import not_negative, positive

Image = NDArray[np.uint8]
"""Grey (rows × columns) or RGB (rows × columns × 3). The first row is the top; OpenCV's pixel
coordinates: u to the right, v down, the centre of the first pixel at (0, 0)."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A picture with the time at which it was taken.

    Attributes
    ----------
    image : array of uint8
        Grey, or RGB.
    t : float
        Time of capture in s, the middle of the exposure. A camera that does not know it gives the
        time of arrival; the latency that is measured then holds the rest.
    number : int
        Counts the frames that the camera took, so that a gap shows those that were dropped.

    Examples
    --------
    >>> Frame(np.zeros((480, 640), np.uint8), t=0.5, number=15).image.shape
    (480, 640)
    """

    image: Image
    t: float
    number: int


class Missing(enum.Enum):
    """Why there is no frame.

    Examples
    --------
    >>> Missing.ENDED.sentence
    'the camera has ended'
    """

    LATE = "no frame came in time"
    ENDED = "the camera has ended"

    @property
    def sentence(self) -> str:
        """In words."""
        return self.value


class Camera(Protocol):
    """Gives frames one after the other."""

    def read(self, timeout: float) -> Frame | Missing:
        """The next frame, the newest if several wait; waits at most ``timeout`` s for it."""

    def close(self) -> None:
        """Give the camera back. May be called twice."""


class RobotLimits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the robot can do, as far as it is known.

    Parameters
    ----------
    speed, turn_rate : float
        Largest |v| in m/s and |ω| in rad/s that may be sent.
    acceleration, turn_acceleration : float
        Largest change of v in m/s² and of ω in rad/s² from command to command.
    least_speed, least_turn_rate : float
        A dead-band: speeds below these, in m/s and rad/s, may not move the robot at all. 0 if it
        has none.

    Raises
    ------
    InputError
        If a number is not positive (dead-band: negative), or the dead-band reaches the limit.

    Examples
    --------
    >>> RobotLimits(speed=0.3, turn_rate=1.5, acceleration=1.0, turn_acceleration=6.0).least_speed
    0.0
    """

    speed: float
    turn_rate: float
    acceleration: float
    turn_acceleration: float
    least_speed: float = 0.0
    least_turn_rate: float = 0.0

    def __post_init__(self) -> None:
        for name in ("speed", "turn_rate", "acceleration", "turn_acceleration"):
            force_setattr(self, name, positive(name, getattr(self, name)))
        for name, limit in (("least_speed", self.speed), ("least_turn_rate", self.turn_rate)):
            value = not_negative(name, getattr(self, name))
            if value >= limit:
                raise InputError(
                    f"{name} = {value:g}: the dead-band must be below the limit {limit:g}; "
                    f"write for example {name} = {0.05 * limit:g}"
                )
            force_setattr(self, name, value)


class Robot(Protocol):
    """Carries out velocities: the usual mobile base."""

    @property
    def limits(self) -> RobotLimits:
        """What it can do."""

    def send(self, v: float, omega: float) -> None:
        """Drive at v in m/s and turn at ω in rad/s, counter-clockwise from above, until told else.

        A robot that does not answer raises `parkproof.lab.devices.RobotSilentError`.
        """

    def stop(self) -> None:
        """Stand still. Must not raise, and may be called twice."""

    def close(self) -> None:
        """Stop, and give the robot back. May be called twice."""


@runtime_checkable
class AcceleratedRobot(Protocol):
    """Carries out accelerations: a mobile base whose motors are commanded by torque.

    From the accelerations it makes torques of its wheels, with what its maker knows of its inertia
    (`parkproof.model.drive.DifferentialDrive`). Errors of the motors, friction and slopes are for
    the law to overcome. It needs no encoders: its speeds are estimated from the pictures.
    """

    @property
    def limits(self) -> RobotLimits:
        """What it can do; the least speeds of a dead-band mean nothing here."""

    def accelerate(self, v_dot: float, omega_dot: float) -> None:
        """Accelerate by v̇ in m/s² and ω̇ in rad/s², counter-clockwise from above, until told else.

        A robot that does not answer raises `parkproof.lab.devices.RobotSilentError`. One that hears
        nothing for some tenths of a second should brake by itself: no speed limits it otherwise.
        """

    def stop(self) -> None:
        """Brake at once, and hold the wheels. Must not raise, and may be called twice."""

    def close(self) -> None:
        """Stop, and give the robot back. May be called twice."""


class RobotSilentError(Exception):
    """The robot does not answer; the sentence says which and for how long."""


class Clock(Protocol):
    """Reads the time."""

    def now(self) -> float:
        """Time in s, never running backwards by itself."""


class WallClock:
    """The computer's monotonic clock.

    Examples
    --------
    >>> clock = WallClock()
    >>> clock.now() <= clock.now()
    True
    """

    def now(self) -> float:
        """Time in s since some moment."""
        return time.monotonic()
