"""A camera that goes on whether its frames are read or not: the newest one is kept."""

import atexit
import threading
import time
from contextlib import suppress
from typing import Any, Protocol

from parkproof.errors import InputError
from parkproof.lab.devices import Frame, Missing
from parkproof.lab.footage import colours

FAILURES = 10
"""So many frames in a row that cannot be read are the end; fewer are only lost."""

LAST_FRAME = 6.0
"""How long closing may wait in s: a camera that went silent keeps OpenCV waiting that long."""


class Capture(Protocol):
    """What is needed of OpenCV's VideoCapture."""

    def read(self) -> tuple[bool, Any]:
        """Wait for the next frame: whether there is one, and the frame."""

    def release(self) -> None:
        """Give the camera back."""


class LiveCamera:
    """Reads a camera in a thread, which keeps the newest frame and stamps it when it arrives.

    Parameters
    ----------
    capture : Capture
        An open OpenCV capture.
    name : str
        What it is, for messages.
    patience : float
        How long to wait for the first frame, in s.

    Raises
    ------
    InputError
        If no frame comes.

    Attributes
    ----------
    why_ended : str
        After `Missing.ENDED`, why.

    Examples
    --------
    >>> import numpy as np
    >>> class Dark:
    ...     def read(self):
    ...         time.sleep(0.01)
    ...         return True, np.zeros((480, 640, 3), np.uint8)
    ...     def release(self):
    ...         pass
    >>> camera = LiveCamera(Dark(), name="a dark one")
    >>> camera.read(1.0).image.shape
    (480, 640, 3)
    >>> camera.close()
    >>> camera.read(1.0)
    <Missing.ENDED: 'the camera has ended'>
    """

    def __init__(self, capture: Capture, *, name: str, patience: float = 10.0) -> None:
        self._capture = capture
        self._name = name
        self._change = threading.Condition()
        self._newest: Frame | None = None
        self._closed = False
        self.why_ended = ""
        self._thread = threading.Thread(target=self._keep, name=f"camera {name}", daemon=True)
        self._thread.start()
        # Python must not end while OpenCV works in a thread: the process would be aborted.
        atexit.register(self.close)
        with self._change:
            self._change.wait_for(lambda: self._newest or self.why_ended, patience)
            come = self._newest is not None
        if not come:
            self.close()
            raise InputError(
                f"{name}: the camera gives no frame; see that no other program uses it and that "
                "its cable is in, or choose another source"
            )

    def read(self, timeout: float) -> Frame | Missing:
        """The newest frame that was not read yet; waits at most ``timeout`` s for it."""
        with self._change:
            self._change.wait_for(lambda: self._newest or self.why_ended, max(timeout, 0.0))
            frame, self._newest = self._newest, None
            if frame is not None and not self._closed:
                return frame
            return Missing.ENDED if self.why_ended else Missing.LATE

    def close(self) -> None:
        """Give the camera back. May be called twice."""
        with self._change:
            self._closed = True
            self.why_ended = self.why_ended or f"{self._name} was closed"
            self._change.notify_all()
        self._thread.join(timeout=LAST_FRAME)  # which gives the camera back
        atexit.unregister(self.close)

    def _keep(self) -> None:
        number = failures = 0
        size: tuple[int, ...] | None = None
        try:
            while not self._closed and failures < FAILURES:
                whole, image = self._capture.read()
                t = time.monotonic()
                if not whole or image is None or image.size == 0:
                    failures += 1
                    time.sleep(0.01 * failures)
                    continue
                failures = 0
                size = size or image.shape[:2]
                if image.shape[:2] != size:
                    self._end(f"{self._name} has changed the size of its frames")
                    return
                self._show(Frame(colours(image), t=t, number=number))
                number += 1
            self._end(f"{self._name} gives no frames any more, after {number}: unplugged?")
        except Exception as error:  # drivers raise what they like; a reader waits
            self._end(f"{self._name} failed after {number} frames: {error}")
        finally:
            with suppress(Exception):  # nothing is left to be done about it
                self._capture.release()

    def _show(self, frame: Frame) -> None:
        with self._change:
            self._newest = frame
            self._change.notify_all()

    def _end(self, why: str) -> None:
        with self._change:
            self.why_ended = self.why_ended or why
            self._change.notify_all()
