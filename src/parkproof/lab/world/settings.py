"""A simulated world as a file describes it: its parts, poses of start and goal, a seed."""

import tomllib
from pathlib import Path

import msgspec
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.lab.world.camera_settings import CameraSettings
from parkproof.lab.world.floor_settings import FloorSettings
from parkproof.lab.world.pushes import PushSettings
from parkproof.lab.world.robot_settings import RobotSettings
from parkproof.model.homography import numbers
from parkproof.scenario_file.read import converted
from parkproof.scenario_file.templates import template
from parkproof.scenario_file.toml import load_toml
from parkproof.validate import whole_number, within

FloorPose = tuple[float, float, float]
"""x and y of the middle of the axle in m, and θ in rad."""

FARTHEST = 1e3
"""Largest coordinate in m, or angle in rad, of a pose."""


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
            pose = numbers(name, getattr(self, name), 3)
            for value in pose:
                within(name, value, -FARTHEST, FARTHEST, unit="m and rad")
            force_setattr(self, name, pose)
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
    return converted(load_toml(path, kind="world"), WorldSettings, str(path))


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
