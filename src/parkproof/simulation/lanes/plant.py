"""The plant of a block of lanes: signals, coordinates, and one control period of motion.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`.
"""

import math

from numba.extending import register_jitable

from parkproof.model.chained import body_inputs, chained_inputs
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
    """Write the signals that vary at a time into their rows; those of constant ones are right."""
    for i in range(SIGNALS):
        row = i * BLOCK
        for m in range(kinds.shape[1]):
            kind = kinds[i, m]
            if kind == SINES and m == 0:
                for j in range(BLOCK):
                    b[rows + row + j] = b[MEAN + row + j] + tone_at(tones, i, 0, j, False, t)
            elif kind == SINES:
                for j in range(BLOCK):
                    b[rows + row + j] += tone_at(tones, i, m, j, False, t)
            elif kind == SQUARES:
                for j in range(BLOCK):
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
def rates(b, j, row, adversary1, adversary2):
    """Rates γτ + φ of both channels, with the signals of rows from one on."""
    tau1, tau2 = b[TAU1 + j], b[TAU2 + j]
    phi1 = -adversary1 * sign(tau1) if adversary1 > 0.0 else b[row + PHI1 + j]
    phi2 = -adversary2 * sign(tau2) if adversary2 > 0.0 else b[row + PHI2 + j]
    return b[row + GAMMA1 + j] * tau1 + phi1, b[row + GAMMA2 + j] * tau2 + phi2


@inlined
def scales_at(b, j, row):
    """Give α1, α2 and b2 of rows from one on."""
    return b[row + ALPHA1 + j], b[row + ALPHA2 + j], b[row + B2 + j]


@inlined
def move(b, j, state, adversary, h, step):
    """Move a lane from a state by one integration step, in the chart or outside it."""
    adversary1, adversary2 = adversary[0, j], adversary[1, j]
    a1, a2 = rates(b, j, START, adversary1, adversary2)
    m1, m2 = rates(b, j, MIDDLE, adversary1, adversary2)
    e1, e2 = rates(b, j, END, adversary1, adversary2)
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
def advance(b, turning, tones, kinds, adversary, t, h, steps, first, euler, step, turn):
    """Move all lanes by one control period; before the first, find the signals at its start.

    Integration steps are ``step`` in the chart and ``turn`` outside it; Euler's know no middle.
    """
    part = h / steps
    for i in range(-1 if first else 0, steps):
        begin = t + i * part
        middle, end = begin + 0.5 * part, begin + part
        if not euler:
            fill_signals(b, tones, kinds, MIDDLE, middle)
        fill_signals(b, tones, kinds, END, end)
        if i >= 0:
            if turning:  # the loop for lanes in the chart takes all along, and is then undone
                for j in range(BLOCK):
                    for k in range(5):
                        b[KEPT0 + k * BLOCK + j] = b[S0 + k * BLOCK + j]
                    b[KEPT_PATH + j] = b[PATH + j]
            for j in range(BLOCK):
                move(b, j, state_at(b, j, S0), adversary, part, step)
            if turning:
                for j in range(BLOCK):
                    if b[CHART + j] == 0.0:
                        b[PATH + j] = b[KEPT_PATH + j]
                        move(b, j, state_at(b, j, KEPT0), adversary, part, turn)
        for j in range(SIGNALS * BLOCK):
            b[START + j] = b[END + j]
