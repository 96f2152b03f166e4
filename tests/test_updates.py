"""Numbers of a buffer that are replaced where a condition holds."""

import math
import re
from typing import Any

import numba
import numpy as np
import pytest

from parkproof.simulation.compiler import KERNEL
from parkproof.simulation.lanes.memory import Buffer
from parkproof.simulation.lanes.updates import put_if, raise_to

LANES = 64
MASKED = re.compile(r"vmaskmovp[sd]\s+%\w+, %\w+, \S*\(|\(%\w+\S*\) \{%k\d\}$", re.MULTILINE)
"""A masked store: with the mask in a register of its own, or as AVX-512 has it."""


@numba.njit(**KERNEL)  # type: ignore[untyped-decorator]
def update(b: Any) -> None:
    """Rows: two that are updated, a condition, a number."""
    for j in range(LANES):
        put_if(b, j, b[2 * LANES + j] == 1.0, b[3 * LANES + j])
        raise_to(b, LANES + j, b[3 * LANES + j])


def rows(rng: np.random.Generator) -> np.ndarray:
    given = rng.choice([-2.5, -0.0, 0.0, 1.0, 7.0, math.inf, math.nan], (4, LANES))
    given[2] = rng.choice([0.0, 1.0, math.nan], LANES)
    return given


@pytest.mark.parametrize("single", [False, True])
def test_compiled_updates_are_the_plain_ones(single: bool) -> None:
    rng = np.random.default_rng(8)
    for _ in range(20):
        given = rows(rng)
        buffer = Buffer(given.ravel(), dtype=np.float32 if single else np.float64)
        update(buffer)
        plain = given.ravel().copy()
        update.py_func(plain)
        assert np.array_equal(buffer.numbers, plain.astype(buffer.numbers.dtype), equal_nan=True)
        assert np.array_equal(np.signbit(buffer.numbers), np.signbit(plain))


def code_of(compiled: Any) -> str:
    """Machine code for doubles."""
    compiled(Buffer(np.zeros(4 * LANES)))
    (code,) = (text for kind, text in compiled.inspect_asm().items() if "float64" in str(kind))
    return str(code)


def test_updates_are_no_masked_stores() -> None:
    @numba.njit(**KERNEL)  # type: ignore[untyped-decorator]
    def condition(b: Any) -> None:
        for j in range(LANES):
            if b[2 * LANES + j] == 1.0:
                b[j] = b[3 * LANES + j]

    if "ymm" not in code_of(condition):
        pytest.skip("this processor has no masked stores")
    assert MASKED.search(code_of(condition))
    assert "ymm" in code_of(update)
    assert not MASKED.search(code_of(update))
