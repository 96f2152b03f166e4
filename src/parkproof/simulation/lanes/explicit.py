"""Inputs of a block of lanes in the explicit form.

In four loops for each step, most of them over half a power of both channels, so that a processor
works on several groups of lanes at once: a power takes it a hundred cycles in which it can look
some two hundred instructions ahead. (The second also has the power that is in the offset of
`parkproof.laws.chains.three_chain`, where that is in force.) Each step has rows of its own for what
one loop leaves for the next, so that only the last has to leave lanes of other steps alone.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`, ``groups`` what
`parkproof.simulation.lanes.order.find_steps` lists, ``seen`` the first of the five rows that
controllers are given.
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
    OWN_ROWS,
    STEP,
    WAY,
)
from .order import count_of, group_of
from .plant import state_at
from .updates import put_two_if


@inlined
def own_row(step):
    """Say how far a step's own row lies behind that of Step 1."""
    return (int(step) - 1) * BLOCK if OWN_ROWS > 1 else 0


@inlined
def begin_errors(b, step, groups, seen, p, law_channels):
    """Begin the errors of both channels of the groups of lanes that have some in a step."""
    own = own_row(step)
    for i in range(count_of(groups, step)):
        first = group_of(groups, step, i)
        for j in range(first, first + GROUP):
            x0, x1, x2, u0, u1 = state_at(b, j, seen)
            one, two = law_channels(step, b[WAY + j], x0, x1, x2, u0, p)
            begun = begun_errors(one, two, u0, u1)
            b[BEGUN1 + own + j], b[BEGUN2 + own + j] = begun


@inlined
def end_errors(b, step, groups, seen, p, law_channels):
    """Find the errors."""
    own = own_row(step)
    for i in range(count_of(groups, step)):
        first = group_of(groups, step, i)
        for j in range(first, first + GROUP):
            x0, x1, x2, u0, u1 = state_at(b, j, seen)
            one, two = law_channels(step, b[WAY + j], x0, x1, x2, u0, p)
            begun1, begun2 = b[BEGUN1 + own + j], b[BEGUN2 + own + j]
            errors = ended_errors(one, two, begun1, begun2, u0, u1)
            b[ERROR1 + own + j], b[ERROR2 + own + j] = errors


@inlined
def begin_answers(b, step, groups, seen, p, law_channels):
    """Begin the answers to the errors."""
    own = own_row(step)
    for i in range(count_of(groups, step)):
        first = group_of(groups, step, i)
        for j in range(first, first + GROUP):
            x0, x1, x2, u0, _ = state_at(b, j, seen)
            one, two = law_channels(step, b[WAY + j], x0, x1, x2, u0, p)
            begun = begun_answers(one, two, b[ERROR1 + own + j], b[ERROR2 + own + j])
            b[BEGUN1 + own + j], b[BEGUN2 + own + j] = begun


@inlined
def end_answers(b, step, groups, seen, p, law_channels, law_direct):
    """Find the inputs of the lanes in a step."""
    own = own_row(step)
    for i in range(count_of(groups, step)):
        first = group_of(groups, step, i)
        for j in range(first, first + GROUP):
            x0, x1, x2, u0, u1 = state_at(b, j, seen)
            way = b[WAY + j]
            one, two = law_channels(step, way, x0, x1, x2, u0, p)
            begun1, begun2 = b[BEGUN1 + own + j], b[BEGUN2 + own + j]
            error1, error2 = b[ERROR1 + own + j], b[ERROR2 + own + j]
            tau1, tau2 = ended_answers(one, two, begun1, begun2, error1, error2, p)
            tau2 = with_direct(tau2, law_direct(step, way, x1, x2, u1, p), p)
            put_two_if(b, NEW1 + j, NEW2 + j, b[STEP + j] == step, (tau1, tau2))


@inlined
def answer_turn(b, groups, pose, p):
    """Find the inputs of lanes that turn: few, and for a short while."""
    for i in range(count_of(groups, 0.0)):
        first = group_of(groups, 0.0, i)
        for j in range(first, first + GROUP):
            theta, v, omega = pose(b, j)
            one, two = turn_channels(theta + p.lookahead * omega, p)
            put_two_if(
                b, NEW1 + j, NEW2 + j, b[STEP + j] == 0.0, explicit_inputs(one, two, v, omega, p)
            )


@inlined
def find_inputs(b, groups, seen, pose, turns, p, law_channels, law_direct):
    """Find the inputs of all lanes; steps are written out, so that the compiler knows each."""
    if turns:
        answer_turn(b, groups, pose, p)
    begin_errors(b, 1.0, groups, seen, p, law_channels)
    begin_errors(b, 2.0, groups, seen, p, law_channels)
    begin_errors(b, 3.0, groups, seen, p, law_channels)
    begin_errors(b, 4.0, groups, seen, p, law_channels)
    end_errors(b, 1.0, groups, seen, p, law_channels)
    end_errors(b, 2.0, groups, seen, p, law_channels)
    end_errors(b, 3.0, groups, seen, p, law_channels)
    end_errors(b, 4.0, groups, seen, p, law_channels)
    begin_answers(b, 1.0, groups, seen, p, law_channels)
    begin_answers(b, 2.0, groups, seen, p, law_channels)
    begin_answers(b, 3.0, groups, seen, p, law_channels)
    begin_answers(b, 4.0, groups, seen, p, law_channels)
    end_answers(b, 1.0, groups, seen, p, law_channels, law_direct)
    end_answers(b, 2.0, groups, seen, p, law_channels, law_direct)
    end_answers(b, 3.0, groups, seen, p, law_channels, law_direct)
    end_answers(b, 4.0, groups, seen, p, law_channels, law_direct)
