"""When a robot has arrived, and when it rests there."""

import math
from typing import NamedTuple

from parkproof.lab.predict import GoalPose

HOLD = 4
"""The step in which the law holds a parked robot."""


class Arrival(NamedTuple):
    """When a robot has arrived, and when it is no longer parked.

    Attributes
    ----------
    position, heading : float
        Within these (goal units, rad) of the goal it has arrived, and rests.
    release : float
        How many times these it may be off until it is corrected.
    """

    position: float
    heading: float
    release: float = 2.0


class Resting:
    """Whether the robot is parked, with hysteresis.

    Parameters
    ----------
    arrival : Arrival
        When it is.

    Attributes
    ----------
    parked : bool
        Whether it is.

    Examples
    --------
    >>> resting = Resting(Arrival(0.02, 0.01))
    >>> [resting.update(HOLD, GoalPose(x, 0.0, 0.0)) for x in (0.03, 0.01, 0.03, 0.05, 0.03)]
    [False, True, True, False, False]
    """

    def __init__(self, arrival: Arrival) -> None:
        self._arrival = arrival
        self.parked = False

    def update(self, step: int, pose: GoalPose, *, slow: bool = True) -> bool:
        """Whether it is parked now.

        Parameters
        ----------
        step : int
            Step of the law.
        pose : GoalPose
            Where the robot is.
        slow : bool
            Whether it is slow enough to begin to rest.

        Returns
        -------
        bool
            Also kept in ``parked``.
        """
        position, heading, release = self._arrival
        wide = release if self.parked else 1.0
        self.parked = (
            step == HOLD
            and (slow or self.parked)
            and math.hypot(pose.x, pose.y) <= wide * position
            and abs(pose.theta) <= wide * heading
        )
        return self.parked
