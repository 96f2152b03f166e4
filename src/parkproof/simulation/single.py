"""Single precision from the same source: written numbers become singles, too.

In Python ``0.5`` is a double, and whatever is multiplied by it becomes one. A function any argument
of which is single, or holds singles, takes all numbers that are written in it, and those of the
modules that it names, as singles; those in tuples stay as they are. Times are doubles, and what is
worked out from them alone is double, but for such a written number in it.
"""

from types import ModuleType
from typing import Any

import numpy as np
from numba import types
from numba.core import ir
from numba.core.compiler_machinery import FunctionPass, register_pass

from parkproof.simulation.instructions import assignments_of, replace_value


def has_singles(kind: Any) -> bool:
    """Whether a type is of singles, or holds some.

    Parameters
    ----------
    kind : numba type
        Of an argument.

    Returns
    -------
    bool
        True for singles, for tuples with some, and for buffers of singles.

    Examples
    --------
    >>> has_singles(types.float32), has_singles(types.UniTuple(types.float64, 2))
    (True, False)
    """
    if isinstance(kind, types.BaseTuple):
        return any(has_singles(part) for part in kind)
    return bool(getattr(kind, "number", getattr(kind, "dtype", kind)) == types.float32)


@register_pass(mutates_CFG=False, analysis_only=False)
class SingleConstants(FunctionPass):
    """Make written numbers singles where a function is given singles."""

    _name = "parkproof_single_constants"

    def __init__(self) -> None:  # numba's own is abstract
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        """Replace them, and say whether there were any."""
        if not any(has_singles(kind) for kind in state.args):
            return False
        assignments = assignments_of(state.func_ir)
        modules = {
            each.target.name: each.value.value
            for each in assignments
            if isinstance(each.value, ir.Global) and isinstance(each.value.value, ModuleType)
        }
        found = [(each, _written(each.value, modules)) for each in assignments]
        for each, number in found:
            if number is not None:
                replace_value(state.func_ir, each, ir.Const(np.float32(number), each.loc))
        return any(number is not None for _, number in found)


def _written(value: Any, modules: dict[str, ModuleType]) -> float | None:
    """Number that an expression is: written, of this module, or of another."""
    if isinstance(value, ir.Const | ir.Global | ir.FreeVar):
        number = value.value
    elif isinstance(value, ir.Expr) and value.op == "getattr" and value.value.name in modules:
        number = getattr(modules[value.value.name], value.attr)
    else:
        return None
    return number if isinstance(number, float) else None
