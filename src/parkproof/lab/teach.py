"""Teaching by showing: one picture of the robot where it shall park is the whole goal."""

import io
from pathlib import Path

import numpy as np

from parkproof.errors import InputError
from parkproof.lab.devices import Frame, Image
from parkproof.lab.goal import Goal, gain_range
from parkproof.lab.image_pose import TagMount, image_pose
from parkproof.lab.tag import Detection, TagDetector, Unseen, the_one
from parkproof.lab.tag_square import QUIET, SQUARE


def teach(
    frame: Frame, detector: TagDetector, mount: TagMount, *, margin: float | None = None
) -> Goal:
    """Take the goal from one frame.

    Parameters
    ----------
    frame : Frame
        Shows the robot where it shall park.
    detector : TagDetector
        Finds its tag.
    mount : TagMount
        How the tag sits on the robot.
    margin : float, optional
        Factor by which the bounds of the gains exceed what this frame lets expect; default
        `extrapolation_margin`.

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
    >>> empty = Frame(np.full((480, 640), 200, np.uint8), t=0.0, number=0)
    >>> teach(empty, TagDetector(), TagMount(tag_id=7))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: the goal frame shows no tag: ...
    """
    seen = detector.detect(frame.image)
    height, width = frame.image.shape[:2]
    found = the_one(seen, mount.tag_id)
    if isinstance(found, Unseen):
        _refuse_cut_tag(frame.image, detector, mount.tag_id)
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
        "its white margin, sharp, and with sides of about 16 px or more; print one with: "
        f"parkproof tag --id {tag_id}"
    )


def _check_whole(tag: Detection, width: int, height: int) -> None:
    """Refuse a tag that the border of the picture cuts, or its white margin."""
    whole = 1.0 + 2.0 * QUIET
    for x, y in SQUARE:
        u, v = tag.homography.project(whole * x, whole * y)
        if not (-0.5 <= u <= width - 0.5 and -0.5 <= v <= height - 0.5):
            raise _cut(tag.tag_id)


def _refuse_cut_tag(image: Image, detector: TagDetector, tag_id: int) -> None:
    """Raise if a tag that is not seen is seen once the border is made white: it is cut there.

    Finds cuts through the outer ring of cells only; for others there is the sentence of no tag.
    """
    wide = ((_PAD, _PAD), (_PAD, _PAD), (0, 0))[: image.ndim]
    padded = np.pad(image, wide, constant_values=255)
    if isinstance(detector.find(padded, tag_id), Detection):
        raise _cut(tag_id)


_PAD = 16


def _cut(tag_id: int) -> InputError:
    return InputError(
        f"the border of the goal frame cuts tag {tag_id} or its white margin: all of it must be in "
        "view; park further inside, or turn the camera"
    )


def read_picture(path: Path | str) -> Image:
    """Read a picture from a file.

    Parameters
    ----------
    path : Path or str
        A PNG, JPEG or another kind that Pillow reads.

    Returns
    -------
    array of uint8, rows × columns × 3
        Red, green, blue.

    Raises
    ------
    InputError
        If there is no such file, or it is no picture or a damaged one.

    Examples
    --------
    >>> read_picture("parked.png")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: cannot read parked.png: No such file or directory; ...
    """
    from PIL import Image as Pictures
    from PIL import UnidentifiedImageError

    damaged = (
        UnidentifiedImageError,
        Pictures.DecompressionBombError,
        Pictures.DecompressionBombWarning,
        SyntaxError,  # a broken PNG
    )
    try:
        with Pictures.open(io.BytesIO(Path(path).read_bytes())) as picture:
            if picture.mode.startswith(("I", "F")):
                raise InputError(
                    f"cannot read {path}: it has more than 8 bits a pixel; save it with 8, as the "
                    "camera gives it"
                )
            return np.asarray(picture.convert("RGB"))
    except damaged as error:
        raise InputError(
            f"cannot read {path}: no picture, or a damaged one; give a PNG or JPEG of the camera"
        ) from error
    except OSError as error:
        raise InputError(
            f"cannot read {path}: {error.strerror or 'a damaged picture'}; name a picture of the "
            "parked robot"
        ) from error
