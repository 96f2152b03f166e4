"""The same scalar functions compiled for ensembles: 64 trials side by side, the loop inside.

The kernel repeats the reference run of `parkproof.simulation.run`. Law, switching, inputs and
measurements are the functions used there; only the order of the loops differs. A lane's result does
not depend on its place in a batch or on its company, as every operation rounds alike in whichever
loop (`parkproof.simulation.compiler`).

A law goes through eight lanes at a time, once for each step in which some of them are, with that
step known to the compiler: what only other steps need is then not there. Changes of step and
all that comes with them are rare, and done one lane at a time.

A controller is given the rows X0 … X4: for robots of kind "chained" whose measurements are exact
and prompt, those of the state itself, else those that `parkproof.simulation.lanes.sensor` or
`parkproof.simulation.lanes.robots` fills. What else differs between robots and cameras is chosen in
`parkproof.simulation.lanes.parts`.
"""

import math
from collections.abc import Callable
from typing import Any

from parkproof.laws.controller import RobotKind
from parkproof.laws.table import law_named
from parkproof.laws.turn import turned
from parkproof.model.chained import chained_inputs
from parkproof.model.unicycle import wrap_angle
from parkproof.simulation.compiler import inlined, register

from . import explicit as explicit_form
from . import implicit as implicit_form
from .buffer import (
    ASK,
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
    S2,
    SEEN0,
    STEP,
    TAU1,
    TAU2,
    WAY,
)
from .metrics import can_go_on, end_beyond_limits, hand_in, mark_ends, measure, note_step
from .order import arrange, count_of, find_steps, group_of
from .parts import parts_of
from .plant import push, state_at
from .sensor import end_unseen, is_misled, is_unseen
from .trace import no_trace, trace_lane
from .updates import put_if


