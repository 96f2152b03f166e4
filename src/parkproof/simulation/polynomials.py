"""Polynomial forms of the primitives, for compiled lanes.

A call of the mathematics library would keep the compiler from turning the loop over lanes into
vector instructions; these forms are inlined. Their error against the library is pinned by a test.
Imported only when lanes are first compiled.
"""

import math
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload, register_jitable

from parkproof.scalar import MARKED, sine, spow, tangent

OPTIONS: dict[str, Any] = {
    # numba's default error model leaves the loop at every division, and it stays scalar then
    "error_model": "numpy",
    # not "reassoc": it would fold the rounding trick below away
    "fastmath": {"nsz", "arcp", "contract", "afn"},
}

ROUNDER = 6755399441055744.0
"""1.5·2⁵²: adding it to a number below 2⁵¹ rounds to an integer, held in the last bits."""
ROUNDER_BITS = 0x4338000000000000
SQRT_HALF_BITS = 0x3FE6A09E667F3BCD
SMALLEST_NORMAL = 2.2250738585072014e-308

# log2(m) = 2/ln 2 · (f + f³/3 + f⁵/5 + …) with f = (m − 1)/(m + 1)
LOG = tuple(2.0 / math.log(2.0) / (2 * i + 1) for i in range(11))
# 2^r = Σ (r ln 2)^i / i!
EXP = tuple(math.log(2.0) ** i / math.factorial(i) for i in range(14))
# sin r = Σ (−1)^i r^(2i+1) / (2i + 1)!
SIN = tuple((-1.0) ** i / math.factorial(2 * i + 1) for i in range(11))
# π in three parts, the first two short, so that multiples of them are exact
PI_PARTS = (3.141592651605606, 1.9841871583270443e-09, 1.034036596358821e-18)


@intrinsic
def bits_of(_context: Any, x: Any) -> Any:  # noqa: ARG001
    """Reinterpret a double as a 64-bit integer."""

    def generate(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), generate


@intrinsic
def double_of(_context: Any, bits: Any) -> Any:  # noqa: ARG001
    """Reinterpret a 64-bit integer as a double."""

    def generate(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), generate


def _spow_polynomial(x: float, p: float) -> float:
    """⌈x⌋^p = sign(x)·2^(p·log2|x|); 0 where |x| is below the smallest normal number."""
    size = abs(x)
    bits = bits_of(size)
    exponent = (bits - SQRT_HALF_BITS) >> 52
    m = double_of(bits - (exponent << 52))
    f = (m - 1.0) / (m + 1.0)
    g = f * f
    g2 = g * g
    g4 = g2 * g2
    low = (LOG[1] + LOG[2] * g) + (LOG[3] + LOG[4] * g) * g2
    high = (LOG[5] + LOG[6] * g) + (LOG[7] + LOG[8] * g) * g2
    series = low + (high + (LOG[9] + LOG[10] * g) * g4) * g4
    log2 = (double_of(exponent + ROUNDER_BITS) - ROUNDER) + f * (LOG[0] + g * series)

    y = max(-1022.0, min(1023.0, p * log2))
    shifted = y + ROUNDER
    r = y - (shifted - ROUNDER)
    r2 = r * r
    r4 = r2 * r2
    first = (EXP[0] + EXP[1] * r) + (EXP[2] + EXP[3] * r) * r2
    second = (EXP[4] + EXP[5] * r) + (EXP[6] + EXP[7] * r) * r2
    third = (EXP[8] + EXP[9] * r) + (EXP[10] + EXP[11] * r) * r2
    fraction = first + (second + (third + (EXP[12] + EXP[13] * r) * r4) * r4) * r4
    power = fraction * double_of(((bits_of(shifted) - ROUNDER_BITS) + 1023) << 52)
    return math.copysign(power, x) if size >= SMALLEST_NORMAL else 0.0


def _sine_polynomial(x: float) -> float:
    """Sine by reduction to [−π/2, π/2]; exact reduction for |x| below about 10⁶."""
    shifted = x * (1.0 / math.pi) + ROUNDER
    k = shifted - ROUNDER
    r = ((x - k * PI_PARTS[0]) - k * PI_PARTS[1]) - k * PI_PARTS[2]
    g = r * r
    g2 = g * g
    g4 = g2 * g2
    low = (SIN[1] + SIN[2] * g) + (SIN[3] + SIN[4] * g) * g2
    high = (SIN[5] + SIN[6] * g) + (SIN[7] + SIN[8] * g) * g2
    series = low + (high + (SIN[9] + SIN[10] * g) * g4) * g4
    value = r + r * g * series
    return double_of(bits_of(value) ^ (bits_of(shifted) << 63))


_REGISTERED: set[Any] = set()


def register() -> None:
    """Hand every marked function and the polynomial primitives to the compiler.

    May be called again after more functions have been marked.

    Examples
    --------
    >>> register()
    """
    inline = register_jitable(forceinline=True, **OPTIONS)
    if not _REGISTERED:
        _register_primitives(inline)
    for function in MARKED:
        if function not in _REGISTERED:
            inline(function)
            _REGISTERED.add(function)


def _register_primitives(inline: Any) -> None:
    power, wave = inline(_spow_polynomial), inline(_sine_polynomial)
    options = {"forceinline": True, **OPTIONS}

    # numba compares the argument lists of both functions, annotations included: hence Any on both
    @overload(spow, jit_options=options)
    def choose_power(x: Any, p: Any) -> Any:  # noqa: ARG001
        def polynomial(x: Any, p: Any) -> Any:
            return power(x, p)

        return polynomial

    @overload(sine, jit_options=options)
    def choose_sine(x: Any) -> Any:  # noqa: ARG001
        def polynomial(x: Any) -> Any:
            return wave(x)

        return polynomial

    @overload(tangent, jit_options=options)
    def choose_tangent(x: Any) -> Any:  # noqa: ARG001
        def quotient(x: Any) -> Any:
            return wave(x) / wave(x + 0.5 * math.pi)

        return quotient
