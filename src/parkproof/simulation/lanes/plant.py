"""The plant of a block of lanes: signals, coordinates, and one control period of motion.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`.
"""

import math

from numba.extending import register_jitable

from parkproof.model.chained import body_inputs, chained_inputs, extension_rate
from parkproof.model.signals import tone_value
from parkproof.scalar import sign
from parkproof.simulation.compiler import OPTIONS
from parkproof.simulation.lanes.buffer import (
    ALPHA1,
    ALPHA2,
    B2,
    BLOCK,
    CHART,
    END,
    GAMMA1,
    GAMMA2,
    KEPT0,
    KEPT_PATH,
    MEAN,
    MIDDLE,
    PATH,
    PHI1,
    PHI2,
    S0,
    S2,
    S3,
    S4,
    SIGNALS,
    SINES,
    SQUARES,
    START,
    STEP,
    TAU1,
    TAU2,
)
from parkproof.simulation.steps import chained_step, turning_step

inlined = register_jitable(forceinline=True, **OPTIONS)


@inlined
def tone_at(tones, i, m, j, squares, t):
    """Value of a lane's tone; where no lane has square waves, that is known before the loop."""
    square = tones[i, m, 3, j] if squares else 0.0
    return tone_value(tones[i, m, 0, j], tones[i, m, 1, j], tones[i, m, 2, j], square, t)


@inlined
def fill_signals(b, tones, kinds, middle, end):
    """Write the signals that vary at two times into the rows for a step's middle and end.

    Rows of constant signals are left alone.
    """
    for i in range(SIGNALS):
        row = i * BLOCK
        for m in range(kinds.shape[1]):
            kind = kinds[i, m]
            if kind == SINES and m == 0:
                for j in range(BLOCK):
                    mean = b[MEAN + row + j]
                    b[MIDDLE + row + j] = mean + tone_at(tones, i, 0, j, False, middle)
                    b[END + row + j] = mean + tone_at(tones, i, 0, j, False, end)
            elif kind == SINES:
                for j in range(BLOCK):
                    b[MIDDLE + row + j] += tone_at(tones, i, m, j, False, middle)
                    b[END + row + j] += tone_at(tones, i, m, j, False, end)
            elif kind == SQUARES:
                for j in range(BLOCK):
                    mean = b[MEAN + row + j]
                    at_middle = mean if m == 0 else b[MIDDLE + row + j]
                    at_end = mean if m == 0 else b[END + row + j]
                    b[MIDDLE + row + j] = at_middle + tone_at(tones, i, m, j, True, middle)
                    b[END + row + j] = at_end + tone_at(tones, i, m, j, True, end)


@inlined
def change_coordinates(b, j):
    """Enter or leave the chart, as the step of a lane asks."""
    if b[STEP + j] >= 1.0 and b[CHART + j] == 0.0:
        x2 = math.tan(b[S2 + j])
        u0, u1 = chained_inputs(b[S3 + j], b[S4 + j], x2)
        b[S2 + j], b[S3 + j], b[S4 + j], b[CHART + j] = x2, u0, u1, 1.0
    elif b[STEP + j] == 0.0 and b[CHART + j] == 1.0:
        x2 = b[S2 + j]
        v, omega = body_inputs(b[S3 + j], b[S4 + j], x2)
        b[S2 + j], b[S3 + j], b[S4 + j], b[CHART + j] = math.atan(x2), v, omega, 0.0


@inlined
def disturbed(b, j, row, adversary, inputs):
    """Rates γτ + φ of both channels' last states, with the signals of rows from one on.

    ``inputs`` is the first of the two rows that γ multiplies; an adversary opposes τ.
    """
    adversary1, adversary2 = adversary[0, j], adversary[1, j]
    phi1 = -adversary1 * sign(b[TAU1 + j]) if adversary1 > 0.0 else b[row + PHI1 + j]
    phi2 = -adversary2 * sign(b[TAU2 + j]) if adversary2 > 0.0 else b[row + PHI2 + j]
    rate1 = extension_rate(b[inputs + j], b[row + GAMMA1 + j], phi1)
    return rate1, extension_rate(b[inputs + BLOCK + j], b[row + GAMMA2 + j], phi2)


