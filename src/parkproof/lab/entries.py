"""What happens in a run of the laboratory, one entry at a time: as it is recorded and read back.

Times are seconds on the loop's clock, kept to the last bit, so that a run can be gone through again
exactly.
"""

import json
from dataclasses import dataclass

import msgspec

from parkproof.lab.devices import Frame, Missing

STEP_NAMES = {0: "turn", 1: "run-up", 2: "approach", 3: "return", 4: "hold"}
"""What the steps of a law are called."""


@dataclass(frozen=True, eq=False)
class Taken:
    """A frame came.

    Attributes
    ----------
    frame : Frame
        The picture as the loop got it, to the last bit.
    arrived : float
        When it came, in s.
    lost : bool
        Whether the picture could not be recorded in time; it is black then.
    """

    frame: Frame
    arrived: float
    lost: bool = False


class Missed(msgspec.Struct, frozen=True, kw_only=True, tag="missing"):
    """No frame came.

    Attributes
    ----------
    t : float
        When that was clear, in s.
    reason : Missing
        Why.
    """

    t: float
    reason: Missing


class Measured(msgspec.Struct, frozen=True, kw_only=True, tag="measured"):
    """What was made of a frame.

    Attributes
    ----------
    t : float
        Time of capture of the frame, in s.
    image : tuple of 5 floats or None
        The image pose (u, v, ψ) in px and rad, β, and a in px/m or relative; None if the tag was
        not seen.
    corners : tuple of 4 pairs or None
        The tag's corners in px.
    estimate, prediction : tuple of 3 floats or None
        (x0, x1, ψ) in the goal frame, at ``t`` and at ``predicted_for``.
    predicted_for : float or None
        For when the prediction is, in s.
    """

    t: float
    image: tuple[float, float, float, float, float] | None = None
    corners: tuple[tuple[float, float], ...] | None = None
    estimate: tuple[float, float, float] | None = None
    prediction: tuple[float, float, float] | None = None
    predicted_for: float | None = None


class Commanded(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, tag="command"):
    """A command was sent.

    Attributes
    ----------
    t : float
        When, in s.
    v, omega : float
        Speed in m/s and turn rate in rad/s; those that a robot that takes accelerations is taken
        to have.
    step : int
        The step that the law was in; see `STEP_NAMES`.
    accelerations : two floats or None
        v̇ in m/s² and ω̇ in rad/s² for a robot that takes them; None if it was told to brake, and
        for one that takes velocities.
    asked : two floats or None
        What the law asked where the watchdog sent something else: v and ω, or v̇ and ω̇.
    halted : float or None
        When the robot was stopped unasked since the command before, in s.
    """

    t: float
    v: float
    omega: float
    step: int
    accelerations: tuple[float, float] | None = None
    asked: tuple[float, float] | None = None
    halted: float | None = None


class Event(msgspec.Struct, frozen=True, kw_only=True, tag="event"):
    """Something happened that is worth a sentence.

    Attributes
    ----------
    t : float
        When, in s.
    name : str
        What, in a word or two, always the same for the same thing.
    sentence : str
        What, in words.
    level : int
        0 for good to know, 1 for a warning, 2 for an error.
    """

    t: float
    name: str
    sentence: str
    level: int = 0


class FrameLog(msgspec.Struct, frozen=True, kw_only=True, tag="frame"):
    """A frame without its picture.

    Attributes
    ----------
    number : int
        That of the frame.
    t, arrived : float
        When it was taken and when it came, in s.
    shape : tuple of int
        Of the picture.
    lost : bool
        Whether the picture was not recorded.
    """

    number: int
    t: float
    arrived: float
    shape: tuple[int, ...]
    lost: bool = False


class Readings(msgspec.Struct, frozen=True, kw_only=True, tag="readings"):
    """What the clock said to the loop between one reading of the camera and the next.

    Attributes
    ----------
    times : tuple of float
        In order, in s.
    """

    times: tuple[float, ...]


Logged = FrameLog | Missed | Measured | Commanded | Event | Readings
"""What the log of a recording holds."""

Entry = Taken | Missed | Measured | Commanded | Event
"""What a recording gives back."""


def to_text(entry: Logged) -> str:
    """Write an entry as JSON.

    Parameters
    ----------
    entry : Logged
        The entry.

    Returns
    -------
    str
        One line; floats to the last bit.

    Examples
    --------
    >>> to_text(Commanded(t=0.1, v=0.2, omega=-0.3, step=2))
    '{"type": "command", "t": 0.1, "v": 0.2, "omega": -0.3, "step": 2}'
    """
    return json.dumps(msgspec.to_builtins(entry))


def from_text(text: str) -> Logged:
    """Read an entry.

    Parameters
    ----------
    text : str
        What `to_text` wrote.

    Returns
    -------
    Logged
        The entry.

    Raises
    ------
    ValueError
        If it is no entry.

    Examples
    --------
    >>> from_text('{"type": "missing", "t": 0.5, "reason": "no frame came in time"}').reason
    <Missing.LATE: 'no frame came in time'>
    """
    entry: Logged = msgspec.convert(json.loads(text), Logged)
    return entry
