"""Reads a recorded run back, and plays it to the loop again: camera and clock as they were."""

import struct
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.lab.devices import Frame, Image, Missing
from parkproof.lab.entries import (
    Commanded,
    Entry,
    FrameLog,
    Logged,
    Missed,
    Readings,
    Taken,
    from_text,
)
from parkproof.lab.run_file import IMAGE, LOG, METADATA

MAGIC = b"\x89MCAP0\r\n"
"""First and last bytes of an MCAP file."""


@dataclass(frozen=True)
class Recording:
    """A recorded run.

    Attributes
    ----------
    path : Path
        The file.
    settings : dict
        What was given to the recorder.
    version : str
        The version of parkproof that recorded it.
    whole : bool
        Whether the file was closed properly. Otherwise the computer, the program or the disk failed
        during the run, and the recording ends there.

    Examples
    --------
    >>> from parkproof.lab.record import Recorder
    >>> with Recorder(directory / "run.mcap", settings={"tag": 7}) as recorder:
    ...     recorder.frame(Frame(np.zeros((48, 64), np.uint8), t=0.0, number=0), arrived=0.066)
    ...     recorder.command(0.07, 0.1, 0.0, step=1)
    >>> recording = Recording.open(directory / "run.mcap")
    >>> recording.settings, recording.whole
    ({'tag': 7}, True)
    >>> recording.commands()
    [Commanded(t=0.07, v=0.1, omega=0.0, step=1, accelerations=None, asked=None, halted=None)]
    >>> camera, clock = recording.replay()
    >>> camera.read(0.1).number, clock.now(), clock.now()
    (0, 0.066, 0.07)
    """

    path: Path
    settings: dict[str, Any]
    version: str
    whole: bool

    @classmethod
    def open(cls, path: Path | str) -> "Recording":
        """Open a file that `parkproof.lab.record.Recorder` wrote.

        Raises
        ------
        InputError
            If it is missing, no MCAP file, or not a recording of Parkproof.
        """
        require("cv2", "mcap", "mcap_ros2", extra="lab", purpose="reading a recording")
        given = Path(path)
        try:
            with given.open("rb") as file:
                if file.read(len(MAGIC)) != MAGIC:
                    raise InputError(f"{path}: not an MCAP file; give the run.mcap of a lab run")
                file.seek(0, 2)
                size = file.tell()
                file.seek(max(0, size - len(MAGIC)))
                whole = size > 2 * len(MAGIC) and file.read() == MAGIC
            metadata = _metadata(given)
        except OSError as error:
            cause = "no such file" if isinstance(error, FileNotFoundError) else error.strerror
            raise InputError(f"{path}: {cause}; give the run.mcap of a lab run") from error
        return cls(
            path=given,
            settings=_settings(path, metadata),
            version=metadata.get("version", "unknown"),
            whole=whole,
        )

    def entries(self) -> Iterator[Entry]:
        """All that happened, in the order in which it did; pictures to the last bit.

        Raises
        ------
        InputError
            If the file is damaged before its end. One that merely breaks off is read up to there.
        """
        for entry in self._logged():
            if not isinstance(entry, Readings):
                yield entry

    def commands(self) -> list[Commanded]:
        """The commands that were sent, in order."""
        return [entry for entry in self._logged(pictures=False) if isinstance(entry, Commanded)]

    def replay(self) -> "tuple[RecordedCamera, RecordedClock]":
        """A camera and a clock that tell a loop what they told it when it was recorded."""
        clock = RecordedClock()
        return RecordedCamera(self._logged(), clock), clock

    def _logged(self, *, pictures: bool = True) -> Iterator[Entry | Readings]:
        """The log, with frames in the place of what it says about them."""
        from mcap_ros2.decoder import DecoderFactory

        factory = DecoderFactory()
        schemas: dict[int, Any] = {}
        topics: dict[int, tuple[str, Any]] = {}
        picture: tuple[int, Any] | None = None
        for record in _records(self.path, whole=self.whole):
            kind = type(record).__name__
            if kind == "Schema":
                schemas[record.id] = record
            elif kind == "Channel":
                decode = factory.decoder_for(record.message_encoding, schemas[record.schema_id])
                topics[record.id] = record.topic, decode
            elif kind == "Message":
                topic, decode = topics[record.channel_id]
                if topic == IMAGE and pictures:
                    picture = record.sequence, decode(record.data).data
                elif topic == LOG:
                    entry = self._entry(decode(record.data).data)
                    if isinstance(entry, FrameLog):
                        same = picture is not None and picture[0] == record.sequence
                        data = picture[1] if picture is not None and same else None
                        yield self._taken(entry, data, pictures=pictures)
                    else:
                        yield entry

    def _entry(self, text: str) -> Logged:
        try:
            return from_text(text)
        except ValueError as error:
            raise InputError(
                f"{self.path}: {error}; was recorded by parkproof {self.version}: replay it with "
                "that version"
            ) from error

    def _taken(self, log: FrameLog, data: Any, *, pictures: bool) -> Taken:
        image = np.zeros(log.shape, np.uint8)
        if pictures and not log.lost and image.size:
            image = _decoded(data, log.shape)
            if image.shape != tuple(log.shape):
                raise InputError(
                    f"{self.path}: the picture of frame {log.number} is damaged; record the run "
                    "again"
                )
        return Taken(Frame(image, t=log.t, number=log.number), log.arrived, lost=log.lost)


