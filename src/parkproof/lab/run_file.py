"""The file of a recorded run: MCAP with standard ROS 2 messages.

All is stored twice, but for the pictures: as messages that tools know, and in the topic
``/parkproof/log`` as JSON to the last bit, from which a run is gone through again.
"""

import json
import math
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from parkproof import __version__
from parkproof.errors import InputError
from parkproof.lab.devices import Image
from parkproof.lab.entries import (
    STEP_NAMES,
    Commanded,
    Event,
    FrameLog,
    Logged,
    Measured,
    Missed,
    to_text,
)
from parkproof.lab.messages import definition

METADATA = "parkproof"
"""Name of the metadata record that holds the settings."""

LOG = "/parkproof/log"
IMAGE = "/camera/image/compressed"
TAG = "/camera/tag"
MEASURED = "/robot/image_pose"
ESTIMATE = "/robot/estimate"
PREDICTION = "/robot/prediction"
COMMAND = "/robot/cmd_vel"
ACCELERATION = "/robot/cmd_accel"
STEP = "/robot/step"
DIAGNOSTICS = "/diagnostics"

TOPICS = {
    LOG: "std_msgs/msg/String",
    IMAGE: "sensor_msgs/msg/CompressedImage",
    TAG: "visualization_msgs/msg/ImageMarker",
    MEASURED: "geometry_msgs/msg/PoseStamped",
    ESTIMATE: "geometry_msgs/msg/PoseStamped",
    PREDICTION: "geometry_msgs/msg/PoseStamped",
    COMMAND: "geometry_msgs/msg/TwistStamped",
    ACCELERATION: "geometry_msgs/msg/AccelStamped",
    STEP: "std_msgs/msg/Int32",
    DIAGNOSTICS: "diagnostic_msgs/msg/DiagnosticArray",
}
"""Type of the messages of each topic."""

CHUNK = 1 << 16
"""The file grows by parts of at least so many bytes: a picture each, so that a crash costs one."""


class Item(NamedTuple):
    """An entry on its way to the file.

    Parameters
    ----------
    entry : Logged
        What happened.
    sequence : int
        Its number.
    now : float
        When it was logged, in s.
    image : array or None
        The picture of a frame.
    """

    entry: Logged
    sequence: int
    now: float
    image: Image | None

    def without_image(self) -> "Item":
        """The same for a picture that is lost."""
        entry = self.entry
        if isinstance(entry, FrameLog) and self.image is not None:
            entry = msgspec.structs.replace(entry, lost=True)
        return self._replace(entry=entry, image=None)


