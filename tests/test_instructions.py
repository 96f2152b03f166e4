"""What stands for max, min and int in compiled code gives what Python gives."""

import math
from itertools import product
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import ir
from numba.core.compiler import run_frontend
from numba.core.errors import TypingError

from parkproof.simulation.compiler import KERNEL, inlined
from parkproof.simulation.instructions import Instructions, assignments_of

NUMBERS = (-math.inf, -2.5, -0.0, 0.0, 1.0, math.nan)


@inlined
def extremes(a: Any, b: Any, c: Any, d: Any) -> Any:
    return max(a, b), min(a, b), max(a, b, c), min(a, b, c), max(a, b, c, d), min(a, b, c, d)


@numba.njit(**KERNEL)  # type: ignore[untyped-decorator]
def compiled_extremes(a: Any, b: Any, c: Any, d: Any) -> Any:
    return extremes(a, b, c, d)


def names_left(function: Any) -> set[str]:
    """Functions that a function still calls by their names after the pass."""
    form = run_frontend(function)
    Instructions().run_pass(SimpleNamespace(func_ir=form))
    return {
        each.value.name
        for each in assignments_of(form)
        if isinstance(each.value, ir.Global) and each.value.name
    }


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


def test_a_call_with_a_choice_among_its_numbers_is_left_to_numba() -> None:
    """Numba's form names the function before the choice, in another block than the call."""
    assert "max" in names_left(lambda x, up: max(0.5, x if up else -x))

    @numba.njit(**KERNEL)  # type: ignore[untyped-decorator]
    def compiled(x: Any, up: bool) -> Any:
        return max(0.5, x if up else -x)

    assert (compiled(2.0, True), compiled(2.0, False)) == (2.0, 0.5)


def test_other_calls_are_left_to_numba() -> None:
    assert names_left(lambda x: max(x, -x) + int(x)) == set()
    assert names_left(lambda x: int(x, base=7)) == {"int"}
    assert names_left(lambda x: min(*x)) == {"min"}


@pytest.mark.parametrize("numbers", [(True, False), (np.uint64(2**63), np.uint64(1))])
def test_numbers_that_would_be_compared_as_signed_ones_are_refused(numbers: Any) -> None:
    @numba.njit(**KERNEL)  # type: ignore[untyped-decorator]
    def compiled(a: Any, b: Any) -> Any:
        return max(a, b)

    with pytest.raises(TypingError, match="signed"):
        compiled(*numbers)
