"""One picture of the parked robot is the goal; what does not show it is refused in a sentence."""

import json
import math
import re
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest

from parkproof.cli import main
from parkproof.cli.teach import _from_camera
from parkproof.errors import InputError
from parkproof.lab.devices import Frame, Missing
from parkproof.lab.goal import GainRange, Goal, extrapolation_margin, gain_range
from parkproof.lab.image_pose import ImagePose, TagMount, image_pose
from parkproof.lab.tag import TagDetector
from parkproof.lab.teach import teach
from parkproof.model.goal_frame import gain_bounds, goal_homography
from parkproof.model.homography import Homography
from parkproof.model.image_unicycle import image_of
from parkproof.model.unicycle import Pose
from tag_pictures import picture, view

SIDE = 0.1
DETECTOR = TagDetector()
TO_IMAGE = view((350.0, 260.0), 32.0, turn=0.4, tilt=0.5, roll=1.0, aspect=0.9)
"""Tag's frame at the goal → px."""


def frame(*tags: tuple[int, Homography]) -> Frame:
    return Frame(picture(*tags), t=0.0, number=0)


@pytest.fixture(scope="module")
def goal() -> Goal:
    return teach(frame((7, TO_IMAGE)), DETECTOR, TagMount(tag_id=7, offset=(-0.5, 0.2), angle=0.3))


def tag_at(x: float, y: float, turn: float) -> Homography:
    """Tag's frame → px when the tag is moved on the floor, from the frame it had at the goal."""
    c, s = math.cos(turn), math.sin(turn)
    return TO_IMAGE @ Homography((c, -s, x, s, c, y, 0.0, 0.0, 1.0))


# ------------------------------------------------------------------------------- the goal


def test_the_goal_is_where_the_robot_is_shown(goal: Goal) -> None:
    exact = image_pose(TO_IMAGE, goal.mount)
    assert (goal.u, goal.v) == pytest.approx((exact.u, exact.v), abs=0.1)
    assert goal.psi == pytest.approx(exact.psi, abs=math.radians(0.5))
    assert goal.unit == pytest.approx(exact.side, rel=0.01)
    assert goal.mirrored
    assert not goal.flipped
    assert goal.picture == (640, 480)
    assert goal.a == pytest.approx(1.0, abs=0.3)


def test_the_goal_is_the_origin_of_its_own_coordinates(goal: Goal) -> None:
    there = goal.to_image(image_pose(Homography(goal.homography), goal.mount))
    assert there.pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert there.a == pytest.approx(goal.a)
    assert there.beta == pytest.approx(goal.beta)
    assert goal.beta > 0.0


