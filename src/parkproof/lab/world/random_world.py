"""Random worlds from a seed: any camera over the floor, a goal and starts in its view."""

import math

import msgspec
import numpy as np

from parkproof.errors import InputError
from parkproof.lab.world.camera_settings import CameraSettings
from parkproof.lab.world.pushes import PushSettings
from parkproof.lab.world.robot_settings import LAST_TAG, RobotSettings
from parkproof.lab.world.settings import FloorPose, WorldSettings
from parkproof.lab.world.view import TagView
from parkproof.validate import whole_number

TAG_PIXELS = (20.0, 60.0)
"""Side of the tag at the goal and at the starts."""

GOAL_SHARE, START_SHARE = 0.6, 0.85
"""Share of the picture's width and height, around its middle, in which goals and starts lie."""

VIEW_MARGIN = 12.0
"""Least distance in px from the tag's white plate to the border, at the goal and at the starts."""

LEAST_DISTANCE = 3.0
"""From start to goal, in tag sides."""

_TRIES = 10_000


def random_world(seed: int, *, start: int = 0, hard: bool = False) -> WorldSettings:
    """Draw a world: camera and goal from the seed, all else from the seed and the start's number.

    Tilt to 35°, any roll and pan, pixel aspect 0.8 to 1.25, focal length 500 to 900 px, the height
    such that the tag's side is 20 to 60 px; 30 frames/s with a latency of 66 ms, noise and blur;
    motor gains within ±30 % for each wheel, a dead-band, a tag off the axle and turned, pushes.

    Parameters
    ----------
    seed : int
        Names the camera, its goal and its tag.
    start : int
        Number of the start under this camera: another pose, other motors, other pushes.
    hard : bool
        Whether 10 % of the frames are dropped, the latency is 150 ms and k1 = −0.15.

    Returns
    -------
    WorldSettings
        The world.

    Raises
    ------
    InputError
        If a seed is no whole number, or negative.

    Examples
    --------
    >>> first, second = random_world(3), random_world(3, start=1)
    >>> first.camera == second.camera, first.goal == second.goal, first.start == second.start
    (True, True, False)
    >>> random_world(3, hard=True).camera.drop
    0.1
    """
    for name, value in (("seed", seed), ("start", start)):
        whole_number(name, value)
    rng = np.random.default_rng((seed, 0))
    robot = RobotSettings(
        tag_id=int(rng.integers(0, LAST_TAG + 1)),
        tag_offset=(rng.uniform(-0.03, 0.03), rng.uniform(-0.02, 0.02)),
        tag_angle=rng.uniform(-math.pi, math.pi),
        dead_band=0.25,
    )
    camera = _camera(rng, robot, hard=hard)
    world = WorldSettings(camera=camera, robot=robot)
    view = TagView(world)
    goal = _pose(rng, view, camera.image_size, share=GOAL_SHARE)
    own = np.random.default_rng((seed, 1, start))
    pose = _pose(own, view, camera.image_size, share=START_SHARE, away_from=goal)
    gains = (own.uniform(0.7, 1.3), own.uniform(0.7, 1.3))
    return WorldSettings(
        camera=camera,
        robot=msgspec.structs.replace(robot, motor_gains=gains),
        pushes=PushSettings(force=2.0, duration=0.2, rate=0.5),
        start=pose,
        goal=goal,
        seed=int(own.integers(0, 2**31)),
    )


def _camera(rng: np.random.Generator, robot: RobotSettings, *, hard: bool) -> CameraSettings:
    focal_length = rng.uniform(500.0, 900.0)
    aspect = math.exp(rng.uniform(math.log(0.8), math.log(1.25)))
    tilt = math.radians(rng.uniform(0.0, 35.0))
    pan, roll = rng.uniform(-180.0, 180.0, size=2).tolist()
    # Side of the tag in the middle of the picture: s √(f_x f_y cos tilt)/depth.
    side = rng.uniform(*TAG_PIXELS)
    depth = robot.tag_side * focal_length * math.sqrt(aspect * math.cos(tilt)) / side
    # The optical axis meets the floor near its origin.
    ahead = depth * math.sin(tilt)
    x, y = rng.uniform(-0.5, 0.5, size=2).tolist()
    heading = math.radians(pan)
    return CameraSettings(
        position=(x + ahead * math.sin(heading), y - ahead * math.cos(heading)),
        height=robot.tag_height + depth * math.cos(tilt),
        tilt_deg=math.degrees(tilt),
        roll_deg=roll,
        pan_deg=pan,
        focal_length=focal_length,
        aspect=aspect,
        exposure=rng.uniform(0.7, 1.1),
        noise=rng.uniform(1.0, 4.0),
        blur=rng.uniform(0.3, 0.8),
        k1=-0.15 if hard else 0.0,
        latency=0.150 if hard else 0.066,
        drop=0.1 if hard else 0.0,
    )


def _pose(
    rng: np.random.Generator,
    view: TagView,
    image_size: tuple[int, int],
    *,
    share: float,
    away_from: FloorPose | None = None,
) -> FloorPose:
    """Draw a pose with the whole tag in view, at a size that the detector likes."""
    width, height = image_size
    low, high = 0.5 * (1.0 - share), 0.5 * (1.0 + share)
    for _ in range(_TRIES):
        x, y = view.to_floor(width * rng.uniform(low, high), height * rng.uniform(low, high))
        theta = rng.uniform(-math.pi, math.pi)
        # So far the tag's place; the axle's follows from how the tag is mounted.
        there = view.tag_centre((0.0, 0.0, theta))
        pose = (x - there[0], y - there[1], theta)
        near = away_from is not None and (
            math.dist(pose[:2], away_from[:2]) < LEAST_DISTANCE * view.tag_side
        )
        if (
            not near
            and view.holds(pose, margin=VIEW_MARGIN, plate=True)
            and TAG_PIXELS[0] <= view.size(pose) <= TAG_PIXELS[1]
        ):
            return pose
    raise InputError("no pose of the robot is in view of this camera; take another seed")
