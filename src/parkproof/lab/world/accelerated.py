"""The world's robot when it is commanded by torque: it takes accelerations."""

from typing import Protocol

from parkproof.lab.devices import RobotLimits, RobotSilentError
from parkproof.lab.world.settings import WorldSettings


class Accelerated(Protocol):
    """What the robot needs of its world."""

    settings: WorldSettings

    @property
    def closed(self) -> bool:
        """Whether it has been closed."""

    def accelerate(self, v_dot: float, omega_dot: float) -> None:
        """Accelerate the robot until told else."""

    def brake(self) -> None:
        """Have the robot brake."""


class WorldAcceleratedRobot:
    """The world's robot (`parkproof.lab.devices.AcceleratedRobot`): commands act at once.

    Parameters
    ----------
    world : World
        The world, whose robot has ``commanded_by = "torque"``.

    Examples
    --------
    >>> from parkproof.lab.world import RobotSettings, World
    >>> with World(WorldSettings(robot=RobotSettings(commanded_by="torque"))) as world:
    ...     world.robot.accelerate(0.5, 0.0)
    ...     world.advance(0.5)
    ...     moving = world.truth().v
    ...     world.robot.stop()
    ...     world.advance(0.2)
    ...     0.1 < moving < 0.25, abs(world.truth().v) < 0.001
    (True, True)
    """

    def __init__(self, world: Accelerated) -> None:
        self._world = world

    @property
    def limits(self) -> RobotLimits:
        """What its maker says that it can do."""
        return self._world.settings.robot.limits()

    def accelerate(self, v_dot: float, omega_dot: float) -> None:
        """Accelerate by v_dot in m/s² and omega_dot in rad/s², as well as the motors can.

        Parameters
        ----------
        v_dot, omega_dot : float
            Acceleration, and rate of the turn rate, counter-clockwise from above.

        Raises
        ------
        InputError
            If a number is not finite.
        RobotSilentError
            If the world is closed.
        """
        if self._world.closed:
            raise RobotSilentError("the simulated robot does not answer: its world is closed")
        self._world.accelerate(v_dot, omega_dot)

    def stop(self) -> None:
        """Brake at once, and stand still."""
        if not self._world.closed:
            self._world.brake()

    def close(self) -> None:
        """Stop. May be called twice."""
        self.stop()
