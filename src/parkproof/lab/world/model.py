"""The world as MuJoCo's own description (MJCF): floor, light, camera, robot."""

import math
from collections.abc import Iterable

import numpy as np

from parkproof.lab.world.inertia import (
    ARMATURE,
    BALLAST,
    CASTOR,
    CASTOR_MASS,
    WHEEL_MASS,
    body_box,
)
from parkproof.lab.world.settings import WorldSettings
from parkproof.lab.world.textures import (
    FLOOR_METRES,
    PLATE_CELLS,
    TAG_CELLS,
    floor_texture,
    png,
    tag_texture,
)

STEP = 0.002
"""Longest step of the physics in s."""

SERVO_GAIN = 1.0
"""Torque of a wheel's servo by its error in speed, N m s."""

_SENSOR = 1e-5
"""Size of a pixel in m; only ratios to the focal length matter."""

_FLOOR_STREAM = 1
"""Stream of the seed from which the floor is drawn."""


def _text(values: Iterable[float]) -> str:
    return " ".join(f"{value:.12g}" for value in values)


def _servo(wheel: str, settings: WorldSettings) -> str:
    """A motor that follows a speed; `Physics` frees that of a robot commanded by torque."""
    robot = settings.robot
    lag = f'dyntype="filter" dynprm="{robot.servo_time:.12g}"' if robot.servo_time else ""
    return (
        f'<general name="{wheel}" joint="{wheel}" gainprm="{SERVO_GAIN}" biastype="affine" '
        f'biasprm="0 0 {-SERVO_GAIN}" forcelimited="true" {lag} '
        f'forcerange="{_text((-robot.torque_limit, robot.torque_limit))}"/>'
    )


def _wheel(name: str, side: float, settings: WorldSettings) -> str:
    robot = settings.robot
    r = robot.wheel_radius
    # An ellipsoid touches the floor in one point: a cylinder would scrub on two edges in turns.
    return f"""
      <body name="{name}" pos="0 {side * 0.5 * robot.track:.12g} 0">
        <joint name="{name}" type="hinge" axis="0 1 0" armature="{ARMATURE:.12g}"
               frictionloss="{robot.friction_torque:.12g}"/>
        <geom type="ellipsoid" size="{_text((r, 0.3 * r, r))}" mass="{WHEEL_MASS:.12g}"
              friction="{settings.floor.friction:.12g} 0.005 0.0001" rgba="0.08 0.08 0.08 1"/>
      </body>"""


def _robot(settings: WorldSettings) -> str:
    robot = settings.robot
    r, track = robot.wheel_radius, robot.track
    top = robot.tag_height - r - 0.002  # of the body, over the axle
    bottom = -0.4 * r
    back, front, half_width = body_box(robot)
    middle, half = 0.5 * (back + front), 0.5 * (front - back)
    castor = 0.4 * r
    inertia = (
        robot.mass * (4.0 * half_width**2 + 0.03**2) / 12.0,
        robot.mass * (4.0 * half**2 + 0.03**2) / 12.0,
        robot.mass * 4.0 * (half_width**2 + half**2) / 12.0,
    )
    x, y = robot.tag_offset
    turn = (math.cos(0.5 * robot.tag_angle), 0.0, 0.0, math.sin(0.5 * robot.tag_angle))
    # The ballast lies low and behind the axle, or the robot would tip when it brakes.
    return f"""
    <body name="robot" pos="0 0 {r:.12g}">
      <freejoint/>
      <inertial pos="{-BALLAST * track:.12g} 0 {-0.2 * r:.12g}" mass="{robot.mass:.12g}"
                diaginertia="{_text(inertia)}"/>
      <geom class="shown" type="box" rgba="0.2 0.32 0.5 1"
            pos="{_text((middle, 0.0, 0.5 * (top + bottom)))}"
            size="{_text((half, half_width, 0.5 * (top - bottom)))}"/>
      <geom class="shown" type="mesh" mesh="tag" material="tag"
            pos="{_text((x, y, robot.tag_height - r))}" quat="{_text(turn)}"/>
      <geom name="castor" type="sphere" size="{castor:.12g}" condim="1" priority="1"
            pos="{_text((-CASTOR * track, 0.0, castor - r))}" mass="{CASTOR_MASS:.12g}"
            rgba="0.3 0.3 0.3 1"/>
      {_wheel("left", 1.0, settings)}
      {_wheel("right", -1.0, settings)}
    </body>"""


