"""Finds the period of a camera from the time stamps of its frames."""

import statistics
from collections import deque

KEPT = 15
"""Intervals between frames that are kept."""

LEAST = 5
"""Intervals from which on a rate is told."""

NEAR = 0.1
"""Share by which a period may differ from the one that is expected and still be taken for it."""


class FrameRate:
    """The period of the frames: as it is set, unless the frames show another one.

    Parameters
    ----------
    rate : float
        Frames per s that are expected.

    Examples
    --------
    >>> frames = FrameRate(30.0)
    >>> for number in range(8):
    ...     frames.take(number / 15.0, number)
    >>> round(frames.period * 15.0, 6), round(frames.other, 3)
    (1.0, 15.0)
    """

    def __init__(self, rate: float) -> None:
        self._expected = 1.0 / rate
        self._intervals: deque[float] = deque(maxlen=KEPT)
        self._last: tuple[float, int] | None = None

    def take(self, t: float, number: int) -> None:
        """Take in a frame: its time of capture in s, and its number, so that gaps are known."""
        last, self._last = self._last, (t, number)
        if last is not None and t > last[0] and number > last[1]:
            self._intervals.append((t - last[0]) / (number - last[1]))

    @property
    def period(self) -> float:
        """Time between frames in s."""
        if not self._intervals:
            return self._expected
        found = statistics.median(self._intervals)
        near = abs(found - self._expected) <= NEAR * self._expected
        return self._expected if near else found

    @property
    def other(self) -> float | None:
        """The rate in frames per s, once it is known and not as expected."""
        period = self.period
        if len(self._intervals) < LEAST or period == self._expected:
            return None
        return 1.0 / period
