"""The world in MuJoCo's own format: floor, robot with its tag, camera, light."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from parkproof.lab.tag_sheet import tag_cells
from parkproof.lab.world.settings import WorldSettings

if TYPE_CHECKING:
    from numpy.typing import NDArray

STEP = 0.002
"""Step of the physics in s."""

MASS = 1.2
"""Of the robot without wheels, in kg."""

TAG_HEIGHT = 0.1
"""Of the tag's plane over the floor in m."""

CELL = 40
"""Pixels of a cell of the tag in its texture."""

QUIET_CELLS = 1
"""Width of the white margin around the tag, in cells."""

TAG_CELLS = 8
"""Cells along the black square's side."""

PATCHES = 9
"""Octaves of the floor's pattern."""


def tag_texture(tag_id: int) -> "NDArray[np.uint8]":
    """The tag with its white margin, as a grey picture, upright.

    Parameters
    ----------
    tag_id : int
        Which one.

    Returns
    -------
    array
        Rows × columns.
    """
    framed = np.pad(tag_cells(tag_id), QUIET_CELLS, constant_values=True)
    return np.repeat(np.repeat(np.where(framed, 255, 0).astype(np.uint8), CELL, 0), CELL, 1)


def floor_texture(seed: int, size: int = 512) -> "NDArray[np.uint8]":
    """Smooth random spots in muted grey.

    Parameters
    ----------
    seed : int
        Of the pattern.
    size : int
        Rows and columns.

    Returns
    -------
    array
        Rows × columns.
    """
    import cv2

    rng = np.random.default_rng([seed, 1])
    total = np.zeros((size, size), np.float32)
    for octave in range(2, PATCHES):
        small = rng.standard_normal((2**octave, 2**octave)).astype(np.float32)
        total += cv2.resize(small, (size, size), interpolation=cv2.INTER_CUBIC) / octave
    total /= float(np.abs(total).max())
    return np.asarray(np.clip(150.0 + 45.0 * total, 0.0, 255.0), np.uint8)


def _png(picture: "NDArray[np.uint8]") -> bytes:
    import cv2

    return bytes(cv2.imencode(".png", picture)[1].tobytes())


def world_model(settings: WorldSettings, *, widen: float = 1.0) -> tuple[str, dict[str, bytes]]:
    """MuJoCo's description of a world, and its pictures by name.

    Parameters
    ----------
    settings : WorldSettings
        The world.
    widen : float
        By how much the rendered picture is wider than the camera's, for distortion.

    Returns
    -------
    tuple
        XML, and the contents of the files that it names.
    """
    robot, camera = settings.robot, settings.camera
    width, height = (math.ceil(widen * size / 2) * 2 for size in camera.image_size)
    axis_u, axis_v, _ = camera.pinhole.axes
    axes = " ".join(f"{x:.12g}" for x in (*axis_u, *(-x for x in axis_v)))
    fx, fy = camera.focal_length, camera.focal_length * camera.aspect
    r, half = robot.wheel_radius, 0.5 * robot.track
    quad = 0.5 * robot.tag_side * (1.0 + 2.0 * QUIET_CELLS / TAG_CELLS)
    x, y = robot.tag_position
    wheels = "".join(
        f"""
      <body name="{name}" pos="0 {side * half:.6g} {r:.6g}">
        <joint name="{name}" axis="0 1 0" armature="5e-4"
               frictionloss="{robot.friction_torque:.6g}"/>
        <geom type="ellipsoid" size="{r:.6g} 0.006 {r:.6g}" euler="0 0 0" mass="0.05"
              friction="1 0.005 0.0001" rgba="0.12 0.12 0.13 1"/>
      </body>"""
        for name, side in (("left", 1.0), ("right", -1.0))
    )
    actuators = "".join(
        f'<velocity name="{name}" joint="{name}" kv="0.2" '
        f'forcerange="{-robot.max_torque:.6g} {robot.max_torque:.6g}"/>'
        for name in ("left", "right")
    )
    px, py = camera.position
    xml = f"""
<mujoco model="parkproof">
  <compiler angle="radian"/>
  <option timestep="{STEP}" integrator="implicitfast" cone="elliptic"/>
  <visual>
    <global offwidth="{width}" offheight="{height}"/>
    <quality shadowsize="0" offsamples="0"/>
    <headlight ambient="0.75 0.75 0.75" diffuse="0.2 0.2 0.2" specular="0 0 0"/>
    <map znear="0.005" zfar="20"/>
  </visual>
  <asset>
    <texture name="floor" type="2d" file="floor.png"/>
    <material name="floor" texture="floor" texrepeat="1 1" specular="0"/>
    <texture name="tag" type="2d" file="tag.png"/>
    <material name="tag" texture="tag" specular="0" shininess="0"/>
    <mesh name="tag" inertia="shell"
          vertex="{-quad:.8g} {-quad:.8g} 0  {quad:.8g} {-quad:.8g} 0
                  {quad:.8g} {quad:.8g} 0  {-quad:.8g} {quad:.8g} 0"
          texcoord="0 1 1 1 1 0 0 0" face="0 1 2 0 2 3"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="4 4 0.1" material="floor" friction="1 0.005 0.0001"/>
    <camera name="overhead" pos="{px:.12g} {py:.12g} {camera.height:.12g}" xyaxes="{axes}"
            resolution="{width} {height}" focalpixel="{fx:.12g} {fy:.12g}" principalpixel="0 0"
            sensorsize="{width * 1e-5:.12g} {height * 1e-5:.12g}"/>
    <body name="robot" pos="0 0 0">
      <freejoint name="robot"/>
      <geom name="chassis" type="box" pos="-0.01 0 0.06" size="0.085 {half - 0.012:.6g} 0.03"
            mass="{0.4 * MASS:.6g}" rgba="0.22 0.33 0.42 1"/>
      <geom name="ballast" type="box" pos="-0.02 0 0.03" size="0.05 0.04 0.012"
            mass="{0.6 * MASS:.6g}" rgba="0.2 0.2 0.2 1"/>
      <geom name="castor" type="sphere" pos="-0.075 0 0.012" size="0.012" mass="0.02" condim="1"
            priority="1" rgba="0.3 0.3 0.3 1"/>
      <geom name="tag" type="mesh" mesh="tag" material="tag" contype="0" conaffinity="0" mass="0"
            pos="{x:.8g} {y:.8g} {TAG_HEIGHT:.8g}"
            euler="0 0 {math.radians(robot.tag_angle_deg):.10g}"/>{wheels}
    </body>
  </worldbody>
  <actuator>{actuators}</actuator>
</mujoco>"""
    pictures = {
        "floor.png": _png(floor_texture(settings.seed)),
        "tag.png": _png(tag_texture(robot.tag_id)),
    }
    return xml, pictures


def placed(robot: Any, x: float, y: float, theta: float) -> None:
    """Put the robot's joint at a pose on the floor, upright.

    Parameters
    ----------
    robot : array of 7 floats
        Position and quaternion, changed in place.
    x, y, theta : float
        The pose.
    """
    robot[:] = (x, y, 0.0, math.cos(0.5 * theta), 0.0, 0.0, math.sin(0.5 * theta))
