"""What is wrong is noticed; the robot slows down, stops, says why, and goes on."""

import math

import numpy as np
import pytest

from parkproof.errors import InputError
from parkproof.lab.answer import Phase
from parkproof.lab.carry_out import carry_out
from parkproof.lab.devices import Frame, Missing, RobotLimits
from parkproof.lab.estimate import Estimate, Sighting
from parkproof.lab.frame_rate import FrameRate
from parkproof.lab.goal import Goal
from parkproof.lab.image_pose import TagMount
from parkproof.lab.parker import AT_MOST
from parkproof.lab.predict import CommandHistory, GoalPose, Motion, advanced
from parkproof.lab.safety import Alarm, Guard, SafetyLimits
from parkproof.lab.stall import StallWatch
from parkproof.lab.tag import TagDetector
from parkproof.lab.teach import teach
from parkproof.lab.velocity_parker import VelocityParker
from parkproof.lab.view import ImageView
from parkproof.lab.watchdog import StoppingRobot
from parkproof.lab.world.model import tag_texture
from test_watchdog import Hands, Script, wait_until

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
        self.parker, self.k, self.events = VelocityParker(goal(), LIMITS), 0, []

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
        (np.zeros(0, np.uint8), Alarm.OTHER_PICTURE),
        (np.zeros((480, 640, 4), np.uint8), Alarm.OTHER_PICTURE),
        (np.zeros((480, 640)), Alarm.OTHER_PICTURE),
        (None, Alarm.OTHER_PICTURE),
        (picture((150, 150), tag_id=3), Alarm.TAG_LOST),
    ],
)
def test_the_robot_is_stopped_within_the_stated_time_and_told_why(
    driving, what, alarm, monkeypatch
):
    allowed = SafetyLimits().stopping_time(LIMITS)
    if alarm is Alarm.TWO_TAGS:  # outside the region that is searched until the next whole look
        monkeypatch.setattr("parkproof.lab.tracker.WHOLE_EVERY", 1)
    answer = driving.see(what, 1 + round(allowed * RATE))
    assert (answer.v, answer.omega) == (0.0, 0.0)
    assert answer.alarm is alarm
    assert alarm.name.lower() in driving.names()


STOPPING = 1 + round(SafetyLimits().stopping_time(LIMITS) * RATE)
"""Frames within which the robot stands."""


def test_stale_frames_stop_the_robot(driving):
    answer = driving.see(picture((150, 150)), STOPPING + 1, late=0.7)
    assert (answer.v, answer.omega) == (0.0, 0.0)
    assert "stale" in driving.names()


@pytest.mark.parametrize("late", [-0.3, math.nan])
def test_time_stamps_from_the_future_or_of_no_number_stop_the_robot(driving, late):
    answer = driving.see(picture((150, 150)), STOPPING, late=late)
    assert (answer.v, answer.omega, answer.alarm) == (0.0, 0.0, Alarm.CLOCK)
    assert "clock" in driving.names()


def test_a_clock_that_jumps_back_stops_the_robot(driving):
    for k in range(STOPPING):
        answer = driving.see(picture((150, 150)), late=0.2 + 2 * k / RATE)
    assert (answer.v, answer.omega, answer.alarm) == (0.0, 0.0, Alarm.CLOCK)
    assert "clock" in driving.names()


def test_a_tag_that_no_robot_before_the_camera_can_carry_stops_the_robot(driving, monkeypatch):
    def behind(*_):
        raise InputError("the middle of the axle lies behind the camera")

    monkeypatch.setattr("parkproof.lab.tracker.image_pose", behind)
    answer = driving.see(picture((150, 150)), STOPPING)
    assert (answer.v, answer.omega, answer.alarm) == (0.0, 0.0, Alarm.NO_POSE)


def noisy(seed: int) -> np.ndarray:
    """The robot where it stands, as a camera shows it: no two pictures are the same."""
    noise = np.random.default_rng(seed).normal(0.0, 2.0, BLANK.shape)
    return np.clip(picture((150, 150)) + noise, 0.0, 255.0).astype(np.uint8)


