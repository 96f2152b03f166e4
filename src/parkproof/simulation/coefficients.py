"""Coefficients of polynomials, read from memory by compiled code.

Written as numbers they would be made anew, each in two instructions, in every pass of a loop that
has more of them than registers. Read from a table they are made once, before the loop, and what
does not fit into registers is added or multiplied straight from memory.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core.cpu import CPUContext
from numba.extending import intrinsic

_TABLES: dict[str, tuple[float, ...]] = {}
"""Numbers by name: where two have one, the linker would take either."""


def table(name: str, *numbers: float, number: types.Float = types.float64) -> Any:
    """Make a table of numbers for compiled code.

    Parameters
    ----------
    name : str
        A name that no other table has.
    *numbers : float
        What is in it.
    number : numba type
        Of its entries.

    Returns
    -------
    callable
        Called in compiled code with a written index, it gives that number.

    Raises
    ------
    ValueError
        If another table has the name.

    Examples
    --------
    >>> import numba
    >>> entry = table("an example", 2.5, 3.5)
    >>> numba.njit(lambda: entry(1))()
    3.5
    """
    label = f"parkproof.{name}"
    if _TABLES.setdefault(label, numbers) != numbers:
        raise ValueError(f"there is another table of the name {name}; choose another name")

    @intrinsic(prefer_literal=True)
    def entry(_context: Any, index: Any) -> Any:
        def generate(context: Any, builder: Any, _signature: Any, _args: Any) -> Any:
            kind, place = context.get_value_type(number), index.literal_value
            if not isinstance(context, CPUContext):
                return kind(numbers[place])
            module = builder.module
            known = module.globals.get(label)
            if known is None:
                known = ir.GlobalVariable(module, ir.ArrayType(kind, len(numbers)), label)
                known.initializer = ir.Constant(known.value_type, numbers)
                known.global_constant = True
                # the compiler would else write the numbers out again
                known.linkage = "weak"
            zero = ir.IntType(32)(0)
            return builder.load(builder.gep(known, [zero, zero.type(place)], inbounds=True))

        return number(index), generate

    return entry
