"""Polynomial forms of the primitives, for compiled lanes.

A call of the mathematics library would keep the compiler from turning the loop over lanes into
vector instructions; these forms are inlined. Their error against the library is pinned by a test.
The polynomials interpolate in Chebyshev's points, worked out with 60 digits. Multiplications and
additions are fused where it says so, and nowhere else, so that results do not depend on the loop
that a function is compiled into, nor on the machine.
"""

import math
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from parkproof.scalar import sine, spow, spow_begun, spow_ended, spows_begun, tangent
from parkproof.simulation.coefficients import table
from parkproof.simulation.compiler import inlined, replace
from parkproof.simulation.fused import fused
from parkproof.simulation.single_polynomials import begun_single, ended_single, sine_single

ROUNDER = 6755399441055744.0
"""1.5·2⁵²: adding it to a number below 2⁵¹ rounds to an integer, held in the last bits."""
ROUNDER_BITS = 0x4338000000000000
SQRT_HALF_BITS = 0x3FE6A09E667F3BCD
SMALLEST_NORMAL = 2.2250738585072014e-308

# log2((1 + f)/(1 − f))/f as a polynomial in f², |f| ≤ (√2 − 1)/(√2 + 1)
LOG = table(
    "logarithm",
    2.885390081777927, 0.9617966939243345, 0.5770780172463286, 0.4121984020482752,
    0.32061638813224547, 0.2614442493522915, 0.2429160853987535,
)  # fmt: skip
# 2^r for |r| ≤ ½
EXP = table(
    "power of two",
    1.0, 0.69314718055995, 0.24022650695910097, 0.05550410866444772, 0.009618129107606888,
    0.0013333558230164974, 0.0001540353044173605, 1.5252657260200837e-05, 1.321544258792169e-06,
    1.0208690299958306e-07, 7.072585949269223e-09,
)  # fmt: skip
# (sin r − r)/r³ as a polynomial in r², |r| ≤ π/2
SIN = table(
    "sine",
    -0.16666666666666666, 0.008333333333333316, -0.00019841269841254966, 2.7557319219160833e-06,
    -2.505210761669045e-08, 1.6058977292642743e-10, -7.643969663988074e-13, 2.7314368769379893e-15,
)  # fmt: skip
LIMITS = table("limits of powers", SMALLEST_NORMAL, ROUNDER - 1021.0, ROUNDER + 1023.0)
PLACES = table("places of numbers", 1.0, ROUNDER)
BITS = table("bits of numbers", SQRT_HALF_BITS, ROUNDER_BITS, number=types.int64)
PI_REST = 1.2246467991473532e-16
"""What π is more than the nearest double."""


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


def _split(x: float) -> tuple[float, float]:
    """Exponent e and m of |x| = m·2^e with m in [√½, √2), for normal numbers."""
    bits = bits_of(abs(x))
    exponent = (bits - BITS(0)) >> 52
    return double_of(exponent + BITS(1)) - PLACES(1), double_of(bits - (exponent << 52))


def _logarithm(f: float, exponent: float) -> float:
    """log2 of what `_split` took apart, for f = (m − 1)/(m + 1)."""
    g = f * f
    g2 = g * g
    a = fused(fused(LOG(3), g, LOG(2)), g2, fused(LOG(1), g, LOG(0)))
    b = fused(LOG(6), g2, fused(LOG(5), g, LOG(4)))
    return fused(f, fused(b, g2 * g2, a), exponent)


def _begun_polynomial(x: float, p: float) -> float:
    """p·log2|x|, for normal numbers."""
    exponent, m = _split(x)
    return p * _logarithm((m - PLACES(0)) / (m + PLACES(0)), exponent)


