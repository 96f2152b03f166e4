"""Metrics and ends of a block of lanes.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`. What every sample needs
is done for all lanes at once; what is rare, one lane at a time. A lane that ends hands in its
results there and then and stays behind as an idle one, so that no other loop has to leave it out.
"""

import math

from parkproof.simulation.compiler import inlined

from .buffer import (
    BEFORE,
    BLOCK,
    CHART,
    DIVERGED,
    END0,
    ENDED,
    ENDED_AT,
    ENDING,
    EXCURSION2,
    HEADING,
    HELD0,
    HELD1,
    HELD2,
    HIGH0,
    INPUT_LIMIT,
    LEFT_CHART,
    LOW0,
    MAX0,
    MAX1,
    MAX2,
    MAX3,
    MAX4,
    NEW1,
    NEW2,
    NEXT,
    OUT_OF_VIEW,
    PEAK1,
    PEAK2,
    PLACE,
    RESIDUAL0,
    RESIDUAL1,
    RESIDUAL2,
    RESULTS,
    RETURNS,
    S0,
    S1,
    S2,
    S3,
    S4,
    SPEED,
    SPEED_LIMIT,
    SQUARE1,
    SQUARE2,
    STEP,
    TAU1,
    TAU2,
    TURN_RATE,
    TURN_SQUARE,
    VARIATION1,
    VARIATION2,
    WAY,
)
from .plant import state_at
from .sums import add_to
from .updates import put_if, raise_to

RESULT_ROWS = len(RESULTS)


