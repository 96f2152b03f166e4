"""Tags are found to hundredths of a pixel, and the image pose follows from their homography."""

import ctypes
import math

import numpy as np
import pytest

from parkproof.errors import InputError
from parkproof.lab.image_pose import ImagePose, TagMount, expected, image_pose
from parkproof.lab.tag import Detection, TagDetector, Unseen, _Thresholds
from parkproof.lab.tag_square import Near, near, square_homography
from parkproof.model.homography import Homography
from parkproof.model.unicycle import wrap_angle
from tag_pictures import picture, view


@pytest.fixture(scope="module")
def detector() -> TagDetector:
    return TagDetector()


def random_view(rng: np.random.Generator, side: float) -> Homography:
    return view(
        (rng.uniform(100, 540), rng.uniform(100, 380)),
        side,
        turn=rng.uniform(-math.pi, math.pi),
        tilt=math.radians(rng.uniform(0, 35)),
        roll=rng.uniform(-math.pi, math.pi),
        aspect=rng.uniform(0.8, 1.25),
        focal=rng.uniform(400, 900),
    )


def the(found: Detection | Unseen) -> Detection:
    assert isinstance(found, Detection)
    return found


# ------------------------------------------------------------------------------- homography


def test_homography_goes_exactly_through_the_corners() -> None:
    true = view((300.0, 200.0), 40.0, turn=1.0, tilt=0.6, roll=2.0, aspect=1.2)
    square = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
    a, b, c, d = (true.project(x, y) for x, y in square)
    found = square_homography((a, b, c, d))
    for place in (*square, (0.0, 0.0), (3.0, -2.0)):
        assert found.project(*place) == pytest.approx(true.project(*place), abs=1e-9)


def test_corners_on_a_line_are_refused() -> None:
    with pytest.raises(InputError, match="lie on a line"):
        square_homography(((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0)))


# ------------------------------------------------------------------------------- detection


@pytest.mark.parametrize(
    ("side", "position", "heading_deg", "gain"),
    [(20.0, 0.08, 0.6, 0.02), (28.0, 0.05, 0.2, 0.01), (60.0, 0.05, 0.1, 0.005)],
)
def test_position_heading_and_gains_are_sub_pixel(
    detector: TagDetector, side: float, position: float, heading_deg: float, gain: float
) -> None:
    rng = np.random.default_rng(int(side))
    mount = TagMount(tag_id=11)
    errors = []
    for seed in range(12):
        true = random_view(rng, side)
        exact = image_pose(true, mount)
        image = picture((11, true), seed=seed)
        seen = the(detector.find(image, 11, near=near((exact.u, exact.v), side)))
        pose = image_pose(seen.homography, mount)
        turn = math.degrees(wrap_angle(pose.psi - exact.psi))
        errors.append(
            (pose.u - exact.u, pose.v - exact.v, turn, pose.a / exact.a, pose.beta / exact.beta)
        )
    table = np.array(errors) - [0.0, 0.0, 0.0, 1.0, 1.0]
    rms = np.sqrt(np.mean(table**2, axis=0))
    assert rms[0] <= position
    assert rms[1] <= position
    assert rms[2] <= heading_deg
    assert rms[3] <= gain
    assert rms[4] <= gain


def test_pixels_are_opencvs(detector: TagDetector) -> None:
    square = Homography((40.0, 0.0, 319.5, 0.0, -40.0, 239.5, 0.0, 0.0, 1.0))
    seen = the(detector.find(picture((0, square), blur=0.0, noise=0.0), 0))
    assert seen.centre == pytest.approx((319.5, 239.5), abs=0.02)
    assert seen.corners[0] == pytest.approx((299.5, 259.5), abs=0.05)
    assert seen.side == pytest.approx(40.0, abs=0.05)


def test_region_gives_what_the_whole_picture_gives(detector: TagDetector) -> None:
    image = picture((3, view((333.0, 222.0), 30.0, turn=0.4, tilt=0.4)))
    whole = the(detector.find(image, 3))
    part = the(detector.find(image, 3, near=near((340.0, 230.0), 30.0)))
    assert np.allclose(whole.corners, part.corners, atol=1e-9)


