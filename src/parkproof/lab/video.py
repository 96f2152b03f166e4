"""The video of a run, which browsers play, and a strip of pictures from it."""

import math
from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.lab.devices import Image
from parkproof.lab.overlay import Overlay, overlay, overlay_size
from parkproof.lab.worker import Worker, WrittenBeside
from parkproof.output import write_whole

TICKS = 90_000
"""Time in a video counts in parts of a second of this many."""

LONGEST = 1.0
"""No picture is shown for longer than this many seconds, whatever the clock did."""

WAITING_FRAMES = 120
"""So many pictures may wait to be drawn and encoded."""


class RunVideo(WrittenBeside):
    """Writes a run as H.264 in MP4, with what `parkproof.lab.overlay` draws.

    Drawing and encoding happen in a thread beside the loop. Pictures are shown for as long as it
    took to the next, so that the video runs as the run did even where frames are missing. Use it in
    a ``with`` block: a video that is not closed does not play.

    Parameters
    ----------
    path : Path or str
        The file, usually run.mp4.
    size : tuple of 2 ints
        Width and height of the camera's pictures, px; others are resized.
    rate : float
        Frames per second of the camera.
    realtime : bool
        Whether the loop may not wait: pictures that come too fast are then left out.

    Attributes
    ----------
    frames, lost : int
        Pictures that were given to it, and those of them that are not in the video.

    Raises
    ------
    InputError
        If a number is not positive, or the file cannot be written.

    Examples
    --------
    >>> info = Overlay(t=0.0, goal=(32.0, 24.0, 0.0))
    >>> with RunVideo(directory / "run.mp4", (64, 48), 30.0) as video:
    ...     video.add(np.zeros((48, 64), np.uint8), info)
    >>> (directory / "run.mp4").read_bytes()[4:8]
    b'ftyp'
    """

    def __init__(
        self, path: Path | str, size: tuple[int, int], rate: float, *, realtime: bool = True
    ) -> None:
        require("cv2", "av", extra="lab", purpose="the video of a run")
        if min(size) < 1 or not 0.0 < rate < math.inf:
            raise InputError(
                f"size, rate = {size}, {rate:g}: must be positive; write for example size = "
                "(640, 480), rate = 30"
            )
        self._path = Path(path)
        self._size = size
        super().__init__(Worker("the video", capacity=WAITING_FRAMES, realtime=realtime))
        self._ticks: int | None = None
        self._last = 0.0
        self.frames = 0
        self.lost = 0
        self._container, self._stream = _begin(self._path, overlay_size(*size), rate)

    @property
    def fault(self) -> str | None:
        """Why there is no whole video, in a sentence; None if there is."""
        fault = self._worker.fault
        if fault is not None:
            return f"{fault}; there is no {self._path.name}, and the run went on without it"
        if self.lost:
            return f"{self.lost} of {self.frames} pictures came too fast for the video"
        return None

    def add(self, image: Image, info: Overlay) -> None:
        """Add a picture, with what is known of its moment; ``info.t`` says when to show it."""
        self.frames += 1
        if image.size == 0:
            self.lost += 1
            return
        copy = image.copy()  # a camera may use its buffer again
        if not self._worker.do(lambda: self._encode(copy, info), bulky=True):
            self.lost += self._worker.fault is None

    # ------------------------------------------------------------------ in the thread beside

    def _encode(self, image: Image, info: Overlay) -> None:
        import av
        import cv2

        if image.shape[1::-1] != self._size:
            resized = cv2.resize(image, self._size, interpolation=cv2.INTER_AREA)
            image = np.asarray(resized, np.uint8)
        planes = cv2.cvtColor(even(overlay(image, info)), cv2.COLOR_RGB2YUV_I420)
        frame = av.VideoFrame.from_ndarray(np.asarray(planes, np.uint8), format="yuv420p")
        if self._ticks is None:
            self._ticks = 0
        else:
            shown = min(info.t - self._last, LONGEST)
            self._ticks += max(round(TICKS * shown), 1)
        self._last = info.t
        frame.pts = self._ticks
        frame.time_base = Fraction(1, TICKS)
        self._mux(frame)

    def _finish(self) -> None:
        import av

        self._mux(None)
        try:
            self._container.close()
        except av.FFmpegError as error:
            raise OSError(error.errno, error.strerror) from error
        if not _is_whole(self._path):  # what is written last is not checked by the library
            raise OSError(None, "the end of the file could not be written")

    def _mux(self, frame: Any) -> None:
        import av

        try:
            self._container.mux(self._stream.encode(frame))
        except av.FFmpegError as error:
            raise OSError(error.errno, error.strerror) from error

    def _let_go(self) -> None:
        """Leave no file that does not play."""
        import av

        if self._worker.fault is None:
            return
        with suppress(av.FFmpegError, OSError):
            self._container.close()
        with suppress(OSError):
            self._path.unlink()


