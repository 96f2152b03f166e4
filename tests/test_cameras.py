"""Cameras: footage on disk, live cameras over a real socket, and all that can go wrong."""

import http.server
import subprocess
import sys
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from parkproof.errors import InputError
from parkproof.lab.cameras import open_camera
from parkproof.lab.devices import Frame, Missing
from parkproof.lab.live_camera import LiveCamera

RED = np.zeros((48, 64, 3), np.uint8) + np.array([0, 0, 250], np.uint8)  # OpenCV's order


def write_video(path: Path, *, frames: int = 12, rate: float = 20.0, kind: str = "MJPG") -> Path:
    """A video that grows brighter, of noise so that every frame takes some space."""
    rng = np.random.default_rng(0)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*kind), rate, (64, 48))
    for k in range(frames):
        writer.write(rng.integers(0, 20, (48, 64, 3), dtype=np.uint8) + np.uint8(15 * (k % 15)))
    writer.release()
    return path


def write_images(path: Path, *, frames: int = 4, shape: tuple[int, ...] = (48, 64, 3)) -> Path:
    path.mkdir(exist_ok=True)
    for k in range(frames):
        cv2.imwrite(str(path / f"{k:03d}.png"), np.full(shape, 10 * k, np.uint8))
    return path


def all_of(camera) -> list[Frame]:
    frames = []
    while isinstance(frame := camera.read(1.0), Frame):
        frames.append(frame)
    assert frame is Missing.ENDED
    assert camera.read(0.0) is Missing.ENDED
    camera.close()
    return frames


# ------------------------------------------------------------------------------- footage


@pytest.mark.parametrize(("ending", "kind"), [("avi", "MJPG"), ("mp4", "mp4v")])
def test_a_video_gives_all_its_frames_with_their_times(tmp_path, ending, kind):
    camera = open_camera(str(write_video(tmp_path / f"v.{ending}", kind=kind)))
    frames = all_of(camera)
    assert [frame.number for frame in frames] == list(range(12))
    assert [frame.t for frame in frames] == pytest.approx([k / 20.0 for k in range(12)], abs=1e-3)
    brightness = [frame.image.mean() for frame in frames]
    assert np.all(np.diff(brightness) > 10.0)
    assert frames[0].image.shape == (48, 64, 3)
    assert camera.why_ended.endswith("has ended after 12 frames")


def test_times_in_footage_count_whatever_rate_is_given(tmp_path):
    video = open_camera(str(write_video(tmp_path / "v.avi", frames=4, rate=20.0)), rate=10.0)
    assert [frame.t for frame in all_of(video)] == pytest.approx([0.0, 0.05, 0.1, 0.15])
    folder = write_images(tmp_path / "frames")
    (folder / "times.csv").write_text("file,t\n000.png,1.5\n001.png,1.75\n", encoding="utf-8")
    assert [frame.t for frame in all_of(open_camera(str(folder), rate=10.0))] == [1.5, 1.75]


def test_images_of_a_folder_come_in_the_order_of_their_names(tmp_path):
    folder = write_images(tmp_path / "frames")
    (folder / "notes.txt").write_text("no image", encoding="utf-8")
    frames = all_of(open_camera(str(folder), rate=10.0))
    assert [int(frame.image[0, 0, 0]) for frame in frames] == [0, 10, 20, 30]
    assert [frame.t for frame in frames] == pytest.approx([0.0, 0.1, 0.2, 0.3])


def test_times_of_a_folder_stand_in_its_table(tmp_path):
    folder = write_images(tmp_path / "frames")
    (folder / "times.csv").write_text("file,t\n002.png,1.5\n000.png,1.75\n", encoding="utf-8")
    frames = all_of(open_camera(str(folder)))
    assert [(int(frame.image[0, 0, 0]), frame.t) for frame in frames] == [(20, 1.5), (0, 1.75)]


def test_colours_are_red_green_and_blue(tmp_path):
    cv2.imwrite(str(tmp_path / "0.png"), RED)
    (frame,) = all_of(open_camera(str(tmp_path)))
    assert frame.image[0, 0].tolist() == [250, 0, 0]


@pytest.mark.parametrize("kind", ["grey", "16 bits", "see-through"])
def test_images_of_other_kinds_are_taken(tmp_path, kind):
    image = {
        "grey": np.full((48, 64), 100, np.uint8),
        "16 bits": np.full((48, 64), 100 * 257, np.uint16),
        "see-through": np.full((48, 64, 4), 100, np.uint8),
    }[kind]
    cv2.imwrite(str(tmp_path / "0.png"), image)
    (frame,) = all_of(open_camera(str(tmp_path)))
    assert frame.image.dtype == np.uint8
    assert frame.image.shape in {(48, 64), (48, 64, 3)}
    assert abs(int(frame.image[0, 0].max()) - 100) <= 1