def test_tag_far_from_where_it_is_expected_is_found(detector: TagDetector) -> None:
    image = picture((3, view((100.0, 100.0), 30.0)))
    for wrong in (near((500.0, 400.0), 30.0), near((-900.0, 2.0), 30.0), Near(math.nan, 0.0, 9.0)):
        seen = the(detector.find(image, 3, near=wrong))
        assert seen.centre == pytest.approx((100.0, 100.0), abs=0.1)


def test_colour_and_grey_pictures_agree(detector: TagDetector) -> None:
    image = picture((3, view((300.0, 200.0), 30.0)))
    colour = np.repeat(image[:, :, None], 3, axis=2)
    assert detector.detect(colour) == detector.detect(image) == detector.detect(image[:, :, None])


def test_several_tags_are_named_by_their_ids(detector: TagDetector) -> None:
    image = picture((9, view((150.0, 100.0), 30.0)), (4, view((450.0, 300.0), 40.0, turn=1.0)))
    assert [seen.tag_id for seen in detector.detect(image)] == [4, 9]
    assert detector.find(image, 5) is Unseen.ABSENT


def test_two_robots_with_one_id_are_noticed(detector: TagDetector) -> None:
    image = picture((4, view((150.0, 100.0), 30.0)), (4, view((450.0, 300.0), 40.0)))
    assert detector.find(image, 4) is Unseen.TWICE
    close = picture((4, view((300.0, 200.0), 30.0)), (4, view((345.0, 200.0), 30.0)))
    assert detector.find(close, 4, near=near((320.0, 200.0), 30.0)) is Unseen.TWICE


def test_a_mirrored_picture_has_the_other_handedness(detector: TagDetector) -> None:
    image = picture((5, view((200.0, 120.0), 40.0, turn=0.5)))
    direct = the(detector.find(image, 5))
    mirrored = the(detector.find(image[:, ::-1], 5))
    assert mirrored.centre == pytest.approx((639 - direct.centre[0], direct.centre[1]), abs=0.01)
    mount = TagMount(tag_id=5)
    here, there = (image_pose(seen.homography, mount) for seen in (direct, mirrored))
    assert here.beta < 0.0 < there.beta
    assert there.beta == pytest.approx(-here.beta, rel=0.01)
    assert wrap_angle(there.psi - (math.pi - here.psi)) == pytest.approx(0.0, abs=0.005)
    assert detector.find(image, 5, flipped=True) is Unseen.ABSENT
    place = near(there[:2], there.side)
    again = the(detector.find(image[:, ::-1], 5, near=place, flipped=True))
    assert np.allclose(again.corners, mirrored.corners, atol=0.02)


def test_tags_of_little_contrast_are_still_found(detector: TagDetector) -> None:
    image = picture((3, view((300.0, 200.0), 30.0, turn=0.3)), noise=0.0).astype(np.float64)
    dim = 60.0 + 0.3 * (image - 140.0) + np.random.default_rng(0).normal(0.0, 2.0, image.shape)
    seen = the(detector.find(np.clip(np.rint(dim), 0, 255).astype(np.uint8), 3))
    assert seen.centre == pytest.approx((300.0, 200.0), abs=0.15)


def test_the_detector_ignores_the_noise_of_a_plain_floor(detector: TagDetector) -> None:
    settings = detector._detector.tag_detector_ptr
    found = ctypes.cast(settings, ctypes.POINTER(_Thresholds)).contents
    assert found.min_white_black_diff > 16  # of what σ = 3 makes between a dozen pixels


