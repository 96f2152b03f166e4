"""Masses of the robot, and what its maker knows of its inertia."""

from parkproof.lab.world.robot_settings import RobotSettings
from parkproof.model.drive import DifferentialDrive

WHEEL_MASS, CASTOR_MASS = 0.05, 0.01
"""In kg."""

ARMATURE = 5e-4
"""Inertia of a motor's rotor behind its gear in kg m²."""

BALLAST = 0.25
"""How far the centre of mass lies behind the axle, in tracks, or the robot would tip when it
brakes."""

CASTOR = 0.55
"""How far the castor lies behind the axle, in tracks."""


def body_box(robot: RobotSettings) -> tuple[float, float, float]:
    """Rear and front end of the body from the axle, and half its width, in m.

    Parameters
    ----------
    robot : RobotSettings
        The robot.

    Returns
    -------
    tuple of float
        Rear (negative), front, half the width.

    Examples
    --------
    >>> [round(x, 4) for x in body_box(RobotSettings())]
    [-0.1125, 0.075, 0.0628]
    """
    return -0.75 * robot.track, 0.5 * robot.track, 0.5 * robot.track - 0.35 * robot.wheel_radius


def nominal_drive(robot: RobotSettings) -> DifferentialDrive:
    """What the maker knows of the robot: from accelerations to torques of the wheels.

    The mass includes what the turning wheels and rotors add. Friction, errors of the motors, and
    the forces of a centre of mass behind the axle are not in it.

    Parameters
    ----------
    robot : RobotSettings
        The robot.

    Returns
    -------
    DifferentialDrive
        With its mass and inertia about the axle's middle.

    Examples
    --------
    >>> drive = nominal_drive(RobotSettings())
    >>> round(drive.mass, 2), round(drive.inertia, 4)
    (2.37, 0.0134)
    """
    half_track = 0.5 * robot.track
    back, front, half_width = body_box(robot)
    half = 0.5 * (front - back)
    turning = ARMATURE / robot.wheel_radius**2 + 0.4 * WHEEL_MASS
    body = robot.mass * ((half_width**2 + half**2) / 3.0 + (BALLAST * robot.track) ** 2)
    castor = CASTOR_MASS * (CASTOR * robot.track) ** 2
    return DifferentialDrive(
        wheel_radius=robot.wheel_radius,
        half_track=half_track,
        mass=robot.mass + CASTOR_MASS + 2.0 * (WHEEL_MASS + turning),
        inertia=body + castor + 2.0 * (WHEEL_MASS + turning) * half_track**2,
    )
