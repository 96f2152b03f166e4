"""How scalar functions are handed to the compiler."""

from typing import Any

from numba.core import codegen, config
from numba.extending import register_jitable

from parkproof.scalar import MARKED

OPTIONS: dict[str, Any] = {
    # numba's default error model leaves the loop at every division, and it stays scalar then
    "error_model": "numpy",
    # arrays are the caller's: counting references to them would take calls inside the loops
    "_nrt": False,
}
"""No licence to reorder or fuse: every operation rounds as IEEE 754 and plain Python have it, so a
number is the same whichever loop it is worked out in."""


def _use_wide_registers() -> None:
    """Let loops over lanes use all of a 512-bit register, half of which compilers avoid by default.

    This holds for everything that numba compiles in this process from here on, unless the user has
    named a processor to numba. It changes speed only.
    """
    features: str = codegen.get_host_cpu_features()
    settings: Any = config
    if settings.CPU_NAME is None and settings.CPU_FEATURES is None and "+avx512f" in features:
        settings.CPU_FEATURES = f"{features},-prefer-256-bit"


_use_wide_registers()

_REGISTERED: set[Any] = set()


def register() -> None:
    """Hand every marked function and the polynomial primitives to the compiler.

    May be called again after more functions have been marked.

    Examples
    --------
    >>> register()
    """
    from parkproof.simulation import polynomials

    if not _REGISTERED:
        polynomials.replace_primitives()
    inline = register_jitable(forceinline=True, **OPTIONS)
    for function in MARKED:
        if function not in _REGISTERED:
            inline(function)
            _REGISTERED.add(function)
