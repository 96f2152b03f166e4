"""The robot of a simulated world: wheels, motors, tag, and what its maker knows of it."""

import math
from typing import Literal

import msgspec
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.lab.devices import RobotLimits
from parkproof.lab.image_pose import TagMount
from parkproof.model.homography import numbers
from parkproof.validate import finite, not_negative, positive, whole_number, within

LAST_TAG = 586
"""Greatest number of a tag of the family tag36h11."""


class RobotSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The true robot: two driven wheels, a castor behind them, a tag on top.

    Parameters
    ----------
    wheel_radius, track : float
        Radius of the wheels and distance between them in m.
    mass : float
        Mass without the wheels in kg.
    tag_id : int
        Number of the tag, of the family tag36h11.
    tag_side : float
        Side of the tag's black square in m.
    tag_offset : two floats
        Centre of the tag from the middle of the axle in m: forward, and to the left.
    tag_angle : float
        Direction of the tag's x axis (to the right as it is printed) from the robot's forward
        direction in rad, counter-clockwise from above.
    tag_height : float
        Height of the tag over the floor in m, above the wheels.
    commanded_by : "velocity" or "torque"
        What is commanded: speeds that the motors follow; or accelerations, which become torques of
        the wheels by the nominal inertia (`parkproof.lab.world.inertia.nominal_drive`).
    motor_gains : two floats
        What the left and the right wheel make of a speed or torque: true over commanded.
    gain_error : float
        Known bound: each motor gain lies in [1 − gain_error, 1 + gain_error].
    dead_band : float
        A wheel whose speed (commanded times gain) is below this, in rad/s, does not turn; above, it
        turns as it is told (a threshold, not an offset). Commanded by torque, it has none.
    friction_torque : float
        Dry friction of each wheel's gear in N m.
    torque_limit : float
        Largest torque of a motor in N m.
    wheel_speed_limit : float
        Largest speed of a wheel in rad/s.
    servo_time : float
        Time constant in s with which a wheel's speed, or its torque, follows its command.
    speed, turn_rate, acceleration, turn_acceleration : float
        What the robot's maker allows to command: m/s, rad/s, m/s², rad/s².

    Raises
    ------
    InputError
        If a number is out of its range, or the wheels cannot turn as fast as the maker says.

    Examples
    --------
    >>> round(RobotSettings(dead_band=0.3).limits().least_speed, 4)
    0.015
    >>> RobotSettings(tag_id=900)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: tag_id = 900: tags of the family tag36h11 have ...
    """

    wheel_radius: float = 0.035
    track: float = 0.15
    mass: float = 1.4
    tag_id: int = 0
    tag_side: float = 0.1
    tag_offset: tuple[float, float] = (0.0, 0.0)
    tag_angle: float = 0.0
    tag_height: float = 0.09
    commanded_by: Literal["velocity", "torque"] = "velocity"
    motor_gains: tuple[float, float] = (1.0, 1.0)
    gain_error: float = 0.3
    dead_band: float = 0.0
    friction_torque: float = 0.005
    torque_limit: float = 0.3
    wheel_speed_limit: float = 25.0
    servo_time: float = 0.05
    speed: float = 0.3
    turn_rate: float = 2.0
    acceleration: float = 1.0
    turn_acceleration: float = 8.0

    def __post_init__(self) -> None:
        for name in (
            "wheel_radius", "track", "mass", "tag_side", "torque_limit", "wheel_speed_limit",
            "speed", "turn_rate", "acceleration", "turn_acceleration",
        ):  # fmt: skip
            force_setattr(self, name, positive(name, getattr(self, name)))
        for name in ("dead_band", "friction_torque", "servo_time"):
            force_setattr(self, name, not_negative(name, getattr(self, name)))
        within("mass", self.mass, 0.01, 1e3, unit="kg")
        if not whole_number("tag_id", self.tag_id) <= LAST_TAG:
            raise InputError(
                f"tag_id = {self.tag_id}: tags of the family tag36h11 have numbers 0 to "
                f"{LAST_TAG}; write for example tag_id = 0"
            )
        if not self.track >= 1.5 * self.wheel_radius:
            raise InputError(
                f"track = {self.track:g}: must be at least 1.5 times wheel_radius = "
                f"{self.wheel_radius:g}, or the wheels meet; write for example track = "
                f"{4.0 * self.wheel_radius:g}"
            )
        numbers("tag_offset", self.tag_offset, 2)
        finite("tag_angle", self.tag_angle)
        lowest = 2.0 * self.wheel_radius + 0.005
        if not finite("tag_height", self.tag_height) >= lowest:
            raise InputError(
                f"tag_height = {self.tag_height:g}: the tag must lie above the wheels, at least at "
                f"{lowest:g} m; write for example tag_height = {lowest + 0.02:.3g}"
            )
        if not 0.0 <= finite("gain_error", self.gain_error) < 1.0:
            raise InputError(
                f"gain_error = {self.gain_error:g}: must be in [0, 1); "
                "write for example gain_error = 0.3"
            )
        for gain in numbers("motor_gains", self.motor_gains, 2):
            if not abs(gain - 1.0) <= self.gain_error + 1e-12:
                raise InputError(
                    f"motor_gains = {list(self.motor_gains)}: must lie within gain_error = "
                    f"{self.gain_error:g} of 1; write gain_error = {abs(gain - 1.0):.2g} or more"
                )
        if not self.torque_limit > 2.0 * self.friction_torque:
            raise InputError(
                f"torque_limit = {self.torque_limit:g}: must be more than twice friction_torque = "
                f"{self.friction_torque:g}, or the wheels hardly turn; write for example "
                f"torque_limit = {10.0 * self.friction_torque:g}"
            )
        needed = max(self.speed, 0.5 * self.track * self.turn_rate) / self.wheel_radius
        if not self.wheel_speed_limit >= needed:
            raise InputError(
                f"wheel_speed_limit = {self.wheel_speed_limit:g}: speed and turn_rate need "
                f"{needed:.3g} rad/s; write wheel_speed_limit = {2.0 * needed:.2g}, or less speed"
            )
        self.limits()

    def wheel_speeds(self, v: float, omega: float) -> tuple[float, float]:
        """Nominal speeds of the left and the right wheel.

        Parameters
        ----------
        v, omega : float
            Speed in m/s and turn rate in rad/s.

        Returns
        -------
        tuple of float
            rad/s.
        """
        turn = 0.5 * self.track * omega
        return (v - turn) / self.wheel_radius, (v + turn) / self.wheel_radius

    def mount(self) -> TagMount:
        """Return how the tag sits on the robot, as its maker knows it."""
        c, s = math.cos(self.tag_angle), math.sin(self.tag_angle)
        x, y = self.tag_offset
        return TagMount(
            tag_id=self.tag_id,
            offset=(-(c * x + s * y) / self.tag_side, (s * x - c * y) / self.tag_side),
            angle=-self.tag_angle,
            side=self.tag_side,
        )

    def limits(self) -> RobotLimits:
        """What the robot's maker knows: limits, and speeds that the dead-band may swallow."""
        dead_band = self.dead_band if self.commanded_by == "velocity" else 0.0
        least = dead_band * self.wheel_radius / (1.0 - self.gain_error)
        return RobotLimits(
            speed=self.speed,
            turn_rate=self.turn_rate,
            acceleration=self.acceleration,
            turn_acceleration=self.turn_acceleration,
            least_speed=least,
            least_turn_rate=2.0 * least / self.track,
        )
