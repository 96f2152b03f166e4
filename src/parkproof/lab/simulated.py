"""A run in the simulated laboratory: the goal is shown, the robot put at its start, and parked."""

import math
from dataclasses import dataclass

import msgspec

from parkproof.lab.devices import Frame
from parkproof.lab.goal import Goal
from parkproof.lab.loop import Finished, Watch, run_lab
from parkproof.lab.record import Recorder
from parkproof.lab.safety import SafetyLimits
from parkproof.lab.settings import LabSettings
from parkproof.lab.summary import Error
from parkproof.lab.tag import TagDetector
from parkproof.lab.teach import teach
from parkproof.lab.world.world import World, image_error
from parkproof.model.unicycle import Pose, wrap_angle


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
    """Put the robot at its goal, take a picture, and the goal from it; then put it at its start.

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
        If the picture does not show the robot's tag whole.
    """
    settings = world.settings
    world.place(Pose(*settings.goal))
    frame = Frame(world.picture(), t=world.now, number=0)
    goal = teach(frame, TagDetector(), settings.robot.mount)
    world.place(Pose(*settings.start))
    return goal


def run_simulated(
    world: World,
    goal: Goal,
    *,
    settings: LabSettings,
    safety: SafetyLimits | None = None,
    recorder: Recorder | None = None,
    watch: Watch = lambda *_: None,
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

    Returns
    -------
    Judged
        The run with its true errors.
    """
    world.truth.clear()
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
    unseen = sum(not truth.in_view for truth in world.truth)
    run.frames = msgspec.structs.replace(run.frames, out_of_view=unseen)
    wanted, found = Pose(*world.settings.goal), world.pose
    held = [truth.pose for truth in world.truth if truth.t >= (run.parked_at or math.inf)]
    errors = [image_error(world, pose, wanted) for pose in [*held, found]]
    return Judged(
        run,
        image_error=Error(distance=errors[-1][0], heading_deg=math.degrees(errors[-1][1])),
        true_error=Error(
            distance=math.dist(found[:2], wanted[:2]),
            heading_deg=math.degrees(abs(wrap_angle(found.theta - wanted.theta))),
        ),
        worst_image_error=Error(
            distance=max(error[0] for error in errors),
            heading_deg=math.degrees(max(error[1] for error in errors)),
        ),
        floor_width=floor_width(world),
    )


def floor_width(world: World) -> float:
    """How much of the plane of the tag the picture shows across its middle, in m.

    Parameters
    ----------
    world : World
        The laboratory.

    Returns
    -------
    float
        Distance between the images of the middles of its left and right border.
    """
    width, height = world.settings.camera.image_size
    floor = world.to_pixels.inverse()
    middle = 0.5 * (height - 1)
    return math.dist(floor.project(0.0, middle), floor.project(width - 1.0, middle))
