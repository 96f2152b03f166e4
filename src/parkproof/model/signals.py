"""Named kinds of signals for γ, φ, α and b2: constant, waves, switched, seeded noise, adversary."""

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
from msgspec.structs import force_setattr

from parkproof.errors import InputError
from parkproof.scalar import scalar, sign, sine
from parkproof.validate import finite, not_negative, positive

if TYPE_CHECKING:
    from numpy.typing import NDArray

FASTEST = 1e6
"""Highest angular frequency in rad/s: far above what a plant step can follow."""

TONES = 8
"""Number of sines in band-limited noise."""

SLOW = 1e-8
"""Angular frequency in rad/s of a square wave that jumps once in a run: its period is 20 years."""

MOST_SWITCHES = 64
"""Most times of a switched signal: each costs a tone."""


class Tone(NamedTuple):
    """One periodic component: amplitude·wave(ω·t + phase), a sine or (square = 1) its sign."""

    amplitude: float
    omega: float
    phase: float
    square: float


@scalar
def tone_value(amplitude: float, omega: float, phase: float, square: float, t: float) -> float:
    """Value of one tone.

    Parameters
    ----------
    amplitude, omega, phase : float
        Amplitude, angular frequency in rad/s, phase in rad.
    square : float
        0 for a sine, 1 for a square wave.
    t : float
        Time in s.

    Returns
    -------
    float
        amplitude·sin(ω·t + phase), or amplitude·sign(sin(ω·t + phase)).

    Examples
    --------
    >>> tone_value(2.0, 1.0, 0.5, 1.0, 0.0)
    2.0
    """
    wave = sine(omega * t + phase)
    return amplitude * (sign(wave) if square > 0.0 else wave)


class Constant(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="constant"
):
    """A constant.

    Parameters
    ----------
    value : float
        The constant.

    Examples
    --------
    >>> Constant(1.5).range
    (1.5, 1.5)
    """

    value: float

    def __post_init__(self) -> None:
        force_setattr(self, "value", finite("value", self.value))

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest value."""
        return self.value, self.value

    @property
    def mean_and_tones(self) -> tuple[float, tuple[Tone, ...]]:
        """Mean and periodic components."""
        return self.value, ()


def _frequency(name: str, value: float) -> float:
    if positive(name, value, example=10.0) > FASTEST:
        raise InputError(f"{name} = {value:g} rad/s: at most {FASTEST:g}; write a lower frequency")
    return float(value)


class _Periodic(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What sine and square wave have in common."""

    mean: float = 0.0
    amplitude: float
    omega: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        for name in ("mean", "amplitude", "phase"):
            force_setattr(self, name, finite(name, getattr(self, name)))
        force_setattr(self, "omega", _frequency("omega", self.omega))

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest value."""
        return self.mean - abs(self.amplitude), self.mean + abs(self.amplitude)


class Sine(_Periodic, frozen=True, kw_only=True, tag_field="kind", tag="sine"):
    """mean + amplitude·sin(omega·t + phase).

    Parameters
    ----------
    mean, amplitude : float
        Mean and amplitude.
    omega : float
        Angular frequency in rad/s, positive.
    phase : float
        Phase in rad.

    Raises
    ------
    InputError
        If a number is not finite or omega not positive.

    Examples
    --------
    >>> Sine(mean=1.5, amplitude=0.5, omega=1.0).range
    (1.0, 2.0)
    """

    @property
    def mean_and_tones(self) -> tuple[float, tuple[Tone, ...]]:
        """Mean and periodic components."""
        return self.mean, (Tone(self.amplitude, self.omega, self.phase, 0.0),)


class Square(_Periodic, frozen=True, kw_only=True, tag_field="kind", tag="square"):
    """mean + amplitude·sign(sin(omega·t + phase)).

    Parameters
    ----------
    mean, amplitude : float
        Mean and amplitude.
    omega : float
        Angular frequency in rad/s, positive.
    phase : float
        Phase in rad.

    Raises
    ------
    InputError
        If a number is not finite or omega not positive.

    Examples
    --------
    >>> Square(amplitude=2.5, omega=3.0).range
    (-2.5, 2.5)
    """

    @property
    def mean_and_tones(self) -> tuple[float, tuple[Tone, ...]]:
        """Mean and periodic components."""
        return self.mean, (Tone(self.amplitude, self.omega, self.phase, 1.0),)


class Switched(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    tag_field="kind",
    tag="switched",
):
    """One value until the first time, another until the second, then the first again, and so on.

    Parameters
    ----------
    first, second : float
        The two values.
    times : list of float
        When it switches, in s, increasing.

    Raises
    ------
    InputError
        If a number is not finite, there are no times or more than 64, or they do not increase
        from 0 or later.

    Examples
    --------
    >>> push = Switched(first=2.5, second=-2.5, times=(1.0, 3.0))
    >>> [signal_value(*push.mean_and_tones, t) for t in (0.5, 2.0, 4.0)]
    [2.5, -2.5, 2.5]
    """

    first: float
    second: float
    times: tuple[float, ...]

    def __post_init__(self) -> None:
        for name in ("first", "second"):
            force_setattr(self, name, finite(name, getattr(self, name)))
        times = tuple(not_negative("times", value) for value in self.times)
        if not 1 <= len(times) <= MOST_SWITCHES or any(b <= a for a, b in pairwise(times)):
            raise InputError(
                f"times = {list(times)}: must be 1 to {MOST_SWITCHES} increasing times in s; write "
                "for example times = [1.0, 2.5]"
            )
        if times[-1] >= 1.0 / SLOW:
            raise InputError(f"times = {list(times)}: must be below {1.0 / SLOW:g} s")
        force_setattr(self, "times", times)

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest value."""
        return min(self.first, self.second), max(self.first, self.second)

    @property
    def mean_and_tones(self) -> tuple[float, tuple[Tone, ...]]:
        """Mean and, for each time, a square wave that jumps there and not again in any run."""
        half = 0.5 * (self.first - self.second)
        mean = 0.5 * (self.first + self.second) if len(self.times) % 2 else self.first
        return mean, tuple(
            Tone(half if i % 2 else -half, SLOW, -SLOW * time, 1.0)
            for i, time in enumerate(self.times)
        )