def test_names_beyond_ascii_are_read(tmp_path):
    folder = tmp_path / "картинки é"
    write_images(folder)
    assert len(all_of(open_camera(str(folder)))) == 4


def test_paced_footage_comes_at_its_own_times_and_leaves_out_what_was_overtaken(tmp_path):
    folder = write_images(tmp_path / "frames", frames=6)
    camera = open_camera(str(folder), rate=20.0, paced=True)
    begin = time.monotonic()
    first = camera.read(0.0)
    assert isinstance(first, Frame)
    assert begin <= first.t <= time.monotonic()
    late = camera.read(0.0)
    assert late is Missing.LATE
    time.sleep(0.125)
    second = camera.read(0.0)
    assert isinstance(second, Frame)
    assert second.number >= 2
    assert second.t == pytest.approx(first.t + second.number / 20.0)
    assert second.t <= time.monotonic()
    rest = all_of(camera)
    assert all(frame.t <= time.monotonic() for frame in rest)


def test_a_closed_camera_gives_nothing(tmp_path):
    camera = open_camera(str(write_video(tmp_path / "v.avi")))
    camera.close()
    camera.close()
    assert camera.read(0.0) is Missing.ENDED
    assert camera.why_ended.endswith("was closed")


# ------------------------------------------------------------------------------- bad footage


def test_a_video_that_breaks_off_says_where(tmp_path):
    whole = write_video(tmp_path / "v.avi", frames=30).read_bytes()
    broken = tmp_path / "broken.avi"
    broken.write_bytes(whole[: len(whole) // 2])
    camera = open_camera(str(broken))
    frames = all_of(camera)
    assert 5 < len(frames) < 25
    expected = f"broken.avi ends early: frame {len(frames)} of the 30 that it announces"
    assert expected in camera.why_ended


@pytest.mark.parametrize("content", ["nothing", "text", "cut off"])
def test_a_corrupt_video_is_refused(tmp_path, content):
    file = tmp_path / "corrupt.mp4"
    whole = write_video(tmp_path / "whole.mp4", kind="mp4v").read_bytes()
    file.write_bytes({"nothing": b"", "text": b"hello" * 50, "cut off": whole[:-400]}[content])
    with pytest.raises(InputError, match=r"corrupt\.mp4 cannot be read as a video"):
        open_camera(str(file))


def test_a_folder_without_images_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("no image", encoding="utf-8")
    with pytest.raises(InputError, match=r"holds no images \(\.png"):
        open_camera(str(tmp_path))


def test_an_empty_image_is_found_before_the_start(tmp_path):
    write_images(tmp_path)
    (tmp_path / "002.png").write_bytes(b"")
    with pytest.raises(InputError, match=r"002\.png is empty"):
        open_camera(str(tmp_path))


def test_a_corrupt_image_ends_the_footage_and_is_named(tmp_path):
    write_images(tmp_path)
    (tmp_path / "002.png").write_bytes(b"no image")
    camera = open_camera(str(tmp_path))
    assert len(all_of(camera)) == 2
    assert camera.why_ended.endswith("002.png cannot be read as an image")
    (tmp_path / "000.png").write_bytes(b"no image")
    with pytest.raises(InputError, match=r"000\.png cannot be read as an image; choose"):
        open_camera(str(tmp_path))


def test_an_image_that_announces_more_pixels_than_there_can_be_is_refused(tmp_path):
    def chunk(kind: bytes, data: bytes) -> bytes:
        whole = kind + data
        return len(data).to_bytes(4, "big") + whole + zlib.crc32(whole).to_bytes(4, "big")

    head = (60_000).to_bytes(4, "big") * 2 + bytes([8, 2, 0, 0, 0])
    data = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(999)))
    (tmp_path / "0.png").write_bytes(data + chunk(b"IEND", b""))
    with pytest.raises(InputError, match=r"0\.png cannot be read as an image"):
        open_camera(str(tmp_path))


def test_an_image_that_is_deleted_meanwhile_ends_the_footage_and_is_named(tmp_path):
    camera = open_camera(str(write_images(tmp_path)))
    (tmp_path / "002.png").unlink()
    assert len(all_of(camera)) == 2
    assert camera.why_ended.endswith("002.png cannot be read: No such file or directory")


