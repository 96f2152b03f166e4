"""Everything that a simulated world is made of: camera, robot, pushes, floor, poses, seed."""

import math
import tomllib
from pathlib import Path
from typing import Literal

import msgspec
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.lab.devices import RobotLimits
from parkproof.lab.image_pose import TagMount
from parkproof.lab.world.lens import Lens
from parkproof.model.camera import PinholeCamera
from parkproof.model.homography import numbers
from parkproof.scenario_file.read import converted
from parkproof.scenario_file.templates import template
from parkproof.scenario_file.toml import load_toml
from parkproof.validate import finite, not_negative, positive

LAST_TAG = 586
"""Greatest number of a tag of the family tag36h11."""

FloorPose = tuple[float, float, float]
"""x and y of the middle of the axle in m, and θ in rad."""


def whole_number(name: str, value: int) -> int:
    """Return a whole number, or raise if it is not one or is negative.

    Parameters
    ----------
    name : str
        What it is called where the user wrote it.
    value : int
        The number.

    Returns
    -------
    int
        The number.

    Raises
    ------
    InputError
        If it is no whole number, or below 0.

    Examples
    --------
    >>> whole_number("seed", 3)
    3
    """
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise InputError(
            f"{name} = {value!r}: must be a whole number, not negative; "
            f"write for example {name} = 0"
        )
    return value


class CameraSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The true camera: where it hangs, its lens, its sensor, and when its frames arrive.

    Parameters
    ----------
    position : two floats
        Floor coordinates of the camera in m.
    height : float
        Its height over the floor in m.
    tilt_deg, roll_deg, pan_deg : float
        Angles in degrees (`parkproof.model.camera.PinholeCamera`); all 0 looks straight down.
    focal_length : float
        Focal length f_x in px.
    aspect : float
        Vertical over horizontal focal length, f_y/f_x.
    image_size : two ints
        Width and height of the picture in px.
    k1 : float
        Radial distortion, x_d = x (1 + k1 r²) in normalised coordinates, as in OpenCV.
    noise : float
        Standard deviation of the noise of each pixel in grey levels.
    blur : float
        Standard deviation of the blur in px.
    exposure : float
        Factor on the brightness; 1 shows white as nearly white.
    exposure_time : float
        Time in s over which the shutter is open: what moves meanwhile is blurred.
    rate : float
        Frames taken in a second.
    latency : float
        Time in s from the middle of the exposure until the frame arrives.
    drop : float
        Probability that a frame never arrives.
    colour : bool
        Whether frames are RGB; else they are grey.

    Raises
    ------
    InputError
        If a number is out of its range, the picture shows the horizon, or the distortion folds it.

    Examples
    --------
    >>> CameraSettings(tilt_deg=20.0, latency=0.1).rate
    30.0
    >>> CameraSettings(drop=1.5)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: drop = 1.5: must be in [0, 1); write for example drop = 0.1
    """

    position: tuple[float, float] = (0.0, 0.0)
    height: float = 2.0
    tilt_deg: float = 0.0
    roll_deg: float = 0.0
    pan_deg: float = 0.0
    focal_length: float = 600.0
    aspect: float = 1.0
    image_size: tuple[int, int] = (640, 480)
    k1: float = 0.0
    noise: float = 2.0
    blur: float = 0.5
    exposure: float = 1.0
    exposure_time: float = 0.0
    rate: float = 30.0
    latency: float = 0.066
    drop: float = 0.0
    colour: bool = False

    def __post_init__(self) -> None:
        for name in ("noise", "blur", "exposure_time", "latency"):
            force_setattr(self, name, not_negative(name, getattr(self, name)))
        positive("exposure", self.exposure)
        positive("rate", self.rate, example=30.0)
        if not 0.0 <= finite("drop", self.drop) < 1.0:
            raise InputError(
                f"drop = {self.drop:g}: must be in [0, 1); write for example drop = 0.1"
            )
        if not self.exposure_time < 1.0 / self.rate:
            raise InputError(
                f"exposure_time = {self.exposure_time:g}: must be shorter than the time between "
                f"frames, {1.0 / self.rate:.3g} s; write for example exposure_time = "
                f"{0.2 / self.rate:.2g}"
            )
        if not self.latency >= 0.5 * self.exposure_time:
            raise InputError(
                f"latency = {self.latency:g}: must be at least half of exposure_time = "
                f"{self.exposure_time:g}, when the shutter closes; write for example latency = "
                f"{0.5 * self.exposure_time + 0.05:.2g}"
            )
        width, height = numbers("image_size", self.image_size, 2)
        whole = width == int(width) and height == int(height)
        if not (whole and 64 <= width <= 4096 and 64 <= height <= 4096):
            raise InputError(
                f"image_size = {list(self.image_size)}: width and height must be whole numbers in "
                "[64, 4096] px; write for example image_size = [640, 480]"
            )
        force_setattr(self, "image_size", (int(width), int(height)))
        floor = self.pinhole().homography().inverse()
        for corner in self.lens().ideal_corners():
            if not floor.depth(*corner) > 0.0:
                raise InputError(
                    f"tilt_deg = {self.tilt_deg:g}: a corner of the picture shows the horizon; "
                    "tilt the camera less or take a longer focal_length"
                )

    def pinhole(self) -> PinholeCamera:
        """Return the camera without its lens distortion."""
        return PinholeCamera(
            position=self.position,
            height=self.height,
            focal_length=self.focal_length,
            image_size=self.image_size,
            tilt=math.radians(finite("tilt_deg", self.tilt_deg)),
            roll=math.radians(finite("roll_deg", self.roll_deg)),
            pan=math.radians(finite("pan_deg", self.pan_deg)),
            aspect=self.aspect,
        )

    def lens(self) -> Lens:
        """Return the lens, which bends what the pinhole camera would show."""
        return Lens(
            image_size=self.image_size,
            focal_length=self.focal_length,
            aspect=self.aspect,
            k1=self.k1,
        )


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


class PushSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Horizontal pushes on the robot: at random times, in random directions, off its centre.

    Parameters
    ----------
    force : float
        Largest force in N; each push has between a half and all of it. 0: no pushes.
    duration : float
        Duration of a push in s.
    rate : float
        Pushes in a second, on average.
    lever : float
        Largest distance in m of a push's line from the robot's centre, by which it turns it.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> PushSettings(force=1.0).duration
    0.2
    """

    force: float = 0.0
    duration: float = 0.2
    rate: float = 0.5
    lever: float = 0.05

    def __post_init__(self) -> None:
        for name in ("force", "lever"):
            force_setattr(self, name, not_negative(name, getattr(self, name)))
        positive("duration", self.duration, example=0.2)
        positive("rate", self.rate, example=0.5)


class FloorSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The floor: a mottled grey.

    Parameters
    ----------
    brightness : float
        Mean grey level, 30 to 225.
    contrast : float
        Standard deviation of the grey level, 0 to 60.
    friction : float
        Coefficient of friction under the wheels.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> FloorSettings(contrast=20.0).friction
    0.9
    """

    brightness: float = 130.0
    contrast: float = 14.0
    friction: float = 0.9

    def __post_init__(self) -> None:
        for name, low, high in (("brightness", 30.0, 225.0), ("contrast", 0.0, 60.0)):
            if not low <= finite(name, getattr(self, name)) <= high:
                raise InputError(
                    f"{name} = {getattr(self, name):g}: must be in [{low:g}, {high:g}]; "
                    f"write for example {name} = {0.4 * high:g}"
                )
        positive("friction", self.friction, example=0.9)


class WorldSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A simulated world.

    Parameters
    ----------
    camera, robot, pushes, floor
        Its parts: `CameraSettings`, `RobotSettings`, `PushSettings`, `FloorSettings`.
    start, goal : three floats
        x and y of the middle of the axle in m, and θ in rad, on the floor.
    seed : int
        Of all that is random: floor, noise, drops, pushes.

    Raises
    ------
    InputError
        If a number is not finite, the seed is negative, or the tag reaches the camera.

    Examples
    --------
    >>> WorldSettings(start=(0.3, 0.2, 1.0)).camera.height
    2.0
    >>> msgspec.convert({"camera": {"tilt_deg": 10.0}}, WorldSettings).camera.tilt_deg
    10.0
    """

    camera: CameraSettings = CameraSettings()
    robot: RobotSettings = RobotSettings()
    pushes: PushSettings = PushSettings()
    floor: FloorSettings = FloorSettings()
    start: FloorPose = (-0.3, -0.2, 0.5)
    goal: FloorPose = (0.2, 0.1, 0.0)
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("start", "goal"):
            force_setattr(self, name, numbers(name, getattr(self, name), 3))
        whole_number("seed", self.seed)
        if not self.camera.height > self.robot.tag_height + 0.1:
            raise InputError(
                f"height = {self.camera.height:g}: the camera must hang at least 0.1 m above the "
                f"tag, which is at {self.robot.tag_height:g} m; write for example height = 2.0"
            )


def read_world(path: Path) -> WorldSettings:
    """Read a file that describes a simulated laboratory.

    Parameters
    ----------
    path : Path
        A TOML file.

    Returns
    -------
    WorldSettings
        Checked.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or is no valid description.

    Examples
    --------
    >>> read_world(Path("no-such-world.toml"))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...
    """
    path = Path(path)
    return converted(load_toml(path), WorldSettings, str(path))


def example_world() -> WorldSettings:
    """The simulated laboratory of `parkproof init --kind world`: a tilted camera, unequal wheels.

    Returns
    -------
    WorldSettings
        What parkproof lab uses where it is told nothing else.

    Examples
    --------
    >>> example_world().camera.tilt_deg
    27.0
    """
    return converted(tomllib.loads(template("world")), WorldSettings, "world.toml")
