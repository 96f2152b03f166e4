"""Recorded frames as a camera: a video file, or a folder of images."""

import contextlib
import csv
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.lab.devices import Frame, Image, Missing
from parkproof.validate import positive

IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".pgm", ".ppm")
"""Endings of files that count as images of a folder."""

RATE = 30.0
"""Frames per second of footage that does not say when its frames were taken."""


class FootageError(Exception):
    """Footage cannot be read further; the sentence says where and why."""


class Footage:
    """Frames that were recorded, given as they were taken or one after the other.

    Parameters
    ----------
    frames : iterator of tuple of float and image
        Times of capture in s, increasing, with the images. The first is read at once. Raises
        `FootageError` if it breaks off.
    name : str
        What it is, for messages.
    paced : bool
        Give a frame when its time has come, and leave out those that were overtaken; its time is
        then on the clock `time.monotonic`. Else every call gives the next frame at once, with its
        own time.

    Raises
    ------
    InputError
        If there is no first frame.

    Attributes
    ----------
    why_ended : str
        After `Missing.ENDED`, why.

    Examples
    --------
    >>> black = np.zeros((480, 640), np.uint8)
    >>> camera = Footage(iter([(0.0, black), (0.1, black)]), name="night")
    >>> [camera.read(0.0).t for _ in range(2)]
    [0.0, 0.1]
    >>> camera.read(0.0), camera.why_ended
    (<Missing.ENDED: 'the camera has ended'>, 'night has ended after 2 frames')
    """

    def __init__(
        self, frames: Iterator[tuple[float, Image]], *, name: str, paced: bool = False
    ) -> None:
        self._frames = frames
        self._name = name
        self._paced = paced
        self._number = 0
        self._start: float | None = None
        self._size: tuple[int, ...] | None = None
        self.why_ended = ""
        self._next = self._take()
        if self._next is None:
            raise InputError(f"{self.why_ended}; choose another source")

    def read(self, timeout: float) -> Frame | Missing:
        """The next frame; if paced the newest that is due, for which it waits at most that long."""
        if self._next is None:
            return Missing.ENDED
        if not self._paced:
            frame, self._next = self._next, self._take()
            return frame
        now = time.monotonic()
        if self._start is None:
            self._start = now - self._next.t
        due = self._start + self._next.t
        if due > now + timeout:
            time.sleep(max(timeout, 0.0))
            return Missing.LATE
        time.sleep(max(due - now, 0.0))
        frame = self._next
        self._next = self._take()
        while self._next is not None and self._start + self._next.t <= time.monotonic():
            frame, self._next = self._next, self._take()
        return Frame(frame.image, t=self._start + frame.t, number=frame.number)

    def close(self) -> None:
        """Give the file back. May be called twice."""
        self._next = None
        self.why_ended = self.why_ended or f"{self._name} was closed"
        close = getattr(self._frames, "close", None)
        if close is not None:
            close()

    def _take(self) -> Frame | None:
        """The next frame of all, or None with the reason in `why_ended`."""
        try:
            t, image = next(self._frames)
        except StopIteration:
            self.why_ended = f"{self._name} has ended after {self._number} frames"
            return None
        except FootageError as error:
            self.why_ended = str(error)
            return None
        size = image.shape[:2]
        if self._size is not None and size != self._size:
            self.why_ended = (
                f"{self._name}: frame {self._number} has {size[1]}×{size[0]} pixels, and those "
                f"before it {self._size[1]}×{self._size[0]}"
            )
            return None
        self._size = size
        self._number += 1
        return Frame(image, t=t, number=self._number - 1)


def video(path: Path, *, rate: float | None = None, paced: bool = False) -> Footage:
    """The frames of a video file.

    Parameters
    ----------
    path : Path
        The file, of any kind that OpenCV reads.
    rate : float, optional
        Frames per second of a file that does not say when its frames were taken; default 30.
    paced : bool
        As in `Footage`.

    Returns
    -------
    Footage
        A camera.

    Raises
    ------
    InputError
        If OpenCV is missing, or there is no such video, or it has no frame.

    Examples
    --------
    >>> _ = Path("broken.mp4").write_bytes(b"no video")
    >>> video(Path("broken.mp4"))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: broken.mp4 cannot be read as a video; ...
    """
    require("cv2", extra="lab", purpose="reading videos")
    import cv2

    usual = RATE if rate is None else positive("rate", rate, example=RATE)
    capture = cv2.VideoCapture(str(path))
    if not capture.isOpened():
        raise InputError(f"{path} cannot be read as a video; is it whole? Choose another file")
    return Footage(_video_frames(capture, path, usual), name=str(path), paced=paced)


