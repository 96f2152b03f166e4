"""A recorded run opens in standard tools, comes back to the last bit, and survives accidents."""

import json
import os
import signal
import subprocess
import sys
import textwrap
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from parkproof.errors import InputError
from parkproof.lab.devices import Frame, Missing
from parkproof.lab.entries import STEP_NAMES, Commanded, Event, Measured, Missed, Taken
from parkproof.lab.messages import _DEFINITIONS, definition
from parkproof.lab.record import Recorder
from parkproof.lab.recording import Recording
from parkproof.lab.run_file import TOPICS, encode_png
from parkproof.report.style import step_names

SETTINGS = {"goal": [320.0, 240.0, 0.1], "gains": {"l1": 0.1 + 0.2}, "rate": 30.0, "name": "ünï"}


def picture(seed: int, *, shape: tuple[int, ...] = (48, 64)) -> Any:
    rng = np.random.default_rng(seed)
    return np.clip(rng.normal(120.0, 2.0, shape), 0, 255).astype(np.uint8)


class Ticking:
    """A clock that never reads the same twice, with digits that nanoseconds do not hold."""

    def __init__(self) -> None:
        self.t = 1000.0

    def now(self) -> float:
        self.t += 1.0 / 300.0 + 1e-11
        return self.t


class Given:
    """A camera that gives what it was given."""

    def __init__(self, frames: list[Frame | Missing]) -> None:
        self.frames = frames

    def read(self, timeout: float) -> Frame | Missing:  # noqa: ARG002
        return self.frames.pop(0) if self.frames else Missing.ENDED

    def close(self) -> None:
        self.frames = []


def loop(camera: Any, clock: Any, recorder: Recorder | None = None) -> list[tuple[float, ...]]:
    """A toy of the real loop: its commands depend on every time and every pixel."""
    sent = []
    begun = clock.now()
    while True:
        got = camera.read(0.1)
        now = clock.now()
        if isinstance(got, Missing):
            if recorder is not None:
                recorder.missing(got, now)
            if got is Missing.ENDED:
                return sent
            mean = 0.0
        else:
            mean = float(got.image.mean()) + got.t
            if recorder is not None:
                recorder.frame(got, now)
                recorder.measured(
                    got.t, estimate=(mean, 0.5, 0.1), prediction=(1.0, 2.0, 3.0), predicted_for=now
                )
        t = clock.now()
        command = (t, mean * (now - begun), 1.0 / (t - now), 2)
        sent.append(command)
        if recorder is not None:
            recorder.command(*command)


def frames_of(count: int) -> list[Frame | Missing]:
    frames: list[Frame | Missing] = [
        Frame(picture(k), t=999.0 + k / 30.0, number=k) for k in range(count)
    ]
    frames.insert(2, Missing.LATE)
    return frames


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[float, ...]]]:
    """A recorded toy run, and the commands that it sent."""
    path = tmp_path_factory.mktemp("record") / "run.mcap"
    with Recorder(path, settings=SETTINGS, realtime=False) as recorder:
        camera, clock = recorder.watch(Given(frames_of(6)), Ticking())
        sent = loop(camera, clock, recorder)
        recorder.event(1000.5, "tag lost", "tag lost: stopped", level=2)
    assert recorder.fault is None
    return path, sent


# ------------------------------------------------------------------------------- reading back


def test_everything_comes_back_to_the_last_bit(
    recorded: tuple[Path, list[tuple[float, ...]]],
) -> None:
    path, sent = recorded
    recording = Recording.open(path)
    assert recording.settings == SETTINGS
    assert recording.whole
    entries = list(recording.entries())
    taken = [entry for entry in entries if isinstance(entry, Taken)]
    assert [entry.frame.number for entry in taken] == list(range(6))
    for k, entry in enumerate(taken):
        np.testing.assert_array_equal(entry.frame.image, picture(k))
        assert entry.frame.t == 999.0 + k / 30.0
        assert not entry.lost
    assert [(c.t, c.v, c.omega, c.step) for c in recording.commands()] == sent
    assert recording.commands() == [entry for entry in entries if isinstance(entry, Commanded)]
    reasons = [entry.reason for entry in entries if isinstance(entry, Missed)]
    assert reasons == [Missing.LATE, Missing.ENDED]
    (event,) = [entry for entry in entries if isinstance(entry, Event)]
    assert event == Event(t=1000.5, name="tag lost", sentence="tag lost: stopped", level=2)
    measured = [entry for entry in entries if isinstance(entry, Measured)]
    assert measured[3].estimate == (float(picture(3).mean()) + measured[3].t, 0.5, 0.1)
    kinds = [type(entry) for entry in entries[:4]]
    assert kinds == [Taken, Measured, Commanded, Taken]


