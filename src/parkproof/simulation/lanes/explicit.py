"""Inputs of a block of lanes in the explicit form.

In four loops for each step, most of them over half a power of both channels, so that a processor
works on several groups of lanes at once: a power takes it a hundred cycles in which it can look
some two hundred instructions ahead. (The second also has the power that is in the offset of
`parkproof.laws.chains.three_chain`, where that is in force.)

A group some of whose lanes are in another step has a slot for each of its steps. So loops hand all
of a slot's numbers on to the next, and only the last has to leave lanes of other steps alone.
Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`, ``seen`` the first of the
five rows that controllers are given, ``before`` how many slots steps before this one take.
"""

from parkproof.laws.inputs import (
    begun_answers,
    begun_errors,
    ended_answers,
    ended_errors,
    explicit_inputs,
    with_direct,
)
from parkproof.laws.turn import turn_channels
from parkproof.simulation.compiler import inlined

from .buffer import (
    BEGUN1,
    BEGUN2,
    BLOCK,
    ERROR1,
    ERROR2,
    GROUP,
    NEW1,
    NEW2,
    SLOT_ROWS,
    STEP,
    WAY,
)
from .plant import state_at
from .updates import put_two_if


@inlined
def slot_of(number):
    """Where the numbers of a slot begin."""
    return (number * GROUP) & (SLOT_ROWS * BLOCK - GROUP)


@inlined
def begin_errors(b, step, before, count, firsts, seen, p, law_channels):
    """Begin the errors of both channels of the groups of lanes that have some in a step."""
    for i in range(count):
        first = firsts[i] & (BLOCK - GROUP)  # so that the compiler sees that it is an index
        slot = slot_of(before + i)
        for lane in range(GROUP):
            j, k = first + lane, slot + lane
            x0, x1, x2, u0, u1 = state_at(b, j, seen)
            one, two = law_channels(step, b[WAY + j], x0, x1, x2, u0, p)
            b[BEGUN1 + k], b[BEGUN2 + k] = begun_errors(one, two, u0, u1)


@inlined
def end_errors(b, step, before, count, firsts, seen, p, law_channels):
    """Find the errors."""
    for i in range(count):
        first, slot = firsts[i] & (BLOCK - GROUP), slot_of(before + i)
        for lane in range(GROUP):
            j, k = first + lane, slot + lane
            x0, x1, x2, u0, u1 = state_at(b, j, seen)
            one, two = law_channels(step, b[WAY + j], x0, x1, x2, u0, p)
            errors = ended_errors(one, two, b[BEGUN1 + k], b[BEGUN2 + k], u0, u1)
            b[ERROR1 + k], b[ERROR2 + k] = errors


@inlined
def begin_answers(b, step, before, count, firsts, seen, p, law_channels):
    """Begin the answers to the errors."""
    for i in range(count):
        first, slot = firsts[i] & (BLOCK - GROUP), slot_of(before + i)
        for lane in range(GROUP):
            j, k = first + lane, slot + lane
            x0, x1, x2, u0, _ = state_at(b, j, seen)
            one, two = law_channels(step, b[WAY + j], x0, x1, x2, u0, p)
            begun = begun_answers(one, two, b[ERROR1 + k], b[ERROR2 + k])
            b[BEGUN1 + k], b[BEGUN2 + k] = begun


@inlined
def end_answers(b, step, before, count, firsts, seen, p, law_channels, law_direct):
    """Find the inputs of the lanes in a step."""
    for i in range(count):
        first, slot = firsts[i] & (BLOCK - GROUP), slot_of(before + i)
        for lane in range(GROUP):
            j, k = first + lane, slot + lane
            x0, x1, x2, u0, u1 = state_at(b, j, seen)
            way = b[WAY + j]
            one, two = law_channels(step, way, x0, x1, x2, u0, p)
            error1, error2 = b[ERROR1 + k], b[ERROR2 + k]
            tau1, tau2 = ended_answers(one, two, b[BEGUN1 + k], b[BEGUN2 + k], error1, error2, p)
            tau2 = with_direct(tau2, law_direct(step, way, x1, x2, u1, p), p)
            put_two_if(b, NEW1 + j, NEW2 + j, b[STEP + j] == step, (tau1, tau2))


@inlined
def answer_turn(b, count, firsts, pose, p):
    """Find the inputs of lanes that turn: few, and for a short while."""
    for i in range(count):
        first = firsts[i] & (BLOCK - GROUP)
        for j in range(first, first + GROUP):
            theta, v, omega = pose(b, j)
            one, two = turn_channels(theta + p.lookahead * omega, p)
            put_two_if(
                b, NEW1 + j, NEW2 + j, b[STEP + j] == 0.0, explicit_inputs(one, two, v, omega, p)
            )


@inlined
def find_inputs(b, counts, groups, seen, pose, turns, p, law_channels, law_direct):
    """Find the inputs of all lanes; steps are written out, so that the compiler knows each."""
    if turns:
        answer_turn(b, counts[0], groups[0], pose, p)
    in_1, in_2, in_3, in_4 = counts[1], counts[2], counts[3], counts[4]
    to_2, to_3, to_4 = in_1, in_1 + in_2, in_1 + in_2 + in_3
    begin_errors(b, 1.0, 0, in_1, groups[1], seen, p, law_channels)
    begin_errors(b, 2.0, to_2, in_2, groups[2], seen, p, law_channels)
    begin_errors(b, 3.0, to_3, in_3, groups[3], seen, p, law_channels)
    begin_errors(b, 4.0, to_4, in_4, groups[4], seen, p, law_channels)
    end_errors(b, 1.0, 0, in_1, groups[1], seen, p, law_channels)
    end_errors(b, 2.0, to_2, in_2, groups[2], seen, p, law_channels)
    end_errors(b, 3.0, to_3, in_3, groups[3], seen, p, law_channels)
    end_errors(b, 4.0, to_4, in_4, groups[4], seen, p, law_channels)
    begin_answers(b, 1.0, 0, in_1, groups[1], seen, p, law_channels)
    begin_answers(b, 2.0, to_2, in_2, groups[2], seen, p, law_channels)
    begin_answers(b, 3.0, to_3, in_3, groups[3], seen, p, law_channels)
    begin_answers(b, 4.0, to_4, in_4, groups[4], seen, p, law_channels)
    end_answers(b, 1.0, 0, in_1, groups[1], seen, p, law_channels, law_direct)
    end_answers(b, 2.0, to_2, in_2, groups[2], seen, p, law_channels, law_direct)
    end_answers(b, 3.0, to_3, in_3, groups[3], seen, p, law_channels, law_direct)
    end_answers(b, 4.0, to_4, in_4, groups[4], seen, p, law_channels, law_direct)