class RecordedClock:
    """Says what the clock said to the loop, from one reading of the camera to the next.

    A loop that asks more often than the one recorded gets the last time again.

    Examples
    --------
    >>> clock = RecordedClock()
    >>> clock.load([0.1, 0.2])
    >>> [clock.now() for _ in range(3)]
    [0.1, 0.2, 0.2]
    """

    def __init__(self) -> None:
        self._coming: deque[float] = deque()
        self._now = 0.0

    def load(self, times: list[float]) -> None:
        """The times to say until the camera is next read (the camera does it)."""
        self._coming = deque(times)

    def now(self) -> float:
        """Time in s."""
        if self._coming:
            self._now = self._coming.popleft()
        return self._now


class RecordedCamera:
    """Gives the recorded frames in order, missing ones included, then says that it has ended.

    `Recording.replay` makes it.

    Parameters
    ----------
    log : iterator
        What the recording holds.
    clock : RecordedClock
        Is told which times come between the frames.

    Attributes
    ----------
    lost : bool
        Whether the frame that was read last has lost its picture, and is black.

    Examples
    --------
    See `Recording`.
    """

    def __init__(self, log: Iterator[Entry | Readings], clock: RecordedClock) -> None:
        self._log = log
        self._clock = clock
        self._next: Taken | Missed | None = None
        self.lost = False
        self._load(None)

    def read(self, timeout: float) -> Frame | Missing:  # noqa: ARG002
        """The next frame, or why there was none then; the timeout is that of the recorded run."""
        now = self._next
        self.lost = isinstance(now, Taken) and now.lost
        if now is None:
            return Missing.ENDED
        self._load(now)
        return now.frame if isinstance(now, Taken) else now.reason

    def close(self) -> None:
        """Read no more. May be called twice."""
        self._next = None
        self._log = iter(())

    def _load(self, now: Taken | Missed | None) -> None:
        """Look ahead to the next reading of the camera, and give the clock its times until then."""
        read: list[float] = []
        known: list[float] = []
        if now is not None:
            known.append(now.arrived if isinstance(now, Taken) else now.t)
        self._next = None
        for entry in self._log:
            if isinstance(entry, Taken | Missed):
                self._next = entry
                break
            if isinstance(entry, Readings):
                read += entry.times
            elif isinstance(entry, Commanded):
                known.append(entry.t)
        self._clock.load(read or known)


def _records(path: Path, *, whole: bool) -> Iterator[Any]:
    """The records of an MCAP file in order, up to where it breaks off."""
    from mcap.exceptions import McapError
    from mcap.stream_reader import StreamReader

    with path.open("rb") as file:
        records = StreamReader(file, validate_crcs=True).records
        while True:
            try:
                record = next(records)
            except StopIteration:
                return
            except (McapError, ValueError, struct.error, MemoryError) as error:
                if whole:
                    raise InputError(
                        f"{path}: damaged at byte {file.tell()}; record the run again"
                    ) from error
                return
            yield record


def _metadata(path: Path) -> dict[str, str]:
    """The metadata that a recorder writes first; empty if there are none."""
    for record in _records(path, whole=False):
        kind = type(record).__name__
        if kind == "Metadata" and record.name == METADATA:
            found: dict[str, str] = record.metadata
            return found
        if kind != "Header":
            break
    return {}


def _settings(path: Path | str, metadata: dict[str, str]) -> dict[str, Any]:
    import json

    try:
        settings = json.loads(metadata["settings"])
    except (KeyError, ValueError) as error:
        raise InputError(
            f"{path}: no recording of Parkproof; give the run.mcap of a lab run"
        ) from error
    if not isinstance(settings, dict):
        raise InputError(f"{path}: no recording of Parkproof; give the run.mcap of a lab run")
    return settings


def _decoded(data: Any, shape: tuple[int, ...]) -> Image:
    """The picture of a PNG; empty if it is none."""
    import cv2

    empty = np.zeros(0, np.uint8)
    if not data:
        return empty
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if image is None:
        return empty
    picture = image if len(shape) == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2RGB)
    return np.asarray(picture, np.uint8)
