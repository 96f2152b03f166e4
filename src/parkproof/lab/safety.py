"""What is never driven through: why a robot is slowed down and stopped, and when it goes on."""

import enum
import math
from dataclasses import dataclass

from parkproof.lab.devices import Frame, RobotLimits
from parkproof.lab.estimate import Estimate, Sighting
from parkproof.lab.image_pose import TagMount
from parkproof.lab.predict import advanced
from parkproof.lab.view import ImageView, tag_footprint
from parkproof.model.unicycle import wrap_angle

REACTION = 0.1
"""Time in s until braking begins, for the guard at the border."""

STEEP = math.radians(84.5)
"""Heading in Steps 1 and 2 beyond which a course is given up: near ±90° the law hardly turns back.
Courses are chosen that keep further away from it."""


class Alarm(enum.Enum):
    """Why the robot is stopped.

    Examples
    --------
    >>> Alarm.TAG_LOST.sentence
    'the tag of the robot is not seen'
    """

    NO_FRAME = "no frame comes from the camera"
    TAG_LOST = "the tag of the robot is not seen"
    TWO_TAGS = "two tags have the id of the robot"
    OTHER_PICTURE = "the picture is not as the goal's was: another size, or no picture at all"
    STALE = "frames come too late"
    CLOCK = "the time stamps of the frames jump"
    JUMP = "the robot jumped farther than it can drive"
    NO_POSE = "the tag is seen where the robot cannot be"
    STALLED = "the robot does not move as it is told"
    FROZEN = "the picture stands still while the robot is told to move"
    BORDER = "the robot comes too near the border of the picture"
    STEEP = "the robot turned further across its course than was foreseen"

    @property
    def sentence(self) -> str:
        """In words."""
        return self.value


@dataclass(frozen=True, kw_only=True)
class SafetyLimits:
    """When something is wrong.

    Attributes
    ----------
    patience : float
        For how long in s the last command is held while nothing new is seen.
    oldest : float
        Age of a frame in s beyond which it is stale.
    surplus : float
        By what factor a motion between two frames may exceed what the limits allow.
    slack, slack_heading : float
        What it may exceed that by besides, in goal units and rad: noise and pushes.
    recovery : int
        Frames in a row that must be right before the robot goes on.
    """

    patience: float = 0.2
    oldest: float = 0.5
    surplus: float = 2.0
    slack: float = 0.3
    slack_heading: float = 0.35
    recovery: int = 3

    def stopping_time(self, limits: RobotLimits) -> float:
        """Time in s within which the robot is told to stand still, once something is wrong.

        Parameters
        ----------
        limits : RobotLimits
            Of the robot.

        Returns
        -------
        float
            Patience, and braking from the largest speeds.

        Examples
        --------
        >>> limits = RobotLimits(speed=0.3, turn_rate=2.0, acceleration=1.0, turn_acceleration=8.0)
        >>> SafetyLimits().stopping_time(limits)
        0.5
        """
        braking = max(
            limits.speed / limits.acceleration, limits.turn_rate / limits.turn_acceleration
        )
        return self.patience + braking


class Guard:
    """Watches frames and poses; holds those of the last frame that was right.

    Attributes
    ----------
    carried : bool
        Whether the last sighting made it believe that somebody carried the robot elsewhere.

    Parameters
    ----------
    safety : SafetyLimits
        When something is wrong.
    limits : RobotLimits
        What the robot can do.
    view : ImageView
        What the camera sees.
    mount : TagMount
        How the tag sits on the robot.
    """

    def __init__(
        self,
        safety: SafetyLimits,
        limits: RobotLimits,
        view: ImageView,
        *,
        mount: TagMount,
    ) -> None:
        self._safety, self._limits, self._view = safety, limits, view
        self._mount = mount
        self._last_stamp = -math.inf
        self._accepted: Sighting | None = None
        self._strange: list[Sighting] = []
        self.carried = False

    def of_frame(self, frame: Frame, now: float) -> Alarm | None:
        """What is wrong with a frame's time.

        Parameters
        ----------
        frame : Frame
            The frame.
        now : float
            Time in s.

        Returns
        -------
        Alarm or None
            None if nothing is.
        """
        before, self._last_stamp = self._last_stamp, frame.t
        if not math.isfinite(frame.t) or frame.t <= before or frame.t > now + 1e-3:
            return Alarm.CLOCK
        return Alarm.STALE if now - frame.t > self._safety.oldest else None

    def of_sighting(self, seen: Sighting) -> Alarm | None:
        """Whether the robot can have come from where it was seen last.

        A place that is seen several times in a row is believed in the end: somebody carried the
        robot there.

        Parameters
        ----------
        seen : Sighting
            Where it is seen now.

        Returns
        -------
        Alarm or None
            None if it can.
        """
        self.carried = False
        if self._accepted is None or self._reachable(self._accepted, seen):
            self._accepted, self._strange = seen, []
            return None
        if self._strange and not self._reachable(self._strange[-1], seen):
            self._strange = []
        self._strange.append(seen)
        if len(self._strange) >= self._safety.recovery:
            self._accepted, self._strange, self.carried = seen, [], True
        return Alarm.JUMP

    def _reachable(self, before: Sighting, seen: Sighting) -> bool:
        safety, limits, dt = self._safety, self._limits, seen.t - before.t
        moved = math.dist(before.pose[:2], seen.pose[:2])
        turned = abs(wrap_angle(seen.pose.theta - before.pose.theta))
        gain, beta = max(before.a, seen.a), max(before.beta, seen.beta)
        return (
            moved <= safety.surplus * gain * limits.speed * dt + safety.slack
            and turned <= safety.surplus * beta * limits.turn_rate * dt + safety.slack_heading
        )

    def of_motion(
        self, estimate: Estimate, v: float, omega: float, *, scale: float, step: int
    ) -> Alarm | None:
        """Whether the course went astray, or the tag would leave the view if the robot braked now.

        Parameters
        ----------
        estimate : Estimate
            Where it is, and will be.
        v, omega : float
            What it is about to be sent, in m/s and rad/s.
        scale : float
            Greatest length in goal units that a side of the tag has there, in any direction.
        step : int
            Step of the law.

        Returns
        -------
        Alarm or None
            None if it can stop inside the view, or comes away from the border.
        """
        if step in {1, 2} and abs(estimate.pose.theta) > STEEP:
            return Alarm.STEEP
        limits, motion = self._limits, estimate.motion
        speed, turn = motion.speed * v, motion.turn * omega + motion.skew * v
        footprint = tag_footprint(self._mount, scale)
        here = self._view.room(footprint, *estimate.ahead)
        for share in (0.5, 1.0):  # it may come nearer on the way than where it rests
            end = advanced(
                estimate.ahead,
                share,
                estimate.a * speed * (abs(speed) / (2.0 * limits.acceleration) + REACTION),
                estimate.beta * turn * (abs(turn) / (2.0 * limits.turn_acceleration) + REACTION),
            )
            there = self._view.room(footprint, *end)
            if there < 0.0 and there < here - 1e-3:
                return Alarm.BORDER
        return None
