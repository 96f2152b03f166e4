"""The video of a run plays in browsers, runs as long as the run, and shows what was seen."""

import os
import subprocess
import sys
import textwrap
from itertools import pairwise
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from parkproof.errors import InputError
from parkproof.lab.lettering import text_width, write_text
from parkproof.lab.overlay import ALARM, STEP_RGB, Bar, Overlay, overlay, overlay_size
from parkproof.lab.video import RunVideo, _is_whole, strip
from parkproof.report.style import STEP_COLOURS

GOAL = (400.0, 300.0, 0.3)
TAG = np.array([(180.0, 180.0), (220.0, 180.0), (220.0, 220.0), (180.0, 220.0)])


def grey(level: int = 128, *, shape: tuple[int, ...] = (480, 640)) -> Any:
    return np.full(shape, level, np.uint8)


def info(**changes: Any) -> Overlay:
    return Overlay(**({"t": 1.0, "goal": GOAL, "step": 2} | changes))


def closeness(image: Any, colour: tuple[int, int, int]) -> Any:
    """How far each pixel is from a colour."""
    return np.abs(image.astype(int) - colour).max(axis=2)


def record(path: Path, times: list[float], *, size: tuple[int, int] = (64, 48)) -> RunVideo:
    with RunVideo(path, size, 30.0, realtime=False) as video:
        for k, t in enumerate(times):
            video.add(grey(8 * k % 256, shape=(size[1], size[0])), info(t=t))
    assert video.fault is None
    return video


def shown(path: Path) -> list[float]:
    """When each picture of a video is shown, in s."""
    with av.open(str(path)) as container:
        return [float(frame.pts * frame.time_base) for frame in container.decode(video=0)]


# ------------------------------------------------------------------------------- the video


def test_browsers_can_play_the_video(tmp_path: Path) -> None:
    path = tmp_path / "run.mp4"
    record(path, [k / 30.0 for k in range(45)], size=(63, 47))
    with av.open(str(path)) as container:
        (stream,) = container.streams
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        assert stream.width % 2 == stream.height % 2 == 0
        width, height = overlay_size(63, 47)
        assert (stream.width, stream.height) == (width + width % 2, height + height % 2)
        assert float(stream.duration * stream.time_base) == pytest.approx(1.5, abs=0.05)
        assert float(stream.average_rate) == pytest.approx(30.0, rel=0.01)
    data = path.read_bytes()
    assert 0 < data.index(b"moov") < data.index(b"mdat")


def test_the_video_keeps_the_times_of_the_run(tmp_path: Path) -> None:
    times = [5.0, 5.033, 5.1, 5.2, 5.2, 5.1, 5.233, 99.0, 99.05]
    record(tmp_path / "run.mp4", times)
    gaps = [b - a for a, b in pairwise(shown(tmp_path / "run.mp4"))]
    assert gaps[:3] == pytest.approx([0.033, 0.067, 0.1], abs=1e-4)
    assert all(0.0 < gap < 1e-3 for gap in gaps[3:5])  # a clock that stands or goes back
    assert gaps[6] == pytest.approx(1.0)  # one that jumps ahead
    assert gaps[7] == pytest.approx(0.05, abs=1e-4)


def test_the_video_shows_the_pictures_that_were_given(tmp_path: Path) -> None:
    path = tmp_path / "run.mp4"
    with RunVideo(path, (640, 480), 30.0, realtime=False) as video:
        for k in range(5):
            video.add(grey(40 * k + 20), info(t=k / 30.0))
        video.add(grey(100, shape=(240, 320)), info(t=0.2))
        video.add(grey(0, shape=(0, 0)), info(t=0.3))
        video.add(grey(200, shape=(480, 640, 3)), info(t=0.4))
    assert (video.frames, video.lost) == (8, 1)
    with av.open(str(path)) as container:
        levels = [int(f.to_ndarray(format="gray")[50, 50]) for f in container.decode(video=0)]
    assert levels == pytest.approx([20, 60, 100, 140, 180, 100, 200], abs=6)


def test_the_video_keeps_the_colours(tmp_path: Path) -> None:
    path = tmp_path / "run.mp4"
    image = grey(shape=(480, 640, 3))
    colours = [(200, 30, 40), (30, 160, 60), (40, 60, 200), (250, 250, 250), (5, 5, 5)]
    for k, colour in enumerate(colours):
        image[:100, 100 * k : 100 * k + 100] = colour
    with RunVideo(path, (640, 480), 30.0) as video:
        video.add(image, info())
    with av.open(str(path)) as container:
        (frame,) = container.decode(video=0)
    back = frame.to_ndarray(format="rgb24")
    for k, colour in enumerate(colours):
        np.testing.assert_allclose(back[50, 100 * k + 50], colour, atol=6)


