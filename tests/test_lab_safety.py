"""What is wrong is noticed; the robot slows down, stops, says why, and goes on."""

import numpy as np
import pytest

from parkproof.lab.devices import Frame, Missing, RobotLimits
from parkproof.lab.estimate import Estimate, Sighting
from parkproof.lab.goal import Goal
from parkproof.lab.image_pose import TagMount
from parkproof.lab.parker import Parker, Phase
from parkproof.lab.predict import GoalPose, Motion
from parkproof.lab.safety import Alarm, Guard, SafetyLimits
from parkproof.lab.tag import TagDetector
from parkproof.lab.teach import teach
from parkproof.lab.view import ImageView
from parkproof.lab.world.model import tag_texture

LIMITS = RobotLimits(speed=0.3, turn_rate=2.0, acceleration=1.0, turn_acceleration=8.0)
VIEW = ImageView(((-8.0, -6.0), (8.0, -6.0), (8.0, 6.0), (-8.0, 6.0)))
BLANK = np.full((480, 640), 150, np.uint8)
RATE = 30.0


def picture(*places: tuple[int, int], turns: int = 0, tag_id: int = 0) -> np.ndarray:
    """A picture with tags of 40 px at these places (column, row of the centre)."""
    import cv2

    small = cv2.resize(tag_texture(tag_id), (50, 50), interpolation=cv2.INTER_AREA)
    small = np.rot90(small, turns)
    image = BLANK.copy()
    for column, row in places:
        image[row - 25 : row + 25, column - 25 : column + 25] = small
    return image


def goal() -> Goal:
    frame = Frame(picture((320, 240)), t=0.0, number=0)
    return teach(frame, TagDetector(), TagMount(tag_id=0, side=0.1))


def guard(**changes) -> Guard:
    return Guard(SafetyLimits(**changes), LIMITS, VIEW, mount=TagMount(side=0.1))


class Driven:
    """A parker that is given pictures at the camera's rate."""

    def __init__(self) -> None:
        self.parker, self.k, self.events = Parker(goal(), LIMITS), 0, []

    def see(self, image: np.ndarray | Missing, frames: int = 1, *, late: float = 0.066):
        for _ in range(frames):
            self.k += 1
            now = self.k / RATE
            reading = (
                image if isinstance(image, Missing) else Frame(image, t=now - late, number=self.k)
            )
            answer = self.parker.step(reading, now)
            self.events += answer.events
        return answer

    def names(self) -> list[str]:
        return [event.name for event in self.events]


@pytest.fixture
def driving() -> Driven:
    driven = Driven()
    answer = driven.see(picture((150, 150)), 8)
    assert answer.phase is Phase.DRIVING
    assert (answer.v, answer.omega) != (0.0, 0.0)
    return driven


@pytest.mark.parametrize(
    ("what", "alarm"),
    [
        (BLANK, Alarm.TAG_LOST),
        (Missing.LATE, Alarm.NO_FRAME),
        (picture((150, 150), (400, 300)), Alarm.TWO_TAGS),
        (np.zeros((240, 320), np.uint8), Alarm.OTHER_PICTURE),
        (np.zeros((0, 0), np.uint8), Alarm.OTHER_PICTURE),
        (picture((150, 150), tag_id=3), Alarm.TAG_LOST),
    ],
)
def test_the_robot_is_stopped_within_the_stated_time_and_told_why(driving, what, alarm):
    allowed = SafetyLimits().stopping_time(LIMITS)
    if alarm is Alarm.TWO_TAGS:  # outside the region that is searched until the next whole look
        driving.see(picture((150, 150)), 141)
    answer = driving.see(what, 1 + round(allowed * RATE))
    assert (answer.v, answer.omega) == (0.0, 0.0)
    assert answer.alarm is alarm
    assert alarm.name.lower() in driving.names()


