"""What the controllers of a block of lanes are given: measurements with noise, and late.

Compiled code: arrays ``b`` are the buffer of `parkproof.simulation.lanes.buffer`. ``ring`` holds
the measurements of the last samples, each as the five states and whether they are in the chart.
"""

import math

from parkproof.model.chained import body_inputs, chained_inputs
from parkproof.model.unicycle import wrap_angle
from parkproof.simulation.compiler import inlined
from parkproof.simulation.noise import standard_noise

from .buffer import (
    BLOCK,
    CHART,
    ENDING,
    LEFT_CHART,
    NEXT,
    RAW2,
    RAW3,
    RAW4,
    RAW_CHART,
    S0,
    S2,
    SEEN0,
    SEEN1,
    SEEN2,
    SEEN3,
    SEEN4,
    STEP,
)


@inlined
def take(b, source, ring, now, k, sensing, keys):
    """Measure five rows from one on at sample k, with noise, into a place of the ring."""
    for i in range(5):
        deviation = sensing.deviations[i]
        for j in range(BLOCK):
            ring[now, i, j] = b[source + i * BLOCK + j]
        if deviation > 0.0:
            for j in range(BLOCK):
                ring[now, i, j] += deviation * standard_noise(keys[0, j], keys[1, j], k, i)


@inlined
def see(b, ring, k, sensing, keys):
    """Measure at sample k, and hand the controllers what is due."""
    now, due = k % ring.shape[0], max(k - sensing.delay, 0) % ring.shape[0]
    take(b, S0, ring, now, k, sensing, keys)
    outside = 0
    for j in range(BLOCK):
        ring[now, 5, j] = b[CHART + j]
        b[RAW_CHART + j] = ring[due, 5, j]
        outside += 1 if ring[due, 5, j] == 0.0 else 0
    for j in range(BLOCK):
        b[SEEN0 + j], b[SEEN1 + j] = ring[due, 0, j], ring[due, 1, j]
        b[RAW2 + j], b[RAW3 + j], b[RAW4 + j] = ring[due, 2, j], ring[due, 3, j], ring[due, 4, j]
        b[SEEN2 + j], b[SEEN3 + j], b[SEEN4 + j] = b[RAW2 + j], b[RAW3 + j], b[RAW4 + j]
    if outside > 0:
        for j in range(BLOCK):
            if b[RAW_CHART + j] == 0.0:
                b[RAW2 + j] = wrap_angle(b[RAW2 + j])
                b[SEEN2 + j], b[SEEN3 + j], b[SEEN4 + j] = seen_in_chart(b, j)


@inlined
def seen_in_chart(b, j):
    """x2, u0 and u1 of a heading and velocities that are measured outside the chart."""
    theta = b[RAW2 + j]
    if abs(theta) >= 0.5 * math.pi:
        return math.copysign(math.inf, theta), math.nan, math.nan
    x2 = math.tan(theta)
    u0, u1 = chained_inputs(b[RAW3 + j], b[RAW4 + j], x2)
    return x2, u0, u1


@inlined
def seen_pose(b, j):
    """Heading, speed and turn rate, however they are measured."""
    if b[RAW_CHART + j] == 0.0:
        return b[RAW2 + j], b[RAW3 + j], b[RAW4 + j]
    v, omega = body_inputs(b[RAW3 + j], b[RAW4 + j], b[RAW2 + j])
    return math.atan(b[RAW2 + j]), v, omega


@inlined
def is_unseen(b, j):
    """Whether a lane whose law cannot turn is outside the chart, or seen there."""
    return not (abs(b[SEEN2 + j]) < 1e6 and (b[CHART + j] == 1.0 or b[STEP + j] < 1.0))


@inlined
def end_unseen(b):
    """Mark such lanes, and say how many."""
    found = 0
    for j in range(BLOCK):
        if b[ENDING + j] == 0.0 and is_unseen(b, j):
            b[ENDING + j] = LEFT_CHART
            found += 1
    return found


@inlined
def is_misled(b, j):
    """Whether a lane is about to enter the chart with a heading that is not in it."""
    enters = b[NEXT + j] >= 1.0 and b[CHART + j] == 0.0
    return enters and abs(b[S2 + j]) >= 0.5 * math.pi
