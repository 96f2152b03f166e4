"""Random laboratories from a seed: any camera, any goal and start in its picture."""

import math
from typing import Any

import numpy as np

from parkproof.errors import InputError
from parkproof.lab.world.model import TAG_HEIGHT
from parkproof.lab.world.settings import Pushes, WorldCamera, WorldRobot, WorldSettings
from parkproof.model.homography import Homography
from parkproof.model.image_unicycle import image_of
from parkproof.model.unicycle import Pose

TILT_DEG = 35.0
"""Largest tilt of a camera."""

ASPECT = (0.8, 1.25)
"""Range of pixel aspects."""

TAG_PX = (20.0, 60.0)
"""Range of the tag's side in px."""

FOCAL = (450.0, 950.0)
"""Range of focal lengths in px."""

MOTOR_ERROR = 0.3
"""Largest error of each wheel's gain."""

EDGE_PX = 12.0
"""Goal and start keep the tag so far from the border."""

HARD_LATENCY, HARD_DROPS, HARD_DISTORTION = 0.15, 0.1, -0.15
"""What makes a hard world hard."""

TRIES = 10_000
"""Draws until a pose in view is found; a few suffice."""


def random_world(seed: int, *, start: int = 0, hard: bool = False) -> WorldSettings:
    """A random camera above a random robot, with a goal and a start in view.

    Parameters
    ----------
    seed : int
        Of camera, robot and goal.
    start : int
        Which start for that camera.
    hard : bool
        With a tenth of the frames dropped, 150 ms latency and a distorting lens.

    Returns
    -------
    WorldSettings
        The world.

    Examples
    --------
    >>> one, two = random_world(5), random_world(5, start=1)
    >>> one.camera == two.camera, one.start == two.start
    (True, False)
    """
    rng = np.random.default_rng([seed, 10])
    robot = WorldRobot(
        gains=(_between(rng, (0.7, 1.3)), _between(rng, (0.7, 1.3))),
        dead_band=_between(rng, (0.004, 0.01)),
    )
    for _ in range(TRIES):
        camera = _camera(rng, robot.tag_side, hard=hard)
        if camera is not None:
            break
    else:  # pragma: no cover  (a third of all draws succeed)
        raise InputError(f"seed = {seed}: no camera was found; take another seed")
    goal = _pose(rng, camera, robot)
    from_here = np.random.default_rng([seed, 11, start])
    return WorldSettings(
        camera=camera,
        robot=robot,
        pushes=Pushes(),
        goal=goal,
        start=_pose(from_here, camera, robot),
        seed=1000 * seed + start,
    )


def _between(rng: np.random.Generator, ends: tuple[float, float]) -> float:
    return float(f"{rng.uniform(*ends):.4g}")


def _camera(rng: np.random.Generator, side: float, *, hard: bool) -> WorldCamera | None:
    """A camera, or None if its picture would hold the horizon or fold."""
    focal, tag = _between(rng, FOCAL), _between(rng, (TAG_PX[0] + 4.0, TAG_PX[1] - 6.0))
    more: dict[str, Any] = (
        {"latency": HARD_LATENCY, "drops": HARD_DROPS, "distortion": HARD_DISTORTION}
        if hard
        else {}
    )
    try:
        camera = WorldCamera(
            height=float(f"{focal * side / tag + TAG_HEIGHT:.4g}"),
            focal_length=focal,
            tilt_deg=_between(rng, (0.0, TILT_DEG)),
            roll_deg=_between(rng, (-180.0, 180.0)),
            pan_deg=_between(rng, (-180.0, 180.0)),
            aspect=_between(rng, ASPECT),
            **more,
        )
    except InputError:
        return None
    floor = camera.pinhole.homography(TAG_HEIGHT).inverse()
    seen = all(floor.depth(*corner) > 0.0 for corner in camera.pinhole.corners())
    return camera if seen else None


def _pose(
    rng: np.random.Generator, camera: WorldCamera, robot: WorldRobot
) -> tuple[float, float, float]:
    """A pose whose tag is well inside the picture and of the right size."""
    to_pixels = camera.pinhole.homography(TAG_HEIGHT)
    to_floor = to_pixels.inverse()
    width, height = camera.image_size
    for _ in range(TRIES):
        u, v = rng.uniform(0.0, width - 1.0), rng.uniform(0.0, height - 1.0)
        heading = _between(rng, (-math.pi, math.pi))
        x, y = (float(f"{value:.4g}") for value in to_floor.project(float(u), float(v)))
        pose = Pose(x, y, heading)
        if _well_seen(to_pixels, pose, camera, robot):
            return (x, y, heading)
    raise InputError(
        "the camera's picture has no room for the robot's tag; take a shorter focal length or a "
        "smaller tag"
    )


def _well_seen(to_pixels: Homography, pose: Pose, camera: WorldCamera, robot: WorldRobot) -> bool:
    """Whether the tag, centred over the axle, is whole in the picture, with sides in range."""
    image = image_of(to_pixels, pose)
    sideways = image_of(to_pixels, Pose(pose.x, pose.y, pose.theta + 0.5 * math.pi))
    sizes = (image.a * robot.tag_side, sideways.a * robot.tag_side)
    if not all(TAG_PX[0] <= size <= TAG_PX[1] for size in sizes):
        return False
    reach = EDGE_PX + 0.75 * max(sizes)
    x, y = image.pose[:2]
    width, height = camera.image_size
    return reach <= x <= width - 1.0 - reach and reach <= y <= height - 1.0 - reach
