"""The same scalar functions compiled for ensembles: 64 trials side by side, the loop inside.

The kernel repeats the reference run of `parkproof.simulation.run` for robots of kind "chained" and
the paper's camera. Law, switching, inputs and measurements are the functions used there; only the
order of the loops differs. A lane's result does not depend on its place in a batch or on its
company, as every operation rounds alike in whichever loop (`parkproof.simulation.compiler`).

A law goes through eight lanes at a time, once for each step in which some of them are, with that
step known to the compiler: powers that a step does not need are then not there. Changes of step and
all that comes with them are rare, and done one lane at a time.

A controller is given the rows X0 … X4: where measurements are exact and prompt, those of the state
itself, else those that `parkproof.simulation.lanes.sensor` fills.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numba
import numpy as np
from numba.extending import register_jitable

from parkproof.laws.inputs import explicit_inputs, implicit_inputs, predicted, with_direct
from parkproof.laws.table import law_named
from parkproof.laws.turn import turn_channels, turned
from parkproof.model.chained import chained_inputs
from parkproof.model.unicycle import wrap_angle
from parkproof.simulation.compiler import OPTIONS, register
from parkproof.simulation.lanes.buffer import (
    BEFORE,
    BLOCK,
    CHART,
    ENDING,
    GROUP,
    LEFT_CHART,
    NEW1,
    NEW2,
    NEXT,
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
    STEPS,
    WAY,
)
from parkproof.simulation.lanes.first import all_tones, first_buffer, kinds_of
from parkproof.simulation.lanes.metrics import (
    end_beyond_limits,
    hand_in,
    measure,
    note_step,
    watch,
)
from parkproof.simulation.lanes.parameters import array_of, parameters_in
from parkproof.simulation.lanes.plant import advance, change_coordinates
from parkproof.simulation.lanes.sensor import end_unseen, is_misled, see, seen_pose
from parkproof.simulation.steps import (
    chained_euler_step,
    chained_step,
    turning_euler_step,
    turning_step,
)

inlined = register_jitable(forceinline=True, **OPTIONS)


@inlined
def true_pose(b, j):
    """Heading, speed and turn rate of a lane that turns, measured exactly."""
    return b[S2 + j], b[S3 + j], b[S4 + j]


@inlined
def find_steps(b, counts, groups):
    """List the groups of lanes in which a step is in force, for each of the five steps."""
    for step in range(STEPS):
        counts[step] = 0
    for first in range(0, BLOCK, GROUP):
        here = 0
        for j in range(first, first + GROUP):
            here |= 1 << int(b[STEP + j])
        for step in range(STEPS):
            if here & (1 << step):
                groups[step, counts[step]] = first
                counts[step] += 1


@cache
def kernel_of(
    law_name: str, *, implicit: bool, exact: bool = True, euler: bool = False
) -> Callable[..., Any]:
    """Give the kernel of a law in one form, compiled when first called, once a process.

    Parameters
    ----------
    law_name : str
        "published", "corrected" or "homogeneous".
    implicit : bool
        Which form of the law.
    exact : bool
        Whether measurements are without noise and latency.
    euler : bool
        Whether to integrate by Euler's method, as the work that lanes are compared with does.

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
    kernel = _compiled(law_name, implicit, exact, euler)

    def block(
        p, clock, limits, sensing, state, in_chart, scale_mean, scale_tones, mean, tones,
        adversary, keys, out,
    ):  # fmt: skip
        b, all_of = first_buffer(state, in_chart, mean, scale_mean), all_tones(tones, scale_tones)
        ring = np.empty((1 if exact else sensing.delay + 1, 6, BLOCK))
        counts, groups = np.zeros(STEPS, np.int64), np.zeros((STEPS, BLOCK // GROUP), np.int64)
        kernel(
            array_of(p), clock, limits, sensing, b, ring, counts, groups, all_of,
            kinds_of(all_of), adversary, keys, out,
        )  # fmt: skip

    return block


@cache
def _compiled(law_name: str, implicit: bool, exact: bool, euler: bool) -> Callable[..., Any]:
    register()
    law = law_named(law_name)
    law_begin, law_direction, law_switch = law.begin, law.direction, law.switch
    law_channels, law_direct, turns = law.channels, law.direct, law.turns
    inputs = implicit_inputs if implicit else explicit_inputs
    X0, X1, X2, X3, X4 = (S0, S1, S2, S3, S4) if exact else (SEEN0, SEEN1, SEEN2, SEEN3, SEEN4)
    pose = true_pose if exact else seen_pose
    step_in_chart = chained_euler_step if euler else chained_step
    step_outside = turning_euler_step if euler else turning_step

    @inlined
    def switch(b, t, p):
        """Next step of each lane in the chart; say how many go on or back."""
        changes = 0
        for j in range(BLOCK):
            x0, x1, x2, u0, u1 = b[X0 + j], b[X1 + j], b[X2 + j], b[X3 + j], b[X4 + j]
            step = b[STEP + j]
            after = law_switch(step, b[WAY + j], t, x0, x1, x2, u0, u1, p)
            after = after if step > 0.0 else step
            b[NEXT + j] = after
            changes += 1 if after != step else 0
        return changes

    @inlined
    def ask_to_begin(b, j, p):
        """First step of a lane at the start, and of one that turns if it is done."""
        x2, rate, ready = b[X2 + j], b[X4 + j], True
        if b[CHART + j] == 0.0:
            b[S2 + j] = wrap_angle(b[S2 + j])
            theta, v, omega = pose(b, j)
            inside = abs(theta) < 0.5 * math.pi
            x2 = math.tan(theta) if inside else math.copysign(math.inf, theta)
            _, rate = chained_inputs(v, omega, x2)
            ready = b[STEP + j] == BEFORE or turned(theta, v, omega, p)
        if ready:
            b[NEXT + j] = law_begin(b[X1 + j], x2, rate, p)

    @inlined
    def change_steps(b, t, p):
        """Begin, end turns, and carry out changes of step, with all that comes with them."""
        misled = 0
        for j in range(BLOCK):
            if b[ENDING + j] == 0.0:
                if b[STEP + j] <= 0.0:
                    ask_to_begin(b, j, p)
                if not exact and is_misled(b, j):
                    b[ENDING + j] = LEFT_CHART
                    misled += 1
                elif b[NEXT + j] != b[STEP + j]:
                    note_step(b, j, t)
                    change_coordinates(b, j)
                    if b[STEP + j] == 1.0:
                        b[WAY + j] = law_direction(b[X0 + j], b[X1 + j], b[X2 + j], b[X3 + j], p)
        return misled

    @inlined
    def command_in_step(b, step, count, firsts, p):
        for i in range(count):
            first = firsts[i] & (BLOCK - GROUP)  # so that the compiler sees that it is an index
            for j in range(first, first + GROUP):
                x0, x1, x2, u0, u1 = b[X0 + j], b[X1 + j], b[X2 + j], b[X3 + j], b[X4 + j]
                way = b[WAY + j]
                y0, y1, y2 = predicted(x0, x1, x2, u0, u1, p)
                one, two = law_channels(step, way, y0, y1, y2, u0, p)
                tau1, tau2 = inputs(one, two, u0, u1, p)
                tau2 = with_direct(tau2, law_direct(step, way, y1, y2, u1, p), p)
                here = b[STEP + j] == step
                b[NEW1 + j] = tau1 if here else b[NEW1 + j]
                b[NEW2 + j] = tau2 if here else b[NEW2 + j]

    @inlined
    def command_turning(b, count, firsts, p):
        for i in range(count):
            for j in range(firsts[i], firsts[i] + GROUP):
                if b[STEP + j] == 0.0:
                    theta, v, omega = pose(b, j)
                    one, two = turn_channels(theta + p.lookahead * omega, p)
                    b[NEW1 + j], b[NEW2 + j] = inputs(one, two, v, omega, p)

    @numba.njit(nogil=True, **OPTIONS)
    def kernel(
        numbers, clock, limits, sensing, b, ring, counts, groups, tones, kinds, adversary, keys, out
    ):
        p = parameters_in(numbers)
        limited = min(limits.tau1, limits.tau2, limits.speed, limits.turn_rate) < math.inf
        running = BLOCK
        turning = False
        for k in range(clock.samples + 1):
            t = k * clock.period
            if not exact:
                see(b, ring, k, sensing, keys)
            ended = watch(b, limits, turns)
            if not exact and not turns:
                ended += end_unseen(b)
            changes = switch(b, t, p)
            if changes > 0 or turning or k == 0:
                ended += change_steps(b, t, p)
            if ended > 0:
                running -= hand_in(b, t, False, out)
            if changes + ended > 0 or turning or k == 0:
                find_steps(b, counts, groups)
                turning = counts[0] > 0
            command_turning(b, counts[0], groups[0], p)
            command_in_step(b, 1.0, counts[1], groups[1], p)
            command_in_step(b, 2.0, counts[2], groups[2], p)
            command_in_step(b, 3.0, counts[3], groups[3], p)
            command_in_step(b, 4.0, counts[4], groups[4], p)
            measure(b, k == 0, t >= clock.residual_from, counts[4] > 0, turning)
            ended = end_beyond_limits(b, limits) if limited else 0
            last = k == clock.samples
            if ended > 0 or last:
                running -= hand_in(b, t, last, out)
                find_steps(b, counts, groups)
                turning = counts[0] > 0
            if running == 0:
                break
            advance(
                b, turning, tones, kinds, adversary, t, clock.period, clock.plant_steps, k == 0,
                euler, step_in_chart, step_outside,
            )  # fmt: skip

    return kernel
