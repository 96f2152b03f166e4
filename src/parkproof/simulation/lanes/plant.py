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
    PUSH1,
    PUSH2,
    S0,
    S1,
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

inlined = register_jitable(forceinline=True, **OPTIONS)


@inlined
def tone_at(tones, i, m, j, squares, t):
    """Value of a lane's tone; where no lane has square waves, that is known before the loop."""
    square = tones[i, m, 3, j] if squares else 0.0
    return tone_value(tones[i, m, 0, j], tones[i, m, 1, j], tones[i, m, 2, j], square, t)


@inlined
def fill_signals(b, tones, kinds, rows, t):
    """Write the signals that vary at a time into their rows; those of constant ones are right.

    A step's end is the next one's start: where the rows are those for the end, what they held
    becomes the start.
    """
    for i in range(SIGNALS):
        row = i * BLOCK
        for m in range(kinds.shape[1]):
            kind = kinds[i, m]
            if kind == SINES and m == 0:
                for j in range(BLOCK):
                    if rows == END:
                        b[START + row + j] = b[END + row + j]
                    b[rows + row + j] = b[MEAN + row + j] + tone_at(tones, i, 0, j, False, t)
            elif kind == SINES:
                for j in range(BLOCK):
                    b[rows + row + j] += tone_at(tones, i, m, j, False, t)
            elif kind == SQUARES:
                for j in range(BLOCK):
                    if rows == END and m == 0:
                        b[START + row + j] = b[END + row + j]
                    before = b[MEAN + row + j] if m == 0 else b[rows + row + j]
                    b[rows + row + j] = before + tone_at(tones, i, m, j, True, t)


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
def push(b, adversary):
    """Disturbances of adversaries, which oppose the inputs; all other lanes keep theirs, 0."""
    for j in range(BLOCK):
        b[PUSH1 + j] = -adversary[0, j] * sign(b[TAU1 + j])
        b[PUSH2 + j] = -adversary[1, j] * sign(b[TAU2 + j])


@inlined
def rates(b, j, row):
    """Rates γτ + φ of both channels, with the signals of rows from one on."""
    phi1, phi2 = b[row + PHI1 + j] + b[PUSH1 + j], b[row + PHI2 + j] + b[PUSH2 + j]
    return (
        extension_rate(b[TAU1 + j], b[row + GAMMA1 + j], phi1),
        extension_rate(b[TAU2 + j], b[row + GAMMA2 + j], phi2),
    )


@inlined
def scales_at(b, j, row):
    """Give α1, α2 and b2 of rows from one on."""
    return b[row + ALPHA1 + j], b[row + ALPHA2 + j], b[row + B2 + j]


@inlined
def move(b, j, state, h, step):
    """Move a lane from a state by one integration step, in the chart or outside it."""
    a1, a2 = rates(b, j, START)
    m1, m2 = rates(b, j, MIDDLE)
    e1, e2 = rates(b, j, END)
    s0, s1, s2, s3, s4 = state
    a, m, e = scales_at(b, j, START), scales_at(b, j, MIDDLE), scales_at(b, j, END)
    n0, n1, n2, n3, n4 = step(s0, s1, s2, s3, s4, a, m, e, a1, m1, e1, a2, m2, e2, h)
    b[S0 + j], b[S1 + j], b[S2 + j], b[S3 + j], b[S4 + j] = n0, n1, n2, n3, n4
    b[PATH + j] += math.sqrt((n0 - s0) * (n0 - s0) + (n1 - s1) * (n1 - s1))


@inlined
def state_at(b, j, row):
    """Give the five numbers of five rows."""
    return (
        b[row + j], b[row + BLOCK + j], b[row + 2 * BLOCK + j], b[row + 3 * BLOCK + j],
        b[row + 4 * BLOCK + j],
    )  # fmt: skip


@inlined
def advance(b, turning, tones, kinds, t, h, steps, first, euler, step, turn):
    """Move all lanes by one control period; before the first, find the signals at its start.

    Integration steps are ``step`` in the chart and ``turn`` outside it; Euler's know no middle.
    """
    part = h / steps
    for i in range(-1 if first and not euler else 0, steps):
        begin = t + i * part
        if euler:
            fill_signals(b, tones, kinds, START, begin)
        else:
            fill_signals(b, tones, kinds, MIDDLE, begin + 0.5 * part)
            fill_signals(b, tones, kinds, END, begin + part)
        if i >= 0:
            if turning:  # the loop for lanes in the chart takes all along, and is then undone
                for j in range(BLOCK):
                    for k in range(5):
                        b[KEPT0 + k * BLOCK + j] = b[S0 + k * BLOCK + j]
                    b[KEPT_PATH + j] = b[PATH + j]
            for j in range(BLOCK):
                move(b, j, state_at(b, j, S0), part, step)
            if turning:
                for j in range(BLOCK):
                    if b[CHART + j] == 0.0:
                        b[PATH + j] = b[KEPT_PATH + j]
                        move(b, j, state_at(b, j, KEPT0), part, turn)