def world_model(
    settings: WorldSettings, *, render_size: tuple[int, int]
) -> tuple[str, dict[str, bytes]]:
    """Describe the world.

    Parameters
    ----------
    settings : WorldSettings
        The world.
    render_size : two ints
        Width and height of what the pinhole camera renders in px, centred on the picture's middle;
        larger than the picture where a barrel distortion draws in what lies outside it.

    Returns
    -------
    tuple of str and dict
        MJCF, and its pictures by name.

    Examples
    --------
    >>> text, pictures = world_model(WorldSettings(), render_size=(640, 480))
    >>> text.startswith("<mujoco"), sorted(pictures)
    (True, ['floor.png', 'tag.png'])
    """
    camera, robot, floor = settings.camera, settings.robot, settings.floor
    pictures = {
        "floor.png": png(
            floor_texture(
                brightness=floor.brightness,
                contrast=floor.contrast,
                rng=np.random.default_rng((settings.seed, _FLOOR_STREAM)),
            )
        ),
        "tag.png": png(tag_texture(robot.tag_id)),
    }
    axis_u, axis_v, _ = camera.pinhole().axes()
    width, height = render_size
    focal = (camera.focal_length * _SENSOR, camera.focal_length * camera.aspect * _SENSOR)
    s = 0.5 * robot.tag_side * PLATE_CELLS / TAG_CELLS
    # The first row of a PNG is at texture coordinate v = 0; these keep the tag from being mirrored.
    text = f"""<mujoco model="parkproof">
  <compiler angle="radian"/>
  <option timestep="{STEP}" integrator="implicitfast" cone="elliptic" impratio="10"/>
  <statistic extent="1"/>
  <visual>
    <global offwidth="{width}" offheight="{height}"/>
    <quality shadowsize="0" offsamples="4"/>
    <headlight ambient="0.5 0.5 0.5" diffuse="0 0 0" specular="0 0 0"/>
    <map znear="0.02" zfar="200"/>
  </visual>
  <default>
    <geom solref="0.005 1"/>
    <default class="shown"><geom contype="0" conaffinity="0" mass="0"/></default>
  </default>
  <asset>
    <texture name="floor" type="2d" file="floor.png"/>
    <texture name="tag" type="2d" file="tag.png"/>
    <material name="floor" texture="floor" texuniform="true"
              texrepeat="{_text((1.0 / FLOOR_METRES, 1.0 / FLOOR_METRES))}" specular="0"/>
    <material name="tag" texture="tag" specular="0"/>
    <mesh name="tag" inertia="shell" vertex="{_text((-s, -s, 0, s, -s, 0, s, s, 0, -s, s, 0))}"
          texcoord="0 1 1 1 1 0 0 0" face="0 1 2 0 2 3"/>
  </asset>
  <worldbody>
    <light type="directional" dir="0.3 0.2 -1" diffuse="0.45 0.45 0.45" specular="0 0 0"
           castshadow="false"/>
    <geom name="floor" type="plane" group="1" size="60 60 1" material="floor"
          friction="0.1 0.005 0.0001"/>
    <camera name="camera" pos="{_text((*camera.position, camera.height))}"
            xyaxes="{_text((*axis_u, *(-component for component in axis_v)))}"
            resolution="{width} {height}" focal="{_text(focal)}"
            sensorsize="{_text((width * _SENSOR, height * _SENSOR))}"/>{_robot(settings)}
  </worldbody>
  <actuator>
    {_servo("left", settings)}
    {_servo("right", settings)}
  </actuator>
</mujoco>
"""
    return text, pictures