def test_noise_shows_no_tags(detector: TagDetector) -> None:
    rng = np.random.default_rng(0)
    for scale in (1, 4, 16):
        coarse = rng.integers(0, 256, (480 // scale, 640 // scale), dtype=np.uint8)
        assert detector.detect(np.kron(coarse, np.ones((scale, scale), np.uint8))) == []


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (np.zeros((0, 0), np.uint8), "0 × 0 pixels"),
        (np.zeros((480, 0, 3), np.uint8), "480 × 0 pixels"),
        (np.zeros((2, 3), np.uint8), "at least 8 rows"),
        (np.zeros((48, 64), np.float32), "picture of float32: must be an array of uint8"),
        (np.zeros(48, np.uint8), "must be rows × columns"),
        (np.zeros((48, 64, 4), np.uint8), "opacity"),
        (None, "picture of NoneType"),
    ],
)
def test_what_is_no_picture_is_refused(detector: TagDetector, image: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        detector.detect(image)  # type: ignore[arg-type]  # what a camera may give


# ------------------------------------------------------------------------------- image pose


def test_offset_and_angle_lead_to_the_axle() -> None:
    to_image = view((320.0, 200.0), 40.0, turn=0.7, tilt=0.5, roll=1.0, aspect=0.9)
    mount = TagMount(offset=(-0.8, 0.3), angle=2.0)
    pose = image_pose(to_image, mount)
    assert pose[:2] == pytest.approx(to_image.project(-0.8, 0.3))
    step = 1e-6
    ahead = to_image.project(-0.8 + step * math.cos(2.0), 0.3 + step * math.sin(2.0))
    velocity = np.subtract(ahead, pose[:2]) / step
    assert pose.a == pytest.approx(np.hypot(*velocity), rel=1e-4)
    assert pose.psi == pytest.approx(math.atan2(velocity[1], velocity[0]), abs=1e-4)
    turned = image_pose(to_image, TagMount(offset=(-0.8, 0.3), angle=2.0 + step))
    assert pose.beta == pytest.approx(wrap_angle(turned.psi - pose.psi) / step, rel=1e-4)
    assert pose.beta < 0.0


def test_least_and_greatest_gain_are_those_over_all_headings() -> None:
    to_image = view((200.0, 300.0), 40.0, tilt=0.6, roll=1.0, aspect=0.8)
    angles = np.linspace(-math.pi, math.pi, 721)
    gains = [image_pose(to_image, TagMount(angle=float(angle))).a for angle in angles]
    pose = image_pose(to_image, TagMount())
    assert pose.a_min == pytest.approx(min(gains), rel=1e-4)
    assert pose.a_max == pytest.approx(max(gains), rel=1e-4)


@pytest.mark.parametrize("mirror", [False, True])
def test_expected_region_holds_the_tag(mirror: bool) -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        to_image = random_view(rng, rng.uniform(20, 60))
        if mirror:
            flip = Homography((-1.0, 0.0, 639.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
            to_image = flip @ to_image
        offset = (rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5))
        mount = TagMount(offset=offset, angle=rng.uniform(-3, 3))
        u, v, reach = expected(image_pose(to_image, mount), mount)
        for x in (-0.625, 0.625):
            for y in (-0.625, 0.625):
                corner = to_image.project(x, y)
                assert max(abs(corner[0] - u), abs(corner[1] - v)) <= reach


def test_an_axle_behind_the_camera_is_refused() -> None:
    to_image = Homography((40.0, 0.0, 300.0, 0.0, -40.0, 200.0, 0.2, 0.0, 1.0))
    with pytest.raises(InputError, match="behind the camera"):
        image_pose(to_image, TagMount(offset=(-8.0, 0.0)))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"tag_id": 587}, "from 0 to 586"),
        ({"tag_id": -1}, "from 0 to 586"),
        ({"tag_id": True}, "from 0 to 586"),
        ({"offset": (30.0, 0.0)}, "within 20 sides"),
        ({"offset": (math.nan, 0.0)}, "finite"),
        ({"angle": math.inf}, "finite"),
        ({"side": 0.0}, "greater than 0"),
    ],
)
def test_impossible_mounts_are_refused(given: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        TagMount(**given)  # type: ignore[arg-type]  # what a user may write


def test_image_pose_is_a_plain_tuple() -> None:
    pose = ImagePose(1.0, 2.0, 0.5, -1.0, 30.0, 30.0, 29.0, 31.0)
    assert pose[:6] == (pose.u, pose.v, pose.psi, pose.beta, pose.a, pose.side)
