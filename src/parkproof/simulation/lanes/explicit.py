"""Inputs of a block of lanes in the explicit form.

In two loops, each short enough for a processor to work on several groups of lanes at once: errors
of both channels, and the answers to them. Compiled code: ``b`` is the buffer of
`parkproof.simulation.lanes.buffer`, ``seen`` the first of the five rows that controllers are given.
"""

from parkproof.laws.inputs import explicit_answers, explicit_errors, with_direct
from parkproof.laws.turn import turn_channels
from parkproof.simulation.compiler import inlined

from .buffer import BLOCK, ERROR1, ERROR2, GROUP, NEW1, NEW2, STEP, WAY
from .plant import state_at


@inlined
def prepare(b, step, count, firsts, seen, p, law_channels):
    """Errors of both channels of the groups of lanes that have some in a step."""
    for i in range(count):
        first = firsts[i] & (BLOCK - GROUP)  # so that the compiler sees that it is an index
        for j in range(first, first + GROUP):
            x0, x1, x2, u0, u1 = state_at(b, j, seen)
            one, two = law_channels(step, b[WAY + j], x0, x1, x2, u0, p)
            error1, error2 = explicit_errors(one, two, u0, u1)
            here = b[STEP + j] == step
            b[ERROR1 + j] = error1 if here else b[ERROR1 + j]
            b[ERROR2 + j] = error2 if here else b[ERROR2 + j]


@inlined
def prepare_turn(b, count, firsts, pose, p):
    """Errors of both channels of lanes that turn."""
    for i in range(count):
        first = firsts[i] & (BLOCK - GROUP)
        for j in range(first, first + GROUP):
            theta, v, omega = pose(b, j)
            one, two = turn_channels(theta + p.lookahead * omega, p)
            error1, error2 = explicit_errors(one, two, v, omega)
            here = b[STEP + j] == 0.0
            b[ERROR1 + j] = error1 if here else b[ERROR1 + j]
            b[ERROR2 + j] = error2 if here else b[ERROR2 + j]


@inlined
def solve(_b):
    """There is nothing to solve."""


@inlined
def answer(b, step, count, firsts, seen, p, law_channels, law_direct):
    """Inputs of the lanes in a step."""
    for i in range(count):
        first = firsts[i] & (BLOCK - GROUP)
        for j in range(first, first + GROUP):
            x0, x1, x2, u0, u1 = state_at(b, j, seen)
            way = b[WAY + j]
            one, two = law_channels(step, way, x0, x1, x2, u0, p)
            tau1, tau2 = explicit_answers(one, two, b[ERROR1 + j], b[ERROR2 + j], p)
            tau2 = with_direct(tau2, law_direct(step, way, x1, x2, u1, p), p)
            here = b[STEP + j] == step
            b[NEW1 + j] = tau1 if here else b[NEW1 + j]
            b[NEW2 + j] = tau2 if here else b[NEW2 + j]


@inlined
def answer_turn(b, count, firsts, pose, p):
    """Inputs of lanes that turn."""
    for i in range(count):
        first = firsts[i] & (BLOCK - GROUP)
        for j in range(first, first + GROUP):
            theta, _, omega = pose(b, j)
            one, two = turn_channels(theta + p.lookahead * omega, p)
            tau1, tau2 = explicit_answers(one, two, b[ERROR1 + j], b[ERROR2 + j], p)
            here = b[STEP + j] == 0.0
            b[NEW1 + j] = tau1 if here else b[NEW1 + j]
            b[NEW2 + j] = tau2 if here else b[NEW2 + j]
