"""Checks of single numbers, shared by everything that takes parameters from a user."""

import math
import re
from collections.abc import Sequence
from fractions import Fraction

from parkproof.errors import InputError

MAX_DENOMINATOR = 999
"""Exponents given as decimals are recognised as ratios up to this denominator."""


def finite(name: str, value: float) -> float:
    """Return the value as a float, or raise if it is not a finite number.

    Parameters
    ----------
    name : str
        What the number is called where the user wrote it.
    value : float
        The number.

    Returns
    -------
    float
        The same number.

    Raises
    ------
    InputError
        If it is NaN, infinite or not a number.

    Examples
    --------
    >>> finite("duration", 35)
    35.0
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(f"{name} = {value}: must be a finite number; replace it with one")
    return float(value)


def positive(name: str, value: float, *, example: float = 1.0) -> float:
    """Return the value as a float, or raise if it is not positive and finite.

    Parameters
    ----------
    name : str
        What the number is called where the user wrote it.
    value : float
        The number.
    example : float
        A value that would do, for the message.

    Returns
    -------
    float
        The same number.

    Raises
    ------
    InputError
        If it is not a finite number greater than 0.

    Examples
    --------
    >>> positive("lambda1", 2)
    2.0
    """
    if not finite(name, value) > 0.0:
        raise InputError(
            f"{name} = {value}: must be greater than 0; write for example {name} = {example}"
        )
    return float(value)


def not_negative(name: str, value: float) -> float:
    """Return the value as a float, or raise if it is negative or not finite.

    Parameters
    ----------
    name : str
        What the number is called where the user wrote it.
    value : float
        The number.

    Returns
    -------
    float
        The same number.

    Raises
    ------
    InputError
        If it is not a finite number of at least 0.

    Examples
    --------
    >>> not_negative("disturbance", 0)
    0.0
    """
    if finite(name, value) < 0.0:
        raise InputError(f"{name} = {value}: must not be negative; write {name} = {abs(value)}")
    return float(value)


def within(name: str, value: float, low: float, high: float, *, unit: str = "") -> float:
    """Return the value as a float, or raise if it does not lie in an interval.

    Parameters
    ----------
    name : str
        What the number is called where the user wrote it.
    value : float
        The number.
    low, high : float
        The interval, ends included.
    unit : str
        Of the number, for the message.

    Returns
    -------
    float
        The same number.

    Raises
    ------
    InputError
        If it is not a finite number in the interval.

    Examples
    --------
    >>> within("rate", 30, 1.0, 1000.0)
    30.0
    """
    if not low <= finite(name, value) <= high:
        nearest = low if value < low else high
        raise InputError(
            f"{name} = {value}: must be in [{low:g}, {high:g}]{unit and ' '}{unit}; the nearest "
            f"is {name} = {nearest:g}"
        )
    return float(value)


def whole_number(name: str, value: int) -> int:
    """Return a whole number, or raise if it is not one or is negative.

    Parameters
    ----------
    name : str
        What it is called where the user wrote it.
    value : int
        The number.

    Returns
    -------
    int
        The number.

    Raises
    ------
    InputError
        If it is no whole number, or below 0.

    Examples
    --------
    >>> whole_number("seed", 3)
    3
    """
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise InputError(
            f"{name} = {value!r}: must be a whole number, not negative; "
            f"write for example {name} = 0"
        )
    return value


def increasing(name: str, values: Sequence[float]) -> tuple[float, float]:
    """Return a pair (low, high) of finite floats, or raise if it is crossed.

    Parameters
    ----------
    name : str
        What the pair is called where the user wrote it.
    values : sequence of 2 floats
        Low and high end.

    Returns
    -------
    tuple of 2 floats
        The same pair.

    Raises
    ------
    InputError
        If an end is not finite, or low > high.

    Examples
    --------
    >>> increasing("alpha", [0.5, 1.5])
    (0.5, 1.5)
    """
    if len(values) != 2:
        raise InputError(
            f"{name} = {list(values)}: must be two numbers; write {name} = [low, high]"
        )
    low, high = (finite(name, value) for value in values)
    if low > high:
        raise InputError(
            f"{name} = [{low}, {high}]: the bounds are crossed; write {name} = [{high}, {low}]"
        )
    return low, high


_NUMBER_OR_RATIO = re.compile(r"\s*[+-]?\d{1,25}(\.\d{0,25})?([eE][+-]?\d{1,3})?(/\d{1,25})?\s*")
"""What may be given to Fraction: without limits on its length, "1e99999999" would take for ever."""


def _no_ratio(name: str, value: object) -> InputError:
    return InputError(f'{name} = {value!r}: must be a number or a ratio; write for example "9/11"')


class Ratio(float):
    """A float that remembers the ratio of integers it was given as.

    Parameters
    ----------
    value : str, int or float
        "9/11", or a decimal; a decimal within 1e-12 of a ratio with denominator up to 999 counts
        as that ratio.

    Raises
    ------
    InputError
        If it cannot be read as a finite number.

    Examples
    --------
    >>> Ratio("9/11") == 9 / 11, str(Ratio(9 / 11)), Ratio("4/5").is_odd_over_odd
    (True, '9/11', False)
    """

    fraction: Fraction | None

    def __new__(cls, value: str | float, name: str = "exponent") -> "Ratio":
        """Read the ratio; ``name`` is what the user calls it."""
        if isinstance(value, str) and not _NUMBER_OR_RATIO.fullmatch(value):
            raise _no_ratio(name, value)
        try:
            number = float(Fraction(value)) if isinstance(value, str) else finite(name, value)
        except (ZeroDivisionError, OverflowError) as error:
            raise _no_ratio(name, value) from error
        near = Fraction(number).limit_denominator(MAX_DENOMINATOR)
        is_near = abs(float(near) - number) <= 1e-12
        self = super().__new__(cls, float(near) if is_near else number)
        self.fraction = near if is_near else None
        return self

    def __str__(self) -> str:
        return str(self.fraction) if self.fraction is not None else repr(float(self))

    @property
    def is_odd_over_odd(self) -> bool:
        """Whether this is a ratio of odd integers in lowest terms, as the paper's exponents."""
        fraction = self.fraction
        return (
            fraction is not None and fraction.numerator % 2 == 1 and fraction.denominator % 2 == 1
        )
