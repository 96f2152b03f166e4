"""The plant of a block of lanes: signals, coordinates, and one control period of motion.

Compiled code: arrays ``b`` are the buffer of `parkproof.simulation.lanes.buffer`.
"""

import math

import numba

from parkproof.model.chained import body_inputs, chained_inputs
from parkproof.model.signals import tone_value
from parkproof.scalar import sign
from parkproof.simulation.lanes.buffer import (
    ALPHA1,
    ALPHA1_END,
    ALPHA1_MID,
    BLOCK,
    CHART,
    ENDED,
    GAMMA1,
    GAMMA1_END,
    GAMMA1_MID,
    PATH,
    S0,
    S1,
    S2,
    S3,
    S4,
    STEP,
    TAU1,
    TAU2,
)
from parkproof.simulation.polynomials import OPTIONS, register
from parkproof.simulation.steps import chained_step, turning_step

register()

compiled = numba.njit(nogil=True, **OPTIONS)
inlined = numba.njit(forceinline=True, **OPTIONS)


@compiled
def fill_signals(b, mean, tones, t, row):
    """Write γ1, γ2, φ1, φ2 or α1, α2, b2 at time t into as many rows."""
    for i in range(mean.shape[0]):
        for j in range(BLOCK):
            b[row + i, j] = mean[i, j]
        for m in range(tones.shape[1]):
            for j in range(BLOCK):
                b[row + i, j] += tone_value(
                    tones[i, m, 0, j],
                    tones[i, m, 1, j],
                    tones[i, m, 2, j],
                    tones[i, m, 3, j],
                    t,
                )


@inlined
def change_coordinates(b, j):
    """Enter or leave the chart, as the step of a lane asks."""
    if b[STEP, j] >= 1.0 and b[CHART, j] == 0.0:
        x2 = math.tan(b[S2, j])
        u0, u1 = chained_inputs(b[S3, j], b[S4, j], x2)
        b[S2, j], b[S3, j], b[S4, j], b[CHART, j] = x2, u0, u1, 1.0
    elif b[STEP, j] == 0.0 and b[CHART, j] == 1.0:
        x2 = b[S2, j]
        v, omega = body_inputs(b[S3, j], b[S4, j], x2)
        b[S2, j], b[S3, j], b[S4, j], b[CHART, j] = math.atan(x2), v, omega, 0.0


@inlined
def rates(b, j, row, adversary1, adversary2):
    """Rates γτ + φ of both channels, with the signals of four rows."""
    tau1, tau2 = b[TAU1, j], b[TAU2, j]
    phi1 = -adversary1 * sign(tau1) if adversary1 > 0.0 else b[row + 2, j]
    phi2 = -adversary2 * sign(tau2) if adversary2 > 0.0 else b[row + 3, j]
    return b[row, j] * tau1 + phi1, b[row + 1, j] * tau2 + phi2


@compiled
def begin_signals(b, mean, tones, scale_mean, scale_tones):
    """Fill the rows for the start of the run; constant α1, α2, b2 are then never filled again."""
    fill_signals(b, mean, tones, 0.0, GAMMA1)
    for row in (ALPHA1, ALPHA1_MID, ALPHA1_END):
        fill_signals(b, scale_mean, scale_tones, 0.0, row)


@inlined
def scales_at(b, j, row):
    """Give α1, α2 and b2 of three rows."""
    return b[row, j], b[row + 1, j], b[row + 2, j]


@inlined
def advance_lane(b, j, adversary, h, in_chart):
    """Move a lane by one integration step, if it is still running and in these coordinates."""
    a1, a2 = rates(b, j, GAMMA1, adversary[0, j], adversary[1, j])
    m1, m2 = rates(b, j, GAMMA1_MID, adversary[0, j], adversary[1, j])
    e1, e2 = rates(b, j, GAMMA1_END, adversary[0, j], adversary[1, j])
    s0, s1, s2, s3, s4 = b[S0, j], b[S1, j], b[S2, j], b[S3, j], b[S4, j]
    a, m, e = scales_at(b, j, ALPHA1), scales_at(b, j, ALPHA1_MID), scales_at(b, j, ALPHA1_END)
    if in_chart:
        n0, n1, n2, n3, n4 = chained_step(s0, s1, s2, s3, s4, a, m, e, a1, m1, e1, a2, m2, e2, h)
    else:
        n0, n1, n2, n3, n4 = turning_step(s0, s1, s2, s3, s4, a, m, e, a1, m1, e1, a2, m2, e2, h)
    moved = math.sqrt((n0 - s0) * (n0 - s0) + (n1 - s1) * (n1 - s1))
    moves = b[ENDED, j] == 0.0 and b[CHART, j] == (1.0 if in_chart else 0.0)
    b[PATH, j] += moved if moves else 0.0
    b[S0, j] = n0 if moves else s0
    b[S1, j] = n1 if moves else s1
    b[S2, j] = n2 if moves else s2
    b[S3, j] = n3 if moves else s3
    b[S4, j] = n4 if moves else s4


@compiled
def advance_all(b, turning, scale_mean, scale_tones, mean, tones, adversary, t, h, steps):
    """Move all lanes by one control period."""
    part = h / steps
    vary = scale_tones.shape[1] > 0
    for i in range(steps):
        fill_signals(b, mean, tones, t + i * part + 0.5 * part, GAMMA1_MID)
        fill_signals(b, mean, tones, t + i * part + part, GAMMA1_END)
        if vary:
            fill_signals(b, scale_mean, scale_tones, t + i * part + 0.5 * part, ALPHA1_MID)
            fill_signals(b, scale_mean, scale_tones, t + i * part + part, ALPHA1_END)
        for j in range(BLOCK):
            advance_lane(b, j, adversary, part, True)
        if turning > 0:
            for j in range(BLOCK):
                advance_lane(b, j, adversary, part, False)
        for k in range(4):
            for j in range(BLOCK):
                b[GAMMA1 + k, j] = b[GAMMA1_END + k, j]
        if vary:
            for k in range(3):
                for j in range(BLOCK):
                    b[ALPHA1 + k, j] = b[ALPHA1_END + k, j]
