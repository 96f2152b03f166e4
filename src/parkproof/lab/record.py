"""Records a run as MCAP with standard ROS 2 messages, which Foxglove and ROS tools open.

Pictures are stored losslessly. All else is stored twice: as the messages that tools know, and in
the topic ``/parkproof/log`` as JSON to the last bit, from which a run is gone through again
(`parkproof.lab.recording`). The file grows while the run goes on: after a crash it can be read up
to there.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from parkproof.extras import require
from parkproof.lab.devices import Camera, Clock, Frame, Image, Missing
from parkproof.lab.entries import (
    Commanded,
    Event,
    FrameLog,
    Logged,
    Measured,
    Missed,
    Readings,
)
from parkproof.lab.picture import as_picture
from parkproof.lab.run_file import Item, RunFile
from parkproof.lab.worker import Worker, WrittenBeside

WAITING_FRAMES = 60
"""So many pictures may wait to be encoded: two seconds' worth."""


class Recorder(WrittenBeside):
    """Writes a run to a file while it goes on, without holding it up.

    Encoding and writing happen in a thread beside the loop. Use it in a ``with`` block, so that the
    file is closed however the run ends. A disk that is full, or goes away, ends the recording and
    not the run: ``fault`` then says so.

    Parameters
    ----------
    path : Path or str
        The file, usually run.mcap.
    settings : dict
        All that a replay needs, in what JSON has: numbers, strings, lists, dicts.
    epoch : float
        Unix time in s at which the loop's clock reads 0: tools then show the date.
    realtime : bool
        Whether the loop may not wait. If pictures come faster than they can be written for two
        seconds, they are lost, and counted; with False the loop waits.

    Attributes
    ----------
    frames, lost : int
        Frames that were given to it, and those of them whose picture is not in the file.

    Raises
    ------
    InputError
        If the file cannot be written, or the settings are no JSON.

    Examples
    --------
    >>> import numpy as np
    >>> with Recorder(directory / "run.mcap", settings={"tag": 7}) as recorder:
    ...     recorder.frame(Frame(np.zeros((48, 64), np.uint8), t=0.0, number=0), arrived=0.066)
    ...     recorder.command(0.07, 0.1, 0.0, step=1)
    >>> recorder.fault is None, recorder.frames
    (True, 1)
    """

    def __init__(
        self,
        path: Path | str,
        *,
        settings: dict[str, Any],
        epoch: float = 0.0,
        realtime: bool = True,
    ) -> None:
        require("cv2", "mcap", "mcap_ros2", extra="lab", purpose="recording a run")
        self._path = Path(path)
        self._file = RunFile(path, settings=settings, epoch=epoch)
        super().__init__(Worker("recording", capacity=WAITING_FRAMES, realtime=realtime))
        self._pending: list[Item] = []
        self._readings: list[float] = []
        self._boundary = 0
        self._sequence = 0
        self._now = 0.0
        self.frames = 0
        self.lost = 0

    @property
    def fault(self) -> str | None:
        """Why the recording is not whole, in a sentence; None if it is."""
        fault = self._worker.fault
        if fault is not None:
            return f"{fault}; {self._path.name} ends there, and the run went on without it"
        if self.lost:
            return (
                f"{self.lost} of {self.frames} pictures came faster than they could be written, "
                "and are not in the recording"
            )
        return None

    def watch(self, camera: Camera, clock: Clock) -> tuple[Camera, Clock]:
        """The same camera and clock, but what the clock says to the loop is recorded, too.

        Then a replay, which reads the clock as often, gets the same times to the last bit. Without
        it a replay's clock knows the times of arrival and of commands only.
        """
        return _WatchedCamera(camera, self), _WatchedClock(clock, self._readings)

    def mark(self) -> None:
        """Remember that the camera has just been read (`watch` does it)."""
        self._boundary = len(self._readings)

    def frame(self, frame: Frame, arrived: float) -> None:
        """Record a frame and when it came, in s; without a pixel if it holds no picture."""
        image = as_picture(frame.image)
        self._flush_readings()
        self._hand_over()
        self.frames += 1
        log = FrameLog(
            number=int(frame.number),
            t=float(frame.t),
            arrived=float(arrived),
            shape=image.shape,
        )
        self._now = log.arrived
        # a copy, as a camera may use its buffer again; of nothing, there is nothing to encode
        self._log(log, image.copy() if image.size else None)

    def missing(self, reason: Missing, t: float) -> None:
        """Record that no frame came, and when that was clear, in s."""
        self._flush_readings()
        self._now = float(t)
        self._log(Missed(t=self._now, reason=reason))
        self._hand_over()

    def measured(
        self,
        t: float,
        *,
        image: Sequence[float] | None = None,
        corners: Sequence[Sequence[float]] | None = None,
        estimate: Sequence[float] | None = None,
        prediction: Sequence[float] | None = None,
        predicted_for: float | None = None,
    ) -> None:
        """Record what was made of the frame taken at t; see `parkproof.lab.entries.Measured`.

        Give what there is: image (u, v, ψ, β, a), corners (four of the tag), estimate and
        prediction (x0, x1, ψ), and in predicted_for the time that the prediction is for.
        """
        measured = Measured(
            t=float(t),
            image=_floats(image),
            corners=None if corners is None else tuple(_floats(c) for c in corners),
            estimate=_floats(estimate),
            prediction=_floats(prediction),
            predicted_for=None if predicted_for is None else float(predicted_for),
        )
        self._log(measured)

    def command(
        self,
        t: float,
        v: float,
        omega: float,
        step: int,
        *,
        accelerations: tuple[float, float] | None = None,
        asked: tuple[float, float] | None = None,
        halted: float | None = None,
    ) -> None:
        """Record a command sent at t: v in m/s, omega in rad/s, and the step of the law.

        See `parkproof.lab.entries.Commanded` for the rest.
        """
        self._now = float(t)
        self._log(
            Commanded(
                t=self._now,
                v=float(v),
                omega=float(omega),
                step=int(step),
                accelerations=_floats(accelerations),
                asked=_floats(asked),
                halted=None if halted is None else float(halted),
            )
        )
        self._hand_over()

    def event(self, t: float, name: str, sentence: str, *, level: int = 1) -> None:
        """Record that something happened at t: a name, a sentence, a level.

        The level is 0 for good to know, 1 for a warning, 2 for an error.
        """
        self._now = float(t)
        self._log(Event(t=self._now, name=name, sentence=sentence, level=int(level)))

    def _flush(self) -> None:
        self.mark()
        self._flush_readings()
        self._hand_over()

    def _let_go(self) -> None:
        self._file.close()

    def _flush_readings(self) -> None:
        """Log what the clock said since the camera was read before this time."""
        if self._boundary:
            times = tuple(self._readings[: self._boundary])
            del self._readings[: self._boundary]
            self._boundary = 0
            self._log(Readings(times=times))

    def _log(self, entry: Logged, image: Image | None = None) -> None:
        self._sequence += 1
        self._pending.append(Item(entry, self._sequence, self._now, image))

    def _hand_over(self) -> None:
        """Have what was logged written: once a frame, when the loop has nothing else to do."""
        items, self._pending = self._pending, []
        pictures = sum(item.image is not None for item in items)
        if self._worker.do(lambda: self._file.write(items), bulky=pictures > 0):
            return
        if pictures and self._worker.fault is None:  # too many wait: all but the picture is kept
            self.lost += pictures
            bare = [item.without_image() for item in items]
            self._worker.do(lambda: self._file.write(bare))

    def _finish(self) -> None:
        self._file.finish({"frames": str(self.frames), "lost": str(self.lost)})


class _WatchedCamera:
    """A camera that marks when it was read."""

    def __init__(self, camera: Camera, recorder: Recorder) -> None:
        self._camera = camera
        self._recorder = recorder

    def read(self, timeout: float) -> Frame | Missing:
        got = self._camera.read(timeout)
        self._recorder.mark()
        return got

    def close(self) -> None:
        self._camera.close()


class _WatchedClock:
    """A clock that keeps what it says."""

    def __init__(self, clock: Clock, readings: list[float]) -> None:
        self._clock = clock
        self._readings = readings

    def now(self) -> float:
        t = self._clock.now()
        self._readings.append(float(t))
        return t


def _floats(values: Sequence[float] | None) -> Any:
    """Plain floats, of NumPy's or others."""
    return None if values is None else tuple(float(value) for value in values)
