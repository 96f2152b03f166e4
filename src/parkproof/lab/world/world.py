"""The simulated laboratory: its camera, robot and clock are those of `parkproof.lab.devices`.

Time is simulated: it passes while the camera waits for a frame, and stands still while anything is
computed. The same settings give the same frames on one machine.
"""

import math
import os
from collections import deque
from types import TracebackType
from typing import Any, NamedTuple, Self

import numpy as np

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.lab.devices import Frame, Missing, RobotLimits
from parkproof.lab.world.model import STEP, TAG_HEIGHT, placed, world_model
from parkproof.lab.world.sensor import Sensor, widening
from parkproof.lab.world.settings import WorldSettings
from parkproof.model.homography import Homography
from parkproof.model.unicycle import Pose, wrap_angle

SETTLE = 0.3
"""Time in s in which a robot that was put down comes to rest on its wheels."""

DEBIAN = "libosmesa6"
"""Debian's package for rendering without a screen."""


class Truth(NamedTuple):
    """Where the robot really is.

    Attributes
    ----------
    t : float
        Time in s.
    pose : Pose
        Of the axle's middle, on the floor.
    in_view : bool
        Whether the whole black square of its tag is in the picture.
    """

    t: float
    pose: Pose
    in_view: bool


def _mujoco() -> Any:
    """MuJoCo, with a way to render off screen."""
    require("mujoco", "cv2", "OpenGL", extra="lab", purpose="the simulated laboratory")
    if "MUJOCO_GL" not in os.environ and "DISPLAY" not in os.environ:
        os.environ["MUJOCO_GL"] = "osmesa"
    import mujoco

    return mujoco


