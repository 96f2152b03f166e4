"""How scalar functions are handed to the compiler."""

from importlib.util import find_spec
from typing import Any

from numba.core import codegen, config
from numba.extending import overload
from numba.np import linalg

from parkproof.scalar import MARKED
from parkproof.simulation.inlining import InlinedCompiler, KernelCompiler

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


def _load_arrays_without_scipy() -> None:
    """Import numba's functions of arrays, but not SciPy's linear algebra, which no kernel uses.

    numba imports that, which takes 0.3 s, only to note whether it is there. Functions that do use
    it import it when they are compiled, as ever.
    """
    asked = linalg.ensure_blas

    def ask() -> None:
        if find_spec("scipy") is None:
            asked()

    linalg.ensure_blas = ask
    try:
        from numba.np import arraymath

        arraymath.ensure_blas = asked
    finally:
        linalg.ensure_blas = asked


_load_arrays_without_scipy()

_INLINED: dict[str, Any] = {"forceinline": True, **OPTIONS}
_INLINED_HERE: dict[str, Any] = {
    **_INLINED, "pipeline_class": InlinedCompiler, "no_cfunc_wrapper": True
}  # fmt: skip

KERNEL: dict[str, Any] = {"nogil": True, "pipeline_class": KernelCompiler, **OPTIONS}
"""How a kernel is compiled for this computer's processor."""

_REGISTERED: set[Any] = set()


def replace(function: Any, make: Any) -> None:
    """Have compiled code call what is made for a function in its place, inlined.

    Parameters
    ----------
    function : callable
        A function that compiled code names.
    make : callable
        Given the types of its arguments, what to compile.

    Examples
    --------
    >>> def half(x):
    ...     return x / 2.0
    >>> replace(half, lambda x: lambda x: 0.5 * x)
    """
    # of these numba takes the first on this computer's processor, the second elsewhere
    overload(function, jit_options=_INLINED_HERE, strict=False, target="cpu")(make)
    overload(function, jit_options=_INLINED, strict=False)(make)


def inlined(function: Any) -> Any:
    """Hand a function to the compiler, to be inlined wherever compiled code calls it.

    Parameters
    ----------
    function : callable
        Of numbers and buffers.

    Returns
    -------
    callable
        The same.

    Examples
    --------
    >>> @inlined
    ... def half(x):
    ...     return 0.5 * x
    >>> half(3.0)
    1.5
    """
    replace(function, lambda *_args, **_options: function)
    return function


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
    for function in MARKED:
        if function not in _REGISTERED:
            inlined(function)
            _REGISTERED.add(function)
