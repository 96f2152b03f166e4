"""Cameras of a laboratory, by what they are called: USB, network, a video, a folder of images."""

import contextlib
import os
import re
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.lab.footage import Footage, folder, video
from parkproof.lab.live_camera import LiveCamera
from parkproof.validate import positive

NETWORK = ("rtsp://", "rtsps://", "http://", "https://")
"""How the address of a network camera begins."""

NETWORK_PATIENCE = 5000
"""How long OpenCV may wait for a network camera, in ms."""

FORMS = "usb:0, rtsp://address, a video file or a folder of images"


def open_camera(
    source: str, *, rate: float | None = None, paced: bool = False
) -> LiveCamera | Footage:
    """Open a camera, or footage in its place.

    A camera that is live is read in a thread that keeps only the newest frame and stamps it on
    arrival with `time.monotonic`. What has passed since the exposure belongs to the latency that
    ``parkproof camera --latency`` measures.

    Parameters
    ----------
    source : str
        "0" or "usb:0": a USB camera by its number. "rtsp://..." or "http://...": a network camera.
        Else a video file, or a folder of images in the order of their names, whose times stand in
        times.csv (columns file and t).
    rate : float, optional
        Frames per second: what a USB camera is asked for, and those of footage that does not say
        when its frames were taken (default 30). A network camera ignores it.
    paced : bool
        Give frames of a video or a folder at the times at which they were taken, as a live camera
        would. Else one after the other, as fast as they are read, with the times in the footage.

    Returns
    -------
    LiveCamera or Footage
        A `parkproof.lab.devices.Camera`. Once it has ended, ``why_ended`` says why.

    Raises
    ------
    InputError
        If there is no such camera or file, or it gives no frame.

    Examples
    --------
    >>> open_camera("no_such_video.mp4")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: source = no_such_video.mp4: there is no such ...
    """
    if rate is not None:
        positive("rate", rate, example=30.0)
    require("cv2", extra="lab", purpose="reading a camera")
    number = _usb_number(source)
    path = Path(source)
    with _quiet():
        if number is not None:
            return _usb(number, rate)
        if source.lower().startswith(NETWORK):
            return _network(source)
        if source and path.is_dir():
            return folder(path, rate=rate, paced=paced)
        if source and path.is_file():
            return video(path, rate=rate, paced=paced)
    raise InputError(f"source = {source}: there is no such camera, file or folder; write {FORMS}")


def _usb_number(source: str) -> int | None:
    """The number of a USB camera, if that is what is named."""
    found = re.fullmatch(r"(?:usb:|/dev/video)?(\d{1,4})", source)
    if found is not None:
        return int(found[1])
    if source.startswith("usb:"):
        raise InputError(f"source = {source}: must be usb: and a number; write for example usb:0")
    return None


def _usb(number: int, rate: float | None) -> LiveCamera:
    import cv2

    device = Path(f"/dev/video{number}")
    linux = sys.platform.startswith("linux")
    if linux and not (device.exists() and stat.S_ISCHR(device.stat().st_mode)):
        others = sorted(other.name for other in Path("/dev").glob("video[0-9]*"))
        there = [f"usb:{name.removeprefix('video')}" for name in others]
        raise InputError(
            f"source = usb:{number}: there is no {device}; "
            + (f"there are {', '.join(there)}" if there else "no USB camera is plugged in")
        )
    capture = cv2.VideoCapture(number, cv2.CAP_V4L2 if linux else cv2.CAP_ANY)
    if not capture.isOpened():
        capture.release()
        raise InputError(
            f"source = usb:{number}: cannot be opened as a camera; see that no other program uses "
            "it and that you may read it, or try the next number"
        )
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    if rate is not None:
        capture.set(cv2.CAP_PROP_FPS, rate)
    return LiveCamera(capture, name=f"usb:{number}")


def _network(source: str) -> LiveCamera:
    import cv2

    patience = [
        cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, NETWORK_PATIENCE,
        cv2.CAP_PROP_READ_TIMEOUT_MSEC, NETWORK_PATIENCE,
    ]  # fmt: skip
    capture = cv2.VideoCapture(source, cv2.CAP_FFMPEG, patience)
    # The address may hold a password.
    name = re.sub(r"//[^/@]*@", "//", source)
    if not capture.isOpened():
        capture.release()
        raise InputError(
            f"source = {name}: no camera answers there; see that it is on and that the address, "
            "name and password are right"
        )
    return LiveCamera(capture, name=name)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Let OpenCV and FFmpeg not write to standard error what an `InputError` says better."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # read once, when FFmpeg is first used
    import cv2

    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(level)
