"""The plant of a block of lanes: signals, coordinates, and one control period of motion.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`.
"""

import math

from numba.extending import register_jitable

from parkproof.model.chained import body_inputs, chained_inputs, extension_rate
from parkproof.model.signals import tone_value
from parkproof.scalar import sign
from parkproof.simulation.compiler import OPTIONS
from parkproof.simulation.steps import (
    chained_euler_step,
    chained_step,
    time_in_period,
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
    KEPT_PATH,
    MEAN,
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
def tone_at(tones, first, j, squares, t):
    """Value of a lane's tone; where no lane has square waves, that is known before the loop."""
    square = tones[first + 3 * BLOCK + j] if squares else 0.0
    omega, phase = tones[first + BLOCK + j], tones[first + 2 * BLOCK + j]
    return tone_value(tones[first + j], omega, phase, square, t)


def _filling(rows):
    """Make the function that writes the signals that vary into rows of a time.

    Rows of constant signals are left alone. A step's end is the next one's start: where the rows
    are those for the end, what they held becomes the start.
    """

    @inlined
    def fill(b, tones, kinds, t):
        """Fill the rows with all signals at a time."""
        for i in range(SIGNALS):
            row = i * BLOCK
            for m in range(kinds.shape[1]):
                kind, tone = kinds[i, m], (i * kinds.shape[1] + m) * 4 * BLOCK
                if kind == SINES and m == 0:
                    for j in range(BLOCK):
                        if rows == END:
                            b[START + row + j] = b[END + row + j]
                        b[rows + row + j] = b[MEAN + row + j] + tone_at(tones, tone, j, False, t)
                elif kind == SINES:
                    for j in range(BLOCK):
                        b[rows + row + j] += tone_at(tones, tone, j, False, t)
                elif kind == SQUARES:
                    for j in range(BLOCK):
                        if rows == END and m == 0:
                            b[START + row + j] = b[END + row + j]
                        before = b[MEAN + row + j] if m == 0 else b[rows + row + j]
                        b[rows + row + j] = before + tone_at(tones, tone, j, True, t)

    return fill


fill_start, fill_middle, fill_end = _filling(START), _filling(MIDDLE), _filling(END)


@inlined
def signals_of_step(b, tones, kinds, t, h, i, steps):
    """Find signals at the middle and end of an integration step; its start is the last one's end.

    The step with i = −1 comes before the first of all, and only its end matters.
    """
    fill_middle(b, tones, kinds, time_in_period(t, h, i, steps) + 0.5 * (h / steps))
    fill_end(b, tones, kinds, time_in_period(t, h, i + 1, steps))


@inlined
def signals_at_start(b, tones, kinds, t, h, i, steps):
    """Find signals at the start of an integration step, which is all that Euler's asks for."""
    fill_start(b, tones, kinds, time_in_period(t, h, i, steps))


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
    """Move a lane from a state by one integration step, to rows from one on."""
    a1, a2 = rates(b, j, START)
    m1, m2 = rates(b, j, MIDDLE)
    e1, e2 = rates(b, j, END)
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


def advancing(find_signals, inside, outside):
    """Make the function that moves all lanes by one control period.

    Before the first, it finds the signals at its start. ``find_signals`` is one of those above;
    ``inside`` and ``outside`` are integration steps in the chart and outside it.
    """

    @inlined
    def advance(b, camera, turning, tones, kinds, t, h, steps, first):
        part = h / steps
        for i in range(-1 if first else 0, steps):
            find_signals(b, tones, kinds, t, h, i, steps)
            if i >= 0:
                if turning:  # the loop for lanes in the chart takes all along, and is then undone
                    for j in range(BLOCK):
                        for k in range(5):
                            b[KEPT0 + k * BLOCK + j] = b[S0 + k * BLOCK + j]
                        b[KEPT_PATH + j] = b[PATH + j]
                for j in range(BLOCK):
                    move(b, camera, j, state_at(b, j, S0), S0, part, input_rates, inside)
                if turning:
                    for j in range(BLOCK):
                        if b[CHART + j] == 0.0:
                            b[PATH + j] = b[KEPT_PATH + j]
                            state = state_at(b, j, KEPT0)
                            move(b, camera, j, state, S0, part, input_rates, outside)

    return advance