def test_pictures_that_come_too_fast_are_left_out_and_counted(tmp_path: Path) -> None:
    path = tmp_path / "run.mp4"
    noise = np.random.default_rng(0).integers(0, 256, (480, 640)).astype(np.uint8)
    with RunVideo(path, (640, 480), 30.0) as video:
        for k in range(250):
            video.add(noise, info(t=k / 30.0))
    assert video.lost > 0
    assert video.fault == f"{video.lost} of 250 pictures came too fast for the video"
    assert len(shown(path)) == 250 - video.lost


def test_ctrl_c_leaves_a_video_that_plays(tmp_path: Path) -> None:
    path = tmp_path / "run.mp4"

    def run() -> None:
        with RunVideo(path, (64, 48), 30.0) as video:
            for k in range(10):
                video.add(grey(shape=(48, 64)), info(t=k / 30.0))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run()
    assert len(shown(path)) == 10


FULL = """
    import resource, sys
    import numpy as np
    from parkproof.lab.overlay import Overlay
    from parkproof.lab.video import RunVideo
    noise = np.random.default_rng(0).integers(0, 256, (480, 640)).astype(np.uint8)
    with RunVideo(sys.argv[1], (640, 480), 30.0, realtime=False) as video:
        resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, resource.RLIM_INFINITY))
        for k in range(20):
            video.add(np.roll(noise, 37 * k), Overlay(t=k / 30, goal=(0.0, 0.0, 0.0)))
    print(k, video.fault)
"""


@pytest.mark.skipif(os.name != "posix", reason="limits of files are POSIX")
def test_a_full_disk_costs_the_video_and_not_the_run(tmp_path: Path) -> None:
    program = [sys.executable, "-c", textwrap.dedent(FULL), str(tmp_path / "run.mp4")]
    done = subprocess.run(program, capture_output=True, check=False, text=True)
    assert done.stdout == (
        "19 the video stopped: File too large; there is no run.mp4, and the run went on without "
        "it\n"
    )
    assert list(tmp_path.iterdir()) == []