class RunFile:
    """Writes entries to a file as they come; the file can be read up to where it breaks off.

    Parameters
    ----------
    path : Path or str
        The file.
    settings : dict
        What a replay needs.
    epoch : float
        Unix time in s at which the loop's clock reads 0.

    Raises
    ------
    InputError
        If the file cannot be written, or the settings are no JSON.

    Examples
    --------
    >>> file = RunFile(directory / "run.mcap", settings={}, epoch=0.0)
    >>> file.write([Item(Commanded(t=0.0, v=0.1, omega=0.0, step=1), 1, 0.0, None)])
    >>> file.finish({"frames": "0"})
    """

    def __init__(self, path: Path | str, *, settings: dict[str, Any], epoch: float) -> None:
        from mcap.writer import CompressionType
        from mcap_ros2.writer import Writer

        text = _settings_text(settings)
        self._epoch = round(1e9 * epoch)
        self._schemas: dict[str, Any] = {}
        self._step: int | None = None
        metadata = {"version": __version__, "epoch": repr(epoch), "settings": text}
        try:
            self._file = Path(path).open("wb")  # noqa: SIM115  # open as long as the run goes on
            # pictures are compressed already, and the rest is little
            self._writer: Any = Writer(
                self._file, chunk_size=CHUNK, compression=CompressionType.NONE
            )
            try:
                self._writer.add_metadata(METADATA, metadata)
                self._file.flush()
            except OSError:
                self.close()
                raise
        except OSError as error:
            raise InputError(
                f"cannot write {path}: {error.strerror or error}; choose another place for the "
                "recording"
            ) from error

    def finish(self, end: dict[str, str]) -> None:
        """Write the index, and what is known at the end; may raise `OSError`."""
        self._writer.add_metadata(f"{METADATA}.end", end)
        self._writer.finish()
        self._file.close()

    def close(self) -> None:
        """Let go of the file, whatever is in it. May be called twice."""
        with suppress(OSError):  # a full disk: told already
            self._file.close()

    def _stamp(self, t: float) -> dict[str, int]:
        sec, nanosec = divmod(self._epoch + round(1e9 * t), 1_000_000_000)
        return {"sec": sec, "nanosec": nanosec}

    def _header(self, t: float, frame_id: str) -> dict[str, Any]:
        return {"stamp": self._stamp(t), "frame_id": frame_id}

    def _write(
        self, topic: str, message: dict[str, Any], sequence: int, now: float, t: float | None = None
    ) -> None:
        kind = TOPICS[topic]
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_msgdef(kind, definition(kind))
        log_time = max(0, self._epoch + round(1e9 * now))
        publish = log_time if t is None else max(0, self._epoch + round(1e9 * t))
        self._writer.write_message(
            topic, self._schemas[kind], message, log_time, publish, sequence % (1 << 32)
        )

    def write(self, items: Sequence[Item]) -> None:
        """Write entries in order; may raise `OSError`."""
        for entry, sequence, now, image in items:
            if isinstance(entry, FrameLog) and image is not None:
                self._write_image(image, entry, sequence)
            self._write(LOG, {"data": to_text(entry)}, sequence, now)
            if isinstance(entry, Measured):
                self._write_measured(entry, sequence, now)
            elif isinstance(entry, Commanded):
                self._write_command(entry, sequence, now)
            elif isinstance(entry, Event):
                self._write_status(entry.t, entry.name, entry.sentence, entry.level, sequence, now)
            elif isinstance(entry, Missed):
                self._write_status(entry.t, "camera", entry.reason.value, 1, sequence, now)
        self._file.flush()

    def _write_image(self, image: Image, log: FrameLog, sequence: int) -> None:
        message = {
            "header": self._header(log.t, "camera"),
            "format": "png",
            "data": encode_png(image),
        }
        self._write(IMAGE, message, sequence, log.arrived, log.t)

    def _write_measured(self, entry: Measured, sequence: int, now: float) -> None:
        if entry.image is not None:
            message = self._pose(entry.t, "image", entry.image[:3])
            self._write(MEASURED, message, sequence, now, entry.t)
        if entry.corners is not None:
            self._write(TAG, self._marker(entry.t, entry.corners), sequence, now, entry.t)
        if entry.estimate is not None:
            message = self._pose(entry.t, "goal", entry.estimate)
            self._write(ESTIMATE, message, sequence, now, entry.t)
        if entry.prediction is not None:
            t = entry.t if entry.predicted_for is None else entry.predicted_for
            message = self._pose(t, "goal", entry.prediction)
            self._write(PREDICTION, message, sequence, now, t)

    def _write_command(self, entry: Commanded, sequence: int, now: float) -> None:
        twist = {"linear": {"x": entry.v}, "angular": {"z": entry.omega}}
        message = {"header": self._header(entry.t, "robot"), "twist": twist}
        self._write(COMMAND, message, sequence, now)
        if entry.accelerations is not None:
            v_dot, omega_dot = entry.accelerations
            accel = {"linear": {"x": v_dot}, "angular": {"z": omega_dot}}
            message = {"header": self._header(entry.t, "robot"), "accel": accel}
            self._write(ACCELERATION, message, sequence, now)
        self._write(STEP, {"data": entry.step}, sequence, now)
        if entry.step != self._step:
            self._step = entry.step
            name = STEP_NAMES.get(entry.step, str(entry.step))
            self._write_status(entry.t, "step", name, 0, sequence, now)

    def _write_status(
        self, t: float, name: str, sentence: str, level: int, sequence: int, now: float
    ) -> None:
        status = {
            "level": level,
            "name": f"parkproof: {name}",
            "message": sentence,
            "hardware_id": "parkproof",
            "values": [{"key": "t", "value": f"{t:.3f}"}],
        }
        message = {"header": self._header(t, ""), "status": [status]}
        self._write(DIAGNOSTICS, message, sequence, now)

    def _pose(self, t: float, frame_id: str, pose: Sequence[float]) -> dict[str, Any]:
        x, y, psi = pose
        turned = {"z": math.sin(0.5 * psi), "w": math.cos(0.5 * psi)}
        position = {"x": x, "y": y}
        return {
            "header": self._header(t, frame_id),
            "pose": {"position": position, "orientation": turned},
        }

    def _marker(self, t: float, corners: Sequence[tuple[float, float]]) -> dict[str, Any]:
        return {
            "header": self._header(t, "camera"),
            "ns": "tag",
            "type": 3,
            "scale": 2.0,
            "outline_color": {"r": 0.0, "g": 0.45, "b": 0.7, "a": 1.0},
            "points": [{"x": u, "y": v} for u, v in corners],
        }


def _settings_text(settings: dict[str, Any]) -> str:
    """The settings as JSON."""
    try:
        return json.dumps(msgspec.to_builtins(settings), allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"settings of a recording: {error}; give what JSON has, with finite numbers"
        ) from error


def encode_png(image: Image) -> bytes:
    """Encode a picture losslessly and fast.

    Parameters
    ----------
    image : array of uint8
        Grey or RGB, not empty; grey stays grey.

    Returns
    -------
    bytes
        A PNG file.

    Examples
    --------
    >>> import numpy as np
    >>> encode_png(np.zeros((48, 64), np.uint8))[1:4]
    b'PNG'
    """
    import cv2

    # noise has no repetitions to look for: coding differences by frequency is as small, and faster
    options = [cv2.IMWRITE_PNG_COMPRESSION, 1]
    options += [cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY]
    if hasattr(cv2, "IMWRITE_PNG_FILTER"):  # OpenCV 4.12 on
        options += [cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP]
    bgr = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    _, data = cv2.imencode(".png", bgr, options)
    return bytes(data)