class Noise(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    tag_field="kind",
    tag="noise",
):
    """Seeded band-limited noise: eight sines with random frequencies, phases and weights.

    Parameters
    ----------
    mean : float
        Mean.
    amplitude : float
        The noise never leaves mean ± amplitude (the weights add up to it).
    bandwidth : float
        No frequency exceeds it, in rad/s.
    seed : int
        The same seed gives the same noise.

    Raises
    ------
    InputError
        If a number is not finite, the bandwidth not positive, or the seed negative.

    Examples
    --------
    >>> noise = Noise(amplitude=2.5, bandwidth=20.0, seed=7)
    >>> mean, tones = noise.mean_and_tones
    >>> round(sum(abs(tone.amplitude) for tone in tones), 9), max(t.omega for t in tones) <= 20.0
    (2.5, True)
    """

    mean: float = 0.0
    amplitude: float
    bandwidth: float
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("mean", "amplitude"):
            force_setattr(self, name, finite(name, getattr(self, name)))
        force_setattr(self, "bandwidth", _frequency("bandwidth", self.bandwidth))
        not_negative("seed", self.seed)

    @property
    def range(self) -> tuple[float, float]:
        """Bounds that the noise never leaves."""
        return self.mean - abs(self.amplitude), self.mean + abs(self.amplitude)

    @property
    def mean_and_tones(self) -> tuple[float, tuple[Tone, ...]]:
        """Mean and periodic components."""
        places, phases, weights = noise_spectrum(self.seed)
        omegas = self.bandwidth * places / TONES
        amplitudes = self.amplitude * weights / weights.sum()
        return self.mean, tuple(
            Tone(float(a), float(w), float(f), 0.0)
            for a, w, f in zip(amplitudes, omegas, phases, strict=True)
        )


def noise_spectrum(seed: int) -> "tuple[NDArray[Any], NDArray[Any], NDArray[Any]]":
    """What the seed of a `Noise` decides.

    Parameters
    ----------
    seed : int
        Its seed.

    Returns
    -------
    three arrays
        Places of the frequencies, in eighths of the bandwidth; phases in rad; weights, which do not
        add up to 1.

    Examples
    --------
    >>> places, phases, weights = noise_spectrum(7)
    >>> [int(place) for place in places]
    [0, 1, 2, 3, 4, 5, 6, 7]
    """
    import numpy as np

    rng = np.random.default_rng(seed)
    places = np.arange(TONES) + rng.random(TONES)
    return places, 2.0 * math.pi * rng.random(TONES), 0.5 + rng.random(TONES)


class Adversary(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="adversary"
):
    """Makes Theorem 1's inequality as tight as the bounds allow, at every instant.

    As a gain it is the lower bound, γ_i = γ_i^m, and so for α and b2; as a disturbance
    φ_i = −φ_i^M·sign τ̃_i, so nothing where τ̃_i = 0.

    Examples
    --------
    >>> Adversary()
    Adversary()
    """


Signal = Constant | Sine | Square | Switched | Noise | Adversary


def signal_value(mean: float, tones: tuple[Tone, ...], t: float) -> float:
    """Value of a signal given by its mean and tones.

    Parameters
    ----------
    mean : float
        Mean.
    tones : tuple of Tone
        Periodic components.
    t : float
        Time in s.

    Returns
    -------
    float
        The value at t.

    Examples
    --------
    >>> signal_value(*Sine(mean=1.0, amplitude=2.0, omega=1.0).mean_and_tones, 0.0)
    1.0
    """
    for amplitude, omega, phase, square in tones:
        mean += tone_value(amplitude, omega, phase, square, t)
    return mean


def check_range(name: str, signal: Signal, low: float, high: float) -> None:
    """Check that a signal stays inside its bounds.

    Parameters
    ----------
    name : str
        What the signal is called where the user wrote it.
    signal : Signal
        The signal; an adversary stays inside by definition.
    low, high : float
        The bounds.

    Raises
    ------
    InputError
        If it can leave them.

    Examples
    --------
    >>> check_range("gamma[0]", Constant(1.5), 1.0, 2.0)
    """
    if isinstance(signal, Adversary):
        return
    smallest, largest = signal.range
    slack = 1e-12 * max(abs(low), abs(high), 1.0)
    if smallest < low - slack or largest > high + slack:
        raise InputError(
            f"{name} ranges over [{smallest:g}, {largest:g}], outside its bounds "
            f"[{low:g}, {high:g}]: widen the bounds, or write outside_bounds = true under [truth] "
            "for an experiment outside the guarantee"
        )
