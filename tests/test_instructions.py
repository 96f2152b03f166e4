"""What stands for max, min and int in compiled code gives what Python gives."""

import math
from itertools import product
from typing import Any

import numba
import numpy as np
import pytest

from parkproof.simulation.compiler import KERNEL, inlined

NUMBERS = (-math.inf, -2.5, -0.0, 0.0, 1.0, math.nan)


@inlined
def extremes(a: Any, b: Any, c: Any, d: Any) -> Any:
    return max(a, b), min(a, b), max(a, b, c), min(a, b, c), max(a, b, c, d), min(a, b, c, d)


@numba.njit(**KERNEL)  # type: ignore[untyped-decorator]
def compiled_extremes(a: Any, b: Any, c: Any, d: Any) -> Any:
    return extremes(a, b, c, d)


def bits(numbers: Any) -> list[bytes]:
    return [np.float64(number).tobytes() for number in numbers]


def test_the_first_number_stays_unless_a_later_one_is_beyond_it() -> None:
    for a, b, c, d in product(NUMBERS, repeat=4):
        assert bits(compiled_extremes(a, b, c, d)) == bits(extremes(a, b, c, d))


def test_whole_numbers_are_compared_as_such() -> None:
    for numbers in product((-(2**62), -1, 0, 2**62 + 1), repeat=4):
        assert compiled_extremes(*numbers) == extremes(*numbers)


def test_whole_numbers_and_others_are_compared_as_numbers() -> None:
    assert compiled_extremes(1, 0.5, -2, 3.5) == (1.0, 0.5, 1.0, -2.0, 3.5, -2.0)


@pytest.mark.parametrize("number", [0.0, -0.0, 2.9, -2.9, 7])
def test_int_cuts_off_as_python_does(number: float) -> None:
    @numba.njit(**KERNEL)  # type: ignore[untyped-decorator]
    def compiled(x: Any) -> Any:
        return int(x)

    assert compiled(number) == int(number)


def test_a_choice_between_functions_is_left_to_numba() -> None:
    """The pass replaces only what it can see to be called with so many numbers."""

    @numba.njit(**KERNEL)  # type: ignore[untyped-decorator]
    def compiled(x: Any, up: bool) -> Any:
        return max(0.5, x if up else -x)

    assert (compiled(2.0, True), compiled(2.0, False)) == (2.0, 0.5)
