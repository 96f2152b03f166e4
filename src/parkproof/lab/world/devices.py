"""Camera, robot and clock of a simulated world, as the loop takes them."""

from typing import TYPE_CHECKING

from parkproof.lab.devices import Frame, Missing, RobotLimits, RobotSilentError

if TYPE_CHECKING:
    from parkproof.lab.world.world import World


class WorldCamera:
    """The world's camera (`parkproof.lab.devices.Camera`).

    Parameters
    ----------
    world : World
        The world.

    Examples
    --------
    >>> from parkproof.lab.world import World, WorldSettings
    >>> with World(WorldSettings()) as world:
    ...     world.camera.read(timeout=0.01)
    <Missing.LATE: 'no frame came in time'>
    """

    def __init__(self, world: "World") -> None:
        self._world = world
        self._closed = False

    def read(self, timeout: float) -> Frame | Missing:
        """Let time pass until the next frame arrives, at most the timeout.

        Parameters
        ----------
        timeout : float
            Longest simulated time to wait in s.

        Returns
        -------
        Frame or Missing
            The newest frame if several have arrived; its t is the middle of the exposure.
        """
        return Missing.ENDED if self._closed else self._world.read(timeout)

    def close(self) -> None:
        """Give the camera back. May be called twice."""
        self._closed = True


class WorldRobot:
    """The world's robot (`parkproof.lab.devices.Robot`): commands act at once.

    Parameters
    ----------
    world : World
        The world.

    Examples
    --------
    >>> from parkproof.lab.world import World, WorldSettings
    >>> with World(WorldSettings()) as world:
    ...     world.robot.limits.speed
    0.3
    """

    def __init__(self, world: "World") -> None:
        self._world = world

    @property
    def limits(self) -> RobotLimits:
        """What its maker says that it can do."""
        return self._world.settings.robot.limits()

    def send(self, v: float, omega: float) -> None:
        """Drive at v in m/s and turn at ω in rad/s, as well as the motors can.

        Parameters
        ----------
        v, omega : float
            Speed, and turn rate, counter-clockwise from above.

        Raises
        ------
        InputError
            If a number is not finite.
        RobotSilentError
            If the world is closed.
        """
        if self._world.closed:
            raise RobotSilentError("the simulated robot does not answer: its world is closed")
        self._world.command(v, omega)

    def stop(self) -> None:
        """Stand still."""
        if not self._world.closed:
            self._world.command(0.0, 0.0)

    def close(self) -> None:
        """Stop. May be called twice."""
        self.stop()


class WorldAcceleratedRobot:
    """The world's robot (`parkproof.lab.devices.AcceleratedRobot`): commands act at once.

    Parameters
    ----------
    world : World
        The world, whose robot has ``commanded_by = "torque"``.

    Examples
    --------
    >>> from parkproof.lab.world import RobotSettings, World, WorldSettings
    >>> with World(WorldSettings(robot=RobotSettings(commanded_by="torque"))) as world:
    ...     world.robot.accelerate(0.5, 0.0)
    ...     world.advance(0.5)
    ...     moving = world.truth().v
    ...     world.robot.stop()
    ...     world.advance(0.2)
    ...     0.1 < moving < 0.25, abs(world.truth().v) < 0.001
    (True, True)
    """

    def __init__(self, world: "World") -> None:
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


class WorldClock:
    """Simulated time (`parkproof.lab.devices.Clock`).

    Parameters
    ----------
    world : World
        The world.

    Examples
    --------
    >>> from parkproof.lab.world import World, WorldSettings
    >>> with World(WorldSettings()) as world:
    ...     world.advance(0.25)
    ...     world.clock.now()
    0.25
    """

    def __init__(self, world: "World") -> None:
        self._world = world

    def now(self) -> float:
        """Time in s since the world was made."""
        return self._world.t
