"""Why the robot's tag was never seen: what a picture shows in its place, and what to do."""

from parkproof.lab.devices import Image
from parkproof.lab.tag import Detection, TagDetector, Unseen, the_one

NAMED = 5
"""So many tags are named at most."""


def why_unseen(image: Image, tag_id: int, *, flipped: bool) -> str:
    """Say why a picture does not show the robot's tag, and what to do.

    Parameters
    ----------
    image : array of uint8
        Grey or RGB.
    tag_id : int
        The robot's tag.
    flipped : bool
        Whether tags are seen as in a mirror; see `parkproof.lab.tag.TagDetector.find`.

    Returns
    -------
    str
        A sentence; empty if the tag is there.

    Raises
    ------
    InputError
        If it is no picture.

    Examples
    --------
    >>> import numpy as np
    >>> why_unseen(np.zeros((480, 640), np.uint8), 7, flipped=False)
    'the picture shows no tag: tag 7 of the family 36h11 must be seen whole, ...
    """
    detector = TagDetector()
    seen = detector.detect(image, flipped=flipped)
    found = the_one(seen, tag_id)
    if isinstance(found, Detection):
        return ""
    if found is Unseen.TWICE:
        return (
            f"the picture shows tag {tag_id} more than once: each robot in view needs an id of its "
            "own; cover the others, or print another with: parkproof tag --id"
        )
    if isinstance(detector.find(image, tag_id, flipped=not flipped), Detection):
        return (
            f"the picture shows tag {tag_id} as in a mirror, unlike that of the goal; set the "
            "camera as it was then, or teach the goal again"
        )
    ids = sorted({detection.tag_id for detection in seen})
    if ids:
        names = ", ".join(map(str, ids[:NAMED])) + (", ..." if len(ids) > NAMED else "")
        return (
            f"the picture shows tag{'s' * (len(ids) > 1)} {names}, but not tag {tag_id}; put tag "
            f"{tag_id} on the robot, or teach the goal with another --tag-id"
        )
    return (
        f"the picture shows no tag: tag {tag_id} of the family 36h11 must be seen whole, with its "
        "white margin, sharp and well lit"
    )
