"""Which parker a robot needs: by what it takes."""

from parkproof.lab.accelerated_parker import AcceleratedParker
from parkproof.lab.devices import AcceleratedRobot, Robot, RobotLimits
from parkproof.lab.goal import Goal
from parkproof.lab.parker import Parker
from parkproof.lab.safety import SafetyLimits
from parkproof.lab.settings import CommandedBy, LabSettings
from parkproof.lab.velocity_parker import VelocityParker


def commanded_by(robot: Robot | AcceleratedRobot) -> CommandedBy:
    """What a robot takes.

    Parameters
    ----------
    robot : Robot or AcceleratedRobot
        The robot.

    Returns
    -------
    str
        "velocity" or "torque".
    """
    return "torque" if isinstance(robot, AcceleratedRobot) else "velocity"


def parker_for(
    commanded: CommandedBy,
    goal: Goal,
    limits: RobotLimits,
    settings: LabSettings | None = None,
    safety: SafetyLimits | None = None,
) -> Parker:
    """Make the parker for a kind of robot.

    Parameters
    ----------
    commanded : "velocity" or "torque"
        What the robot takes.
    goal, limits, settings, safety
        See `parkproof.lab.parker.Parker`.

    Returns
    -------
    Parker
        The parker.
    """
    kind = AcceleratedParker if commanded == "torque" else VelocityParker
    return kind(goal, limits, settings, safety)