def _begun_polynomials(x1: float, p1: float, x2: float, p2: float) -> tuple[float, float]:
    """p·log2|x| of two numbers, by one division, the slowest instruction of a logarithm.

    m lies in [√½, √2) whatever the bits of x are, so that neither spoils the other's quotient.
    """
    exponent1, m1 = _split(x1)
    exponent2, m2 = _split(x2)
    d1, d2 = m1 + PLACES(0), m2 + PLACES(0)
    part = PLACES(0) / (d1 * d2)
    f1, f2 = (m1 - PLACES(0)) * d2 * part, (m2 - PLACES(0)) * d1 * part
    return p1 * _logarithm(f1, exponent1), p2 * _logarithm(f2, exponent2)


def _ended_polynomial(begun: float, x: float, p: float) -> float:
    """sign(x)·2^begun where that is a normal number; 0 where |x| is below the smallest one.

    Beyond, from 2^−1021.5 down and from 2^1023.5 up, the size is off by a factor of two.
    """
    shifted = begun + PLACES(1)
    r = begun - (shifted - PLACES(1))
    r2 = r * r
    r4 = r2 * r2
    first = fused(fused(EXP(3), r, EXP(2)), r2, fused(EXP(1), r, EXP(0)))
    second = fused(fused(EXP(7), r, EXP(6)), r2, fused(EXP(5), r, EXP(4)))
    third = fused(EXP(10), r2, fused(EXP(9), r, EXP(8)))
    fraction = fused(fused(third, r4, second), r4, first)
    whole = max(LIMITS(1), min(LIMITS(2), shifted))
    power = double_of(bits_of(fraction) + (bits_of(whole) << 52))
    # where the compiler knows the exponent to be 1, nothing is left of this half
    signed = x if p == 1.0 else math.copysign(power, x)
    return signed if abs(x) >= LIMITS(0) else 0.0


def _sine_polynomial(x: float) -> float:
    """Sine by reduction to [−π/2, π/2]; accurate for |x| below about 10⁶."""
    shifted = fused(x, 1.0 / math.pi, ROUNDER)
    k = shifted - ROUNDER
    r = fused(-k, PI_REST, fused(-k, math.pi, x))
    g = r * r
    series = SIN(7)
    series = fused(series, g, SIN(6))
    series = fused(series, g, SIN(5))
    series = fused(series, g, SIN(4))
    series = fused(series, g, SIN(3))
    series = fused(series, g, SIN(2))
    series = fused(series, g, SIN(1))
    series = fused(series, g, SIN(0))
    value = fused(r * g, series, r)
    return double_of(bits_of(value) ^ (bits_of(shifted) << 63))


def replace_primitives() -> None:
    """Give the primitives these forms in compiled code."""
    for form in (_split, _logarithm, _sine_polynomial, sine_single):
        inlined(form)

    def power(x: Any, p: Any) -> Any:
        return spow_ended(spow_begun(x, p), x, p)

    def begun_of(x: Any, p: Any) -> Any:
        return begun_single if x == p == types.float32 else _begun_polynomial

    def two_begun(x1: Any, p1: Any, x2: Any, p2: Any) -> Any:
        return spow_begun(x1, p1), spow_begun(x2, p2)

    def two_begun_of(x1: Any, p1: Any, x2: Any, p2: Any) -> Any:
        # logarithms of singles take no division
        single = x1 == p1 == types.float32 or x2 == p2 == types.float32
        return two_begun if single else _begun_polynomials

    def ended_of(begun: Any, x: Any, p: Any) -> Any:
        return ended_single if begun == x == p == types.float32 else _ended_polynomial

    def wave_of(x: Any) -> Any:
        return sine_single if x == types.float32 else _sine_polynomial

    def quotient(x: Any) -> Any:
        return sine(x) / sine(x + 0.5 * math.pi)

    replace(spow_begun, begun_of)
    replace(spows_begun, two_begun_of)
    replace(spow_ended, ended_of)
    replace(spow, lambda x, p: power)  # noqa: ARG005
    replace(sine, wave_of)
    replace(tangent, lambda x: quotient)  # noqa: ARG005
