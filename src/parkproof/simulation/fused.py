"""A product and a sum rounded once, for compiled code."""

from typing import Any

from numba import types
from numba.extending import intrinsic


@intrinsic
def fused(_context: Any, x: Any, y: Any, z: Any) -> Any:
    """x·y + z, rounded once: of singles a single, else a double."""
    number = types.float32 if x == y == z == types.float32 else types.float64

    def generate(_ctx: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.fma(*args)

    return number(number, number, number), generate
