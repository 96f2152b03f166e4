"""What the simulated laboratory is like: camera, robot, pushes, floor."""

import math
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta

from parkproof.errors import InputError
from parkproof.lab.devices import RobotLimits
from parkproof.lab.image_pose import TagMount
from parkproof.model.camera import PinholeCamera
from parkproof.scenario_file.read import converted
from parkproof.scenario_file.toml import load_toml
from parkproof.validate import finite, not_negative, positive

Floats2 = Annotated[tuple[float, float], Meta(description="two numbers")]
Floats3 = Annotated[tuple[float, float, float], Meta(description="x and y in m, heading in rad")]


class WorldCamera(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The camera above the floor, and what it does to pictures.

    Parameters
    ----------
    position : two floats
        Floor coordinates in m.
    height, focal_length, tilt_deg, roll_deg, pan_deg, aspect, image_size
        As in `parkproof.model.camera.PinholeCamera`, angles in degrees.
    distortion : float
        k1 of OpenCV's radial model.
    noise, blur, exposure : float
        Standard deviation in grey levels, that of a Gaussian in px, and a factor on brightness.
    rate : float
        Frames per s.
    latency : float
        Time from capture to arrival in s.
    drops : float
        Share of frames that never arrive.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> WorldCamera(height=2.0, focal_length=700.0).rate
    30.0
    """

    position: Floats2 = (0.0, -0.9)
    height: float = 2.2
    focal_length: float = 650.0
    tilt_deg: float = 24.0
    roll_deg: float = 12.0
    pan_deg: float = 0.0
    aspect: float = 1.1
    image_size: tuple[int, int] = (640, 480)
    distortion: float = 0.0
    noise: float = 2.0
    blur: float = 0.6
    exposure: float = 1.0
    rate: float = 30.0
    latency: float = 0.066
    drops: float = 0.0

    def __post_init__(self) -> None:
        _ = self.pinhole
        positive("exposure", self.exposure, example=1.0)
        positive("rate", self.rate, example=30.0)
        for name in ("noise", "blur", "latency", "drops"):
            not_negative(name, getattr(self, name))
        if self.drops >= 1.0:
            raise InputError(
                f"drops = {self.drops:g}: must be below 1, or no frame ever arrives; write 0.1"
            )
        corner = math.hypot(*(0.5 * size for size in self.image_size)) / self.focal_length
        if finite("distortion", self.distortion) < 0.0:
            # r(1 + k1 r²) has its maximum at r = 1/√(−3 k1): beyond it, the picture would fold
            farthest = 2.0 / 3.0 / math.sqrt(-3.0 * self.distortion)
            if corner > 0.98 * farthest:
                raise InputError(
                    f"distortion = {self.distortion:g}: the picture would fold over at its "
                    f"corners; take a focal_length of {corner * self.focal_length / farthest:.0f} "
                    "px or more"
                )

    @property
    def pinhole(self) -> PinholeCamera:
        """The camera without distortion."""
        return PinholeCamera(
            position=self.position,
            height=self.height,
            focal_length=self.focal_length,
            image_size=self.image_size,
            tilt=math.radians(self.tilt_deg),
            roll=math.radians(self.roll_deg),
            pan=math.radians(self.pan_deg),
            aspect=self.aspect,
        )


class WorldRobot(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robot: two driven wheels, a castor, a tag on top.

    Parameters
    ----------
    wheel_radius, track : float
        In m.
    tag_id : int
        Of the family 36h11.
    tag_side : float
        Side of the tag's black square in m.
    tag_position : two floats
        Centre of the tag in the robot's frame in m: forward, and to the left of the axle's middle.
    tag_angle_deg : float
        Direction of the tag's x axis in the robot's frame.
    gains : two floats
        What the left and the right wheel make of a speed.
    dead_band : float
        Speed of a wheel's rim in m/s below which it does not turn.
    lag : float
        Time constant of the wheels' speed in s.
    max_torque, friction_torque : float
        Of a motor and of its gear, in N·m.
    limits : RobotLimits, optional
        What the program is told of it.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> WorldRobot().limits.speed
    0.3
    """

    wheel_radius: float = 0.035
    track: float = 0.16
    tag_id: int = 0
    tag_side: float = 0.1
    tag_position: Floats2 = (0.0, 0.0)
    tag_angle_deg: float = 0.0
    gains: Floats2 = (1.15, 0.9)
    dead_band: float = 0.008
    lag: float = 0.04
    max_torque: float = 0.15
    friction_torque: float = 0.02
    limits: RobotLimits = RobotLimits(
        speed=0.3,
        turn_rate=2.5,
        acceleration=1.0,
        turn_acceleration=10.0,
        least_speed=0.012,
        least_turn_rate=0.15,
    )

    def __post_init__(self) -> None:
        for name in ("wheel_radius", "track", "tag_side", "lag", "max_torque"):
            positive(name, getattr(self, name))
        for name in ("dead_band", "friction_torque"):
            not_negative(name, getattr(self, name))
        for gain in self.gains:
            positive("gains", gain, example=1.0)
        for name in ("tag_position",):
            for value in getattr(self, name):
                finite(name, value)
        finite("tag_angle_deg", self.tag_angle_deg)
        _ = self.mount

    @property
    def mount(self) -> TagMount:
        """How the tag sits on the robot, as the program is told."""
        angle = math.radians(self.tag_angle_deg)
        c, s = math.cos(angle), math.sin(angle)
        x, y = self.tag_position
        offset = (-(c * x + s * y) / self.tag_side, (s * x - c * y) / self.tag_side)
        return TagMount(tag_id=self.tag_id, offset=offset, angle=-angle, side=self.tag_side)


class Pushes(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Pushes on the robot, at random times, in random directions.

    Parameters
    ----------
    force : float
        Largest force in N.
    lever : float
        Largest distance in m of the force from the axle's middle.
    duration : float
        Of a push in s.
    rate : float
        Pushes per s, on average.

    Raises
    ------
    InputError
        If a number is negative.

    Examples
    --------
    >>> Pushes(force=0.5).rate
    0.5
    """

    force: float = 1.0
    lever: float = 0.06
    duration: float = 0.15
    rate: float = 0.5

    def __post_init__(self) -> None:
        for name in ("force", "lever", "duration", "rate"):
            not_negative(name, getattr(self, name))


class WorldSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A simulated laboratory.

    Parameters
    ----------
    camera : WorldCamera
        The camera.
    robot : WorldRobot
        The robot.
    pushes : Pushes
        What disturbs it.
    goal, start : three floats
        Where it shall park and where it starts: x, y in m and heading in rad on the floor.
    seed : int
        For floor, noise, drops and pushes.

    Examples
    --------
    >>> WorldSettings().seed
    0
    """

    camera: WorldCamera = WorldCamera()
    robot: WorldRobot = WorldRobot()
    pushes: Pushes = Pushes()
    goal: Floats3 = (0.05, 0.0, 0.2)
    start: Floats3 = (-0.45, 0.3, 2.0)
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("goal", "start"):
            for value in getattr(self, name):
                finite(name, value)


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
