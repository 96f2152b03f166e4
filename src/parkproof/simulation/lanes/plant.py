"""The plant of a block of lanes: signals, coordinates, and one control period of motion.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`.
"""

import math

import numba

from parkproof.model.chained import body_inputs, chained_inputs
from parkproof.model.signals import tone_value
from parkproof.scalar import sign
from parkproof.simulation.compiler import OPTIONS
from parkproof.simulation.lanes.buffer import (
    ALPHA1,
    ALPHA1_END,
    ALPHA1_MEAN,
    ALPHA1_MID,
    BLOCK,
    CHART,
    GAMMA1,
    GAMMA1_END,
    GAMMA1_MEAN,
    GAMMA1_MID,
    KEPT0,
    KEPT_PATH,
    PATH,
    S0,
    S1,
    S2,
    S3,
    S4,
    SINES,
    SQUARES,
    STEP,
    TAU1,
    TAU2,
)
from parkproof.simulation.steps import chained_step, turning_step

inlined = numba.njit(forceinline=True, **OPTIONS)


@inlined
def tone_at(tones, i, m, j, squares, t):
    """Value of a lane's tone; where no lane has square waves, that is known before the loop."""
    square = tones[i, m, 3, j] if squares else 0.0
    return tone_value(tones[i, m, 0, j], tones[i, m, 1, j], tones[i, m, 2, j], square, t)


@inlined
def fill_signals(b, tones, kinds, mean, one, other, t_one, t_other):
    """Write signals that vary at two times into as many rows each, from ``one`` and ``other`` on.

    ``mean`` is the first row of their means. Rows of constant signals are left alone.
    """
    for i in range(kinds.shape[0]):
        row = i * BLOCK
        for m in range(kinds.shape[1]):
            kind = kinds[i, m]
            if kind == SINES and m == 0:
                for j in range(BLOCK):
                    begin = b[mean + row + j]
                    b[one + row + j] = begin + tone_at(tones, i, 0, j, False, t_one)
                    b[other + row + j] = begin + tone_at(tones, i, 0, j, False, t_other)
            elif kind == SINES:
                for j in range(BLOCK):
                    b[one + row + j] += tone_at(tones, i, m, j, False, t_one)
                    b[other + row + j] += tone_at(tones, i, m, j, False, t_other)
            elif kind == SQUARES:
                for j in range(BLOCK):
                    begin = b[mean + row + j]
                    one_before = begin if m == 0 else b[one + row + j]
                    other_before = begin if m == 0 else b[other + row + j]
                    b[one + row + j] = one_before + tone_at(tones, i, m, j, True, t_one)
                    b[other + row + j] = other_before + tone_at(tones, i, m, j, True, t_other)


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
    """Rates γτ + φ of both channels, with the signals of four rows."""
    tau1, tau2 = b[TAU1 + j], b[TAU2 + j]
    phi1 = -adversary1 * sign(tau1) if adversary1 > 0.0 else b[row + 2 * BLOCK + j]
    phi2 = -adversary2 * sign(tau2) if adversary2 > 0.0 else b[row + 3 * BLOCK + j]
    return b[row + j] * tau1 + phi1, b[row + BLOCK + j] * tau2 + phi2


@inlined
def scales_at(b, j, row):
    """Give α1, α2 and b2 of three rows."""
    return b[row + j], b[row + BLOCK + j], b[row + 2 * BLOCK + j]


@inlined
def move(b, j, state, adversary, h, step):
    """Move a lane from a state by one Runge-Kutta step, in the chart or outside it."""
    a1, a2 = rates(b, j, GAMMA1, adversary[0, j], adversary[1, j])
    m1, m2 = rates(b, j, GAMMA1_MID, adversary[0, j], adversary[1, j])
    e1, e2 = rates(b, j, GAMMA1_END, adversary[0, j], adversary[1, j])
    s0, s1, s2, s3, s4 = state
    a, m, e = scales_at(b, j, ALPHA1), scales_at(b, j, ALPHA1_MID), scales_at(b, j, ALPHA1_END)
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
def advance(b, turning, tones, kinds, scale_tones, scale_kinds, adversary, t, h, steps):
    """Move all lanes by one control period."""
    part = h / steps
    for i in range(steps):
        begin = t + i * part
        middle, end = begin + 0.5 * part, begin + part
        fill_signals(b, tones, kinds, GAMMA1_MEAN, GAMMA1_MID, GAMMA1_END, middle, end)
        fill_signals(b, scale_tones, scale_kinds, ALPHA1_MEAN, ALPHA1_MID, ALPHA1_END, middle, end)
        if turning > 0:  # the loop for lanes in the chart takes all along, and is then undone
            for j in range(BLOCK):
                for k in range(5):
                    b[KEPT0 + k * BLOCK + j] = b[S0 + k * BLOCK + j]
                b[KEPT_PATH + j] = b[PATH + j]
        for j in range(BLOCK):
            move(b, j, state_at(b, j, S0), adversary, part, chained_step)
        if turning > 0:
            for j in range(BLOCK):
                if b[CHART + j] == 0.0:
                    b[PATH + j] = b[KEPT_PATH + j]
                    move(b, j, state_at(b, j, KEPT0), adversary, part, turning_step)
        for j in range(4 * BLOCK):
            b[GAMMA1 + j] = b[GAMMA1_END + j]
        if scale_kinds.shape[1] > 0:
            for j in range(3 * BLOCK):
                b[ALPHA1 + j] = b[ALPHA1_END + j]