def test_a_replay_gives_the_loop_the_same_times_and_so_the_same_commands(
    recorded: tuple[Path, list[tuple[float, ...]]],
) -> None:
    path, sent = recorded
    assert loop(*Recording.open(path).replay()) == sent


def test_without_watching_a_replay_knows_arrivals_and_commands(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with Recorder(path, settings={}) as recorder:
        for k in range(3):
            recorder.frame(Frame(picture(k), t=0.1 * k, number=k), arrived=0.1 * k + 0.066)
            recorder.command(0.1 * k + 0.07, 0.1, 0.0, 1)
    camera, clock = Recording.open(path).replay()
    for k in range(3):
        got = camera.read(0.1)
        assert isinstance(got, Frame)
        assert (clock.now(), clock.now(), clock.now()) == (0.1 * k + 0.066, *[0.1 * k + 0.07] * 2)
    assert camera.read(0.1) is Missing.ENDED
    camera.close()
    assert camera.read(0.1) is Missing.ENDED


def test_a_loop_that_reads_the_clock_less_stays_in_step_with_the_frames(
    recorded: tuple[Path, list[tuple[float, ...]]],
) -> None:
    path, sent = recorded
    camera, clock = Recording.open(path).replay()
    camera.read(0.1)
    for _ in range(3):
        camera.read(0.1)
    clock.now()
    assert clock.now() == sent[3][0]


@pytest.mark.parametrize("shape", [(48, 64), (47, 63, 3), (1, 1), (0, 64)])
def test_grey_and_colour_come_back_as_they_were(tmp_path: Path, shape: tuple[int, ...]) -> None:
    image = picture(7, shape=shape)
    with Recorder(tmp_path / "run.mcap", settings={}) as recorder:
        recorder.frame(Frame(image, t=0.0, number=0), arrived=0.0)
    camera, _ = Recording.open(tmp_path / "run.mcap").replay()
    got = camera.read(0.1)
    assert isinstance(got, Frame)
    assert got.image.dtype == np.uint8
    np.testing.assert_array_equal(got.image, image)


def test_a_camera_may_use_its_buffer_again(tmp_path: Path) -> None:
    buffer = picture(1)
    with Recorder(tmp_path / "run.mcap", settings={}) as recorder:
        for k in range(4):
            buffer[:] = k
            recorder.frame(Frame(buffer, t=0.1 * k, number=k), arrived=0.1 * k)
    entries = Recording.open(tmp_path / "run.mcap").entries()
    assert [e.frame.image.max() for e in entries if isinstance(e, Taken)] == [0, 1, 2, 3]


# ------------------------------------------------------------------------------- standard tools


def test_standard_tools_find_standard_messages(
    recorded: tuple[Path, list[tuple[float, ...]]],
) -> None:
    path, sent = recorded
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        (metadata, end) = reader.iter_metadata()
        assert json.loads(metadata.metadata["settings"]) == SETTINGS
        assert end.metadata == {"frames": "6", "lost": "0"}
        found: dict[str, list[tuple[Any, Any]]] = {}
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            assert schema is not None
            assert TOPICS[channel.topic] == schema.name
            found.setdefault(channel.topic, []).append((message, decoded))
    assert len(found["/camera/image/compressed"]) == 6
    message, image = found["/camera/image/compressed"][1]
    assert (image.format, image.data[:4]) == ("png", b"\x89PNG")
    stamp = image.header.stamp
    assert stamp.sec + 1e-9 * stamp.nanosec == pytest.approx(999.0 + 1 / 30, abs=2e-9)
    assert message.log_time > message.publish_time  # arrival, capture
    twists = [decoded.twist for _, decoded in found["/robot/cmd_vel"]]
    assert [(twist.linear.x, twist.angular.z) for twist in twists] == [c[1:3] for c in sent]
    pose = found["/robot/prediction"][0][1]
    assert pose.header.frame_id == "goal"
    assert (pose.pose.position.x, pose.pose.position.y) == (1.0, 2.0)
    turned = 2.0 * np.arctan2(pose.pose.orientation.z, pose.pose.orientation.w)
    assert turned == pytest.approx(3.0)
    said = [decoded.status[0] for _, decoded in found["/diagnostics"]]
    assert [(s.name, s.message, s.level) for s in said] == [
        ("parkproof: step", "approach", 0),
        ("parkproof: camera", Missing.LATE.value, 1),
        ("parkproof: camera", Missing.ENDED.value, 1),
        ("parkproof: tag lost", "tag lost: stopped", 2),
    ]


def test_log_times_rise_and_stamps_may_show_the_date(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", settings={}, epoch=1.7e9) as recorder:
        recorder.frame(Frame(picture(0), t=-0.02, number=0), arrived=0.0)
        recorder.measured(-0.02, image=(1, 2, 3, -1, 200), corners=[(0, 0), (1, 0), (1, 1), (0, 1)])
        recorder.command(0.01, 0.0, 0.0, 0)
    with (tmp_path / "run.mcap").open("rb") as file:
        messages = list(make_reader(file).iter_messages(log_time_order=False))
    times = [message.log_time for _, _, message in messages]
    assert all(a <= b for a, b in pairwise(times))
    assert times[0] == 1_700_000_000_000_000_000
    assert messages[0][2].publish_time == 1_699_999_999_980_000_000


def test_definitions_agree_with_those_of_ros() -> None:
    stores = pytest.importorskip("rosbags.typesys")
    known = stores.get_typestore(stores.Stores.ROS2_HUMBLE)
    for name in _DEFINITIONS:
        ours = stores.get_types_from_msg(definition(name), name)
        assert ours[name][1] == known.fielddefs[name][1], name


def test_steps_are_called_as_in_the_figures() -> None:
    assert step_names("corrected") == STEP_NAMES


# ------------------------------------------------------------------------------- accidents


def test_a_recording_that_breaks_off_is_read_up_to_there(
    recorded: tuple[Path, list[tuple[float, ...]]], tmp_path: Path
) -> None:
    path, _ = recorded
    data = path.read_bytes()
    whole = len(list(Recording.open(path).entries()))
    counts = []
    for cut in range(600, len(data), len(data) // 40):
        (tmp_path / "cut.mcap").write_bytes(data[:cut])
        recording = Recording.open(tmp_path / "cut.mcap")
        assert not recording.whole
        assert recording.settings == SETTINGS
        counts.append(len(list(recording.entries())))
    assert counts == sorted(counts)
    assert counts[0] == 0
    assert counts[-1] == whole


KILLED = """
    import os, signal, sys
    import numpy as np
    from parkproof.lab.devices import Frame
    from parkproof.lab.record import Recorder
    noise = np.random.default_rng(0).integers(0, 256, (480, 640)).astype(np.uint8)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with Recorder(sys.argv[1], settings={"a": 1}, realtime=False) as recorder:
        for k in range(100):
            recorder.frame(Frame(noise, t=k / 30, number=k), arrived=k / 30)
            recorder.command(k / 30, 0.0, 0.0, 1)
            if k == 90:
                os.kill(os.getpid(), getattr(signal, sys.argv[2]))
"""


@pytest.mark.parametrize(("name", "whole", "least"), [("SIGINT", True, 91), ("SIGKILL", False, 25)])
def test_a_killed_program_leaves_what_can_be_read(
    tmp_path: Path, name: str, whole: bool, least: int
) -> None:
    """Ctrl-C closes the file; after a kill at most what waited for the disk is missing."""
    path = tmp_path / "run.mcap"
    program = [sys.executable, "-c", textwrap.dedent(KILLED), str(path), name]
    done = subprocess.run(program, capture_output=True, check=False)
    assert done.returncode != 0
    if name == "SIGKILL":
        assert done.returncode == -signal.SIGKILL
    recording = Recording.open(path)
    assert recording.whole is whole
    numbers = [e.frame.number for e in recording.entries() if isinstance(e, Taken)]
    assert numbers == list(range(len(numbers)))
    assert least <= len(numbers) <= 91


FULL = """
    import resource, sys
    import numpy as np
    from parkproof.lab.devices import Frame
    from parkproof.lab.record import Recorder
    noise = np.random.default_rng(0).integers(0, 256, (480, 640)).astype(np.uint8)
    with Recorder(sys.argv[1], settings={"a": 1}, realtime=False) as recorder:
        resource.setrlimit(resource.RLIMIT_FSIZE, (2_000_000, resource.RLIM_INFINITY))
        for k in range(30):
            recorder.frame(Frame(noise, t=k / 30, number=k), arrived=k / 30)
            recorder.command(k / 30, 0.0, 0.0, 1)
    print(k, recorder.fault)
"""


@pytest.mark.skipif(os.name != "posix", reason="limits of files are POSIX")
def test_a_disk_that_takes_no_more_ends_the_recording_and_not_the_run(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    program = [sys.executable, "-c", textwrap.dedent(FULL), str(path)]
    done = subprocess.run(program, capture_output=True, check=False, text=True)
    assert done.stderr == ""
    assert done.stdout == (
        "29 recording stopped: File too large; run.mcap ends there, and the run went on without "
        "it\n"
    )
    numbers = [e.frame.number for e in Recording.open(path).entries() if isinstance(e, Taken)]
    assert 3 <= len(numbers) < 10


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_a_recording_that_cannot_begin_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot write /dev/full: No space left on device; choose"):
        Recorder("/dev/full", settings={})
    with pytest.raises(InputError, match="No such file or directory; choose another place"):
        Recorder(tmp_path / "missing" / "run.mcap", settings={})
    for settings in ({"a": float("nan")}, {"a": object()}):
        with pytest.raises(InputError, match=r"settings of a recording: .*; give what JSON has"):
            Recorder(tmp_path / "run.mcap", settings=settings)
    assert list(tmp_path.iterdir()) == []


def test_pictures_that_come_too_fast_are_counted_and_the_rest_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    image = np.random.default_rng(0).integers(0, 256, (480, 640)).astype(np.uint8)
    with Recorder(path, settings={}, realtime=True) as recorder:
        for k in range(200):
            recorder.frame(Frame(image, t=k / 30, number=k), arrived=k / 30)
            recorder.command(k / 30, 0.1 * k, 0.0, 1)
    assert recorder.frames == 200
    assert recorder.lost > 0
    assert recorder.fault == (
        f"{recorder.lost} of 200 pictures came faster than they could be written, and are not in "
        "the recording"
    )
    recording = Recording.open(path)
    assert [command.v for command in recording.commands()] == [0.1 * k for k in range(200)]
    taken = [entry for entry in recording.entries() if isinstance(entry, Taken)]
    assert len(taken) == 200
    assert sum(entry.lost for entry in taken) == recorder.lost
    assert all(entry.lost or (entry.frame.image == image).all() for entry in taken)


@pytest.mark.parametrize(
    ("image", "shape"),
    [
        (np.zeros((4, 4), np.float64), (0, 0)),
        (np.zeros((4, 4, 4), np.uint8), (0, 0)),
        (np.zeros(4, np.uint8), (0, 0)),
        (None, (0, 0)),
        (np.zeros((4, 5, 1), np.uint8), (4, 5)),
    ],
)
def test_what_is_no_picture_is_recorded_as_a_frame_without_a_pixel(
    tmp_path: Path, image: Any, shape: tuple[int, ...]
) -> None:
    with Recorder(tmp_path / "run.mcap", settings={}) as recorder:
        recorder.frame(Frame(image, t=0.0, number=0), arrived=0.0)
    (taken,) = Recording.open(tmp_path / "run.mcap").entries()
    assert isinstance(taken, Taken)
    assert (taken.frame.image.shape, taken.lost) == (shape, False)


def test_other_files_are_refused_in_one_line(
    recorded: tuple[Path, list[tuple[float, ...]]], tmp_path: Path
) -> None:
    from mcap.writer import Writer

    path, _ = recorded
    with pytest.raises(InputError, match=r"no such file; give the run.mcap of a lab run"):
        Recording.open(tmp_path / "missing.mcap")
    with pytest.raises(InputError, match=r"Is a directory; give the run.mcap"):
        Recording.open(tmp_path)
    for content in (b"", b"hello", encode_png(picture(0))):
        (tmp_path / "other").write_bytes(content)
        with pytest.raises(InputError, match="not an MCAP file"):
            Recording.open(tmp_path / "other")
    with (tmp_path / "foreign.mcap").open("wb") as file:
        writer: Any = Writer(file)
        writer.start()
        writer.add_metadata("parkproof", {"settings": "[1]"})
        writer.finish()
    data = path.read_bytes()
    (tmp_path / "short.mcap").write_bytes(data[:100])
    (tmp_path / "garbage.mcap").write_bytes(data[:8] + bytes(range(256)) * 9)
    for name in ("foreign", "short", "garbage"):
        with pytest.raises(InputError, match="no recording of Parkproof"):
            Recording.open(tmp_path / f"{name}.mcap")


def test_a_damaged_recording_is_one_line(
    recorded: tuple[Path, list[tuple[float, ...]]], tmp_path: Path
) -> None:
    path, _ = recorded
    data = bytearray(path.read_bytes())
    middle = data.index(b"IDAT") + 200
    data[middle] ^= 0xFF
    (tmp_path / "damaged.mcap").write_bytes(data)
    recording = Recording.open(tmp_path / "damaged.mcap")
    with pytest.raises(InputError, match=r"damaged at byte \d+"):
        list(recording.entries())