def _video_frames(capture: Any, path: Path, usual: float) -> Iterator[tuple[float, Image]]:
    """All frames of an open video."""
    import cv2

    announced = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    rate = capture.get(cv2.CAP_PROP_FPS)
    spacing = 1.0 / (rate if 0.1 <= rate <= 1000.0 else usual)
    number, t = 0, 0.0
    try:
        while True:
            whole, image = capture.read()
            if not whole or image is None or image.size == 0:
                break
            if number > 0:
                stamp = 1e-3 * capture.get(cv2.CAP_PROP_POS_MSEC)
                # Some files have no times of their own, or the same one twice.
                t = stamp if stamp > t else t + spacing
            yield t, colours(np.asarray(image, np.uint8))
            number += 1
    finally:
        capture.release()
    if number < announced:
        raise FootageError(
            f"{path} ends early: frame {number} of the {announced} that it announces cannot be read"
        )


def colours(image: Image) -> Image:
    """An image as OpenCV gives it, in RGB or grey.

    Parameters
    ----------
    image : array
        Grey, or blue, green and red.

    Returns
    -------
    array
        Grey, or red, green and blue.

    Examples
    --------
    >>> colours(np.array([[[1, 2, 3]]], np.uint8)).tolist()
    [[[3, 2, 1]]]
    """
    if image.ndim == 2:
        return image
    return np.ascontiguousarray(image[..., 2::-1]) if image.shape[2] >= 3 else image[..., 0]


def folder(path: Path, *, rate: float | None = None, paced: bool = False) -> Footage:
    """The images of a folder, in the order of their names.

    Parameters
    ----------
    path : Path
        The folder. If it holds times.csv, with a column ``file`` and a column ``t`` in s, that
        names the frames, in this order, and their times.
    rate : float, optional
        Frames per second where there is no times.csv; default 30.
    paced : bool
        As in `Footage`.

    Returns
    -------
    Footage
        A camera.

    Raises
    ------
    InputError
        If OpenCV is missing, the folder has no images, one is empty or the first cannot be read,
        or times.csv is wrong.

    Examples
    --------
    >>> Path("empty").mkdir()
    >>> folder(Path("empty"))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: empty holds no images (.png, ...
    """
    require("cv2", extra="lab", purpose="reading images")
    spacing = 1.0 / (RATE if rate is None else positive("rate", rate, example=RATE))
    times = path / "times.csv"
    if times.exists():
        frames = _times(times)
    else:
        files = sorted(file for file in path.iterdir() if file.suffix.lower() in IMAGES)
        frames = [(number * spacing, file) for number, file in enumerate(files)]
    if not frames:
        raise InputError(f"{path} holds no images ({', '.join(IMAGES)}); choose another folder")
    for _, file in frames:
        if not file.is_file() or file.stat().st_size == 0:
            what = "is empty" if file.is_file() else "is not there"
            raise InputError(f"{file} {what}; remove it from the frames, or copy it anew")
    return Footage(_images(frames), name=str(path), paced=paced)


def _images(frames: list[tuple[float, Path]]) -> Iterator[tuple[float, Image]]:
    """Read images when they are asked for."""
    import cv2

    for t, file in frames:
        # imdecode, since imread does not read names outside the system's code page everywhere
        try:
            data = np.frombuffer(file.read_bytes(), np.uint8)
        except OSError as error:  # removed, or its disk gone, since the footage was opened
            raise FootageError(f"{file} cannot be read: {error.strerror or error}") from error
        image: Any = None
        with contextlib.suppress(cv2.error):  # such as a header that announces too many pixels
            image = cv2.imdecode(data, cv2.IMREAD_ANYCOLOR) if data.size else None
        if image is None or image.size == 0:
            raise FootageError(f"{file} cannot be read as an image")
        yield t, colours(np.asarray(image, np.uint8))


def _times(path: Path) -> list[tuple[float, Path]]:
    """Read times.csv."""
    example = 'write a first line "file,t" and then for example "000.png,0.0"'
    try:
        with path.open(encoding="utf-8-sig", newline="") as text:
            rows = list(csv.DictReader(text))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{path} cannot be read as a table: {why}; {example}") from error
    frames: list[tuple[float, Path]] = []
    for line, row in enumerate(rows, start=2):
        try:
            t, file = float(row["t"]), path.parent / row["file"]
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"{path}, line {line}: needs a file and a time; {example}") from error
        if not np.isfinite(t) or (frames and t <= frames[-1][0]):
            raise InputError(f"{path}, line {line}: t = {t}: times must increase; sort the lines")
        frames.append((t, file))
    return frames
