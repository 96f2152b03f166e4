"""Teaching by showing: one picture of the robot where it shall park is the whole goal."""

from parkproof.errors import InputError
from parkproof.lab.devices import Frame
from parkproof.lab.goal import MARGIN, Goal, gain_range
from parkproof.lab.image_pose import TagMount, image_pose
from parkproof.lab.tag import QUIET, Detection, TagDetector, Unseen, the_one


def teach(frame: Frame, detector: TagDetector, mount: TagMount, *, margin: float = MARGIN) -> Goal:
    """Take the goal from one frame.

    Parameters
    ----------
    frame : Frame
        Shows the robot where it shall park.
    detector : TagDetector
        Finds its tag.
    mount : TagMount
        How the tag sits on the robot.
    margin : float
        Factor by which the bounds of the gains exceed what this frame lets expect.

    Returns
    -------
    Goal
        Where to park, and the bounds of the gains over the view.

    Raises
    ------
    InputError
        If the frame is no picture, or does not show the robot's tag whole and once.

    Examples
    --------
    >>> import numpy as np
    >>> empty = Frame(np.full((480, 640), 200, np.uint8), t=0.0, number=0)
    >>> teach(empty, TagDetector(), TagMount(tag_id=7))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: the goal frame shows no tag: ...
    """
    height, width = frame.image.shape[:2] if hasattr(frame.image, "shape") else (0, 0)
    seen = detector.detect(frame.image)
    found = the_one(seen, mount.tag_id)
    if isinstance(found, Unseen):
        raise _not_the_one(found, seen, mount.tag_id)
    _check_whole(found, width, height)
    pose = image_pose(found.homography, mount)
    unit = pose.side
    return Goal(
        u=pose.u,
        v=pose.v,
        psi=pose.psi,
        unit=unit,
        mirrored=pose.beta < 0.0,
        picture=(width, height),
        mount=mount,
        homography=found.homography.entries,
        a=pose.a / unit,
        beta=abs(pose.beta),
        gains=gain_range(found.homography, unit, (width, height), margin=margin),
    )


def _not_the_one(why: Unseen, seen: list[Detection], tag_id: int) -> InputError:
    """What the goal frame shows instead of the robot's tag, and what to do."""
    if why is Unseen.TWICE:
        return InputError(
            f"the goal frame shows tag {tag_id} more than once: each robot in view needs an id of "
            "its own; cover the others, or print another with: parkproof tag --id"
        )
    ids = sorted({detection.tag_id for detection in seen})
    if ids:
        names = ("tag " if len(ids) == 1 else "tags ") + ", ".join(map(str, ids))
        return InputError(
            f"the goal frame shows {names}, but not tag {tag_id}; name the robot's with --tag-id, "
            f"or put tag {tag_id} on the robot"
        )
    return InputError(
        f"the goal frame shows no tag: tag {tag_id} of the family 36h11 must be seen whole, with "
        "its white margin, with sides of about 16 px or more, and in focus; print one with: "
        f"parkproof tag --id {tag_id}"
    )


def _check_whole(tag: Detection, width: int, height: int) -> None:
    """Refuse a tag that the border of the picture cuts, or its white margin."""
    reach = 0.5 + QUIET
    for x, y in ((-reach, -reach), (reach, -reach), (reach, reach), (-reach, reach)):
        u, v = tag.homography.project(x, y)
        if not (-0.5 <= u <= width - 0.5 and -0.5 <= v <= height - 0.5):
            raise InputError(
                f"the border of the goal frame cuts tag {tag.tag_id} or its white margin, near "
                f"({u:.0f}, {v:.0f}) of {width} × {height} px; park further inside the view, or "
                "turn the camera"
            )
