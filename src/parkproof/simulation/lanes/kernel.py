"""The same scalar functions compiled for ensembles: 64 trials side by side, the loop inside.

The kernel repeats the reference run of `parkproof.simulation.run` for robots of kind "chained" and
the paper's camera. Law, switching, inputs and measurements are the functions used there; only the
order of the loops differs. A lane's result does not depend on its place in a batch or on its
company: all lanes go through the vector loops, whose code rounds in one way, and those that are
turning are then done again one by one.

A controller is given the rows X0 … X4: where measurements are exact and prompt, those of the state
itself, else those that `parkproof.simulation.lanes.sensor` fills.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numba
import numpy as np

from parkproof.laws.inputs import explicit_inputs, implicit_inputs, predicted, with_direct
from parkproof.laws.table import law_named
from parkproof.laws.turn import turn_channels, turned
from parkproof.model.chained import chained_inputs
from parkproof.model.unicycle import wrap_angle
from parkproof.simulation.lanes.buffer import (
    BLOCK,
    CHART,
    END0,
    ENDED,
    ENDED_AT,
    HIGH0,
    KEPT,
    LOW0,
    OLD0,
    OLD1,
    ROWS,
    S0,
    S1,
    S2,
    S3,
    S4,
    SEEN0,
    SEEN1,
    SEEN2,
    SEEN3,
    SEEN4,
    STEP,
    STEP_BEFORE,
    TAU1,
    TAU2,
    WAY,
)
from parkproof.simulation.lanes.metrics import count, measure, watch
from parkproof.simulation.lanes.plant import advance_all, begin_signals, change_coordinates
from parkproof.simulation.lanes.sensor import end_misled, end_unseen, see, seen_pose
from parkproof.simulation.polynomials import OPTIONS, register


@numba.njit(forceinline=True, **OPTIONS)
def true_pose(b, j):
    """Heading, speed and turn rate of a lane that turns, measured exactly."""
    return b[S2, j], b[S3, j], b[S4, j]


@cache
def kernel_of(law_name: str, *, implicit: bool, exact: bool = True) -> Callable[..., Any]:
    """Compile the kernel of a law in one form, once a process.

    Parameters
    ----------
    law_name : str
        "published", "corrected" or "homogeneous".
    implicit : bool
        Which form of the law.
    exact : bool
        Whether measurements are without noise and latency.

    Returns
    -------
    callable
        ``kernel(p, clock, limits, sensing, state, in_chart, scale_mean, scale_tones, mean, tones,
        adversary, keys, out)``: carries out the trials of one block of `BLOCK` lanes, reading
        arrays whose last axis is the lane and writing the rows `RESULTS` into ``out``. It releases
        the interpreter lock.

    Examples
    --------
    >>> callable(kernel_of("corrected", implicit=False))
    True
    """
    register()
    law = law_named(law_name)
    law_begin, law_direction, law_switch = law.begin, law.direction, law.switch
    law_channels, law_direct, turns = law.channels, law.direct, law.turns
    inputs = implicit_inputs if implicit else explicit_inputs
    compiled = numba.njit(nogil=True, **OPTIONS)
    inlined = numba.njit(forceinline=True, **OPTIONS)
    X0, X1, X2, X3, X4 = (S0, S1, S2, S3, S4) if exact else (SEEN0, SEEN1, SEEN2, SEEN3, SEEN4)
    pose = true_pose if exact else seen_pose

    @compiled
    def begin(b, p):
        for j in range(BLOCK):
            if b[CHART, j] == 0.0:
                b[S2, j] = wrap_angle(b[S2, j])
                theta, v, omega = pose(b, j)
                inside = abs(theta) < 0.5 * math.pi
                x2 = math.tan(theta) if inside else math.copysign(math.inf, theta)
                _, rate = chained_inputs(v, omega, x2)
            else:
                x2, rate = b[X2, j], b[X4, j]
            b[STEP, j] = law_begin(b[X1, j], x2, rate, p)
            if not exact:
                end_misled(b, j, 0.0)
            change_coordinates(b, j)
            b[STEP_BEFORE, j] = b[STEP, j]
            b[WAY, j] = law_direction(b[X0, j], b[X1, j], b[X2, j], b[X3, j], p)

    @inlined
    def switch_lane(b, j, t, p):
        x0, x1, x2, u0, u1 = b[X0, j], b[X1, j], b[X2, j], b[X3, j], b[X4, j]
        b[STEP, j] = law_switch(b[STEP, j], b[WAY, j], t, x0, x1, x2, u0, u1, p)

    @inlined
    def turn_lane(b, j, t, p):
        b[S2, j] = wrap_angle(b[S2, j])
        theta, v, omega = pose(b, j)
        if turned(theta, v, omega, p):
            x2 = math.tan(theta)
            _, u1 = chained_inputs(v, omega, x2)
            b[STEP, j] = law_begin(b[X1, j], x2, u1, p)
            if not exact:
                end_misled(b, j, t)
            change_coordinates(b, j)

    @compiled
    def switch_all(b, t, p):
        before = count(b, STEP, 0.0)
        if before > 0:
            for j in range(BLOCK):
                b[KEPT, j] = b[STEP, j]
        for j in range(BLOCK):
            switch_lane(b, j, t, p)
        if not turns:
            return 0
        if before > 0:
            for j in range(BLOCK):
                if b[KEPT, j] == 0.0:
                    b[STEP, j] = 0.0
                    turn_lane(b, j, t, p)
        turning = count(b, STEP, 0.0)
        fresh = 0
        for j in range(BLOCK):
            fresh += 1 if b[STEP, j] == 1.0 and b[STEP_BEFORE, j] != 1.0 else 0
        if fresh > 0:
            for j in range(BLOCK):
                if b[STEP, j] == 1.0 and b[STEP_BEFORE, j] != 1.0:
                    b[WAY, j] = law_direction(b[X0, j], b[X1, j], b[X2, j], b[X3, j], p)
        if turning > 0:
            for j in range(BLOCK):
                change_coordinates(b, j)
        return turning

    @inlined
    def command_in_chart(b, j, p):
        x0, x1, x2, u0, u1 = b[X0, j], b[X1, j], b[X2, j], b[X3, j], b[X4, j]
        y0, y1, y2 = predicted(x0, x1, x2, u0, u1, p)
        one, two = law_channels(b[STEP, j], b[WAY, j], y0, y1, y2, u0, p)
        tau1, tau2 = inputs(one, two, u0, u1, p)
        return tau1, with_direct(tau2, law_direct(b[STEP, j], b[WAY, j], y1, y2, u1, p), p)

    @inlined
    def command_turning(b, j, p):
        theta, v, omega = pose(b, j)
        one, two = turn_channels(theta + p.lookahead * omega, p)
        return inputs(one, two, v, omega, p)

    @compiled
    def command_all(b, turning, p):
        for j in range(BLOCK):
            b[OLD0, j], b[OLD1, j] = b[TAU1, j], b[TAU2, j]
        for j in range(BLOCK):
            b[TAU1, j], b[TAU2, j] = command_in_chart(b, j, p)
        if turning > 0:
            for j in range(BLOCK):
                if b[STEP, j] == 0.0:
                    b[TAU1, j], b[TAU2, j] = command_turning(b, j, p)

    @compiled
    def kernel(
        p, clock, limits, sensing, state, in_chart, scale_mean, scale_tones, mean, tones,
        adversary, keys, out,
    ):  # fmt: skip
        b = np.zeros((len(ROWS), BLOCK))
        for j in range(BLOCK):
            for i in range(5):
                b[S0 + i, j] = state[i, j]
            for i in range(4):
                b[END0 + i, j] = -1.0
            b[CHART, j] = in_chart[j]
            b[ENDED_AT, j] = -1.0
            b[LOW0, j] = b[HIGH0, j] = b[S0, j]
        ring = np.empty((1 if exact else sensing.delay + 1, 6, BLOCK))
        if not exact:
            see(b, ring, 0, sensing, keys)
        begin(b, p)
        begin_signals(b, mean, tones, scale_mean, scale_tones)
        for k in range(clock.samples + 1):
            t = k * clock.period
            if not exact and k > 0:
                see(b, ring, k, sensing, keys)
            watch(b, t, limits, turns)
            if not exact and not turns:
                end_unseen(b, t)
            turning = switch_all(b, t, p) if k > 0 else count(b, STEP, 0.0)
            command_all(b, turning, p)
            measure(b, t, k == 0, clock.residual_from, limits)
            if count(b, ENDED, 0.0) == 0:
                break
            if k < clock.samples:
                advance_all(
                    b, turning, scale_mean, scale_tones, mean, tones, adversary,
                    t, clock.period, clock.plant_steps,
                )  # fmt: skip
        for i in range(out.shape[0]):
            for j in range(BLOCK):
                out[i, j] = b[i, j]

    return kernel
