"""Sums over all samples of a run: in single precision with what rounding takes from them.

A sum of many small numbers in single precision would fall behind, and at last stand still.
Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`.
"""

from parkproof.simulation.compiler import replace

from .buffer import RESTS
from .memory import is_single


def add_to(b, row, j, number):
    """Add a number to a lane's sum in a row."""
    b[row + j] += number


def _add_to_single(b, row, j, number):
    """Kahan's sum: what rounding took from it is kept, and given back with the next number."""
    before, more = b[row + j], number - b[row + RESTS + j]
    after = before + more
    b[row + RESTS + j] = (after - before) - more
    b[row + j] = after


replace(add_to, lambda b, _row, _j, _number: _add_to_single if is_single(b) else add_to)
