"""Metrics and ends of a block of lanes.

Compiled code: arrays ``b`` are the buffer of `parkproof.simulation.lanes.buffer`.
"""

import math

import numba

from parkproof.simulation.lanes.buffer import (
    BLOCK,
    CHART,
    DIVERGED,
    END0,
    ENDED,
    ENDED_AT,
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
    OLD0,
    OLD1,
    OUT_OF_VIEW,
    PEAK1,
    PEAK2,
    RESIDUAL0,
    RESIDUAL1,
    RESIDUAL2,
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
    STEP_BEFORE,
    TAU1,
    TAU2,
    TURN_RATE,
    VARIATION1,
    VARIATION2,
)
from parkproof.simulation.polynomials import OPTIONS

compiled = numba.njit(nogil=True, **OPTIONS)
inlined = numba.njit(forceinline=True, **OPTIONS)


@inlined
def count(b, row, value):
    """Count the lanes with a given value in a row."""
    found = 0
    for j in range(BLOCK):
        found += 1 if b[row, j] == value else 0
    return found


@compiled
def watch(b, t, limits, turns):
    """End lanes that cannot go on from this measurement."""
    for j in range(BLOCK):
        x2 = b[S2, j] if b[CHART, j] == 1.0 else 0.0
        square = 1.0 + x2 * x2
        speed = abs(b[S3, j]) * math.sqrt(square)
        rate = abs(b[S4, j]) / square
        x, y = b[S0, j], b[S1, j]
        sound = max(abs(x), abs(y), speed, rate) < 1e6
        seen = x >= limits.x_min and x <= limits.x_max and y >= limits.y_min and y <= limits.y_max
        inside = turns or abs(x2) < 1e6
        code = (
            DIVERGED
            if not sound
            else (OUT_OF_VIEW if not seen else (LEFT_CHART if not inside else 0.0))
        )
        ends = b[ENDED, j] == 0.0 and code > 0.0
        b[ENDED, j] = code if ends else b[ENDED, j]
        b[ENDED_AT, j] = t if ends else b[ENDED_AT, j]


@compiled
def measure(b, t, first, residual_from, limits):
    """Update metrics of the lanes that are still running; then end those beyond their limits."""
    for j in range(BLOCK):
        live = b[ENDED, j] == 0.0
        step, before = b[STEP, j], b[STEP_BEFORE, j]
        onward, back = live and step > before, live and step < before
        for i in range(4):
            ended = onward and before == i
            b[END0 + i, j] = t if ended else (-1.0 if back and i >= step else b[END0 + i, j])
        b[RETURNS, j] += 1.0 if back else 0.0
        b[STEP_BEFORE, j] = step if live else before
    for j in range(BLOCK):
        live = b[ENDED, j] == 0.0
        x, y = b[S0, j], b[S1, j]
        in_chart = b[CHART, j] == 1.0
        x2 = b[S2, j] if in_chart else 0.0
        tau1, tau2 = b[TAU1, j], b[TAU2, j]
        late = live and t >= residual_from
        holding = live and b[STEP, j] == 4.0
        e0, e1, e2 = abs(x), abs(y), abs(b[S2, j])  # outside the chart |θ| counts for |x2|
        b[RESIDUAL0, j] = max(b[RESIDUAL0, j], e0) if late else b[RESIDUAL0, j]
        b[RESIDUAL1, j] = max(b[RESIDUAL1, j], e1) if late else b[RESIDUAL1, j]
        b[RESIDUAL2, j] = max(b[RESIDUAL2, j], e2) if late else b[RESIDUAL2, j]
        b[HELD0, j] = max(b[HELD0, j], e0) if holding else 0.0
        b[HELD1, j] = max(b[HELD1, j], e1) if holding else 0.0
        b[HELD2, j] = max(b[HELD2, j], e2) if holding else 0.0
        b[PEAK1, j] = max(b[PEAK1, j], abs(tau1)) if live else b[PEAK1, j]
        b[PEAK2, j] = max(b[PEAK2, j], abs(tau2)) if live else b[PEAK2, j]
        b[SQUARE1, j] += tau1 * tau1 if live else 0.0
        b[SQUARE2, j] += tau2 * tau2 if live else 0.0
        counted = live and not first
        b[VARIATION1, j] += abs(tau1 - b[OLD0, j]) if counted else 0.0
        b[VARIATION2, j] += abs(tau2 - b[OLD1, j]) if counted else 0.0
        b[EXCURSION2, j] = max(b[EXCURSION2, j], x * x + y * y) if live else b[EXCURSION2, j]
        charted, turning = live and in_chart, live and not in_chart
        b[HEADING, j] = max(b[HEADING, j], abs(b[S2, j])) if turning else b[HEADING, j]
        b[MAX0, j] = max(b[MAX0, j], e0) if live else b[MAX0, j]
        b[MAX1, j] = max(b[MAX1, j], e1) if live else b[MAX1, j]
        b[MAX2, j] = max(b[MAX2, j], e2) if charted else b[MAX2, j]
        b[MAX3, j] = max(b[MAX3, j], abs(b[S3, j])) if charted else b[MAX3, j]
        b[MAX4, j] = max(b[MAX4, j], abs(b[S4, j])) if charted else b[MAX4, j]
        b[LOW0, j] = min(b[LOW0, j], x) if live else b[LOW0, j]
        b[HIGH0, j] = max(b[HIGH0, j], x) if live else b[HIGH0, j]
        square = 1.0 + x2 * x2
        speed, turn_rate = abs(b[S3, j]) * math.sqrt(square), abs(b[S4, j]) / square
        b[SPEED, j] = max(b[SPEED, j], speed) if live else b[SPEED, j]
        b[TURN_RATE, j] = max(b[TURN_RATE, j], turn_rate) if live else b[TURN_RATE, j]
        fast = speed > limits.speed or turn_rate > limits.turn_rate
        strong = abs(tau1) > limits.tau1 or abs(tau2) > limits.tau2
        code = INPUT_LIMIT if strong else (SPEED_LIMIT if fast else 0.0)
        ends = live and code > 0.0
        b[ENDED, j] = code if ends else b[ENDED, j]
        b[ENDED_AT, j] = t if ends else b[ENDED_AT, j]
