"""What a frame led to: the command, and all that is known with it."""

import enum
import math
from dataclasses import dataclass

from parkproof.lab.entries import Event
from parkproof.lab.estimate import Estimate
from parkproof.lab.safety import Alarm
from parkproof.lab.tag import Detection


class Phase(enum.Enum):
    """What the parker is doing.

    Examples
    --------
    >>> Phase.PARKED.sentence
    'parked'
    """

    WAITING = "waiting for the tag"
    DRIVING = "driving"
    STOPPED = "stopped"
    PARKED = "parked"
    REFUSED = "no course from here stays inside the picture"

    @property
    def sentence(self) -> str:
        """In words."""
        return self.value


@dataclass(frozen=True)
class Answer:
    """What a frame led to.

    Attributes
    ----------
    t : float
        Time of the command in s.
    v, omega : float
        The command, in m/s and rad/s.
    step : int
        Step of the law; see `parkproof.lab.entries.STEP_NAMES`; −1 on a straight leg.
    phase : Phase
        What the parker is doing.
    alarm : Alarm or None
        Why it is stopped.
    estimate : Estimate or None
        What is known, if the tag was seen.
    tag : Detection or None
        The tag, if it was seen.
    events : tuple of Event
        What happened.
    foreseen : float
        How long the course that is driven takes at most, as foreseen, in s.
    accelerations : two floats or None
        For a robot that takes them: v̇ in m/s² and ω̇ in rad/s² to send, or None to brake. v and
        omega are then the speeds that it is taken to have, 0 while it brakes.
    image : five floats or None
        The image pose (u, v, ψ) in px and rad, β, and a in px/m, if the tag was seen.
    tau : two floats
        For a robot that takes accelerations: the inputs of the law, 0 while it is not in force;
        NaN for others.
    asked : two floats or None
        What the law asked, where the watchdog sent something else: v and ω, or v̇ and ω̇.
    halted : float or None
        When the robot was stopped unasked since the last command, in s.
    """

    t: float
    v: float
    omega: float
    step: int
    phase: Phase
    alarm: Alarm | None = None
    estimate: Estimate | None = None
    tag: Detection | None = None
    events: tuple[Event, ...] = ()
    foreseen: float = math.nan
    accelerations: tuple[float, float] | None = None
    image: tuple[float, float, float, float, float] | None = None
    tau: tuple[float, float] = (math.nan, math.nan)
    asked: tuple[float, float] | None = None
    halted: float | None = None
