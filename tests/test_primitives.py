"""Signed power, sign, clip and the mark of scalar functions."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.scalar import MARKED, arctan, clip, cosine, scalar, sign, sine, spow

NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=False)
EXPONENTS = st.floats(0.05, 3.0)


@given(NUMBERS, EXPONENTS)
def test_signed_power_has_the_sign_of_its_base_and_the_size_of_the_power(
    x: float, p: float
) -> None:
    assert spow(x, p) == pytest.approx(abs(x) ** p * sign(x))


@given(NUMBERS, EXPONENTS)
def test_signed_power_is_odd(x: float, p: float) -> None:
    assert spow(-x, p) == -spow(x, p)


@given(NUMBERS, NUMBERS, EXPONENTS)
def test_signed_power_does_not_decrease(x: float, y: float, p: float) -> None:
    assert spow(min(x, y), p) <= spow(max(x, y), p)


@given(st.floats(-1e3, 1e3).filter(lambda x: x == 0.0 or abs(x) > 1e-6), st.floats(0.2, 3.0))
def test_signed_power_is_undone_by_the_inverse_exponent(x: float, p: float) -> None:
    assert spow(spow(x, p), 1.0 / p) == pytest.approx(x, rel=1e-12)


@pytest.mark.parametrize(("x", "cube_root"), [(-8.0, -2.0), (27.0, 3.0), (0.0, 0.0), (-1.0, -1.0)])
def test_signed_power_equals_the_odd_root(x: float, cube_root: float) -> None:
    assert spow(x, 1 / 3) == pytest.approx(cube_root)


@given(st.floats(allow_nan=False))
def test_sign_is_one_of_three_values(x: float) -> None:
    assert sign(x) == (0.0 if x == 0.0 else math.copysign(1.0, x))


@given(NUMBERS, st.floats(0.0, 1e6))
def test_clip_stays_inside_and_changes_nothing_inside(x: float, bound: float) -> None:
    clipped = clip(x, bound)
    assert abs(clipped) <= bound
    assert clipped == x if abs(x) <= bound else abs(clipped) == bound
    assert clipped * x >= 0.0


@given(st.floats(-100.0, 100.0))
def test_trigonometric_primitives_are_those_of_the_library(x: float) -> None:
    assert sine(x) == math.sin(x)
    assert cosine(x) == pytest.approx(math.cos(x), abs=1e-13)
    assert arctan(x) == math.atan(x)


def test_marking_a_function_returns_it_and_puts_it_last() -> None:
    def double(x: float) -> float:
        return 2.0 * x

    try:
        assert scalar(double) is double
        assert MARKED[-1] is double
    finally:
        MARKED.remove(double)
