"""The numbers of a law, as compiled code reads them: by name, from memory that never changes.

Handed on as a tuple, each of them would be an argument of its own of every compiled function, which
takes seconds to compile; read from an array, the compiler would have to expect that writing to a
buffer changes them, and would not turn loops into vector instructions.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, models, register_model
from numpy.typing import NDArray

from parkproof.laws.parameters import LawParameters


class ParametersType(types.Type):
    """Type of a law's parameters in compiled code."""

    def __init__(self) -> None:
        super().__init__(name="LawParameters")


PARAMETERS = ParametersType()
DOUBLE, WHOLE = ir.DoubleType(), ir.IntType(64)
register_model(ParametersType)(models.OpaqueModel)


@infer_getattr
class ParametersAttributes(AttributeTemplate):
    """Every field of `LawParameters` is a number."""

    key = ParametersType

    def generic_resolve(self, _type: Any, name: str) -> Any:
        """Type of a field."""
        return types.float64 if name in LawParameters._fields else None


@lower_getattr_generic(ParametersType)
def read(_context: Any, builder: Any, _type: Any, value: Any, name: str) -> Any:
    """Load a field."""
    numbers = builder.bitcast(value, DOUBLE.as_pointer())
    return builder.load(builder.gep(numbers, [WHOLE(LawParameters._fields.index(name))]))


@intrinsic
def parameters_in(_context: Any, numbers: Any) -> Any:
    """Copy a law's parameters from an array to the stack, from where they go into registers."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, args[0])
        copy = cgutils.alloca_once(builder, DOUBLE, size=WHOLE(len(LawParameters._fields)))
        for i in range(len(LawParameters._fields)):
            number = builder.load(builder.gep(array.data, [WHOLE(i)]))
            builder.store(number, builder.gep(copy, [WHOLE(i)]))
        return builder.bitcast(copy, context.get_value_type(PARAMETERS))

    return PARAMETERS(numbers), generate


def array_of(p: LawParameters) -> NDArray[np.float64]:
    """Give the array that `parameters_in` takes.

    Parameters
    ----------
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    array
        Its fields.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> array_of(default_parameters()).size == len(LawParameters._fields)
    True
    """
    return np.array(p)
