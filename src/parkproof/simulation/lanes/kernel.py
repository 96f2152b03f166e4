"""The same scalar functions compiled for ensembles: 64 trials side by side, the loop inside.

The kernel repeats the reference run of `parkproof.simulation.run`. Law, switching, inputs and
measurements are the functions used there; only the order of the loops differs. A lane's result does not depend on its place in a batch or on its
company, as every operation rounds alike in whichever loop (`parkproof.simulation.compiler`).

A law goes through eight lanes at a time, once for each step in which some of them are, with that
step known to the compiler: powers that a step does not need are then not there. Changes of step and
all that comes with them are rare, and done one lane at a time.

A controller is given the rows X0 … X4: for robots of kind "chained" whose measurements are exact and
prompt, those of the state itself, else those that `parkproof.simulation.lanes.sensor` or
`parkproof.simulation.lanes.robots` fills. What else differs between robots and cameras is chosen in
`parkproof.simulation.lanes.parts`.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numba
import numpy as np
from numba.extending import register_jitable

from parkproof.laws.controller import RobotKind
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
    WAY,
)
from parkproof.simulation.lanes.first import all_tones, first_buffer, kinds_of
from parkproof.simulation.lanes.metrics import (
    count,
    end_beyond_limits,
    hand_in,
    measure,
    note_step,
    watch,
)
from parkproof.simulation.lanes.parameters import array_of, parameters_in
from parkproof.simulation.lanes.parts import parts_of
from parkproof.simulation.lanes.sensor import end_unseen, is_misled

inlined = register_jitable(forceinline=True, **OPTIONS)


@inlined
def find_steps(b, present):
    """Note in bits which steps are in force in each group of lanes, and count lanes in Step 0."""
    for g in range(BLOCK // GROUP):
        here = 0
        for j in range(g * GROUP, g * GROUP + GROUP):
            here |= 1 << int(b[STEP + j])
        present[g] = here
    return count(b, STEP, 0.0)


@cache
def kernel_of(
    law_name: str,
    *,
    implicit: bool,
    exact: bool = True,
    robot: RobotKind = "chained",
    camera: bool = False,
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
    robot : "chained", "torque" or "velocity"
        What the robots are commanded by.
    camera : bool
        Whether each trial has a camera of its own, or all have the paper's.

    Returns
    -------
    callable
        ``kernel(p, clock, limits, sensing, state, in_chart, scale_mean, scale_tones, mean, tones,
        adversary, keys, camera, out)``: carries out the trials of one block of `BLOCK` lanes, reading
        arrays whose last axis is the lane and writing the rows `RESULTS` into ``out``. It releases
        the interpreter lock.

    Examples
    --------
    >>> callable(kernel_of("corrected", implicit=False))
    True
    """
    kernel = _compiled(law_name, implicit, exact, robot, camera)

    def block(
        p, clock, limits, sensing, state, in_chart, scale_mean, scale_tones, mean, tones,
        adversary, keys, cameras, out,
    ):  # fmt: skip
        b, all_of = first_buffer(state, in_chart, mean, scale_mean), all_tones(tones, scale_tones)
        ring = np.empty((1 if exact else sensing.delay + 1, 6, BLOCK))
        present = np.zeros(BLOCK // GROUP, np.int64)
        kernel(
            array_of(p), clock, limits, sensing, b, ring, present, all_of,
            kinds_of(all_of), adversary, keys, cameras, out,
        )  # fmt: skip

    return block


@cache
def _compiled(
    law_name: str, implicit: bool, exact: bool, robot: RobotKind, camera: bool
) -> Callable[..., Any]:
    register()
    law = law_named(law_name)
    law_begin, law_direction, law_switch = law.begin, law.direction, law.switch
    law_channels, law_direct, turns = law.channels, law.direct, law.turns
    inputs = implicit_inputs if implicit else explicit_inputs
    known = exact and robot == "chained"
    X0, X1, X2, X3, X4 = (S0, S1, S2, S3, S4) if known else (SEEN0, SEEN1, SEEN2, SEEN3, SEEN4)
    can_be_misled = robot == "chained" and not exact
    begin, look, pose, settle, pictured, gain, act, go, idle = parts_of(
        robot, camera=camera, exact=exact
    )

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
                if can_be_misled and is_misled(b, j):
                    b[ENDING + j] = LEFT_CHART
                    misled += 1
                elif b[NEXT + j] != b[STEP + j]:
                    note_step(b, j, t)
                    settle(b, j)
                    if b[STEP + j] == 1.0:
                        b[WAY + j] = law_direction(b[X0 + j], b[X1 + j], b[X2 + j], b[X3 + j], p)
        return misled

    @inlined
    def command_in_step(b, first, step, p):
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
    def command_turning(b, first, p):
        for j in range(first, first + GROUP):
            if b[STEP + j] == 0.0:
                theta, v, omega = pose(b, j)
                one, two = turn_channels(theta + p.lookahead * omega, p)
                b[NEW1 + j], b[NEW2 + j] = inputs(one, two, v, omega, p)

    @numba.njit(nogil=True, **OPTIONS)
    def kernel(
        numbers, clock, limits, sensing, b, ring, present, tones, kinds, adversary, keys, cameras,
        out,
    ):  # fmt: skip
        p = parameters_in(numbers)
        limited = min(limits.tau1, limits.tau2, limits.speed, limits.turn_rate) < math.inf
        running = BLOCK
        turning = 0
        begin(b, cameras)
        for k in range(clock.samples + 1):
            t = k * clock.period
            look(b, cameras, ring, k, sensing, keys)
            ended = watch(b, cameras, limits, turns, pictured)
            if not known and not turns:
                ended += end_unseen(b)
            changes = switch(b, t, p)
            if changes + turning > 0 or k == 0:
                ended += change_steps(b, t, p)
            if ended > 0:
                running -= hand_in(b, t, False, out, idle)
            if changes + turning + ended > 0 or k == 0:
                turning = find_steps(b, present)
            holding = False
            for g in range(BLOCK // GROUP):
                here, first = present[g], g * GROUP
                holding = holding or here & 16 != 0
                if here & 2:
                    command_in_step(b, first, 1.0, p)
                if here & 4:
                    command_in_step(b, first, 2.0, p)
                if here & 8:
                    command_in_step(b, first, 3.0, p)
                if here & 16:
                    command_in_step(b, first, 4.0, p)
                if here & 1:
                    command_turning(b, first, p)
            measure(b, k == 0, t >= clock.residual_from, holding, turning > 0, gain)
            ended = end_beyond_limits(b, limits, gain) if limited else 0
            last = k == clock.samples
            if ended > 0 or last:
                running -= hand_in(b, t, last, out, idle)
                turning = find_steps(b, present)
            if running == 0:
                break
            act(b, clock.period)
            go(
                b, cameras, turning, tones, kinds, adversary, t, clock.period, clock.plant_steps,
                k == 0,
            )  # fmt: skip

    return kernel
