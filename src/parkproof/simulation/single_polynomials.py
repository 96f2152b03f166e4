"""Polynomial forms of the primitives in single precision, shorter than those for doubles.

See `parkproof.simulation.polynomials`; the steps are the same. Whole numbers of 32 bits are kept
inside three small instructions, as compiled Python would make 64 bits of them.
"""

import math
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from parkproof.simulation.coefficients import table
from parkproof.simulation.fused import fused

ROUNDER = 12582912.0
"""1.5·2²³: adding it to a number below 2²² rounds to an integer, held in the last bits."""
SQRT_HALF_BITS = 0x3F3504F3
SMALLEST_NORMAL = 1.1754943508222875e-38

WORD, SINGLE = ir.IntType(32), ir.FloatType()


# log2(1 + z)/z, z from √½ − 1 to √2 − 1
LOG = table(
    "single logarithm",
    1.4426950216293335, -0.7213473320007324, 0.48089852929115295, -0.36069655418395996,
    0.28855255246162415, -0.23960812389850616, 0.20485764741897583, -0.19138838350772858,
    0.18476033210754395, -0.10749789327383041,
    number=types.float32,
)  # fmt: skip
# 2^r for |r| ≤ ½
EXP = table(
    "single power of two",
    1.0, 0.6931471824645996, 0.24022650718688965, 0.05550327152013779, 0.009618056938052177,
    0.0013400427997112274, 0.00015461444854736328,
    number=types.float32,
)  # fmt: skip
# (sin r − r)/r³ as a polynomial in r², |r| ≤ π/2
SIN = table(
    "single sine",
    -0.1666666567325592,
    0.008333242498338223,
    -0.0001982273970497772,
    2.634756356201251e-06,
    number=types.float32,
)
PI_HIGH, PI_LOW = 3.140625, 9.676535897932795e-4
"""π in two parts, of which small multiples of the first are exact."""


@intrinsic
def split(_context: Any, size: Any) -> Any:  # noqa: ARG001
    """Exponent and mantissa, from √½ to √2, of a positive single."""
    pair = types.UniTuple(types.float32, 2)

    def generate(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        bits = builder.bitcast(args[0], WORD)
        exponent = builder.ashr(builder.sub(bits, WORD(SQRT_HALF_BITS)), WORD(23))
        mantissa = builder.bitcast(builder.sub(bits, builder.shl(exponent, WORD(23))), SINGLE)
        numbers = [builder.sitofp(exponent, SINGLE), mantissa]
        return cgutils.pack_array(builder, numbers, ty=context.get_value_type(types.float32))

    return pair(types.float32), generate


@intrinsic
def times_power_of_two(_context: Any, x: Any, shifted: Any) -> Any:  # noqa: ARG001
    """x·2^n for the whole number n that is in the last bits of another; the result is normal."""

    def generate(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
        up = builder.shl(builder.bitcast(args[1], WORD), WORD(23))
        return builder.bitcast(builder.add(builder.bitcast(args[0], WORD), up), SINGLE)

    return types.float32(types.float32, types.float32), generate


@intrinsic
def negated_if_odd(_context: Any, x: Any, shifted: Any) -> Any:  # noqa: ARG001
    """−x where the whole number in the last bits of another is odd, else x."""

    def generate(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
        odd = builder.shl(builder.bitcast(args[1], WORD), WORD(31))
        return builder.bitcast(builder.xor(builder.bitcast(args[0], WORD), odd), SINGLE)

    return types.float32(types.float32, types.float32), generate


def begun_single(x: float, p: float) -> float:
    """First half of a signed power, compiled.

    Parameters
    ----------
    x, p : single
        Base and exponent.

    Returns
    -------
    single
        p·log2|x|, for normal numbers.
    """
    exponent, m = split(abs(x))
    z = m - 1.0
    z2 = z * z
    z4 = z2 * z2
    a = fused(fused(LOG(3), z, LOG(2)), z2, fused(LOG(1), z, LOG(0)))
    b = fused(fused(LOG(7), z, LOG(6)), z2, fused(LOG(5), z, LOG(4)))
    c = fused(LOG(9), z, LOG(8))
    return p * fused(z, fused(fused(c, z4, b), z4, a), exponent)


def ended_single(begun: float, x: float, p: float) -> float:
    """Second half of a signed power, compiled: ⌈x⌋^p = sign(x)·2^(p·log2|x|).

    Parameters
    ----------
    begun, x, p : single
        What `begun_single` gave, base and exponent.

    Returns
    -------
    single
        ⌈x⌋^p, and 0 where |x| is below the smallest normal number.
    """
    y = max(-125.0, min(127.0, begun))
    shifted = y + ROUNDER
    r = y - (shifted - ROUNDER)
    r2 = r * r
    first = fused(fused(EXP(3), r, EXP(2)), r2, fused(EXP(1), r, EXP(0)))
    second = fused(EXP(6), r2, fused(EXP(5), r, EXP(4)))
    power = times_power_of_two(fused(second, r2 * r2, first), shifted)
    signed = x if p == 1.0 else math.copysign(power, x)
    return signed if abs(x) >= SMALLEST_NORMAL else 0.0


def sine_single(x: float) -> float:
    """Sine, compiled, by reduction to [−π/2, π/2].

    Parameters
    ----------
    x : single
        Angle in rad; the sine is accurate for |x| below about 10³.

    Returns
    -------
    single
        sin x.
    """
    shifted = fused(x, 1.0 / math.pi, ROUNDER)
    whole = shifted - ROUNDER
    r = fused(-whole, PI_LOW, fused(-whole, PI_HIGH, x))
    g = r * r
    series = fused(fused(fused(SIN(3), g, SIN(2)), g, SIN(1)), g, SIN(0))
    return negated_if_odd(fused(r * g, series, r), shifted)
