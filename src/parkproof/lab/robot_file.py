"""A robot as a file describes it: its address, what it can do, where its wheels are."""

from pathlib import Path

import msgspec

from parkproof.lab.devices import Robot, RobotLimits
from parkproof.lab.robots import GENTLE, WheelBase, open_robot
from parkproof.scenario_file.read import converted
from parkproof.scenario_file.toml import load_toml

KIND = "robot"
"""Of the file to start from: ``parkproof init --kind robot``."""


class RobotFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a file says of a robot.

    Parameters
    ----------
    address : str
        As `parkproof.lab.robots.open_robot` takes it.
    limits : RobotLimits
        What it can do; default those that small laboratory robots keep.
    wheels : WheelBase, optional
        If given, the robot takes the speeds of these wheels instead of v and ω.

    Examples
    --------
    >>> RobotFile(address="udp://192.168.1.20:5005").limits.speed
    0.3
    """

    address: str
    limits: RobotLimits = GENTLE
    wheels: WheelBase | None = None

    def open(self) -> Robot:
        """Open the robot, and see whether it answers.

        Returns
        -------
        Robot
            The robot.

        Raises
        ------
        InputError
            If the address is none, or nothing answers there.
        """
        return open_robot(self.address, limits=self.limits, wheels=self.wheels)


def read_robot(path: Path) -> RobotFile:
    """Read a file that describes a robot.

    Parameters
    ----------
    path : Path
        A TOML file.

    Returns
    -------
    RobotFile
        Checked.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or is no valid description.

    Examples
    --------
    >>> read_robot(Path("no-such-robot.toml"))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...
    """
    path = Path(path)
    return converted(load_toml(path, kind=KIND), RobotFile, str(path))


def robot_named(robot: str) -> RobotFile:
    """What is known of a robot that is named by its address, or by a file.

    Parameters
    ----------
    robot : str
        An address, or the name of a TOML file.

    Returns
    -------
    RobotFile
        With the usual limits, if it is an address.

    Raises
    ------
    InputError
        If the file cannot be read, or is no valid description.

    Examples
    --------
    >>> robot_named("udp://192.168.1.20:5005").limits.turn_rate
    1.5
    """
    if robot.lower().endswith(".toml") or Path(robot).is_file():
        return read_robot(Path(robot))
    return RobotFile(address=robot)
