"""Compiled kernels, each of which carries out the trials of one block of lanes.

`parkproof.simulation.lanes.block` says what a kernel does.
"""

from collections.abc import Callable
from functools import cache
from threading import Lock
from typing import Any

import numba
import numpy as np

from parkproof.laws.controller import RobotKind
from parkproof.simulation.compiler import KERNEL

from .block import trials_of_a_block
from .buffer import BLOCK, LISTED, LaneLimits
from .first import all_tones, first_buffer, kinds_of, with_times_below
from .kept import keep
from .memory import Buffer, Parameters, on_the_stack
from .trace import ROWS_TRACED

NO_TRACE = np.empty((ROWS_TRACED, 0))
"""Room for no samples."""

_ONE_AT_A_TIME = Lock()
"""Threads that ask for one kernel at once would else each compile one."""


def kernel_of(
    law_name: str,
    *,
    implicit: bool,
    exact: bool = True,
    robot: RobotKind = "chained",
    camera: bool = False,
    single: bool = False,
    euler: bool = False,
    traced: bool = False,
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
    single : bool
        Whether to compute in single precision, all but times.
    euler : bool
        Whether to integrate by Euler's method, as what lanes are compared with does; for robots of
        kind "chained" under the paper's camera.
    traced : bool
        Whether to keep every sample, too.

    Returns
    -------
    callable
        ``kernel(p, clock, limits, sensing, state, in_chart, scale_mean, scale_tones, mean, tones,
        adversary, keys, camera, out, trace)``: carries out the trials of one block of `BLOCK`
        lanes, from arrays whose last axis is the lane, and writes the rows `RESULTS` into ``out``
        and, if it is ``traced``, the samples of the first lane into ``trace``
        (`parkproof.simulation.lanes.trace`), which else is left out. It changes no other array. It
        releases the interpreter lock.

    Examples
    --------
    >>> callable(kernel_of("corrected", implicit=False))
    True
    """
    with _ONE_AT_A_TIME:
        return _kernel_of(
            law_name, implicit=implicit, exact=exact, robot=robot, camera=camera, single=single,
            euler=euler, traced=traced,
        )  # fmt: skip


@cache
def _kernel_of(law_name: str, *, exact: bool, single: bool, **kind: Any) -> Callable[..., Any]:
    kernel = _compiled(law_name, exact=exact, **kind)
    number: type[np.floating[Any]] = np.float32 if single else np.float64

    def block(
        p, clock, limits, sensing, state, in_chart, scale_mean, scale_tones, mean, tones,
        adversary, keys, cameras, out, trace=NO_TRACE,
    ):  # fmt: skip
        b, all_of = first_buffer(state, in_chart, mean, scale_mean), all_tones(tones, scale_tones)
        ring = np.empty((1 if exact else sensing.delay + 1, 6, BLOCK), number)
        groups = Buffer(np.zeros(LISTED), dtype=np.int64)
        deviations = tuple(number(deviation) for deviation in sensing.deviations)
        numbers = Parameters(with_times_below(p) if single else p, dtype=number)
        kernel(
            numbers, clock, LaneLimits(*map(number, limits)),
            sensing._replace(deviations=deviations), Buffer(b, dtype=number), ring, groups,
            Buffer(all_of, dtype=number), kinds_of(all_of), Buffer(adversary, dtype=number),
            keys.copy(), cameras.astype(number), out, trace,
        )  # fmt: skip

    return block


@cache
def _compiled(law_name: str, **kind: Any) -> Callable[..., Any]:
    carry_out = trials_of_a_block(law_name, held=on_the_stack, **kind)
    return keep(numba.njit(carry_out, **KERNEL), f"{law_name} {kind}")
