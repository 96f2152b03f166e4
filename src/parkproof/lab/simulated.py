"""A run in the simulated laboratory: the goal is shown, the robot put at its start, and parked."""

import math
from dataclasses import dataclass

import msgspec

from parkproof.errors import InputError
from parkproof.lab.devices import Missing
from parkproof.lab.goal import Goal
from parkproof.lab.loop import Finished, Watch, run_lab
from parkproof.lab.record import Recorder
from parkproof.lab.safety import SafetyLimits
from parkproof.lab.settings import LabSettings
from parkproof.lab.summary import Error
from parkproof.lab.tag import TagDetector
from parkproof.lab.teach import teach
from parkproof.lab.world.settings import FloorPose
from parkproof.lab.world.world import World
from parkproof.model.unicycle import wrap_angle

STEP = 1e-4
"""Half the length in m of the stroke by which a heading in the picture is measured."""

STROKE = 0.01
"""The same in px for a heading on the floor."""


@dataclass(frozen=True)
class Judged:
    """A run with what the simulated world knows of it.

    Attributes
    ----------
    run : Finished
        The run.
    image_error, true_error : Error
        At the end, in px, and in m on the floor.
    worst_image_error : Error
        The largest while the robot was parked and held, or at the end if it was not.
    floor_width : float
        How much of the floor's plane of the tag the picture shows across its middle, in m.
    """

    run: Finished
    image_error: Error
    true_error: Error
    worst_image_error: Error
    floor_width: float


def shown_goal(world: World) -> Goal:
    """Put the robot at its goal, take a frame, and the goal from it; then put it at its start.

    Parameters
    ----------
    world : World
        The laboratory.

    Returns
    -------
    Goal
        The goal.

    Raises
    ------
    InputError
        If the frame does not show the robot's tag whole.
    """
    settings = world.settings
    world.place(settings.goal)
    frame = world.camera.read(1.0)
    while isinstance(frame, Missing):  # of a camera that drops frames, the first that comes
        frame = world.camera.read(1.0)
    goal = teach(frame, TagDetector(), settings.robot.mount())
    world.place(settings.start)
    return goal


def run_simulated(
    world: World,
    goal: Goal,
    *,
    settings: LabSettings,
    safety: SafetyLimits | None = None,
    recorder: Recorder | None = None,
    watch: Watch = lambda *_: None,
    wanted: FloorPose | None = None,
) -> Judged:
    """Park in a simulated laboratory.

    Parameters
    ----------
    world : World
        The laboratory, the robot at its start.
    goal : Goal
        As the camera showed it.
    settings, safety, recorder, watch
        See `parkproof.lab.loop.run_lab`.
    wanted : three floats, optional
        Where on the floor it shall park, by which it is judged; default the world's goal.

    Returns
    -------
    Judged
        The run with its true errors.
    """
    first = len(world.history)
    run = run_lab(
        world.camera,
        world.robot,
        world.clock,
        goal,
        settings=settings,
        safety=safety,
        recorder=recorder,
        watch=watch,
        realtime=False,
    )
    seen = world.history[first:]
    unseen = sum(not truth.in_view for truth in seen)
    run.frames = msgspec.structs.replace(run.frames, out_of_view=unseen)
    found, wanted = world.truth().pose, wanted or world.settings.goal
    held = [truth.pose for truth in seen if truth.t >= (run.parked_at or math.inf)]
    errors = [image_error(world, pose, wanted) for pose in [*held, found]]
    return Judged(
        run,
        image_error=errors[-1],
        true_error=Error(
            distance=math.dist(found[:2], wanted[:2]),
            heading_deg=math.degrees(abs(wrap_angle(found[2] - wanted[2]))),
        ),
        worst_image_error=Error(
            distance=max(error.distance for error in errors),
            heading_deg=max(error.heading_deg for error in errors),
        ),
        floor_width=world.view.width_across(),
    )


def floor_pose(world: World, goal: Goal) -> FloorPose:
    """Where on the floor a robot is whose image is a goal's.

    Parameters
    ----------
    world : World
        With its camera and lens.
    goal : Goal
        As a picture of this camera showed it.

    Returns
    -------
    three floats
        x and y of the middle of the axle in m, and θ in rad.
    """
    x, y = world.view.to_floor(goal.u, goal.v)
    du, dv = STROKE * math.cos(goal.psi), STROKE * math.sin(goal.psi)
    (p, q), (r, s) = (world.view.to_floor(goal.u + k * du, goal.v + k * dv) for k in (-1.0, 1.0))
    return x, y, math.atan2(s - q, r - p)


def image_error(world: World, pose: FloorPose, goal: FloorPose) -> Error:
    """How far a robot's image is from that of the goal.

    Parameters
    ----------
    world : World
        With its camera and lens.
    pose, goal : three floats
        On the floor.

    Returns
    -------
    Error
        Distance of the axle's middle in px, and of the image headings.

    Raises
    ------
    InputError
        If one of them is not before the camera.
    """
    (u, v, psi), (p, q, chi) = (_image(world, place) for place in (pose, goal))
    return Error(
        distance=math.hypot(u - p, v - q), heading_deg=math.degrees(abs(wrap_angle(psi - chi)))
    )


def _image(world: World, pose: FloorPose) -> tuple[float, float, float]:
    """Image of the axle's middle, and image heading, with the lens's distortion."""
    x, y, theta = pose
    dx, dy = STEP * math.cos(theta), STEP * math.sin(theta)
    middle, behind, before = (world.view.appears(x + k * dx, y + k * dy) for k in (0.0, -1.0, 1.0))
    if middle is None or behind is None or before is None:
        raise InputError(f"pose = {pose}: has no image; the robot drove out of the camera's reach")
    return *middle, math.atan2(before[1] - behind[1], before[0] - behind[0])
