"""The robot on the floor: MuJoCo stepped to given times, with motors as they really are."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.lab.world.inertia import nominal_drive
from parkproof.lab.world.model import SERVO_GAIN, STEP
from parkproof.lab.world.pushes import Pushes
from parkproof.lab.world.settings import FloorPose, WorldSettings

_SETTLING = 1.0
"""Time in s in which the robot comes to rest on its wheels when the world is made."""

_CLOSE = 1e-9
"""Times nearer than this are the same."""


class Physics:
    """Motion of the robot: commands in, true pose out.

    Parameters
    ----------
    settings : WorldSettings
        The world.
    model : mujoco.MjModel
        Its model (`parkproof.lab.world.model.world_model`).

    Attributes
    ----------
    t : float
        Simulated time in s.
    axle_height : float
        Height of the axle over the floor at rest in m.

    Examples
    --------
    >>> from parkproof.lab.world.model import world_model
    >>> from parkproof.lab.world.opengl import load_mujoco
    >>> settings = WorldSettings(start=(0.0, 0.0, 0.0))
    >>> text, pictures = world_model(settings, render_size=(640, 480))
    >>> physics = Physics(settings, load_mujoco().MjModel.from_xml_string(text, pictures))
    >>> physics.command(0.2, 0.0)
    >>> physics.advance(1.0)
    >>> 0.17 < physics.pose()[0] < 0.2
    True
    """

    def __init__(self, settings: WorldSettings, model: Any) -> None:
        import mujoco

        self._mujoco = mujoco
        self._settings = settings
        self._model = model
        self._data = mujoco.MjData(model)
        self._robot = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "robot")
        self._drive = nominal_drive(settings.robot)
        self._pushes = Pushes(settings.pushes, settings.seed)
        self.t = 0.0
        mujoco.mj_step(model, self._data, nstep=round(_SETTLING / STEP))
        self._rest: NDArray[np.float64] = self._data.qpos.copy()
        self.axle_height = float(self._rest[2])
        self.place(settings.start)

    def place(self, pose: FloorPose) -> None:
        """Put the robot somewhere, at rest, with its wheels commanded to stand.

        Parameters
        ----------
        pose : three floats
            x, y in m and θ in rad.
        """
        data = self._data
        self._mujoco.mj_resetData(self._model, data)
        x, y, theta = pose
        data.qpos[:] = self._rest
        data.qpos[0:2] = x, y
        # The settled attitude, its own small yaw taken out, turned to θ.
        turn = theta - _yaw(self._rest[3:7])
        self._mujoco.mju_mulQuat(
            data.qpos[3:7],
            np.array([math.cos(0.5 * turn), 0.0, 0.0, math.sin(0.5 * turn)]),
            self._rest[3:7],
        )
        self._mujoco.mj_forward(self._model, data)
        if self._settings.robot.commanded_by == "torque":
            self.brake()

    def command(self, v: float, omega: float) -> None:
        """Set the wheels' speeds: through each motor's gain error, then the dead-band.

        Parameters
        ----------
        v, omega : float
            Commanded speed in m/s and turn rate in rad/s.
        """
        robot = self._settings.robot
        limit = robot.wheel_speed_limit
        for i, nominal in enumerate(robot.wheel_speeds(v, omega)):
            speed = nominal * robot.motor_gains[i]
            turns = abs(speed) >= robot.dead_band
            self._data.ctrl[i] = min(max(speed, -limit), limit) if turns else 0.0

    def accelerate(self, v_dot: float, omega_dot: float) -> None:
        """Set the wheels' torques: nominal ones for an acceleration, through each motor's gain.

        Parameters
        ----------
        v_dot, omega_dot : float
            Commanded acceleration in m/s² and rad/s².
        """
        gains = self._settings.robot.motor_gains
        right, left = self._drive.wheel_torques(v_dot, omega_dot)
        self._data.ctrl[:] = gains[0] * left, gains[1] * right
        self._model.actuator_biasprm[:, 2] = 0.0  # the speed of the wheel does not count

    def brake(self) -> None:
        """Have the motors hold the wheels still at once, as strongly as they can."""
        self._data.ctrl[:] = 0.0
        self._data.act[:] = 0.0  # also where torques come with a lag
        self._model.actuator_biasprm[:, 2] = -SERVO_GAIN

    def advance(self, until: float) -> None:
        """Let time pass.

        Parameters
        ----------
        until : float
            Time in s up to which to go, exactly; one that has passed changes nothing.
        """
        while self.t < until:
            push = self._pushes.next_after(self.t)
            force = self._data.xfrc_applied[self._robot]
            force[:] = 0.0
            stop = until
            if push is not None and push.start <= self.t:
                force[:] = push.force_x, push.force_y, 0.0, 0.0, 0.0, push.torque
                stop = min(until, push.end)
            elif push is not None:
                stop = min(until, push.start)
            self._step(stop - self.t)
            self.t = stop

    def _step(self, gap: float) -> None:
        """Advance by equal steps, so that events fall between steps."""
        if gap > _CLOSE:
            count = math.ceil(gap / STEP - 1e-6)
            self._model.opt.timestep = gap / count
            self._mujoco.mj_step(self._model, self._data, nstep=count)

    def state(self) -> NDArray[np.float64]:
        """Return a copy of the generalised positions, from which a picture can be rendered."""
        positions: NDArray[np.float64] = self._data.qpos.copy()
        return positions

    def pose(self) -> FloorPose:
        """True x, y of the middle of the axle in m, and θ in (−π, π]."""
        q = self._data.qpos
        return float(q[0]), float(q[1]), _yaw(q[3:7])

    def velocity(self) -> tuple[float, float]:
        """Speed along the heading in m/s, and turn rate in rad/s."""
        x, y = self._data.qvel[0:2]
        theta = _yaw(self._data.qpos[3:7])
        return float(x * math.cos(theta) + y * math.sin(theta)), float(self._data.qvel[5])


def _yaw(quaternion: NDArray[np.float64]) -> float:
    w, x, y, z = (float(component) for component in quaternion)
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