@inlined
def hand_in(b, t, last, out, idle):
    """Write the results of lanes that end, or of all that are left; say how many.

    A lane that ends before the others idles at the goal from here on.
    """
    found = 0
    for j in range(BLOCK):
        if b[ENDED + j] == 0.0 and (last or b[ENDING + j] > 0.0):
            if b[ENDING + j] > 0.0:
                b[ENDED + j], b[ENDED_AT + j] = b[ENDING + j], t
            place = int(b[PLACE + j])
            for i in range(RESULT_ROWS):
                out[i, place] = b[i * BLOCK + j]
            out[MAX0 // BLOCK, place] = max(-b[LOW0 + j], b[HIGH0 + j])
            out[SPEED // BLOCK, place] = math.sqrt(b[SPEED + j])
            out[TURN_RATE // BLOCK, place] = b[TURN_RATE + j] / b[TURN_SQUARE + j]
            for i in range(5):
                b[S0 + i * BLOCK + j] = 0.0
            b[STEP + j], b[NEXT + j], b[WAY + j], b[CHART + j] = 4.0, 4.0, 1.0, 1.0
            idle(b, j)
            found += 1
        b[ENDING + j] = 0.0
    return found


@inlined
def checks_of(b, camera, j, charted, limits, turns, pictured):
    """Whether a lane's numbers are sound, it is in view, and it is in the chart if it has to be.

    ``charted`` says in which coordinates its numbers are.
    """
    x, y, third, fourth, fifth = state_at(b, j, S0)
    x2 = third if charted else 0.0
    square = 1.0 + x2 * x2
    slow = fourth * fourth * square < 1e12 and abs(fifth) < 1e6 * square
    sound = max(abs(x), abs(y)) < 1e6 and slow
    inside = x >= limits.x_min and x <= limits.x_max and y >= limits.y_min and y <= limits.y_max
    return sound, inside and pictured(camera, j, x, y), turns or abs(x2) < 1e6


@inlined
def can_go_on(b, camera, j, charted, limits, turns, pictured):
    """Whether a lane can go on from this measurement."""
    sound, seen, placed = checks_of(b, camera, j, charted, limits, turns, pictured)
    return sound and seen and placed


@inlined
def end_code(b, camera, j, limits, turns, pictured):
    """Why a lane cannot go on from this measurement, or 0."""
    charted = b[CHART + j] == 1.0
    sound, seen, placed = checks_of(b, camera, j, charted, limits, turns, pictured)
    code = 0.0 if placed else LEFT_CHART
    return DIVERGED if not sound else (code if seen else OUT_OF_VIEW)


@inlined
def mark_ends(b, camera, limits, turns, pictured):
    """Mark lanes that cannot go on from this measurement, and say how many."""
    found = 0
    for j in range(BLOCK):
        b[ENDING + j] = end_code(b, camera, j, limits, turns, pictured)
        found += 1 if b[ENDING + j] > 0.0 else 0
    return found


@inlined
def note_step(b, j, t):
    """Note when steps end, as a lane begins, goes on to its next step or back to an earlier one."""
    step, after = b[STEP + j], b[NEXT + j]
    if step != BEFORE and after > step:
        b[END0 + int(step) * BLOCK + j] = t
    elif step != BEFORE:
        for i in range(4):
            if i >= after:
                b[END0 + i * BLOCK + j] = -1.0
        b[RETURNS + j] += 1.0
    if after == 4.0:
        b[HELD0 + j] = b[HELD1 + j] = b[HELD2 + j] = 0.0
    b[STEP + j] = after


@inlined
def measure_states(b, all_charted, gain):
    """Update excursions, largest states and speeds.

    Where it is known that ``all_charted`` are in the chart, that is not looked up.
    """
    for j in range(BLOCK):
        x, y, third, u0, u1 = state_at(b, j, S0)
        charted = all_charted or b[CHART + j] == 1.0
        x2 = third if charted else 0.0
        size0, size1 = (abs(u0) if charted else 0.0), (abs(u1) if charted else 0.0)
        raise_to(b, EXCURSION2 + j, x * x + y * y)
        put_if(b, LOW0 + j, x < b[LOW0 + j], x)
        raise_to(b, HIGH0 + j, x)
        raise_to(b, MAX1 + j, abs(y))
        raise_to(b, MAX2 + j, abs(x2))
        raise_to(b, MAX3 + j, size0)
        raise_to(b, MAX4 + j, size1)
        # no roots and quotients here: speed is kept squared, turn rate as a fraction
        square = 1.0 + x2 * x2
        raise_to(b, SPEED + j, u0 * u0 * square)
        per_turn = square * gain(b, j)
        faster = abs(u1) * b[TURN_SQUARE + j] > b[TURN_RATE + j] * per_turn
        put_if(b, TURN_RATE + j, faster, abs(u1))
        put_if(b, TURN_SQUARE + j, faster, per_turn)


@inlined
def measure(b, late, holding, outside, gain):
    """Update the metrics of all lanes; the new inputs become those in force.

    ``outside`` says whether any may be outside the chart, and ``gain`` gives β, from the robot's
    turn rate to that of its heading.
    """
    for j in range(BLOCK):
        tau1, tau2 = b[NEW1 + j], b[NEW2 + j]
        change1, change2 = abs(tau1 - b[TAU1 + j]), abs(tau2 - b[TAU2 + j])
        raise_to(b, PEAK1 + j, abs(tau1))
        raise_to(b, PEAK2 + j, abs(tau2))
        add_to(b, SQUARE1, j, tau1 * tau1)
        add_to(b, SQUARE2, j, tau2 * tau2)
        add_to(b, VARIATION1, j, change1)
        add_to(b, VARIATION2, j, change2)
        b[TAU1 + j], b[TAU2 + j] = tau1, tau2
    if outside:
        measure_states(b, False, gain)
    else:
        measure_states(b, True, gain)
    # errors; outside the chart |θ| counts for |x2|
    if holding:
        for j in range(BLOCK):
            raise_to(b, HELD0 + j, abs(b[S0 + j]))
            raise_to(b, HELD1 + j, abs(b[S1 + j]))
            raise_to(b, HELD2 + j, abs(b[S2 + j]))
    if late:
        for j in range(BLOCK):
            raise_to(b, RESIDUAL0 + j, abs(b[S0 + j]))
            raise_to(b, RESIDUAL1 + j, abs(b[S1 + j]))
            raise_to(b, RESIDUAL2 + j, abs(b[S2 + j]))
    if outside:
        for j in range(BLOCK):
            third = abs(b[S2 + j])
            theta = 0.0 if b[CHART + j] == 1.0 else third
            raise_to(b, HEADING + j, theta)


@inlined
def end_beyond_limits(b, limits, gain):
    """Mark lanes whose input or speed is beyond its limit, and say how many."""
    found = 0
    for j in range(BLOCK):
        third = b[S2 + j]
        x2 = third if b[CHART + j] == 1.0 else 0.0
        square = 1.0 + x2 * x2
        fast = abs(b[S3 + j]) * math.sqrt(square) > limits.speed
        turns_fast = abs(b[S4 + j]) / (square * gain(b, j)) > limits.turn_rate
        strong = abs(b[TAU1 + j]) > limits.tau1 or abs(b[TAU2 + j]) > limits.tau2
        code = INPUT_LIMIT if strong else (SPEED_LIMIT if fast or turns_fast else 0.0)
        b[ENDING + j] = code
        found += 1 if code > 0.0 else 0
    return found
