"""Python's ``max``, ``min`` and ``int`` as an instruction or two each, for compiled code.

numba compiles functions of its own for them, each with optimisation and machine code, though nobody
calls them once they have been inlined. These give what Python gives: the first of several numbers,
unless a later one is beyond it (as a double, where some of them are doubles).
"""

from typing import Any

from numba import types
from numba.core import ir
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.errors import TypingError
from numba.extending import intrinsic


def _beyond(context: Any, relation: str, *kinds: Any) -> Any:
    """Choose the number that has a relation to all before it, else stay with the one before."""
    kind = context.unify_types(*kinds)
    real = isinstance(kind, types.Float)
    if not real and not (isinstance(kind, types.Integer) and kind.signed):
        raise TypingError(f"max and min of {kinds} in a kernel: give floats or signed integers")

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        pairs = zip(args, sig.args, strict=True)
        best, *others = (context.cast(builder, number, given, kind) for number, given in pairs)
        compare = builder.fcmp_ordered if real else builder.icmp_signed
        for other in others:
            best = builder.select(compare(relation, other, best), other, best)
        return best

    return kind(*kinds), generate


def _of_two(relation: str) -> Any:
    return intrinsic(lambda context, a, b: _beyond(context, relation, a, b))


def _of_three(relation: str) -> Any:
    return intrinsic(lambda context, a, b, c: _beyond(context, relation, a, b, c))


def _of_four(relation: str) -> Any:
    return intrinsic(lambda context, a, b, c, d: _beyond(context, relation, a, b, c, d))


@intrinsic
def truncated(_context: Any, number: Any) -> Any:
    """``int`` of a number."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return context.cast(builder, args[0], sig.args[0], types.int64)

    return types.int64(number), generate


KNOWN = {
    (function, count): of(relation)
    for function, relation in ((max, ">"), (min, "<"))
    for count, of in ((2, _of_two), (3, _of_three), (4, _of_four))
} | {(int, 1): truncated}
"""What stands for a function called with so many numbers."""


@register_pass(mutates_CFG=False, analysis_only=False)
class Instructions(FunctionPass):
    """Let functions call these, where it sees a call with so many numbers.

    With a conditional expression among them, numba's form names the function in another block; that
    call is left as it is.
    """

    _name = "parkproof_instructions"

    def __init__(self) -> None:  # numba's own is abstract
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        """Replace what they call, and say whether there was anything."""
        assignments = assignments_of(state.func_ir)
        counts = {
            each.value.func.name: len(each.value.args)
            for each in assignments
            if isinstance(each.value, ir.Expr)
            and each.value.op == "call"
            and not each.value.vararg
            and not each.value.kws
        }
        found = [
            (each, KNOWN[call])
            for each in assignments
            if isinstance(each.value, ir.Global)
            and callable(each.value.value)
            and (call := (each.value.value, counts.get(each.target.name))) in KNOWN
        ]
        for each, instruction in found:
            replace_value(state.func_ir, each, ir.Global("", instruction, each.loc))
        return bool(found)


def assignments_of(func_ir: Any) -> list[Any]:
    """All assignments of numba's intermediate form of a function.

    Parameters
    ----------
    func_ir : numba.core.ir.FunctionIR
        The function's form.

    Returns
    -------
    list of numba.core.ir.Assign
        In order, block by block.
    """
    return [
        statement
        for block in func_ir.blocks.values()
        for statement in block.body
        if isinstance(statement, ir.Assign)
    ]


def replace_value(func_ir: Any, assignment: Any, value: Any) -> None:
    """Let an assignment of numba's intermediate form assign something else.

    Parameters
    ----------
    func_ir : numba.core.ir.FunctionIR
        The function's form.
    assignment : numba.core.ir.Assign
        One of its assignments.
    value : numba.core.ir.Inst
        What to assign.
    """
    before, assignment.value = assignment.value, value
    known = func_ir._definitions[assignment.target.name]
    known[:] = [value if each is before else each for each in known]