def test_a_change_of_size_ends_the_footage(tmp_path):
    write_images(tmp_path)
    cv2.imwrite(str(tmp_path / "002.png"), np.zeros((10, 20), np.uint8))
    camera = open_camera(str(tmp_path))
    assert len(all_of(camera)) == 2
    assert "frame 2 has 20×10 pixels, and those before it 64×48" in camera.why_ended


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("file,t\n000.png,1.0\n001.png,1.0\n", r"line 3: t = 1\.0: times must increase"),
        ("file,t\n000.png,nan\n", "line 2: t = nan"),
        ("file,t\n000.png\n", "line 2: needs a file and a time"),
        ("name,time\n000.png,1.0\n", "line 2: needs a file and a time"),
        ("file,t\n000.png,soon\n", "line 2: needs a file and a time"),
        ("t,file\n1.0\n", "line 2: needs a file and a time"),
        ("file,t\nnone.png,1.0\n", r"none\.png is not there"),
        ("", "holds no images"),
        ("file,t\n", "holds no images"),
    ],
)
def test_a_table_of_times_that_is_wrong_is_refused(tmp_path, table, message):
    write_images(tmp_path)
    (tmp_path / "times.csv").write_text(table, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        open_camera(str(tmp_path))


def test_a_table_of_times_that_is_no_text_is_refused(tmp_path):
    write_images(tmp_path)
    (tmp_path / "times.csv").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(InputError, match="cannot be read as a table"):
        open_camera(str(tmp_path))


def test_a_folder_in_the_place_of_the_table_of_times_is_refused(tmp_path):
    (write_images(tmp_path) / "times.csv").mkdir()
    with pytest.raises(InputError, match=r"times\.csv cannot be read as a table: Is a directory"):
        open_camera(str(tmp_path))


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_a_rate_that_is_none_is_refused(tmp_path, rate):
    with pytest.raises(InputError, match="rate = "):
        open_camera(str(write_images(tmp_path)), rate=rate)


@pytest.mark.parametrize("source", ["", "nowhere.mp4", "no/folder", "usb", "webcam"])
def test_a_source_that_is_none_is_refused(source):
    with pytest.raises(InputError, match=r"source = .*there is no such camera, file or folder"):
        open_camera(source)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="devices are named otherwise")
@pytest.mark.parametrize("source", ["9876", "usb:9876", "/dev/video9876"])
def test_a_usb_camera_that_is_not_there_is_refused(source):
    with pytest.raises(InputError, match=r"source = usb:9876: there is no /dev/video9876; "):
        open_camera(source)


def test_a_usb_camera_needs_a_number():
    with pytest.raises(InputError, match="write for example usb:0"):
        open_camera("usb:left")


@pytest.mark.parametrize("scheme", ["rtsp", "http"])
def test_a_network_camera_that_does_not_answer_is_refused_without_its_password(scheme):
    with pytest.raises(InputError, match="no camera answers there") as refused:
        open_camera(f"{scheme}://me:secret@127.0.0.1:1/stream")
    assert "secret" not in str(refused.value)


def test_refusals_are_one_line_and_nothing_else_is_printed(tmp_path):
    file = tmp_path / "corrupt.mp4"
    file.write_bytes(b"hello")
    code = (
        "import sys; from parkproof.errors import InputError\n"
        "from parkproof.lab.cameras import open_camera\n"
        "for source in sys.argv[1:]:\n"
        "    try: open_camera(source)\n"
        "    except InputError as error: print(error)\n"
    )
    sources = [str(file), "rtsp://127.0.0.1:1/x", "usb:9876"]
    done = subprocess.run(
        [sys.executable, "-c", code, *sources], capture_output=True, text=True, check=True
    )
    assert len(done.stdout.splitlines()) == 3
    assert done.stderr == ""


# ------------------------------------------------------------------------------- live cameras


@pytest.fixture
def stream() -> Iterator[Callable[[int], str]]:
    """Serve so many frames as a network camera does, and give its address."""
    servers = []

    def serve(frames: int) -> str:
        class Pictures(http.server.BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                self.send_response(200)
                kind = "multipart/x-mixed-replace; boundary=frame"
                self.send_header("Content-Type", kind)
                self.end_headers()
                for k in range(frames):
                    _, packed = cv2.imencode(".jpg", np.full((48, 64, 3), 2 * k, np.uint8))
                    data = packed.tobytes()
                    head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(data)}"
                    try:
                        self.wfile.write(f"{head}\r\n\r\n".encode() + data + b"\r\n")
                    except OSError:
                        return
                    time.sleep(0.01)

            def log_message(self, *_: object) -> None:
                pass

        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Pictures)
        servers.append(server)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        return f"http://127.0.0.1:{server.server_port}/video"

    yield serve
    for server in servers:
        server.shutdown()
        server.server_close()


