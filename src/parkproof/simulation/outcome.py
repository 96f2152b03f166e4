"""How a run can end. An end is a value with a sentence, never an exception."""

from enum import Enum


class Outcome(Enum):
    """The end of a run.

    Examples
    --------
    >>> Outcome.PARKED.value, Outcome("parked").sentence
    ('parked', 'The robot reached the goal and stayed there to the end of the run.')
    """

    PARKED = "parked"
    MISSED = "finished away from the goal"
    STILL_MOVING = "still moving"
    OUT_OF_VIEW = "out of view"
    LEFT_CHART = "left the chart"
    INPUT_LIMIT = "input limit"
    SPEED_LIMIT = "speed limit"
    DIVERGED = "diverged"

    @property
    def sentence(self) -> str:
        """What the outcome means."""
        return _SENTENCES[self]


_SENTENCES = {
    Outcome.PARKED: "The robot reached the goal and stayed there to the end of the run.",
    Outcome.MISSED: (
        "The law went through all its steps, but at the end the robot was not at the goal."
    ),
    Outcome.STILL_MOVING: "The run's duration was over before the law had gone through its steps.",
    Outcome.OUT_OF_VIEW: "The robot left the camera's view; the run ended there.",
    Outcome.LEFT_CHART: (
        "The heading reached ±90°, where the law's coordinates end; the run ended there."
    ),
    Outcome.INPUT_LIMIT: "The law asked for more input than the robot has; the run ended there.",
    Outcome.SPEED_LIMIT: "The robot went or turned faster than it can; the run ended there.",
    Outcome.DIVERGED: "The state grew without bound; the run ended there.",
}
