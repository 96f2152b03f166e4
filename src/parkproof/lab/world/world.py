"""A laboratory in the computer: physics, a camera over it, and a clock that only they move.

Time is simulated: it passes while the camera waits for a frame, or in `World.advance`, and at no
other moment. A frame is taken at k/rate, on the way, whether anyone reads it or not, and arrives
after the latency; meanwhile the robot goes on with its last command.
"""

import math
from collections import deque
from types import TracebackType
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.lab.devices import Frame, Image, Missing
from parkproof.lab.world.devices import (
    WorldAcceleratedRobot,
    WorldCamera,
    WorldClock,
    WorldRobot,
)
from parkproof.lab.world.model import world_model
from parkproof.lab.world.opengl import load_mujoco
from parkproof.lab.world.physics import Physics
from parkproof.lab.world.render import Renderer
from parkproof.lab.world.sensor import Sensor, render_size
from parkproof.lab.world.settings import FloorPose, WorldSettings
from parkproof.lab.world.truth import Truth
from parkproof.lab.world.view import TagView
from parkproof.model.homography import Homography
from parkproof.validate import finite, not_negative

_DROP_STREAM = 4
_SUBFRAMES = 5
"""Renderings that are averaged over the time of exposure; odd, so that one is in its middle."""


class _Exposure(NamedTuple):
    """A frame on its way: what to render when it arrives."""

    number: int
    t: float
    arrival: float
    states: tuple[NDArray[np.float64], ...]


