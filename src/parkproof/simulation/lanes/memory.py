"""Memory as compiled code sees it: a buffer of numbers, and the numbers of a law by name.

Each is one address and nothing else. An array of numba is seven arguments of every function that it
is handed to, and each index asks first whether it counts from the end; the numbers of a law, as a
tuple, would be an argument each. Kernels compiled with those took three times as long to compile.
"""

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_global, signature
from numba.extending import (
    NativeValue,
    infer_getattr,
    intrinsic,
    lower_builtin,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)
from numba.np.numpy_support import from_dtype

from parkproof.laws.parameters import LawParameters
from parkproof.simulation.compiler import replace

WHOLE = ir.IntType(64)

LINE = 64
"""Bytes of a line of a processor's caches, and of its widest registers: what such a register reads
should not lie in two lines."""


class BufferType(types.Type):
    """Type of a buffer in compiled code: any whole number indexes it, and none is checked."""

    def __init__(self, number: types.Number) -> None:
        self.number = number
        super().__init__(name=f"Buffer({number})")


class ParametersType(types.Type):
    """Type of a law's parameters in compiled code."""

    def __init__(self, number: types.Float) -> None:
        self.number = number
        super().__init__(name=f"LawParameters({number})")


register_model(BufferType)(models.OpaqueModel)
register_model(ParametersType)(models.OpaqueModel)


# -------------------------------------------------------------------------------------- buffers


@infer_global(operator.getitem)
class Reading(AbstractTemplate):
    """A buffer gives a number."""

    def generic(self, args: Any, _kws: Any) -> Any:
        """Signature."""
        buffer, index = args
        if isinstance(buffer, BufferType) and isinstance(index, types.Integer):
            return signature(buffer.number, buffer, types.int64)
        return None


@infer_global(operator.setitem)
class Writing(AbstractTemplate):
    """A buffer takes a number."""

    def generic(self, args: Any, _kws: Any) -> Any:
        """Signature."""
        buffer, index, _ = args
        if isinstance(buffer, BufferType) and isinstance(index, types.Integer):
            return signature(types.none, buffer, types.int64, buffer.number)
        return None


def address_of(context: Any, builder: Any, kind: Any, address: Any, index: Any) -> Any:
    """Address of a number."""
    number = context.get_value_type(kind.number)
    return builder.gep(builder.bitcast(address, number.as_pointer()), [index], inbounds=True)


@lower_builtin(operator.getitem, BufferType, types.Integer)
def read(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Load a number of a buffer."""
    return builder.load(address_of(context, builder, sig.args[0], *args))


@lower_builtin(operator.setitem, BufferType, types.Integer, types.Float)
@lower_builtin(operator.setitem, BufferType, types.Integer, types.Integer)
def write(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Store a number in a buffer."""
    buffer, index, number = args
    builder.store(number, address_of(context, builder, sig.args[0], buffer, index))
    return context.get_dummy_value()


def is_single(kind: Any) -> bool:
    """Whether a type is that of a buffer of singles."""
    return isinstance(kind, BufferType) and bool(kind.number == types.float32)


@intrinsic
def _converted(_context: Any, buffer: Any, number: Any) -> Any:
    """Convert a number to one such as a buffer holds."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return context.cast(builder, args[1], sig.args[1], sig.return_type)

    return buffer.number(buffer, number), generate


def like(_buffer: Any, number: Any) -> Any:
    """Give a number in the precision of a buffer, which times and their differences are not in."""
    return number


def _like(buffer: Any, number: Any) -> Any:
    return _converted(buffer, number)


replace(like, lambda buffer, _number: _like if is_single(buffer) else like)


# ------------------------------------------------------------------------------- parameters


@infer_getattr
class Fields(AttributeTemplate):
    """Every field of `LawParameters` is a number."""

    key = ParametersType

    def generic_resolve(self, kind: Any, name: str) -> Any:
        """Type of a field."""
        return kind.number if name in LawParameters._fields else None


@lower_getattr_generic(ParametersType)
def read_field(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    """Load a field."""
    index = WHOLE(LawParameters._fields.index(name))
    return builder.load(address_of(context, builder, kind, value, index))


@intrinsic
def on_the_stack(_context: Any, numbers: Any) -> Any:
    """Copy a law's parameters to the stack, from where they go into registers.

    Read from elsewhere, the compiler would have to expect that writing to a buffer changes them,
    and would not turn loops into vector instructions. To be called in the kernel itself: what is on
    the stack of a function that it calls is gone after the call.
    """

    def generate(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        number = context.get_value_type(numbers.number)
        copy = cgutils.alloca_once(builder, number, size=WHOLE(len(LawParameters._fields)))
        for i in range(len(LawParameters._fields)):
            field = builder.load(address_of(context, builder, numbers, args[0], WHOLE(i)))
            builder.store(field, builder.gep(copy, [WHOLE(i)]))
        return builder.bitcast(copy, context.get_value_type(numbers))

    return numbers(numbers), generate


# ------------------------------------------------------------------- what a kernel is handed


class Handle:
    """A copy of numbers, whose address is all that a kernel is given.

    Parameters
    ----------
    numbers : array
        Or a tuple of them.
    dtype : type
        What to keep them as: doubles, singles or 64-bit whole numbers.

    Examples
    --------
    >>> Handle((1.0, 2.0)).numbers
    array([1., 2.])
    """

    def __init__(self, numbers: Any, *, dtype: type[np.number[Any]] = np.float64) -> None:
        self.number = from_dtype(np.dtype(dtype))
        given = np.asarray(numbers, dtype=dtype)
        room = np.empty(given.nbytes + LINE, np.uint8)
        begin = -room.ctypes.data % LINE
        self.numbers = room[begin : begin + given.nbytes].view(given.dtype).reshape(given.shape)
        self.numbers[...] = given
        self.address = self.numbers.ctypes.data


class Buffer(Handle):
    """A `BufferType` in compiled code."""


class Parameters(Handle):
    """A `ParametersType` in compiled code, made of a `LawParameters`."""


@typeof_impl.register(Buffer)
def _type_of_buffer(handle: Any, _context: Any) -> Any:
    return BufferType(handle.number)


@typeof_impl.register(Parameters)
def _type_of_parameters(handle: Any, _context: Any) -> Any:
    return ParametersType(handle.number)


@unbox(BufferType)
@unbox(ParametersType)
def _take(kind: Any, handle: Any, compiler: Any) -> Any:
    """Take the address out of a handle."""
    number = compiler.pyapi.object_getattr_string(handle, "address")
    address = compiler.unbox(types.intp, number).value
    compiler.pyapi.decref(number)
    pointer = compiler.builder.inttoptr(address, compiler.context.get_value_type(kind))
    return NativeValue(pointer)
