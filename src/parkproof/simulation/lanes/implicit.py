"""Inputs of a block of lanes in the implicit form.

Most channels slide along their surface, and have nothing to seek; a group of lanes looks for the
ends of its channels until the last of them is found, and none is sought further than alone.
Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`, ``groups`` what
`parkproof.simulation.lanes.order.find_steps` lists, ``seen`` the first of the five rows that
controllers are given.
"""

from parkproof.laws.inputs import implicit_answers, predicted, with_direct
from parkproof.laws.robustify import (
    CLOSE,
    LOOKS,
    begun_search,
    implicit_excess,
    implicit_surface,
    narrowed_search,
)
from parkproof.laws.turn import turn_channels
from parkproof.simulation.compiler import inlined

from .buffer import (
    AT,
    AT_HIGH,
    AT_LOW,
    BLOCK,
    CHANNELS,
    DISTANCE,
    GROUP,
    HIGH,
    LAST,
    LOW,
    NEW1,
    NEW2,
    OFFSET,
    OPEN,
    OUTER,
    POWER,
    SIDE,
    SIZE,
    STEP,
    SURFACE,
    WAY,
)
from .order import count_of, group_of
from .plant import state_at
from .updates import put_if, put_two_if


@inlined
def put(b, j, here, channel, u, phi, kappa):
    """Write a channel's law and where its search begins into rows from one on."""
    gain, power, offset, outer = channel
    surface, side, distance = implicit_surface(u, power, offset, kappa * phi)
    put_if(b, SIZE + j, here, kappa * gain)
    put_if(b, POWER + j, here, power)
    put_if(b, OFFSET + j, here, offset)
    put_if(b, OUTER + j, here, outer)
    put_if(b, SURFACE + j, here, surface)
    put_if(b, SIDE + j, here, side)
    put_if(b, DISTANCE + j, here, distance)


@inlined
def prepare(b, step, groups, seen, p, law_channels):
    """Laws and surfaces of both channels of the lanes in a step."""
    for i in range(count_of(groups, step)):
        first = group_of(groups, step, i)
        for j in range(first, first + GROUP):
            x0, x1, x2, u0, u1 = state_at(b, j, seen)
            y0, y1, y2 = predicted(x0, x1, x2, u0, u1, p)
            one, two = law_channels(step, b[WAY + j], y0, y1, y2, u0, p)
            here = b[STEP + j] == step
            put(b, j, here, one, u0, p.phi1, p.kappa1)
            put(b, j + CHANNELS, here, two, u1, p.phi2, p.kappa2)


@inlined
def prepare_turn(b, groups, pose, p):
    """Laws and surfaces of both channels of lanes that turn."""
    for i in range(count_of(groups, 0.0)):
        first = group_of(groups, 0.0, i)
        for j in range(first, first + GROUP):
            theta, v, omega = pose(b, j)
            one, two = turn_channels(theta + p.lookahead * omega, p)
            here = b[STEP + j] == 0.0
            put(b, j, here, one, v, p.phi1, p.kappa1)
            put(b, j + CHANNELS, here, two, omega, p.phi2, p.kappa2)


@inlined
def look(b, j):
    """What is left over of a channel's equation where its search looks."""
    return implicit_excess(
        b[AT + j], b[SURFACE + j], b[SIDE + j], b[DISTANCE + j], b[SIZE + j], b[POWER + j],
        b[OFFSET + j], b[OUTER + j],
    )  # fmt: skip


@inlined
def note(b, j, here, search):
    """Keep a search that has got further."""
    low, high, at_low, at_high, last, at = search
    put_if(b, LOW + j, here, low)
    put_if(b, HIGH + j, here, high)
    put_if(b, AT_LOW + j, here, at_low)
    put_if(b, AT_HIGH + j, here, at_high)
    put_if(b, LAST + j, here, last)
    put_if(b, AT + j, here, at)