def test_stale_frames_and_a_clock_that_jumps_stop_the_robot(driving):
    steps = 1 + round(SafetyLimits().stopping_time(LIMITS) * RATE)
    answer = driving.see(picture((150, 150)), steps, late=0.7)
    assert (answer.v, answer.omega) == (0.0, 0.0)
    assert {"clock", "stale"} & set(driving.names())


def test_one_missing_frame_changes_nothing(driving):
    before = driving.see(picture((150, 150)))
    answer = driving.see(BLANK)
    assert (answer.v, answer.omega, answer.phase) == (before.v, before.omega, Phase.DRIVING)


def test_it_goes_on_when_the_tag_is_back(driving):
    assert driving.see(BLANK, 30).phase is Phase.STOPPED
    answer = driving.see(picture((150, 150)), 12)
    assert answer.phase is Phase.DRIVING
    assert driving.names().count("course") == 2


def test_a_robot_that_was_carried_elsewhere_is_stopped_and_goes_on_from_there(driving):
    driving.see(picture((500, 330)), 2)
    assert "jump" not in driving.names()
    answer = driving.see(picture((500, 330)), 1)
    assert answer.phase is Phase.STOPPED
    assert driving.names()[-1] == "jump"
    answer = driving.see(picture((500, 330)), 20)
    assert answer.phase is Phase.DRIVING
    assert driving.names().count("course") == 2


def test_nothing_moves_before_the_tag_is_seen():
    driven = Driven()
    answer = driven.see(BLANK, 60)
    assert (answer.v, answer.omega, answer.phase) == (0.0, 0.0, Phase.WAITING)


def test_a_start_without_a_course_inside_the_view_is_refused_before_it_moves(monkeypatch):
    monkeypatch.setattr("parkproof.lab.parker.plan_course", lambda *_: None)
    driven = Driven()
    sent = [driven.see(picture((150, 150))) for _ in range(12)]
    assert sent[-1].phase is Phase.REFUSED
    assert all((answer.v, answer.omega) == (0.0, 0.0) for answer in sent)
    assert driven.names() == ["refused"]


def estimate(x: float, theta: float = 0.0) -> Estimate:
    pose = GoalPose(x, 0.0, theta)
    return Estimate(0.0, pose, 0.0, 0.0, pose, 10.0, 1.0, Motion())


def test_the_border_stops_what_drives_at_it_and_not_what_drives_away():
    watch = guard()
    assert watch.of_motion(estimate(6.0), 0.3, 0.0, scale=1.0) is None
    assert watch.of_motion(estimate(7.3), 0.3, 0.0, scale=1.0) is Alarm.BORDER
    assert watch.of_motion(estimate(7.3), -0.3, 0.0, scale=1.0) is None
    assert watch.of_motion(estimate(7.3, theta=3.1), -0.3, 0.0, scale=1.0) is Alarm.BORDER


def test_a_turn_that_would_take_a_corner_of_the_tag_out_of_the_picture_is_stopped():
    watch = guard()
    assert watch.of_motion(estimate(7.45), 0.0, 2.0, scale=1.0) is Alarm.BORDER
    assert watch.of_motion(estimate(7.2), 0.0, 2.0, scale=1.0) is None


def test_what_the_limits_allow_is_no_jump_and_more_is():
    watch = guard()
    assert watch.of_sighting(Sighting(0.0, GoalPose(0.0, 0.0, 0.0), 10.0, 1.0)) is None
    assert watch.of_sighting(Sighting(1 / 30, GoalPose(0.1, 0.0, 0.06), 10.0, 1.0)) is None
    assert watch.of_sighting(Sighting(2 / 30, GoalPose(1.5, 0.0, 0.06), 10.0, 1.0)) is Alarm.JUMP
    assert watch.of_sighting(Sighting(3 / 30, GoalPose(0.3, 0.0, 0.06), 10.0, 1.0)) is None
    assert watch.of_sighting(Sighting(4 / 30, GoalPose(0.3, 0.0, 2.0), 10.0, 1.0)) is Alarm.JUMP