def test_a_picture_that_stands_still_stops_the_robot_until_it_changes(driving):
    answer = driving.see(picture((150, 150)), 25)
    assert (answer.v, answer.omega, answer.alarm) == (0.0, 0.0, Alarm.FROZEN)
    answer = driving.see(picture((150, 150)), 60)
    assert (answer.v, answer.omega, answer.alarm) == (0.0, 0.0, Alarm.FROZEN)
    assert driving.names().count("frozen") == 1
    answer = driving.see(picture((151, 150)), 8)
    assert answer.phase is Phase.DRIVING


def test_a_robot_that_does_not_move_as_it_is_told_is_stopped_and_at_last_given_up(driving):
    driven = [driving.see(noisy(seed)) for seed in range(40)]
    assert driven[-1].alarm is Alarm.STALLED
    way = sum(abs(answer.v) for answer in driven) / RATE
    assert way < 0.3
    for seed in range(40, 400):
        answer = driving.see(noisy(seed))
    assert answer.phase is Phase.REFUSED
    assert driving.names().count("stalled") == AT_MOST[Alarm.STALLED]
    assert "does not move" in driving.events[-1].sentence


def test_a_robot_of_half_the_speed_that_answers_late_is_not_taken_to_stand():
    history, watch = CommandHistory(), StallWatch(LIMITS, delay=0.05)
    pose, rng, late = GoalPose(0.0, 0.0, 0.0), np.random.default_rng(0), 0.2
    for k in range(1, 600):
        t = k / RATE
        way, angle = history.totals(t - 1.0 / RATE - late, t - late)
        pose = advanced(pose, 1.0, 10.0 * 0.5 * way, 0.5 * angle)
        seen = GoalPose(*(x + 2e-3 * rng.normal() for x in pose))
        corners = ((*seen[:2],), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
        assert watch.of_sighting(Sighting(t, seen, 10.0, 1.0), corners, history) is None
        v = 0.3 * min(1.0, max(-1.0, 3.0 * math.sin(0.9 * t)))
        history.add(t, v, 2.0 * math.sin(1.7 * t))


def test_alarms_that_pass_do_not_use_a_run_up(driving):
    for _ in range(9):
        driving.see(BLANK, 20)
        answer = driving.see(picture((150, 150)), 8)
    assert answer.phase is Phase.DRIVING
    assert driving.names().count("course") == 10


def test_a_robot_that_comes_to_the_border_again_and_again_is_given_up(monkeypatch):
    monkeypatch.setattr(Guard, "of_motion", lambda *_, **__: Alarm.BORDER)
    driven = Driven()
    answer = driven.see(picture((150, 150)), 60)
    assert answer.phase is Phase.REFUSED
    assert driven.names().count("border") == AT_MOST[Alarm.BORDER]
    assert "border of the picture, 8 times: given up" in driven.events[-1].sentence


def test_a_camera_of_half_the_rate_is_driven_with_and_told_of():
    parker, events, k = VelocityParker(goal(), LIMITS), [], 0
    while k < 30:
        k += 1
        now = k / RATE
        shown = Frame(picture((150, 150)), t=now - 0.066, number=k // 2)
        answer = parker.step(shown if k % 2 else Missing.LATE, now)
        events += answer.events
        if answer.phase is Phase.DRIVING:
            break
    assert answer.phase is Phase.DRIVING
    assert parker.period == pytest.approx(2.0 / RATE)
    for k in range(k + 1, k + 12):  # noqa: B020  # goes on from there
        now = k / RATE
        shown = Frame(picture((150, 150)), t=now - 0.066, number=k // 2)
        events += parker.step(shown if k % 2 else Missing.LATE, now).events
    (told,) = [event.sentence for event in events if event.name == "rate"]
    assert told == "the camera gives 15 frames per s, and 30 were expected; write rate=15"


def test_gaps_in_the_numbers_of_frames_are_no_other_rate():
    frames = FrameRate(30.0)
    for number in (0, 2, 3, 7, 8, 10, 12, 14):
        frames.take(number / 30.0, number)
    assert (frames.period, frames.other) == (1.0 / 30.0, None)


def test_courses_are_planned_for_the_gains_that_were_seen_with_a_margin(monkeypatch):
    tasks = []
    monkeypatch.setattr("parkproof.lab.planning.plan_course", lambda task, *_: tasks.append(task))
    Driven().see(picture((150, 150)), 4)
    low, high = tasks[0].bounds.alpha_of(0)
    assert low <= 0.7 / 1.04
    assert high >= 1.3 * 1.04


# ------------------------------------------------------------------------------- what is sent


def test_the_parker_learns_what_was_sent_in_place_of_its_command(driving):
    answer = driving.see(picture((150, 150)))
    robot = Script()
    clock = Hands()
    with StoppingRobot(robot, clock=clock, timeout=None, longest_step=1e-3) as safe:
        done = carry_out(safe, driving.parker, answer)
    assert done.asked == (answer.v, answer.omega)
    assert (done.v, done.omega) == robot.told[0] != done.asked
    assert abs(done.v) <= 1e-3
    way, _ = driving.parker.history.totals(answer.t, answer.t + 1.0)
    assert way == pytest.approx(done.v)


def test_a_stop_that_nobody_asked_for_is_told_and_remembered(driving):
    answer = driving.see(picture((150, 150)))
    before, _ = driving.parker.history.totals(answer.t - 0.02, answer.t)
    clock = Hands()
    clock.t = answer.t - 0.02
    with StoppingRobot(Script(), clock=clock, timeout=0.05) as safe:
        safe.send(answer.v, answer.omega)
        wait_until(lambda: safe.late_stops == 1)
        clock.t = answer.t
        done = carry_out(safe, driving.parker, answer)
    assert done.halted == answer.t - 0.02
    assert (done.events[-1].name, done.events[-1].t) == ("halt", done.halted)
    way, _ = driving.parker.history.totals(answer.t - 0.02, answer.t)
    assert before != 0.0
    assert way == 0.0


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
    answer = driving.see(picture((500, 330)), 12)
    assert answer.phase is Phase.DRIVING
    assert driving.names().count("course") == 2


def test_nothing_moves_before_the_tag_is_seen():
    driven = Driven()
    answer = driven.see(BLANK, 60)
    assert (answer.v, answer.omega, answer.phase) == (0.0, 0.0, Phase.WAITING)


def test_a_start_without_a_course_inside_the_view_is_refused_before_it_moves(monkeypatch):
    monkeypatch.setattr("parkproof.lab.planning.plan_course", lambda *_: None)
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
    assert watch.of_motion(estimate(6.0), 0.3, 0.0, scale=1.0, step=3) is None
    assert watch.of_motion(estimate(7.3), 0.3, 0.0, scale=1.0, step=3) is Alarm.BORDER
    assert watch.of_motion(estimate(7.3), -0.3, 0.0, scale=1.0, step=3) is None
    assert watch.of_motion(estimate(7.3, theta=3.1), -0.3, 0.0, scale=1.0, step=3) is Alarm.BORDER


def test_a_turn_that_would_take_a_corner_of_the_tag_out_of_the_picture_is_stopped():
    watch = guard()
    assert watch.of_motion(estimate(7.45), 0.0, 2.0, scale=1.0, step=3) is Alarm.BORDER
    assert watch.of_motion(estimate(7.2), 0.0, 2.0, scale=1.0, step=3) is None


def test_a_course_that_went_astray_towards_ninety_degrees_is_given_up_in_steps_1_and_2() -> None:
    steep = estimate(0.0, theta=-1.51)
    assert guard().of_motion(steep, 0.1, 0.0, scale=1.0, step=2) is Alarm.STEEP
    assert guard().of_motion(steep, 0.1, 0.0, scale=1.0, step=0) is None
    assert guard().of_motion(estimate(0.0, theta=1.4), 0.1, 0.0, scale=1.0, step=2) is None


def test_what_the_limits_allow_is_no_jump_and_more_is():
    watch = guard()
    assert watch.of_sighting(Sighting(0.0, GoalPose(0.0, 0.0, 0.0), 10.0, 1.0)) is None
    assert watch.of_sighting(Sighting(1 / 30, GoalPose(0.1, 0.0, 0.06), 10.0, 1.0)) is None
    assert watch.of_sighting(Sighting(2 / 30, GoalPose(1.5, 0.0, 0.06), 10.0, 1.0)) is Alarm.JUMP
    assert watch.of_sighting(Sighting(3 / 30, GoalPose(0.3, 0.0, 0.06), 10.0, 1.0)) is None
    assert watch.of_sighting(Sighting(4 / 30, GoalPose(0.3, 0.0, 2.0), 10.0, 1.0)) is Alarm.JUMP