@pytest.mark.parametrize("mirror", [False, True])
def test_goal_coordinates_are_those_of_the_model(mirror: bool) -> None:
    flip = Homography((-1.0, 0.0, 639.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
    mount = TagMount(tag_id=7)
    image = picture((7, TO_IMAGE))
    shown = image[:, ::-1] if mirror else image
    goal = teach(Frame(shown, t=0.0, number=0), DETECTOR, mount)
    assert goal.flipped == mirror
    to_px = flip @ TO_IMAGE if mirror else TO_IMAGE
    model = goal_homography(to_px, Pose(0.0, 0.0, 0.0), image_pose(to_px, mount).side)
    for robot in (Pose(2.0, -1.0, 0.5), Pose(-3.0, 2.0, -2.5)):
        moved = tag_at(*robot)
        found = goal.to_image(image_pose(flip @ moved if mirror else moved, mount))
        want = image_of(model, robot)
        assert found.pose == pytest.approx(want.pose, abs=0.03)
        assert found.a == pytest.approx(want.a, rel=0.02)
        assert found.beta == pytest.approx(want.beta, rel=1e-6)
        assert found.beta > 0.0


def test_pixels_and_goal_coordinates_are_inverse(goal: Goal) -> None:
    u, v = goal.to_pixels(2.0, -1.0)
    assert goal.similarity.project(u, v) == pytest.approx((2.0, -1.0))
    assert goal.to_pixels(0.0, 0.0) == pytest.approx((goal.u, goal.v))
    assert [goal.to_pixels(*corner) for corner in goal.corners()][2] == pytest.approx(
        (639.5, 479.5)
    )


# ------------------------------------------------------------------------------- gains


def test_bounds_hold_all_gains_over_the_view(goal: Goal) -> None:
    view_of_all = [(-0.5, -0.5), (639.5, -0.5), (639.5, 479.5), (-0.5, 479.5)]
    true = gain_bounds(TO_IMAGE, view_of_all)
    assert goal.gains.a[0] <= true.a_min / goal.unit
    assert true.a_max / goal.unit <= goal.gains.a[1]
    assert goal.gains.beta[1] >= abs(true.beta_min)
    assert goal.gains.beta[0] <= abs(true.beta_max)
    assert goal.gains.a[1] / goal.gains.a[0] < 2.5 * true.a_max / true.a_min


def test_exact_homographies_need_no_margin_and_noisy_ones_more_for_small_tags() -> None:
    unit = image_pose(TO_IMAGE, TagMount()).side
    true = gain_bounds(TO_IMAGE, [(-0.5, -0.5), (639.5, -0.5), (639.5, 479.5), (-0.5, 479.5)])
    found = gain_range(TO_IMAGE, unit, (640, 480), margin=1.0)
    assert found.a == pytest.approx((true.a_min / unit, true.a_max / unit))
    assert extrapolation_margin(20.0) > extrapolation_margin(40.0) > 1.1


def test_where_the_horizon_is_in_view_only_readable_tags_count() -> None:
    low = view((320.0, 400.0), 40.0, tilt=math.radians(80), focal=500.0)
    unit = image_pose(low, TagMount()).side
    found = gain_range(low, unit, (640, 480))
    assert 0.0 < found.a[0] < found.a[1] < 50.0


def test_frames_seen_widen_the_bounds_and_leave_the_earlier_ones(goal: Goal) -> None:
    inside, unit, gains = image_pose(TO_IMAGE, goal.mount), goal.unit, goal.gains
    assert gains.widened(inside, unit=unit) is gains
    large = inside._replace(a_max=3.0 * gains.a[1] * unit, a_min=inside.a_min)
    wider = gains.widened(large, unit=unit, margin=1.1)
    assert wider.a == pytest.approx((gains.a[0], 3.3 * gains.a[1]))
    assert wider.beta[1] > gains.beta[1]
    assert wider.beta[0] == pytest.approx(1.0 / wider.beta[1])
    assert wider.widened(inside, unit=unit) is wider


# ------------------------------------------------------------------------------- refusals


def straight(u: float, v: float, side: float = 40.0) -> Homography:
    return Homography((side, 0.0, u, 0.0, -side, v, 0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("tags", "words"),
    [
        ([], "shows no tag: tag 7 .*parkproof tag --id 7"),
        ([(3, straight(100.0, 100.0))], "shows tag 3, but not tag 7"),
        ([(3, straight(100.0, 100.0)), (5, straight(300.0, 100.0))], "shows tags 3, 5, but not"),
        ([(7, straight(100.0, 100.0)), (7, straight(300.0, 200.0))], "tag 7 more than once"),
        ([(7, straight(22.0, 240.0))], "border of the goal frame cuts tag 7"),
        ([(7, straight(18.5, 240.0))], "border of the goal frame cuts tag 7"),
        ([(7, straight(320.0, 478.0))], "shows no tag: .*seen whole"),
    ],
    ids=["none", "another", "others", "twice", "margin cut", "cells cut", "half"],
)
def test_a_frame_that_does_not_show_the_robot_is_refused(
    tags: list[tuple[int, Homography]], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        teach(frame(*tags), DETECTOR, TagMount(tag_id=7))


def test_a_frame_without_pixels_is_refused() -> None:
    with pytest.raises(InputError, match="0 × 0 pixels"):
        teach(Frame(np.zeros((0, 0), np.uint8), t=0.0, number=0), DETECTOR, TagMount(tag_id=7))


def test_a_frame_of_another_size_is_refused(goal: Goal) -> None:
    goal.check_picture(np.zeros((480, 640, 3), np.uint8))
    with pytest.raises(InputError, match="1280 × 720 pixels: the goal was taught with 640 × 480"):
        goal.check_picture(np.zeros((720, 1280), np.uint8))


# ------------------------------------------------------------------------------- the file


def test_a_goal_survives_its_file(goal: Goal, tmp_path: Path) -> None:
    file = tmp_path / "goal.json"
    goal.write(file)
    assert Goal.read(file) == goal
    assert json.loads(file.read_text("utf-8"))["schema"] == "parkproof-goal-1"
    assert [path.name for path in tmp_path.iterdir()] == ["goal.json"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"schema": "parkproof-goal-9"}, "no goal .*schema"),
        ({"unit": -1.0}, "unit = -1.*greater than 0"),
        ({"u": None}, "Expected `float`.*u"),
        ({"beta": 0.0}, "beta"),
        ({"picture": [640, 0]}, "picture height"),
        ({"homography": [1.0] * 9}, "singular"),
        ({"gains": {"a": [2.0, 1.0], "beta": [1.0, 1.0]}}, "crossed"),
        ({"gains": {"a": [-1.0, 1.0], "beta": [1.0, 1.0]}}, "greater than 0"),
        ({"mount": {"tag_id": 999}}, "from 0 to 586"),
        ({"colour": "red"}, "unknown field `colour`"),
    ],
)
def test_a_damaged_goal_is_refused(
    goal: Goal, tmp_path: Path, change: dict[str, object], words: str
) -> None:
    file = tmp_path / "goal.json"
    file.write_text(json.dumps(json.loads(goal.to_json()) | change), encoding="utf-8")
    with pytest.raises(InputError, match=words) as refusal:
        Goal.read(file)
    assert "parkproof teach" in str(refusal.value)


def test_a_goal_that_is_cut_short_or_missing_is_refused(goal: Goal, tmp_path: Path) -> None:
    file = tmp_path / "goal.json"
    file.write_text(goal.to_json()[:100], encoding="utf-8")
    with pytest.raises(InputError, match="is no goal"):
        Goal.read(file)
    with pytest.raises(InputError, match=r"cannot read .*No such file"):
        Goal.read(tmp_path / "none.json")
    with pytest.raises(InputError, match="cannot write"):
        goal.write(tmp_path / "nowhere" / "goal.json")


def test_bounds_are_checked() -> None:
    with pytest.raises(InputError, match=re.escape("gains.a = [2.0, 1.0]: the bounds are crossed")):
        GainRange(a=(2.0, 1.0), beta=(1.0, 1.0))


# ------------------------------------------------------------------------------- the command


def test_the_command_teaches_from_a_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    cv2.imwrite("parked.png", picture((7, TO_IMAGE)))
    command = ["teach", "--image", "parked.png", "--tag-id", "7", "--offset", "-0.5", "0.2"]
    assert main([*command, "--angle-deg", "90", "--side", "0.08"]) == 0
    assert "Wrote goal.json" in capsys.readouterr().out
    goal = Goal.read("goal.json")
    assert goal.mount == TagMount(tag_id=7, offset=(-0.5, 0.2), angle=math.pi / 2, side=0.08)
    exact = image_pose(TO_IMAGE, goal.mount)
    assert (goal.u, goal.v) == pytest.approx((exact.u, exact.v), abs=0.1)
    assert main(command) == 2
    assert "already exists" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "one of --image FILE, --camera SOURCE"),
        (["--image", "a.png", "--camera", "0"], "one of --image FILE"),
        (["--image", "none.png"], "cannot read none.png: No such file"),
        (["--image", "broken.png"], "a damaged"),
        (["--image", "half.png"], "a damaged"),
        (["--image", "deep.png"], "more than 8 bits"),
        (["--image", "empty.png"], "no picture, or a damaged one"),
        (["--image", "floor.png", "--tag-id", "7"], "shows no tag"),
        (["--image", "floor.png", "--tag-id", "600"], "from 0 to 586"),
        (["--image", "floor.png", "--offset", "99", "0"], "within 20 sides"),
        (["--image", "floor.png", "--angle-deg", "inf"], "angle_deg.*finite"),
    ],
)
def test_the_command_refuses_bad_input_and_leaves_nothing(
    arguments: list[str],
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    cv2.imwrite("floor.png", picture())
    Path("broken.png").write_bytes(Path("floor.png").read_bytes()[:40])
    Path("half.png").write_bytes(Path("floor.png").read_bytes()[:90_000])
    Path("empty.png").write_bytes(b"")
    cv2.imwrite("deep.png", np.zeros((48, 64), np.uint16))
    assert main(["teach", *arguments]) == 2
    said = capfd.readouterr().err.strip()
    assert re.search(words, said)
    assert "\n" not in said
    assert not Path("goal.json").exists()


class Frames:
    """A camera that gives some frames and ends."""

    def __init__(self, *images: np.ndarray) -> None:
        self.images, self.closed = list(images), False

    def read(self, timeout: float) -> Frame | Missing:
        assert timeout > 0.0
        return Frame(self.images.pop(0), t=0.0, number=0) if self.images else Missing.ENDED

    def close(self) -> None:
        self.closed = True


def test_a_camera_may_be_dark_at_first() -> None:
    camera = Frames(np.zeros((480, 640), np.uint8), picture((7, TO_IMAGE)))
    taught = _from_camera(camera, DETECTOR, TagMount(tag_id=7))
    assert taught.u == pytest.approx(350.0, abs=0.1)
    assert camera.closed


def test_a_camera_that_never_shows_the_robot_is_refused() -> None:
    for images, words in (([], "the camera has ended"), ([picture()], "shows no tag")):
        camera = Frames(*images)
        with pytest.raises(InputError, match=words):
            _from_camera(camera, DETECTOR, TagMount(tag_id=7))
        assert camera.closed


def test_footage_that_ends_before_the_robot_is_seen_says_why(tmp_path, capsys) -> None:
    for k in range(2):
        cv2.imwrite(str(tmp_path / f"{k}.png"), np.zeros((480, 640), np.uint8))
    (tmp_path / "2.png").write_bytes(b"no image")
    assert main(["teach", "--camera", str(tmp_path), "--out", str(tmp_path / "goal.json")]) == 2
    said = capsys.readouterr().err
    assert "shows no tag" in said
    empty = Frames()
    empty.why_ended = "usb:0 gives no frames any more: unplugged?"
    with pytest.raises(InputError, match=r"^usb:0 gives no frames any more: unplugged\? before"):
        _from_camera(empty, DETECTOR, TagMount(tag_id=7))


def test_goals_are_values(goal: Goal) -> None:
    with pytest.raises(AttributeError):
        goal.u = 3.0  # type: ignore[misc]  # frozen
    assert msgspec.structs.replace(goal, u=3.0).u == 3.0
    assert isinstance(image_pose(TO_IMAGE, goal.mount), ImagePose)