class World:
    """A simulated laboratory; use it as a context manager.

    Parameters
    ----------
    settings : WorldSettings
        What it is made of.

    Attributes
    ----------
    settings : WorldSettings
        As given.
    camera : WorldCamera
        Its camera.
    robot : WorldRobot or WorldAcceleratedRobot
        Its robot, by what it is commanded.
    clock : WorldClock
        Reads simulated time.
    to_pixels : Homography
        True map from the plane of the tag (the floor's axes, m) to pixels, without distortion.
    view : TagView
        Where a robot's tag appears, with distortion.
    history : list of Truth
        What was true in the middle of each frame's exposure, by the frame's number; those that
        were dropped are there, too.

    Raises
    ------
    InputError
        If MuJoCo or the library that it renders with is missing, or MuJoCo cannot simulate it.

    Examples
    --------
    >>> with World(WorldSettings(start=(0.1, 0.0, 0.0))) as world:
    ...     world.robot.send(0.1, 0.0)
    ...     frame = world.camera.read(timeout=1.0)
    ...     frame.t, round(world.clock.now(), 3), frame.image.shape, world.truth().in_view
    (0.0, 0.066, (480, 640), True)
    """

    def __init__(self, settings: WorldSettings) -> None:
        self.settings = settings
        size = render_size(settings.camera.lens())
        text, pictures = world_model(settings, render_size=size)
        mujoco = load_mujoco()
        try:
            self._model = mujoco.MjModel.from_xml_string(text, pictures)
        except ValueError as error:  # a mass or a length that is too small or too large for it
            raise InputError(
                f"this world cannot be simulated: {error}; write sizes and masses such as a robot "
                "on a floor has"
            ) from error
        self._physics = Physics(settings, self._model)
        robot = settings.robot
        plane = self._physics.axle_height + robot.tag_height - robot.wheel_radius
        self.to_pixels: Homography = settings.camera.pinhole().homography(plane)
        self.view = TagView(settings, to_pixels=self.to_pixels)
        self.history: list[Truth] = []
        self._sensor = Sensor(settings.camera, settings.seed)
        self._size = size
        self._renderer: Renderer | None = None
        self._closed = False
        self._command = (0.0, 0.0)
        self._next = 0
        self._states: list[NDArray[np.float64]] = []
        self._pending: deque[_Exposure] = deque()
        self.camera = WorldCamera(self)
        self.robot: WorldRobot | WorldAcceleratedRobot = (
            WorldRobot(self)
            if settings.robot.commanded_by == "velocity"
            else WorldAcceleratedRobot(self)
        )
        self.clock = WorldClock(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def t(self) -> float:
        """Simulated time in s."""
        return self._physics.t

    @property
    def closed(self) -> bool:
        """Whether it has been closed."""
        return self._closed

    def close(self) -> None:
        """End it. May be called twice."""
        self._closed = True
        self._pending.clear()
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def place(self, pose: FloorPose) -> None:
        """Put the robot somewhere, at rest, as a hand would; frames on their way are lost.

        Parameters
        ----------
        pose : three floats
            x, y of the middle of the axle in m, and θ in rad.

        Raises
        ------
        InputError
            If a number is not finite.
        """
        x, y, theta = (finite("pose", value) for value in pose)
        if self._states:  # the shutter is open: that frame is lost, too
            self._record(at_least=self._next + 1)
            self._states.clear()
            self._next += 1
        self._physics.place((x, y, theta))
        self._command = (0.0, 0.0)
        self._pending.clear()

    def command(self, v: float, omega: float) -> None:
        """Command the robot, at once (`WorldRobot.send`).

        Parameters
        ----------
        v, omega : float
            Speed in m/s and turn rate in rad/s.
        """
        self._command = finite("v", v), finite("omega", omega)
        self._physics.command(*self._command)

    def accelerate(self, v_dot: float, omega_dot: float) -> None:
        """Accelerate the robot, until told else (`WorldAcceleratedRobot.accelerate`).

        Parameters
        ----------
        v_dot, omega_dot : float
            Acceleration in m/s² and rad/s².
        """
        self._command = finite("v_dot", v_dot), finite("omega_dot", omega_dot)
        self._physics.accelerate(*self._command)

    def brake(self) -> None:
        """Have a robot that takes accelerations brake (`WorldAcceleratedRobot.stop`)."""
        self._command = (0.0, 0.0)
        self._physics.brake()

    def advance(self, duration: float) -> None:
        """Let time pass; frames are taken meanwhile.

        Parameters
        ----------
        duration : float
            Time in s, not negative.

        Raises
        ------
        InputError
            If the duration is negative or not finite.
        """
        self._advance(self.t + not_negative("duration", duration))

    def truth(self) -> Truth:
        """What is true now."""
        pose = self._physics.pose()
        return Truth(
            self.t, *pose, *self._physics.velocity(), *self._command, self.view.holds(pose)
        )

    def read(self, timeout: float) -> Frame | Missing:
        """Wait for a frame (`WorldCamera.read`).

        Parameters
        ----------
        timeout : float
            Longest time to wait in s.

        Returns
        -------
        Frame or Missing
            The newest that has arrived and was not read, or why there is none.
        """
        if self.closed:
            return Missing.ENDED
        deadline = self.t + not_negative("timeout", timeout)
        while True:
            arrived = None
            while self._pending and self._pending[0].arrival <= self.t:
                arrived = self._pending.popleft()
            if arrived is not None:
                return Frame(self._develop(arrived), t=arrived.t, number=arrived.number)
            if self.t >= deadline:
                return Missing.LATE
            arrival = self._pending[0].arrival if self._pending else math.inf
            self._advance(min(arrival, deadline, self._exposure_end(self._next)))

    def picture(self) -> Image:
        """Return the pinhole camera's ideal picture of this moment, in RGB: no lens, no noise.

        It is larger than a frame if there is a distortion.
        """
        return self._render(self._physics.state())

    def _instants(self, number: int) -> list[float]:
        """Times at which a frame's renderings are taken."""
        camera = self.settings.camera
        middle = number / camera.rate
        if camera.exposure_time == 0.0:
            return [middle]
        shares = ((2 * j + 1) / (2 * _SUBFRAMES) - 0.5 for j in range(_SUBFRAMES))
        return [middle + share * camera.exposure_time for share in shares]

    def _exposure_end(self, number: int) -> float:
        return self._instants(number)[-1]

    def _advance(self, until: float) -> None:
        """Advance the physics, and take the frames that are due on the way."""
        if self.closed:
            raise InputError("the world is closed: make a new one to let time pass")
        while True:
            instants = self._instants(self._next)
            instant = instants[len(self._states)]
            if instant > until:
                break
            self._physics.advance(instant)
            self._states.append(self._physics.state())
            if len(self._states) > len(instants) // 2:
                self._record(at_least=self._next + 1)
            if len(self._states) == len(instants):
                self._take()
        self._physics.advance(until)

    def _record(self, *, at_least: int) -> None:
        """Keep the truth of the middle of the exposure, once for every frame."""
        if len(self.history) < at_least:
            self.history.append(self.truth())

    def _take(self) -> None:
        """End the exposure of a frame, and send it on its way unless it is dropped."""
        camera, number = self.settings.camera, self._next
        t = number / camera.rate
        draw = np.random.default_rng((self.settings.seed, _DROP_STREAM, number)).random()
        if draw >= camera.drop:
            arrival = t + camera.latency
            self._pending.append(_Exposure(number, t, arrival, tuple(self._states)))
        self._states.clear()
        self._next += 1

    def _develop(self, exposure: _Exposure) -> Image:
        renderings = [self._render(state) for state in exposure.states]
        return self._sensor.expose(renderings, number=exposure.number)

    def _render(self, state: NDArray[np.float64]) -> Image:
        if self._closed:
            raise InputError("the world is closed: make a new one to see something")
        if self._renderer is None:  # worlds that nobody looks at need none
            self._renderer = Renderer(self.settings, self._model, self._size)
        return self._renderer.picture(state)
