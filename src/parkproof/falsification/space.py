"""What a search may choose: starts in a box and truths within bounds, as points of a unit cube."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import msgspec
import numpy as np
from numpy.typing import NDArray

from parkproof.bounds import Interval
from parkproof.errors import InputError
from parkproof.model.signals import Adversary, Constant, Signal, Sine, Square, Switched
from parkproof.model.truth import Gain, Truth
from parkproof.model.unicycle import headings_to_check
from parkproof.report.measured import bounds_of, gains_of, start_at, switching_of
from parkproof.scenario import RunSettings, Scenario, Start

NUMBERS = 4
"""Numbers of the cube that choose a signal: its kind, and up to three numbers of that kind."""

SLOWEST, FASTEST = 0.1, 50.0
"""Angular frequencies of the waves, in rad/s."""

WAVES = ("sine", "square", "high first", "low first")
KINDS = ("constant", "constant", "constant", *WAVES)
AGAINST = ("adversary", "adversary", "adversary", "constant", *WAVES)
"""Kinds of a gain, whose adversary is its lower bound, and of a disturbance, as often as listed."""

INSIDE = 1.0 - 1e-12
"""Waves stay by so little within their range that rounding does not take them out."""


@dataclass(frozen=True, kw_only=True)
class SearchSpace:
    """Starts and truths among which is searched.

    Attributes
    ----------
    base : Scenario
        What is not searched.
    starts : tuple of 5 intervals
        Ranges of the numbers of the start, those of `base` where it is not searched.
    signals : tuple of (str, int or None, interval)
        What is searched of the truth: a key, its channel, and its range.
    horizon : float
        Signals switch before this time, in s.

    Examples
    --------
    >>> from parkproof.bounds import Bounds
    >>> space = space_of_scenario(Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)),
    ...                                    bounds=Bounds(alpha=(0.5, 1.5))), box=(0.5, 0.1))
    >>> space.dimension, space.starts[0]
    (10, (-1.5, -0.5))
    """

    base: Scenario
    starts: tuple[Interval, ...]
    signals: tuple[tuple[str, int | None, Interval], ...]
    horizon: float

    @property
    def free(self) -> tuple[int, ...]:
        """Which numbers of the start are searched."""
        return tuple(i for i, (low, high) in enumerate(self.starts) if low < high)

    @property
    def dimension(self) -> int:
        """Numbers of a point."""
        return len(self.free) + NUMBERS * len(self.signals)

    def scenario_at(self, point: NDArray[np.float64]) -> Scenario:
        """Make the scenario that a point stands for.

        Parameters
        ----------
        point : array
            `dimension` numbers from 0 to 1.

        Returns
        -------
        Scenario
            `base` with another start and another truth.
        """
        numbers = [float(number) for number in point]
        place = [low for low, _ in self.starts]
        for i, number in zip(self.free, numbers, strict=False):
            place[i] = _between(self.starts[i], number)
        rest = numbers[len(self.free) :]
        chosen: dict[tuple[str, int | None], Signal] = {}
        for i, (key, channel, ends) in enumerate(self.signals):
            four = rest[NUMBERS * i : NUMBERS * (i + 1)]
            kinds = AGAINST if key == "disturbance" else KINDS
            chosen[key, channel] = _signal(ends, kinds, four, self.horizon)
        # a start on the floor stays as it is written where it is not searched
        start = start_of(self.base.start, place) if self.free else self.base.start
        truth = _replaced(self.base.truth, chosen)
        return msgspec.structs.replace(self.base, start=start, truth=truth)


def _between(ends: Interval, number: float) -> float:
    """A number of a range, one of its ends for half of all numbers."""
    low, high = ends
    share = min(1.0, max(0.0, 2.0 * number - 0.5))
    return high if share == 1.0 else low + share * (high - low)


def _signal(ends: Interval, kinds: Sequence[str], four: Sequence[float], horizon: float) -> Signal:
    """A signal within a range; all but constants reach both of its ends."""
    low, high = ends
    which, one, two, three = four
    kind = kinds[min(int(which * len(kinds)), len(kinds) - 1)]
    if kind == "adversary":
        return Adversary()
    if kind == "constant":
        return Constant(_between(ends, one))
    if kind in {"sine", "square"}:
        wave = Sine if kind == "sine" else Square
        return wave(
            mean=0.5 * (low + high),
            amplitude=0.5 * (high - low) * INSIDE,
            omega=SLOWEST * (FASTEST / SLOWEST) ** one,
            phase=2.0 * math.pi * two,
        )
    first, second = (high, low) if kind == "high first" else (low, high)
    times = sorted({horizon * number for number in (one, two, three)})
    return Switched(first=first, second=second, times=tuple(times))


def _replaced(truth: Truth, chosen: dict[tuple[str, int | None], Signal]) -> Truth:
    """A truth with some of its signals replaced."""
    pairs = {
        key: tuple(chosen.get((key, i), getattr(truth, key)[i]) for i in range(2))
        for key in ("alpha", "gamma", "disturbance")
    }
    b2: Gain = chosen.get(("b2", None), truth.b2)
    return msgspec.structs.replace(truth, **cast(dict[str, Any], pairs), b2=b2)


def start_of(start: Start, place: Sequence[float]) -> Start:
    """Give a start of the same kind at another place.

    Parameters
    ----------
    start : Start
        A state, or a pose, of the image or of the floor, with or without velocity.
    place : sequence of 5 floats
        Its numbers; those of a pose are of the image.

    Returns
    -------
    Start
        The start.

    Examples
    --------
    >>> start_of(Start(pose=(-1.0, 0.0, 0.0)), (-2.0, 0.1, 0.2, 0.0, 0.0)).pose
    (-2.0, 0.1, 0.2)
    """
    one, two, three, four, five = place
    if start.state is not None:
        return Start(state=(one, two, three, four, five))
    return Start(pose=(one, two, three), velocity=(four, five))


def _ranges(scenario: Scenario) -> tuple[tuple[str, int | None, Interval], ...]:
    """What may vary of a truth: as far as the bounds go, and the truth itself if it is outside."""
    known, truth = scenario.bounds, scenario.truth
    papers = scenario.camera is None
    known_ranges: list[tuple[str, int | None, Interval, Gain]] = []
    for i in range(2):
        phi = known.disturbance_of(i)
        if papers:  # another camera is what it is
            known_ranges.append(("alpha", i, known.alpha_of(i), truth.alpha[i]))
        known_ranges += [
            ("gamma", i, known.gamma_of(i), truth.gamma[i]),
            ("disturbance", i, (0.0 - phi, phi), truth.disturbance[i]),
        ]
    if papers and scenario.robot.kind == "chained":
        known_ranges.append(("b2", None, known.b2, truth.b2))
    ranges = []
    for key, channel, within, given in known_ranges:
        low, high = within
        if truth.outside_bounds and not isinstance(given, Adversary):
            least, largest = (given, given) if isinstance(given, float) else given.range
            if key == "disturbance":  # it may push either way
                least, largest = min(least, -largest), max(largest, -least)
            low, high = min(low, least), max(high, largest)
        if low < high:
            ranges.append((key, channel, (low, high)))
    return tuple(ranges)


def space_of_scenario(scenario: Scenario, *, box: Sequence[float] = ()) -> SearchSpace:
    """Starts about a scenario's own, and truths within its bounds.

    Parameters
    ----------
    scenario : Scenario
        The scenario. Where its truth lies outside its bounds, the search goes as far as it does.
    box : sequence of at most 5 floats
        By how much each number of the start may differ, in order; 0 where nothing is given.

    Returns
    -------
    SearchSpace
        The space.

    Raises
    ------
    InputError
        If a start of the box is not possible, or nothing is left to search.

    Examples
    --------
    >>> space_of_scenario(Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0))))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: nothing to search: ...
    """
    given = scenario.start.state or (*scenario.start_pose, *scenario.start_velocity)
    widths = (*box, *(0.0 for _ in range(5 - len(box))))
    starts = tuple((x - width, x + width) for x, width in zip(given, widths, strict=True))
    space = SearchSpace(
        base=scenario,
        starts=starts,
        signals=_ranges(scenario),
        horizon=scenario.run.duration,
    )
    if space.dimension == 0:
        raise InputError(
            "nothing to search: [bounds] leave the truth no choice, and there is but one start; "
            "give a box of starts, as in --box 0.5,0.2,0.1, or wider bounds"
        )
    _check_corners(space)
    return space


def _check_corners(space: SearchSpace) -> None:
    """Check that a run can start anywhere in the box: at its corners, and with headings between.

    A law that does not turn takes no heading beyond ±90°, and a box can be a whole turn wide.
    """
    heading = 2 if space.base.start.state is None else None
    probes = [
        headings_to_check(*ends) if i == heading else dict.fromkeys(ends)
        for i, ends in enumerate(space.starts)
    ]
    for corner in itertools.product(*probes):
        place = list(corner)
        try:
            msgspec.structs.replace(space.base, start=start_of(space.base.start, place))
        except InputError as error:
            raise InputError(f"a start in the box: {error}; or make the box smaller") from error


def space_of_certificate(certificate: dict[str, Any], run: RunSettings) -> SearchSpace:
    """Starts and truths that a certificate speaks of.

    Parameters
    ----------
    certificate : dict
        The certificate.
    run : RunSettings
        How its runs are carried out.

    Returns
    -------
    SearchSpace
        The space.

    Raises
    ------
    InputError
        If its numbers make no scenario.
    """
    box = certificate["assumptions"]["starts"]
    starts = tuple((float(low), float(high)) for low, high in box.values())
    if crossed := [name for name, (low, high) in box.items() if low > high]:
        raise InputError(f"the certificate's range of starts {crossed[0]} is crossed")
    worst = (Adversary(), Adversary())
    base = Scenario(
        law=certificate["law"]["name"],
        bounds=bounds_of(certificate),
        gains=gains_of(certificate),
        switching=switching_of(certificate),
        truth=Truth(alpha=worst, gamma=worst, disturbance=worst, b2=Adversary()),
        start=start_at({name: float(high) for name, (_, high) in box.items()}),
        run=run,
    )
    return SearchSpace(base=base, starts=starts, signals=_ranges(base), horizon=run.duration)