@inlined
def solve(b):
    """Find the ends of both channels of all lanes."""
    for channel in range(2):
        for first in range(channel * CHANNELS, channel * CHANNELS + BLOCK, GROUP):
            left = 0
            for j in range(first, first + GROUP):
                distance = b[DISTANCE + j]
                b[AT + j] = distance
                b[OPEN + j] = 1.0 if distance > 0.0 and b[SIZE + j] > 0.0 else 0.0
                left += 1 if b[OPEN + j] > 0.0 else 0
            if left > 0:
                for j in range(first, first + GROUP):
                    search = begun_search(b[DISTANCE + j], look(b, j), b[OUTER + j])
                    note(b, j, b[OPEN + j] > 0.0, search)
            looks = 0
            while left > 0 and looks < LOOKS:
                left = 0
                for j in range(first, first + GROUP):
                    excess = look(b, j)
                    here = b[OPEN + j] > 0.0
                    search = narrowed_search(
                        b[LOW + j], b[HIGH + j], b[AT_LOW + j], b[AT_HIGH + j], b[LAST + j],
                        b[AT + j], excess,
                    )  # fmt: skip
                    note(b, j, here, search)
                    open_still = here and abs(excess) > CLOSE * b[DISTANCE + j]
                    b[OPEN + j] = 1.0 if open_still else 0.0
                    left += 1 if open_still else 0
                looks += 1


@inlined
def end_of(b, j):
    """Where a channel's last state shall end."""
    return b[SURFACE + j] + b[SIDE + j] * b[AT + j]


@inlined
def answer(b, step, groups, seen, p, law_direct):
    """Inputs of the lanes in a step."""
    for i in range(count_of(groups, step)):
        first = group_of(groups, step, i)
        for j in range(first, first + GROUP):
            x0, x1, x2, u0, u1 = state_at(b, j, seen)
            end1, end2 = end_of(b, j), end_of(b, j + CHANNELS)
            size1, size2 = b[SIZE + j], b[SIZE + CHANNELS + j]
            tau1, tau2 = implicit_answers(end1, size1, end2, size2, u0, u1, p)
            _, y1, y2 = predicted(x0, x1, x2, u0, u1, p)
            tau2 = with_direct(tau2, law_direct(step, b[WAY + j], y1, y2, u1, p), p)
            put_two_if(b, NEW1 + j, NEW2 + j, b[STEP + j] == step, (tau1, tau2))


@inlined
def answer_turn(b, groups, pose, p):
    """Inputs of lanes that turn."""
    for i in range(count_of(groups, 0.0)):
        first = group_of(groups, 0.0, i)
        for j in range(first, first + GROUP):
            _, v, omega = pose(b, j)
            end1, end2 = end_of(b, j), end_of(b, j + CHANNELS)
            size1, size2 = b[SIZE + j], b[SIZE + CHANNELS + j]
            answers = implicit_answers(end1, size1, end2, size2, v, omega, p)
            put_two_if(b, NEW1 + j, NEW2 + j, b[STEP + j] == 0.0, answers)


@inlined
def find_inputs(b, groups, seen, pose, turns, p, law_channels, law_direct):
    """Find the inputs of all lanes; steps are written out, so that the compiler knows each."""
    if turns:
        prepare_turn(b, groups, pose, p)
    prepare(b, 1.0, groups, seen, p, law_channels)
    prepare(b, 2.0, groups, seen, p, law_channels)
    prepare(b, 3.0, groups, seen, p, law_channels)
    prepare(b, 4.0, groups, seen, p, law_channels)
    solve(b)
    if turns:
        answer_turn(b, groups, pose, p)
    answer(b, 1.0, groups, seen, p, law_direct)
    answer(b, 2.0, groups, seen, p, law_direct)
    answer(b, 3.0, groups, seen, p, law_direct)
    answer(b, 4.0, groups, seen, p, law_direct)
