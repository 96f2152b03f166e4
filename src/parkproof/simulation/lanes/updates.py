"""Numbers of a buffer that are replaced where a condition holds, and else left as they are.

Written as a condition, such a replacement becomes a masked store in a vector loop. AMD's processors
without AVX-512 carry one out in some forty micro-operations, and cannot forward what it stored to
a later load: lanes took a quarter to two thirds longer there. So each is a load, a choice and a
store.

For the same reason loops over lanes read numbers first and choose between them then: a read under a
condition becomes a masked load, and what is then stored a masked store.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from parkproof.simulation.compiler import inlined, replace

from .memory import BufferType, address_of


def put_if(b: Any, place: Any, condition: Any, number: Any) -> None:
    """Put a number into a buffer where a condition holds.

    Parameters
    ----------
    b : Buffer or array
        The buffer.
    place : int
        Which of its numbers.
    condition : bool
        Whether to replace it.
    number : float
        By what.

    Examples
    --------
    >>> numbers = [1.0, 2.0]
    >>> put_if(numbers, 0, True, 5.0)
    >>> put_if(numbers, 1, False, 5.0)
    >>> numbers
    [5.0, 2.0]
    """
    if condition:
        b[place] = number


def put_two_if(b: Any, place1: Any, place2: Any, condition: Any, numbers: Any) -> None:
    """Put two numbers into a buffer where a condition holds.

    Parameters
    ----------
    b : Buffer or array
        The buffer.
    place1, place2 : int
        Which of its numbers.
    condition : bool
        Whether to replace them.
    numbers : tuple of 2 floats
        By what.

    Examples
    --------
    >>> numbers = [1.0, 2.0]
    >>> put_two_if(numbers, 0, 1, True, (5.0, 6.0))
    >>> numbers
    [5.0, 6.0]
    """
    number1, number2 = numbers
    put_if(b, place1, condition, number1)
    put_if(b, place2, condition, number2)


def raise_to(b: Any, place: Any, number: Any) -> None:
    """Put a number into a buffer where it is larger than what is there.

    Parameters
    ----------
    b : Buffer or array
        The buffer.
    place : int
        Which of its numbers.
    number : float
        By what to replace it.

    Examples
    --------
    >>> numbers = [1.0, 9.0]
    >>> raise_to(numbers, 0, 5.0)
    >>> raise_to(numbers, 1, 5.0)
    >>> numbers
    [5.0, 9.0]
    """
    b[place] = max(b[place], number)


class Freeze(ir.Instruction):  # type: ignore[misc]  # untyped
    """LLVM's instruction of that name: a number as it is.

    The compiler would see through a load, a choice and a store, and make a masked store of them.
    llvmlite has no function for it; inserting it takes one that it does not document, hence the
    narrow range of versions that the package asks for.
    """

    def __init__(self, parent: Any, number: Any) -> None:
        super().__init__(parent, number.type, "freeze", [number])

    def descr(self, buf: Any) -> None:
        """Write the instruction."""
        (number,) = self.operands
        buf.append(f"freeze {number.type} {number.get_reference()}\n")


def _updating(choose: Any, buffer: Any, *others: Any) -> Any:
    """Signature and code of what chooses between a buffer's number and another."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        address = address_of(context, builder, buffer, *args[:2])
        before = Freeze(builder.block, builder.load(address))
        builder._insert(before)
        number = context.cast(builder, args[-1], sig.args[-1], buffer.number)
        builder.store(choose(builder, before, number, *args[2:-1]), address)
        return context.get_dummy_value()

    return types.none(buffer, types.int64, *others), generate


@intrinsic
def _put_if(_context: Any, b: Any, _place: Any, condition: Any, number: Any) -> Any:
    def choose(builder: Any, before: Any, number: Any, condition: Any) -> Any:
        return builder.select(condition, number, before)

    return _updating(choose, b, condition, number)


@intrinsic
def _raise_to(_context: Any, b: Any, _place: Any, number: Any) -> Any:
    def choose(builder: Any, before: Any, number: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", number, before), number, before)

    return _updating(choose, b, number)


def _put_if_in_buffer(b: Any, place: Any, condition: Any, number: Any) -> Any:
    _put_if(b, place, condition, number)


def _raise_to_in_buffer(b: Any, place: Any, number: Any) -> Any:
    _raise_to(b, place, number)


replace(put_if, lambda b, *_: _put_if_in_buffer if isinstance(b, BufferType) else put_if)
replace(raise_to, lambda b, *_: _raise_to_in_buffer if isinstance(b, BufferType) else raise_to)
inlined(put_two_if)