def test_a_network_camera_gives_frames_stamped_on_arrival_until_it_ends(stream):
    begin = time.monotonic()
    camera = open_camera(stream(40))
    frames = []
    while (frame := camera.read(0.5)) is not Missing.ENDED:
        if isinstance(frame, Frame):
            assert begin <= frame.t <= time.monotonic()
            frames.append(frame)
    assert frames
    assert np.all(np.diff([frame.number for frame in frames]) >= 1)
    assert np.all(np.diff([frame.t for frame in frames]) > 0.0)
    assert frames[0].image.shape == (48, 64, 3)
    assert "gives no frames any more, after 40: unplugged?" in camera.why_ended
    camera.close()


def test_of_frames_that_wait_only_the_newest_is_given(stream):
    camera = open_camera(stream(1000))
    first = camera.read(5.0)
    time.sleep(0.2)
    second = camera.read(5.0)
    assert isinstance(first, Frame)
    assert isinstance(second, Frame)
    assert second.number - first.number > 1
    camera.close()
    camera.close()
    assert camera.read(0.0) is Missing.ENDED


class Scripted:
    """A capture that gives what it is told."""

    def __init__(self, *answers: tuple[bool, object]) -> None:
        self.answers = list(answers)
        self.released = False

    def read(self) -> tuple[bool, object]:
        time.sleep(0.002)
        return self.answers.pop(0) if self.answers else (False, None)

    def release(self) -> None:
        self.released = True


GOOD = (True, RED)


def test_frames_that_are_lost_or_of_no_size_are_passed_over():
    nothing = (True, np.zeros((0, 0, 3), np.uint8))
    capture = Scripted(nothing, (False, None), GOOD, nothing, GOOD)
    camera = LiveCamera(capture, name="usb:0")
    numbers = []
    while (frame := camera.read(1.0)) is not Missing.ENDED:
        if isinstance(frame, Frame):
            assert frame.image[0, 0].tolist() == [250, 0, 0]
            numbers.append(frame.number)
    assert numbers[-1] == 1
    assert camera.why_ended == "usb:0 gives no frames any more, after 2: unplugged?"
    camera.close()
    assert capture.released


def test_a_camera_that_gives_no_frame_is_refused_and_given_back():
    capture = Scripted()
    with pytest.raises(InputError, match="usb:0: the camera gives no frame"):
        LiveCamera(capture, name="usb:0")
    assert capture.released


def test_a_camera_that_changes_its_size_ends():
    other = (True, np.zeros((10, 20, 3), np.uint8))
    camera = LiveCamera(Scripted(GOOD, *[other] * 3), name="usb:0")
    while camera.read(1.0) is not Missing.ENDED:
        pass
    assert camera.why_ended == "usb:0 has changed the size of its frames"
    camera.close()


def test_a_driver_that_fails_ends_the_camera_with_its_words(capsys):
    class Fails(Scripted):
        def read(self) -> tuple[bool, object]:
            if not self.answers:
                raise RuntimeError("the bus went away")
            return super().read()

        def release(self) -> None:
            raise RuntimeError("no such device")

    camera = LiveCamera(Fails(GOOD, GOOD), name="usb:0")
    while camera.read(1.0) is not Missing.ENDED:
        pass
    assert camera.why_ended == "usb:0 failed after 2 frames: the bus went away"
    camera.close()
    assert capsys.readouterr().err == ""


def test_a_live_camera_that_is_late_says_so():
    class Slow(Scripted):
        def read(self) -> tuple[bool, object]:
            time.sleep(0.0 if self.answers else 0.3)
            return super().read()

    camera = LiveCamera(Slow(GOOD), name="usb:0")
    assert isinstance(camera.read(1.0), Frame)
    assert camera.read(0.01) is Missing.LATE
    camera.close()


def test_a_program_that_ends_without_closing_its_camera_ends_well(stream):
    code = (
        "import sys; from parkproof.lab.cameras import open_camera\n"
        "camera = open_camera(sys.argv[1]); camera.read(1.0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, stream(2000)], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
