"""The kernel of a graphics processor: a thread takes its trial and carries it out as one lane.

Imported only when asked for: it needs numba's compiler for CUDA, or numba's simulator of it.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

from numba import cuda, float64, int64

from parkproof.laws.controller import RobotKind
from parkproof.simulation.compiler import inlined
from parkproof.simulation.gpu.one_lane import one_lane


@inlined
def as_they_are(p: Any) -> Any:
    """A law's parameters, which each thread has in a tuple."""
    return p


@cache
def device_kernel(
    law_name: str, *, implicit: bool, exact: bool, robot: RobotKind, camera: bool
) -> Callable[..., Any]:
    """Give the kernel of a law in one form, compiled when first launched, once a process.

    Parameters
    ----------
    law_name, implicit, exact, robot, camera
        See `parkproof.simulation.lanes.kernel.kernel_of`.

    Returns
    -------
    callable
        ``kernel[blocks, threads](p, clock, limits, sensing, state, in_chart, means, tones, kinds,
        adversary, keys, cameras, ring, out)``: arrays whose last axis is the trial; ``means`` and
        ``tones`` are those of all seven signals, the tones' numbers one after the other, and
        ``ring`` has room for the measurements under way.

    Examples
    --------
    See `parkproof.simulation.gpu.launch.carry_out_on_gpu`.
    """
    block, buffer = one_lane("block"), one_lane("buffer")
    carry_out = inlined(
        block.trials_of_a_block(
            law_name, implicit=implicit, exact=exact, robot=robot, camera=camera, held=as_they_are
        )
    )
    rows, listed, signals = len(buffer.ROWS), buffer.LISTED, buffer.SIGNALS
    s0, chart, step, way, before = buffer.S0, buffer.CHART, buffer.STEP, buffer.WAY, buffer.BEFORE
    low0, high0, end0, ended_at = buffer.LOW0, buffer.HIGH0, buffer.END0, buffer.ENDED_AT
    turn_square, mean = buffer.TURN_SQUARE, buffer.MEAN

    @cuda.jit
    def kernel(
        p, clock, limits, sensing, state, in_chart, means, tones, kinds, adversary, keys, cameras,
        ring, out,
    ):  # fmt: skip
        i = cuda.grid(1)
        if i < out.shape[1]:
            b = cuda.local.array(rows, float64)
            groups = cuda.local.array(listed, int64)
            for row in range(rows):
                b[row] = 0.0
            for row in range(listed):
                groups[row] = 0
            for row in range(5):
                b[s0 + row] = state[row, i]
            b[chart], b[step], b[way] = in_chart[i], before, 1.0
            b[low0], b[high0] = state[0, i], state[0, i]
            for row in range(4):
                b[end0 + row] = -1.0
            b[ended_at], b[turn_square] = -1.0, 1.0
            for row in range(4 * signals):
                b[mean + row] = means[row % signals, i]
            trace = cuda.local.array((1, 1), float64)  # nothing is kept in it
            here = slice(i, i + 1)
            carry_out(
                p, clock, limits, sensing, b, ring[:, :, here], groups, tones[:, i], kinds,
                adversary[:, i], keys[:, here], cameras[:, here], out[:, here], trace,
            )  # fmt: skip

    return kernel