def test_a_video_without_its_end_is_no_video(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.mp4"
    record(path, [0.0, 0.1])
    assert _is_whole(path)
    data = path.read_bytes()
    for cut in (1, 5, 100, len(data) // 2, len(data) - 4):
        path.write_bytes(data[:-cut])
        assert not _is_whole(path), cut
    monkeypatch.setattr("parkproof.lab.video._is_whole", lambda _: False)
    with RunVideo(path, (64, 48), 30.0) as video:
        video.add(grey(shape=(48, 64)), info())
    assert video.fault == (
        "the video stopped: the end of the file could not be written; there is no run.mp4, and the "
        "run went on without it"
    )
    assert not path.exists()


def test_a_video_that_cannot_begin_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot write .*No such file or directory; choose"):
        RunVideo(tmp_path / "missing" / "run.mp4", (64, 48), 30.0)
    for size, rate in (((0, 48), 30.0), ((64, 48), 0.0), ((64, 48), float("nan"))):
        with pytest.raises(InputError, match="must be positive; write for example size"):
            RunVideo(tmp_path / "run.mp4", size, rate)


# ------------------------------------------------------------------------------- the overlay


def test_the_overlay_is_a_function_of_what_it_is_given() -> None:
    image = grey()
    first = overlay(image, info(pose=(200.0, 200.0, 0.0), tag=TAG))
    assert (image == 128).all()
    np.testing.assert_array_equal(first, overlay(image, info(pose=(200.0, 200.0, 0.0), tag=TAG)))
    assert first.dtype == np.uint8
    assert first.shape[1::-1] == overlay_size(640, 480)


@pytest.mark.parametrize("step", range(5))
def test_the_tag_is_outlined_in_the_colour_of_the_step(step: int) -> None:
    drawn = overlay(grey(), info(step=step, tag=TAG, pose=(200.0, 200.0, 0.0)))
    near = closeness(drawn, STEP_RGB[step]) < 12
    for u, v in ((200, 180), (220, 190), (180, 210), (200, 220)):
        assert near[v - 1 : v + 2, u - 1 : u + 2].any(), (u, v)
    assert near[198:203, 230:250].any(), "the arrow reaches ahead of the tag"
    assert not near[198:203, 140:170].any()
    np.testing.assert_allclose(np.array(STEP_RGB[step]) / 255.0, to_rgb(STEP_COLOURS[step]))


def test_the_heading_is_measured_from_u_towards_v() -> None:
    down = overlay(grey(), info(tag=TAG, pose=(200.0, 200.0, np.pi / 2)))
    near = closeness(down, STEP_RGB[2]) < 12
    assert near[230:250, 198:203].any()
    assert not near[150:170, 198:203].any()


def test_nothing_is_drawn_for_a_tag_that_was_not_seen() -> None:
    bare = overlay(grey(), info())
    assert (closeness(bare[:480], STEP_RGB[2]) > 12).all()
    around_goal = bare[280:320, 380:460]
    assert around_goal.max() > 220, "but the goal is"
    assert (bare[:250, :] == 128).all()


def test_the_path_is_drawn_in_the_colours_of_its_steps() -> None:
    path = np.column_stack([np.linspace(50.0, 550.0, 2000), np.full(2000, 100.0)])
    steps = np.repeat([0, 1, 2, 3], 500)
    drawn = overlay(grey(), info(path=path, path_steps=steps))
    for step, u in enumerate((100, 225, 350, 475)):
        assert closeness(drawn[99:102, u - 3 : u + 4], STEP_RGB[step]).min() < 12


@pytest.mark.parametrize("far", [1e9, -1e9, np.nan, np.inf])
def test_points_far_outside_or_unknown_do_no_harm(far: float) -> None:
    drawn = overlay(
        grey(),
        info(
            path=np.array([(far, 1.0), (100.0, far), (200.0, 100.0)]),
            planned=np.array([(far, far), (200.0, 100.0), (300.0, 100.0)]),
            tag=np.where(TAG > 200.0, far, TAG),
            pose=(far, 100.0, 0.0),
            error_px=far,
        ),
    )
    assert drawn.shape == (564, 640, 3)


def test_an_alarm_is_highlighted_and_other_news_is_not() -> None:
    def alarmed(**changes: Any) -> int:
        return int((closeness(overlay(grey(), info(**changes)), ALARM) < 8).sum())

    sentence = "tag lost: stopped"
    assert alarmed(event=sentence, alarm=True) > 1000
    assert alarmed(event=sentence) == alarmed() == 0
    news, none = (overlay(grey(), info(event=event)) for event in (sentence, None))
    assert (news[480:] != none[480:]).any()


@pytest.mark.parametrize(("value", "share"), [(-1.0, 0.0), (2.5, 0.25), (10.0, 1.0), (11.0, 1.0)])
def test_the_bar_shows_how_much_of_a_bound_is_used(value: float, share: float) -> None:
    drawn = overlay(grey(), info(bar=Bar("parked by 10 s", value, 10.0)))
    row = drawn[-7, 16:625]
    colour = ALARM if value > 10.0 else STEP_RGB[2]
    assert (closeness(row[None], colour) < 8).mean() == pytest.approx(share, abs=0.01)


def test_a_small_picture_is_enlarged_so_that_the_words_have_room() -> None:
    drawn = overlay(grey(shape=(120, 160)), info(tag=TAG / 4.0, pose=(50.0, 50.0, 0.0), step=1))
    assert drawn.shape[1] == 480
    near = closeness(drawn, STEP_RGB[1]) < 12
    assert near[3 * 45 + 1, 3 * 50 - 3 : 3 * 50 + 3].any()


def test_letters_are_cut_off_at_the_edge_of_the_picture() -> None:
    image = np.zeros((20, 40, 3), np.uint8)
    write_text(image, "wide words", (30, 18), size=14, colour=(255, 255, 255))
    assert image[:, 30:].max() > 200
    assert not image[:, :30].any()
    write_text(image, "outside", (100, 100), size=14, colour=(255, 255, 255))
    right = np.zeros((20, 40, 3), np.uint8)
    write_text(right, "ab", (40, 10), size=12, colour=(255, 0, 0), align="right")
    assert right[:, 40 - text_width("ab", 12) :].any()
    assert not right[..., 1:].any()


# ------------------------------------------------------------------------------- the strip


def test_a_strip_holds_the_pictures_in_order(tmp_path: Path) -> None:
    strip([grey(40 * k, shape=(48, 64, 3)) for k in range(5)], tmp_path / "s.png", width=320)
    sheet = cv2.imread(str(tmp_path / "s.png"))
    assert sheet.shape[1] <= 320
    height, width = sheet.shape[:2]
    tops, lefts = (height // 4, 3 * height // 4), (width // 6, width // 2, 5 * width // 6)
    levels = [int(sheet[v, u, 0]) for v in tops for u in lefts]
    assert levels == [0, 40, 80, 120, 160, 255]


def test_a_strip_that_cannot_be_is_one_line(tmp_path: Path) -> None:
    one = grey(shape=(48, 64, 3))
    with pytest.raises(InputError, match="a strip of 0 pictures"):
        strip([], tmp_path / "s.png")
    with pytest.raises(InputError, match="of 2 sizes"):
        strip([one, one[:20]], tmp_path / "s.png")
    with pytest.raises(InputError, match=r"is no format of pictures; write for example strip.png"):
        strip([one], tmp_path / "s.nothing")
    with pytest.raises(InputError, match=r"cannot write .*; choose another directory"):
        strip([one], tmp_path / "missing" / "s.png")
