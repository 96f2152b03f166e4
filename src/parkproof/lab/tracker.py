"""From a frame to a sighting of the robot: its tag, and whether that can be believed."""

from typing import NamedTuple

from parkproof.errors import InputError
from parkproof.lab.devices import Frame, Missing
from parkproof.lab.estimate import Sighting
from parkproof.lab.goal import GainRange, Goal
from parkproof.lab.image_pose import ImagePose, expected, image_pose
from parkproof.lab.picture import grey
from parkproof.lab.predict import CommandHistory, GoalPose
from parkproof.lab.safety import Alarm, Guard
from parkproof.lab.stall import StallWatch
from parkproof.lab.tag import Detection, TagDetector, Unseen
from parkproof.model.homography import Homography

WHOLE_EVERY = 150
"""Every so many frames the whole picture is searched, for a second tag of the same id."""


class Look(NamedTuple):
    """What a frame shows of the robot.

    Attributes
    ----------
    tag : Detection or None
        Its tag, if it was seen.
    shown : ImagePose or None
        Its image pose in px, if the tag was seen.
    seen : Sighting or None
        Where it is, if that can be believed.
    alarm : Alarm or None
        What is wrong, if it cannot.
    """

    tag: Detection | None = None
    shown: ImagePose | None = None
    seen: Sighting | None = None
    alarm: Alarm | None = None


class TagTracker:
    """Looks for the robot's tag frame after frame.

    Parameters
    ----------
    goal : Goal
        What was shown.
    guard : Guard
        Judges times and jumps.
    stall : StallWatch
        Judges whether the robot moves as it is told.
    stamp_delay : float
        By how much in s the time stamps of the frames are late.

    Attributes
    ----------
    gains : GainRange
        Bounds of the gains, from the goal and all frames seen.
    scale : float
        Greatest length in goal units that a side of the tag has where it was seen last.
    """

    def __init__(self, goal: Goal, guard: Guard, stall: StallWatch, *, stamp_delay: float) -> None:
        self._goal, self._guard, self._stall = goal, guard, stall
        self._stamp_delay = stamp_delay
        self._detector = TagDetector()
        self._near: ImagePose | None = None
        self._frames = 0
        at_goal = image_pose(Homography(goal.homography), goal.mount)
        self.gains = GainRange.shown_by(at_goal, unit=goal.unit)
        self.scale = 1.0

    def look(self, reading: Frame | Missing, now: float, history: CommandHistory) -> Look:
        """Look for the robot in a frame.

        Parameters
        ----------
        reading : Frame or Missing
            What the camera gave.
        now : float
            Time in s.
        history : CommandHistory
            What was sent.

        Returns
        -------
        Look
            What there is of it.
        """
        if isinstance(reading, Missing):
            return Look(alarm=Alarm.NO_FRAME)
        if alarm := self._guard.of_frame(reading, now):
            return Look(alarm=alarm)
        try:
            found = self._find(reading)
        except InputError:
            return Look(alarm=Alarm.OTHER_PICTURE)
        if isinstance(found, Unseen):
            self._near = None
            return Look(alarm=Alarm.TWO_TAGS if found is Unseen.TWICE else Alarm.TAG_LOST)
        try:
            shown = image_pose(found.homography, self._goal.mount)
        except InputError:
            self._near = None
            return Look(found, alarm=Alarm.NO_POSE)
        seen = self._sighting(shown, reading.t)
        alarm = self._guard.of_sighting(seen)
        alarm = alarm or self._stall.of_sighting(seen, found.corners, history)
        return Look(found, shown, None if alarm else seen, alarm)

    def _find(self, frame: Frame) -> Detection | Unseen:
        """The robot's tag in a frame; raises if it is no picture like the goal's."""
        goal, near = self._goal, None
        self._frames += 1
        if self._near is not None and self._frames % WHOLE_EVERY:
            near = expected(self._near, goal.mount)
        picture = grey(frame.image)
        goal.check_picture(picture)
        return self._detector.find(picture, goal.mount.tag_id, near=near, flipped=goal.flipped)

    def _sighting(self, shown: ImagePose, t: float) -> Sighting:
        """The robot in goal units; and what its gains are there is kept."""
        goal = self._goal
        self._near = shown
        self.scale = shown.a_max / goal.unit
        self.gains = self.gains.widened(shown, unit=goal.unit)
        pose, a, beta = goal.to_image(shown)
        return Sighting(t - self._stamp_delay, GoalPose(*pose), a / goal.mount.side, beta)
