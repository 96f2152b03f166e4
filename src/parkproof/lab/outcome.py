"""How a run of the laboratory ended."""

import enum


class LabOutcome(enum.Enum):
    """How a run of the laboratory ended.

    Examples
    --------
    >>> LabOutcome.REFUSED.sentence
    'Refused before it moved: no course from the start stays inside the picture.'
    """

    PARKED = "parked"
    REFUSED = "refused"
    GAVE_UP = "gave up"
    STILL_MOVING = "still moving"
    NEVER_SEEN = "never seen"
    CAMERA_ENDED = "camera ended"
    ROBOT_SILENT = "robot silent"
    INTERRUPTED = "interrupted"

    @property
    def sentence(self) -> str:
        """In words."""
        return _SENTENCES[self]


_SENTENCES = {
    LabOutcome.PARKED: "Parked, and held there.",
    LabOutcome.REFUSED: (
        "Refused before it moved: no course from the start stays inside the picture."
    ),
    LabOutcome.GAVE_UP: "Stopped on the way, and given up.",
    LabOutcome.STILL_MOVING: "The time ran out before the robot was parked and held.",
    LabOutcome.NEVER_SEEN: "The robot's tag was never seen, and the robot did not move.",
    LabOutcome.CAMERA_ENDED: "The camera ended; the robot was stopped.",
    LabOutcome.ROBOT_SILENT: "The robot does not answer.",
    LabOutcome.INTERRUPTED: "Interrupted; the robot was stopped.",
}
