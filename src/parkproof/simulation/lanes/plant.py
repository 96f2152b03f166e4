"""The plant of a block of lanes: coordinates, and one control period of motion.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`.
"""

import math

from parkproof.model.chained import body_inputs, chained_inputs, extension_rate
from parkproof.scalar import sign
from parkproof.simulation.compiler import inlined
from parkproof.simulation.steps import (
    chained_euler_step,
    chained_step,
    turning_euler_step,
    turning_step,
)

from .buffer import (
    ALPHA1,
    ALPHA2,
    B2,
    BLOCK,
    CHART,
    END,
    GAMMA1,
    GAMMA2,
    KEPT0,
    KEPT_LENGTH,
    LENGTH,
    MIDDLE,
    PATH,
    PHI1,
    PHI2,
    PUSH1,
    PUSH2,
    S0,
    S2,
    S3,
    S4,
    START,
    STEP,
    TAU1,
    TAU2,
)
from .memory import like
from .sums import add_to
from .updates import put_if


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
        b[PUSH1 + j] = -adversary[j] * sign(b[TAU1 + j])
        b[PUSH2 + j] = -adversary[BLOCK + j] * sign(b[TAU2 + j])


@inlined
def disturbed(b, j, row, inputs):
    """Rates γτ + φ of both channels' last states, with the signals of rows from one on.

    ``inputs`` is the first of the two rows that γ multiplies.
    """
    phi1, phi2 = b[row + PHI1 + j] + b[PUSH1 + j], b[row + PHI2 + j] + b[PUSH2 + j]
    rate1 = extension_rate(b[inputs + j], b[row + GAMMA1 + j], phi1)
    return rate1, extension_rate(b[inputs + BLOCK + j], b[row + GAMMA2 + j], phi2)


@inlined
def input_rates(b, j, row):
    """Rates of the last states of a robot that takes τ itself."""
    return disturbed(b, j, row, TAU1)


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
def euler_in_chart(b, _camera, j, state, one, two, h):
    """Euler's step in the chart, under the paper's camera."""
    s0, s1, s2, s3, s4 = state
    (a1, _, _), (a2, _, _) = one, two
    return chained_euler_step(s0, s1, s2, s3, s4, scales_at(b, j, START), a1, a2, h)


@inlined
def euler_outside(b, _camera, j, state, one, two, h):
    """Euler's step outside the chart, under the paper's camera."""
    s0, s1, s2, s3, s4 = state
    (a1, _, _), (a2, _, _) = one, two
    return turning_euler_step(s0, s1, s2, s3, s4, scales_at(b, j, START), a1, a2, h)


@inlined
def move(b, camera, j, state, row, h, rates, step):
    """Move a lane from a state by one integration step, to rows from one on; say how far."""
    a1, a2 = rates(b, j, START)
    m1, m2 = rates(b, j, MIDDLE)
    e1, e2 = rates(b, j, END)
    n0, n1, n2, n3, n4 = step(b, camera, j, state, (a1, m1, e1), (a2, m2, e2), h)
    b[row + j], b[row + BLOCK + j], b[row + 2 * BLOCK + j] = n0, n1, n2
    b[row + 3 * BLOCK + j], b[row + 4 * BLOCK + j] = n3, n4
    s0, s1, _, _, _ = state
    return math.sqrt((n0 - s0) * (n0 - s0) + (n1 - s1) * (n1 - s1))


@inlined
def state_at(b, j, row):
    """Give the five numbers of five rows."""
    return (
        b[row + j], b[row + BLOCK + j], b[row + 2 * BLOCK + j], b[row + 3 * BLOCK + j],
        b[row + 4 * BLOCK + j],
    )  # fmt: skip


def advancing(find_signals, inside, outside):
    """Make the function that moves all lanes by one control period.

    Before the first, it finds the signals at its start. ``find_signals`` is one of
    `parkproof.simulation.lanes.signals`; ``inside`` and ``outside`` are integration steps in the
    chart and outside it.
    """

    @inlined
    def advance(b, camera, turning, tones, kinds, t, h, steps, k):
        part = like(b, h / steps)
        for i in range(-1 if k == 0 else 0, steps):
            find_signals(b, tones, kinds, t, h, i, steps, k)
            if i >= 0:
                if turning:  # each lane is moved both ways, and then one of them counts
                    for j in range(BLOCK):
                        length = move(
                            b, camera, j, state_at(b, j, S0), KEPT0, part, input_rates, outside
                        )
                        b[KEPT_LENGTH + j] = length
                for j in range(BLOCK):
                    length = move(b, camera, j, state_at(b, j, S0), S0, part, input_rates, inside)
                    b[LENGTH + j] = length
                if turning:
                    for j in range(BLOCK):
                        out = b[CHART + j] == 0.0
                        put_if(b, LENGTH + j, out, b[KEPT_LENGTH + j])
                        for row in range(0, 5 * BLOCK, BLOCK):
                            put_if(b, S0 + row + j, out, b[KEPT0 + row + j])
                for j in range(BLOCK):
                    add_to(b, PATH, j, b[LENGTH + j])

    return advance