@inlined
def input_rates(b, j, row, adversary):
    """Rates of the last states of a robot that takes τ itself."""
    return disturbed(b, j, row, adversary, TAU1)


@inlined
def scales_at(b, j, row):
    """Give α1, α2 and b2 of rows from one on."""
    return b[row + ALPHA1 + j], b[row + ALPHA2 + j], b[row + B2 + j]


@inlined
def step_in_chart(b, _camera, j, state, one, two, h):
    """Integration step in the chart, under the paper's camera."""
    s0, s1, s2, s3, s4 = state
    (a1, m1, e1), (a2, m2, e2) = one, two
    a, m, e = scales_at(b, j, START), scales_at(b, j, MIDDLE), scales_at(b, j, END)
    return chained_step(s0, s1, s2, s3, s4, a, m, e, a1, m1, e1, a2, m2, e2, h)


@inlined
def step_outside(b, _camera, j, state, one, two, h):
    """Integration step outside the chart, under the paper's camera."""
    s0, s1, s2, s3, s4 = state
    (a1, m1, e1), (a2, m2, e2) = one, two
    a, m, e = scales_at(b, j, START), scales_at(b, j, MIDDLE), scales_at(b, j, END)
    return turning_step(s0, s1, s2, s3, s4, a, m, e, a1, m1, e1, a2, m2, e2, h)


@inlined
def move(b, camera, j, state, row, adversary, h, rates, step):
    """Move a lane from a state by one integration step, to rows from one on."""
    a1, a2 = rates(b, j, START, adversary)
    m1, m2 = rates(b, j, MIDDLE, adversary)
    e1, e2 = rates(b, j, END, adversary)
    n0, n1, n2, n3, n4 = step(b, camera, j, state, (a1, m1, e1), (a2, m2, e2), h)
    b[row + j], b[row + BLOCK + j], b[row + 2 * BLOCK + j] = n0, n1, n2
    b[row + 3 * BLOCK + j], b[row + 4 * BLOCK + j] = n3, n4
    s0, s1, _, _, _ = state
    b[PATH + j] += math.sqrt((n0 - s0) * (n0 - s0) + (n1 - s1) * (n1 - s1))


@inlined
def state_at(b, j, row):
    """Give the five numbers of five rows."""
    return (
        b[row + j], b[row + BLOCK + j], b[row + 2 * BLOCK + j], b[row + 3 * BLOCK + j],
        b[row + 4 * BLOCK + j],
    )  # fmt: skip


@inlined
def signals_now_at_start(b):
    """What was a step's end is the next one's start."""
    for j in range(SIGNALS * BLOCK):
        b[START + j] = b[END + j]


@inlined
def advance(b, camera, turning, tones, kinds, adversary, t, h, steps, first, inside, outside):
    """Move all lanes by one control period; before the first, find the signals at its start.

    ``inside`` and ``outside`` are integration steps in the chart and outside it.
    """
    part = h / steps
    for i in range(-1 if first else 0, steps):
        begin = t + i * part
        middle, end = begin + 0.5 * part, begin + part
        fill_signals(b, tones, kinds, middle, end)
        if i >= 0:
            if turning > 0:  # the loop for lanes in the chart takes all along, and is then undone
                for j in range(BLOCK):
                    for k in range(5):
                        b[KEPT0 + k * BLOCK + j] = b[S0 + k * BLOCK + j]
                    b[KEPT_PATH + j] = b[PATH + j]
            for j in range(BLOCK):
                state = state_at(b, j, S0)
                move(b, camera, j, state, S0, adversary, part, input_rates, inside)
            if turning > 0:
                for j in range(BLOCK):
                    if b[CHART + j] == 0.0:
                        b[PATH + j] = b[KEPT_PATH + j]
                        state = state_at(b, j, KEPT0)
                        move(b, camera, j, state, S0, adversary, part, input_rates, outside)
        signals_now_at_start(b)
