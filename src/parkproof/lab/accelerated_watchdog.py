"""The watchdog of a robot that takes accelerations, and which one a robot needs."""

import math

from parkproof.lab.devices import AcceleratedRobot, Clock, Robot
from parkproof.lab.watchdog import Stopping, StoppingRobot


class StoppingAcceleratedRobot(Stopping):
    """As `StoppingRobot`, for a robot that takes accelerations: their limits are kept.

    Those of speed are for the loop to keep, which estimates speeds. The watch holds unless the
    robot was told to brake.

    Parameters
    ----------
    robot : AcceleratedRobot
        What is driven.
    clock : Clock
        Of the loop.
    timeout : float or None
        As in `StoppingRobot`.

    Examples
    --------
    >>> from parkproof.lab.devices import WallClock
    >>> from parkproof.lab.world import RobotSettings, World, WorldSettings
    >>> with World(WorldSettings(robot=RobotSettings(commanded_by="torque"))) as world:
    ...     with StoppingAcceleratedRobot(world.robot, clock=world.clock, timeout=None) as safe:
    ...         safe.accelerate(1e6, 0.0)
    ...         world.truth().commanded_v
    1.0
    """

    def __init__(
        self, robot: AcceleratedRobot, *, clock: Clock, timeout: float | None = 0.3
    ) -> None:
        super().__init__(robot, clock=clock, timeout=timeout)
        self._driven = robot
        self._sent: tuple[float, float] | None = None

    def _rests(self) -> bool:
        return self._sent is None

    @property
    def sent(self) -> tuple[float, float] | None:
        """(v̇, ω̇) as last sent, within the limits; None where it was told to brake."""
        return self._sent

    def accelerate(self, v_dot: float, omega_dot: float) -> None:
        """Send the nearest acceleration within the limits; brake if a number is not finite.

        Raises
        ------
        RobotSilentError
            As the robot does; it has been told to brake.
        """
        if not (math.isfinite(v_dot) and math.isfinite(omega_dot)):
            self.brake()
            return
        most, most_turn = self.limits.acceleration, self.limits.turn_acceleration
        sent = min(max(v_dot, -most), most), min(max(omega_dot, -most_turn), most_turn)

        def command() -> None:
            self._sent = sent
            self._driven.accelerate(*sent)

        self._carry_out(command)

    def brake(self) -> None:
        """Have it brake, as a command of the loop."""
        self._carry_out(self.stop)

    def stop(self) -> None:
        """Brake at once."""
        self._sent = None
        self._robot.stop()


def stopping(
    robot: Robot | AcceleratedRobot, *, clock: Clock, timeout: float | None
) -> StoppingRobot | StoppingAcceleratedRobot:
    """Wrap a robot of either kind.

    Parameters
    ----------
    robot : Robot or AcceleratedRobot
        What is driven.
    clock : Clock
        Of the loop.
    timeout : float or None
        As in `StoppingRobot`.

    Returns
    -------
    StoppingRobot or StoppingAcceleratedRobot
        By what the robot takes.
    """
    if isinstance(robot, AcceleratedRobot):
        return StoppingAcceleratedRobot(robot, clock=clock, timeout=timeout)
    return StoppingRobot(robot, clock=clock, timeout=timeout)