def _begin(path: Path, size: tuple[int, int], rate: float) -> tuple[Any, Any]:
    """A container and its stream of pictures."""
    import av

    width, height = (length + length % 2 for length in size)
    try:
        # the index goes to the front, so that a browser plays while it loads
        container = av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"})
        stream: Any = container.add_stream("libx264", rate=Fraction(rate).limit_denominator(1001))
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        context = stream.codec_context
        context.time_base, context.thread_count = Fraction(1, TICKS), 1
        # what OpenCV's conversion makes: BT.601 with 16 to 235 for black to white
        context.colorspace, context.color_primaries, context.color_trc = 6, 6, 6
        context.color_range = 1
        # the loop may need the processor more than the disk needs the room
        stream.options = {"preset": "ultrafast", "crf": "22"}
        container.start_encoding()
    except av.FFmpegError as error:
        raise InputError(
            f"cannot write {path}: {error.strerror or error}; choose another place for the video"
        ) from error
    return container, stream


def _is_whole(path: Path) -> bool:
    """Whether the boxes that an MP4 file consists of fill it exactly."""
    size, at = path.stat().st_size, 0
    with path.open("rb") as file:
        while at < size:
            file.seek(at)
            head = file.read(16).ljust(16, b"\0")
            length = int.from_bytes(head[:4], "big")
            at += int.from_bytes(head[8:], "big") if length == 1 else max(length, 8)
    return at == size


def even(image: Image) -> Image:
    """A picture with even sides, as H.264 needs them: the last row and column may come twice.

    Parameters
    ----------
    image : array of uint8
        Any picture.

    Returns
    -------
    array of uint8
        The picture, or one larger by one pixel.

    Examples
    --------
    >>> even(np.zeros((47, 63, 3), np.uint8)).shape
    (48, 64, 3)
    """
    height, width = image.shape[:2]
    if height % 2 == 0 and width % 2 == 0:
        return image
    return np.pad(image, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")


def strip(
    images: Sequence[Image], path: Path | str, *, columns: int = 3, width: int = 1280
) -> None:
    """Put pictures of a run side by side in one.

    Parameters
    ----------
    images : sequence of arrays of uint8
        RGB, all of one size, such as `parkproof.lab.overlay.overlay` makes; in order of time.
    path : Path or str
        The file; its ending says in which format (png, jpg, webp).
    columns : int
        Pictures in a row.
    width : int
        Of the whole, in px.

    Raises
    ------
    InputError
        If there is no picture, they differ in size, or the file cannot be written.

    Examples
    --------
    >>> strip([np.full((60, 80, 3), k, np.uint8) for k in range(6)], directory / "strip.png")
    """
    import cv2

    sizes = {image.shape for image in images}
    if len(sizes) != 1 or columns < 1:
        raise InputError(
            f"a strip of {len(images)} pictures of {len(sizes)} sizes in {columns} columns: needs "
            "pictures of one size and a column; give some, with the same camera"
        )
    columns = min(columns, len(images))
    gap = max(2, width // 160)
    across = (width - gap * (columns - 1)) // columns
    height, full = next(iter(sizes))[:2]
    down = max(1, round(across * height / full))
    rows = math.ceil(len(images) / columns)
    sheet = np.full(
        (rows * down + gap * (rows - 1), columns * across + gap * (columns - 1), 3), 255, np.uint8
    )
    method = cv2.INTER_AREA if across < full else cv2.INTER_CUBIC
    for k, image in enumerate(images):
        top, left = (k // columns) * (down + gap), (k % columns) * (across + gap)
        small = cv2.resize(image, (across, down), interpolation=method)
        sheet[top : top + down, left : left + across] = small
    target = Path(path)
    try:
        _, data = cv2.imencode(target.suffix, cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR))
    except cv2.error as error:
        raise InputError(
            f"{path}: {target.suffix or 'no ending'} is no format of pictures; write for example "
            "strip.png"
        ) from error
    write_whole(target, bytes(data))
