"""Distributions of a number that differs from trial to trial, each by its quantile function."""

import math
from typing import Any

import msgspec
import numpy as np
from msgspec.structs import force_setattr
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.validate import finite, positive

Numbers = NDArray[np.float64]


class Uniform(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    tag_field="kind",
    tag="uniform",
):
    """Any number between two ends alike; for seeds, any whole number from low to high.

    Parameters
    ----------
    low, high : float
        The ends.

    Raises
    ------
    InputError
        If they are not finite, or low is not below high.

    Examples
    --------
    >>> Uniform(low=1.0, high=3.0).values(np.array([0.0, 0.25]))
    array([1. , 1.5])
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        _apart(self)

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest value."""
        return self.low, self.high

    def values(self, numbers: Numbers) -> Numbers:
        """Give the values of numbers in [0, 1)."""
        return np.minimum(self.low + (self.high - self.low) * numbers, self.high)

    def whole_values(self, numbers: Numbers) -> Numbers:
        """Give the whole values of numbers in [0, 1), each alike."""
        low, high = math.ceil(self.low), math.floor(self.high)
        whole = low + np.floor((high - low + 1) * numbers)
        return np.asarray(np.minimum(whole, high), dtype=np.float64)


class LogUniform(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    tag_field="kind",
    tag="log-uniform",
):
    """A number whose logarithm is uniform: all orders of magnitude alike.

    Parameters
    ----------
    low, high : float
        The ends, both positive.

    Raises
    ------
    InputError
        If an end is not finite or not positive, or low is not below high.

    Examples
    --------
    >>> LogUniform(low=0.1, high=10.0).values(np.array([0.0, 0.5])).round(12)
    array([0.1, 1. ])
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        positive("low", self.low, example=0.1)
        _apart(self)

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest value."""
        return self.low, self.high

    def values(self, numbers: Numbers) -> Numbers:
        """Give the values of numbers in [0, 1)."""
        low, high = math.log(self.low), math.log(self.high)
        return np.clip(np.exp(low + (high - low) * numbers), self.low, self.high)


class Normal(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    tag_field="kind",
    tag="normal",
):
    """A normal distribution, cut at two ends.

    Parameters
    ----------
    mean, deviation : float
        Of the distribution that is not cut.
    low, high : float
        Where it is cut: every value in between can be drawn, none beyond.

    Raises
    ------
    InputError
        If a number is not finite, the deviation is not positive, low is not below high, or the ends
        are more than 30 deviations to one side of the mean.

    Examples
    --------
    >>> Normal(mean=1.0, deviation=0.1, low=0.8, high=1.2).values(np.array([0.5])).round(12)
    array([1.])
    """

    mean: float
    deviation: float
    low: float
    high: float

    def __post_init__(self) -> None:
        force_setattr(self, "mean", finite("mean", self.mean))
        force_setattr(self, "deviation", positive("deviation", self.deviation, example=0.1))
        _apart(self)
        away = max(self.low - self.mean, self.mean - self.high) / self.deviation
        if away > FARTHEST:
            raise InputError(
                f"[low, high] = [{self.low:g}, {self.high:g}] lies {away:.3g} deviations from mean "
                f"= {self.mean:g}, where nothing is ever drawn; write ends around the mean"
            )

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest value."""
        return self.low, self.high

    def values(self, numbers: Numbers) -> Numbers:
        """Give the values of numbers in [0, 1)."""
        from scipy.stats import truncnorm

        low, high = ((end - self.mean) / self.deviation for end in self.ends)
        drawn = truncnorm.ppf(numbers, low, high, loc=self.mean, scale=self.deviation)
        return np.asarray(np.clip(drawn, self.low, self.high), dtype=np.float64)


FARTHEST = 30.0
"""In deviations: farther out the tail of a normal distribution is beyond the floats."""


class Choice(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    tag_field="kind",
    tag="choice",
):
    """One of the given values, all alike.

    Parameters
    ----------
    values : tuple
        Numbers, or whatever the scenario's key takes.

    Raises
    ------
    InputError
        If there are none, or a number is not finite.

    Examples
    --------
    >>> Choice(values=(0.0, 0.03)).indices(np.array([0.2, 0.7]))
    array([0, 1])
    """

    values: tuple[Any, ...]

    def __post_init__(self) -> None:
        if not self.values:
            raise InputError("values = []: a choice needs at least one value; give some")
        for value in self.values:
            if isinstance(value, float):
                finite("values", value)

    def indices(self, numbers: Numbers) -> NDArray[np.int64]:
        """Give the place in ``values`` of what numbers in [0, 1) choose."""
        return np.minimum((numbers * len(self.values)).astype(np.int64), len(self.values) - 1)


class Constant(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    tag_field="kind",
    tag="constant",
):
    """The same value in every trial.

    Parameters
    ----------
    value : object
        Whatever the scenario's key takes.

    Examples
    --------
    >>> Constant(value=1.5).value
    1.5
    """

    value: Any


Distribution = Uniform | LogUniform | Normal | Choice | Constant
"""A table with a ``kind``."""

Continuous = Uniform | LogUniform | Normal
"""Those between two ends."""


def _apart(given: Uniform | LogUniform | Normal) -> None:
    """Check that two ends are finite and in order, and keep them as floats."""
    for name in ("low", "high"):
        force_setattr(given, name, finite(name, getattr(given, name)))
    if not given.low < given.high:
        raise InputError(
            f"low = {given.low:g}, high = {given.high:g}: low must be below high; change them, or "
            f'write kind = "constant" with value = {given.low:g}'
        )
    if not math.isfinite(given.high - given.low):
        raise InputError(
            f"low = {given.low:g}, high = {given.high:g}: too far apart to draw between them; "
            "write nearer ends"
        )