class World:
    """A robot on a floor under a camera.

    Parameters
    ----------
    settings : WorldSettings, optional
        What it is like.

    Attributes
    ----------
    camera, robot, clock
        As `parkproof.lab.devices` has them.
    truth : list of Truth
        One at each capture, also of frames that were dropped.

    Raises
    ------
    InputError
        If pictures cannot be rendered here.
    """

    def __init__(self, settings: WorldSettings | None = None) -> None:
        self.settings = settings or WorldSettings()
        self._mujoco = _mujoco()
        camera = self.settings.camera
        xml, pictures = world_model(self.settings, widen=widening(camera))
        self._model = self._mujoco.MjModel.from_xml_string(xml, pictures)
        self._data = self._mujoco.MjData(self._model)
        rendered = tuple(int(x) for x in self._model.cam_resolution[0])
        self._renderer = self._new_renderer((rendered[0], rendered[1]))
        noise, self._drops, self._pushes = (
            np.random.default_rng([self.settings.seed, k]) for k in (2, 3, 4)
        )
        self._sensor = Sensor(camera, (rendered[0], rendered[1]), noise)
        self._wanted = (0.0, 0.0)
        self._rims = [0.0, 0.0]
        self._steps = 0
        self._captured = 0
        self._push_until, self._next_push = 0, self._time_to_push()
        self._flying: deque[Frame] = deque()
        self._origin = 0.0
        self.truth: list[Truth] = []
        self.clock = WorldClock(self)
        self.camera = WorldEye(self)
        self.robot = WorldWheels(self)
        self.to_pixels: Homography = camera.pinhole.homography(TAG_HEIGHT)
        self.place(Pose(*self.settings.start))

    def _new_renderer(self, size: tuple[int, int]) -> Any:
        try:
            return self._mujoco.Renderer(self._model, size[1], size[0])
        except (AttributeError, ImportError, RuntimeError, OSError) as error:
            raise InputError(
                "pictures cannot be rendered without a screen here "
                f"({str(error).splitlines()[0] if str(error) else type(error).__name__}); install "
                f"Debian's package {DEBIAN}: apt-get install {DEBIAN}"
            ) from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free what rendering needs. May be called twice."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    @property
    def now(self) -> float:
        """Simulated time in s."""
        return self._steps * STEP

    @property
    def pose(self) -> Pose:
        """Where the axle's middle is on the floor."""
        x, y, _, w, i, j, k = (float(value) for value in self._data.qpos[:7])
        return Pose(x, y, math.atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k)))

    def place(self, pose: Pose) -> None:
        """Put the robot down at rest; time goes on, frames in flight are lost.

        Parameters
        ----------
        pose : Pose
            On the floor.
        """
        self._mujoco.mj_resetData(self._model, self._data)
        placed(self._data.qpos[:7], *pose)
        for _ in range(round(SETTLE / STEP)):
            self._mujoco.mj_step(self._model, self._data)
        placed(self._data.qpos[:7], *pose)
        self._data.qvel[:] = 0.0
        self._wanted, self._rims = (0.0, 0.0), [0.0, 0.0]
        self._flying.clear()
        self._mujoco.mj_forward(self._model, self._data)

    def send(self, v: float, omega: float) -> None:
        """What the robot is told, from now on."""
        self._wanted = (v, omega)

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Where a point of the tag's plane is in the picture, with distortion.

        Parameters
        ----------
        x, y : float
            On the floor, in m.

        Returns
        -------
        tuple of float
            Pixel.
        """
        u, v = self.to_pixels.project(x, y)
        camera = self.settings.camera
        if not camera.distortion:
            return u, v
        width, height = camera.image_size
        fx, fy = camera.focal_length, camera.focal_length * camera.aspect
        cu, cv = 0.5 * (width - 1), 0.5 * (height - 1)
        a, b = (u - cu) / fx, (v - cv) / fy
        factor = 1.0 + camera.distortion * (a * a + b * b)
        return cu + fx * a * factor, cv + fy * b * factor

    def tag_in_view(self, pose: Pose, *, margin: float = 0.0) -> bool:
        """Whether all corners of the tag's black square are in the picture.

        Parameters
        ----------
        pose : Pose
            Of the robot on the floor.
        margin : float
            In px from the border.

        Returns
        -------
        bool
            True if they are.
        """
        robot = self.settings.robot
        width, height = self.settings.camera.image_size
        angle = pose.theta + math.radians(robot.tag_angle_deg)
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        x = pose.x + c * robot.tag_position[0] - s * robot.tag_position[1]
        y = pose.y + s * robot.tag_position[0] + c * robot.tag_position[1]
        c, s, half = math.cos(angle), math.sin(angle), 0.5 * robot.tag_side
        for i, j in ((-half, -half), (half, -half), (half, half), (-half, half)):
            px, py = x + c * i - s * j, y + s * i + c * j
            if not self.to_pixels.depth(px, py) > 0.0:
                return False
            u, v = self.pixel(px, py)
            if not (
                margin - 0.5 <= u <= width - 0.5 - margin
                and margin - 0.5 <= v <= height - 0.5 - margin
            ):
                return False
        return True

    def next_frame(self, timeout: float) -> Frame | Missing:
        """Let time pass until a frame arrives."""
        camera = self.settings.camera
        end = self._steps + max(1, round(timeout / STEP))
        while self._steps < end:
            self._advance()
            if self.now + 1e-9 >= self._captured / camera.rate:
                self._capture()
            arrived = None
            while self._flying and self._flying[0].t + camera.latency <= self.now + 1e-9:
                arrived = self._flying.popleft()
            if arrived is not None:
                return arrived
        return Missing.LATE

    def _capture(self) -> None:
        number, self._captured = self._captured, self._captured + 1
        self.truth.append(Truth(self.now, self.pose, self.tag_in_view(self.pose)))
        if self._drops.random() >= self.settings.camera.drops:
            self._flying.append(Frame(self.picture(), self.now, number))

    def picture(self) -> Any:
        """What the camera sees now: a grey picture."""
        self._renderer.update_scene(self._data, "overhead")
        return self._sensor.frame(self._renderer.render())

    def _advance(self) -> None:
        """One step of the physics."""
        robot, (v, omega) = self.settings.robot, self._wanted
        turn = 0.5 * robot.track * omega
        for i, rim in enumerate((v - turn, v + turn)):
            driven = robot.gains[i] * rim if abs(rim) >= robot.dead_band else 0.0
            self._rims[i] += (driven - self._rims[i]) * min(1.0, STEP / robot.lag)
            self._data.ctrl[i] = self._rims[i] / robot.wheel_radius
        self._push()
        self._mujoco.mj_step(self._model, self._data)
        self._steps += 1

    def _time_to_push(self) -> int:
        """Steps until the next push."""
        rate = self.settings.pushes.rate
        return round(float(self._pushes.exponential(1.0 / rate)) / STEP) if rate else -1

    def _push(self) -> None:
        pushes = self.settings.pushes
        if self._steps == self._next_push:
            angle = float(self._pushes.uniform(-math.pi, math.pi))
            size = pushes.force * float(self._pushes.uniform(0.3, 1.0))
            lever = pushes.lever * float(self._pushes.uniform(-1.0, 1.0))
            force = (size * math.cos(angle), size * math.sin(angle))
            self._data.xfrc_applied[1] = (*force, 0.0, 0.0, 0.0, lever * size)
            self._push_until = self._steps + round(pushes.duration / STEP)
            self._next_push = self._push_until + self._time_to_push() + 1
        elif self._steps == self._push_until:
            self._data.xfrc_applied[1] = 0.0


class WorldClock:
    """Simulated time."""

    def __init__(self, world: World) -> None:
        self._world = world

    def now(self) -> float:
        """Time in s."""
        return self._world.now


class WorldEye:
    """The world's camera."""

    def __init__(self, world: World) -> None:
        self._world = world

    def read(self, timeout: float) -> Frame | Missing:
        """The next frame, or that none came in this simulated time."""
        return self._world.next_frame(timeout)

    def close(self) -> None:
        """Nothing to give back."""


class WorldWheels:
    """The world's robot."""

    def __init__(self, world: World) -> None:
        self._world = world

    @property
    def limits(self) -> RobotLimits:
        """What it can do, as the program is told."""
        return self._world.settings.robot.limits

    def send(self, v: float, omega: float) -> None:
        """Drive so from now on."""
        self._world.send(v, omega)

    def stop(self) -> None:
        """Stand still."""
        self._world.send(0.0, 0.0)

    def close(self) -> None:
        """Stand still."""
        self.stop()


def image_error(world: World, pose: Pose, goal: Pose) -> tuple[float, float]:
    """How far a robot's image is from that of the goal.

    Parameters
    ----------
    world : World
        With its camera.
    pose, goal : Pose
        On the floor.

    Returns
    -------
    tuple of float
        Distance of the axle's middle in px, and of the image heading in rad.
    """
    (u, v), (p, q) = world.pixel(pose.x, pose.y), world.pixel(goal.x, goal.y)
    step = 1e-4

    def heading(at: Pose) -> float:
        x, y = step * math.cos(at.theta), step * math.sin(at.theta)
        (a, b), (c, d) = world.pixel(at.x - x, at.y - y), world.pixel(at.x + x, at.y + y)
        return math.atan2(d - b, c - a)

    return math.hypot(u - p, v - q), abs(wrap_angle(heading(pose) - heading(goal)))