def trials_of_a_block(
    law_name: str,
    *,
    implicit: bool,
    exact: bool,
    robot: RobotKind,
    camera: bool,
    euler: bool = False,
    traced: bool = False,
    held: Callable[..., Any],
) -> Callable[..., Any]:
    """Put together what carries out the trials of one block, to be compiled as a kernel.

    Parameters
    ----------
    law_name, implicit, exact, robot, camera, euler, traced
        See `parkproof.simulation.lanes.kernel.kernel_of`.
    held : callable
        Makes of a law's parameters what a kernel best keeps them as.

    Returns
    -------
    callable
        Not compiled yet; it is called with the memory that it needs.

    Examples
    --------
    >>> callable(trials_of_a_block("corrected", implicit=False, exact=True, robot="chained",
    ...                            camera=False, held=tuple))
    True
    """
    register()
    law = law_named(law_name)
    law_begin, law_direction, law_switch = law.begin, law.direction, law.switch
    law_channels, law_direct, turns = law.channels, law.direct, law.turns
    known = exact and robot == "chained"
    seen = S0 if known else SEEN0
    X0, X1, X2, X3, X4 = range(seen, seen + 5 * BLOCK, BLOCK)
    form = implicit_form if implicit else explicit_form
    find_inputs = form.find_inputs
    must_be_seen = not known and not turns
    can_be_misled = robot == "chained" and not exact
    steps_in_chart = robot == "chained"  # other robots can turn beyond ±90° in any step
    begin, look, pose, settle, pictured, gain, act, go, idle = parts_of(
        robot, camera=camera, exact=exact, euler=euler
    )
    keep_samples = trace_lane if traced else no_trace

    @inlined
    def switch_from(b, step, groups, t, cameras, limits, p):
        """Next step of lanes in one step, or that they cannot go on."""
        for i in range(count_of(groups, step)):
            first = group_of(groups, step, i)
            for j in range(first, first + GROUP):
                x0, x1, x2, u0, u1 = state_at(b, j, seen)
                after = law_switch(step, b[WAY + j], t, x0, x1, x2, u0, u1, p)
                here = b[STEP + j] == step
                charted = steps_in_chart or b[CHART + j] == 1.0
                going = can_go_on(b, cameras, j, charted, limits, turns, pictured)
                going = going and not (must_be_seen and is_unseen(b, j))
                put_if(b, NEXT + j, here, after if going else ASK)

    @inlined
    def turning_from(b, groups, cameras, limits, p):
        """Ask for lanes that may have turned far enough, or cannot go on."""
        for i in range(count_of(groups, 0.0)):
            first = group_of(groups, 0.0, i)
            for j in range(first, first + GROUP):
                theta, v, omega = pose(b, j)
                more = turned(theta, v, omega, p) or abs(b[S2 + j]) >= math.pi
                more = more or not can_go_on(b, cameras, j, False, limits, turns, pictured)
                put_if(b, NEXT + j, b[STEP + j] == 0.0, ASK if more else 0.0)

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
        b[NEXT + j] = law_begin(b[X1 + j], x2, rate, p) if ready else b[STEP + j]

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
                elif b[NEXT + j] >= 0.0 and b[NEXT + j] != b[STEP + j]:
                    note_step(b, j, t)
                    settle(b, j)
                    if b[STEP + j] == 1.0:
                        b[WAY + j] = law_direction(b[X0 + j], b[X1 + j], b[X2 + j], b[X3 + j], p)
        return misled

    def carry_out(
        p, clock, limits, sensing, b, ring, groups, tones, kinds, adversary, keys, cameras,
        out, trace,
    ):  # fmt: skip
        p = held(p)
        limited = min(limits.tau1, limits.tau2, limits.speed, limits.turn_rate) < math.inf
        opposed = False
        for j in range(BLOCK):
            opposed = opposed or max(adversary[j], adversary[BLOCK + j]) > 0.0
        running = BLOCK
        begin(b, cameras)
        for k in range(clock.samples + 1):
            t = k * clock.period
            look(b, cameras, ring, k, sensing, keys)
            switch_from(b, 1.0, groups, t, cameras, limits, p)
            switch_from(b, 2.0, groups, t, cameras, limits, p)
            switch_from(b, 3.0, groups, t, cameras, limits, p)
            switch_from(b, 4.0, groups, t, cameras, limits, p)
            if turns:
                turning_from(b, groups, cameras, limits, p)
            # changes are looked for here: to count them above would take sums across registers
            more = k == 0
            for j in range(BLOCK):
                more |= b[NEXT + j] != b[STEP + j]
            if more:
                ended = mark_ends(b, cameras, limits, turns, pictured)
                if must_be_seen:
                    ended += end_unseen(b)
                ended += change_steps(b, t, p)
                if ended > 0:
                    running -= hand_in(b, t, False, out, idle)
                if BLOCK > 1:  # one lane alone has nothing to sort, and need not compile it
                    arrange(b, ring, tones, kinds, adversary, keys, cameras)
                find_steps(b, groups)
            find_inputs(b, groups, seen, pose, turns, p, law_channels, law_direct)
            if k == 0:
                for j in range(BLOCK):
                    b[TAU1 + j], b[TAU2 + j] = b[NEW1 + j], b[NEW2 + j]
            outside = not steps_in_chart or count_of(groups, 0.0) > 0
            measure(b, t >= clock.residual_from, count_of(groups, 4.0) > 0, outside, gain)
            keep_samples(b, trace, k, gain)
            ended = end_beyond_limits(b, limits, gain) if limited else 0
            last = k == clock.samples
            if ended > 0 or last:
                running -= hand_in(b, t, last, out, idle)
                find_steps(b, groups)  # they stay where they are until the next change
            if running == 0:
                break
            if opposed:
                push(b, adversary)
            act(b, clock.period)
            step = (k + 1) * clock.period - t
            go(b, cameras, count_of(groups, 0.0) > 0, tones, kinds, t, step, clock.plant_steps, k)

    return carry_out
