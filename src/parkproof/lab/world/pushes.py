"""Pushes on the robot: drawn from the seed, one after the other, whatever else happens."""

import math
from typing import NamedTuple

import msgspec
import numpy as np
from msgspec.structs import force_setattr

from parkproof.validate import within

_STREAM = 2
"""Stream of the seed from which pushes are drawn."""


class PushSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Horizontal pushes on the robot: at random times, in random directions, off its centre.

    Parameters
    ----------
    force : float
        Largest force in N; each push has between a half and all of it. 0: no pushes.
    duration : float
        Duration of a push in s.
    rate : float
        Pushes in a second, on average.
    lever : float
        Largest distance in m of a push's line from the robot's centre, by which it turns it.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> PushSettings(force=1.0).duration
    0.2
    """

    force: float = 0.0
    duration: float = 0.2
    rate: float = 0.5
    lever: float = 0.05

    def __post_init__(self) -> None:
        for name, low, high, unit in (
            ("force", 0.0, 1e3, "N"),
            ("lever", 0.0, 1.0, "m"),
            ("duration", 1e-3, 1e3, "s"),
            ("rate", 1e-3, 1e3, "pushes/s"),
        ):
            force_setattr(self, name, within(name, getattr(self, name), low, high, unit=unit))


class Push(NamedTuple):
    """A constant horizontal force on the robot for a while.

    Parameters
    ----------
    start, end : float
        Times in s.
    force_x, force_y : float
        Force along the floor's axes in N.
    torque : float
        Moment about the vertical in N m.

    Examples
    --------
    >>> Push(start=1.0, end=1.2, force_x=0.5, force_y=0.0, torque=0.01).end
    1.2
    """

    start: float
    end: float
    force_x: float
    force_y: float
    torque: float


class Pushes:
    """Gives pushes in order of time: random gaps, forces, directions and levers.

    Parameters
    ----------
    settings : PushSettings
        Their bounds.
    seed : int
        The world's seed.

    Examples
    --------
    >>> pushes = Pushes(PushSettings(force=1.0), seed=0)
    >>> push = pushes.next_after(0.0)
    >>> math.hypot(push.force_x, push.force_y) <= 1.0
    True
    >>> Pushes(PushSettings(), seed=0).next_after(0.0) is None
    True
    """

    def __init__(self, settings: PushSettings, seed: int) -> None:
        self._settings = settings
        self._rng = np.random.default_rng((seed, _STREAM))
        self._current: Push | None = None
        self._end = 0.0

    def next_after(self, t: float) -> Push | None:
        """Return the first push that ends after t; t must not decrease from call to call.

        Parameters
        ----------
        t : float
            Time in s.

        Returns
        -------
        Push or None
            The push, acting already or still to come; None if there are none.
        """
        if self._settings.force == 0.0:
            return None
        while self._current is None or self._current.end <= t:
            self._current = self._draw()
        return self._current

    def _draw(self) -> Push:
        settings, rng = self._settings, self._rng
        start = self._end + rng.exponential(1.0 / settings.rate)
        self._end = start + settings.duration
        size = settings.force * rng.uniform(0.5, 1.0)
        direction = rng.uniform(-math.pi, math.pi)
        lever = settings.lever * rng.uniform(-1.0, 1.0)
        return Push(
            start=start,
            end=self._end,
            force_x=size * math.cos(direction),
            force_y=size * math.sin(direction),
            torque=size * lever,
        )
