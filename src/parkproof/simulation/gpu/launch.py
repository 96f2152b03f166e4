"""Trials on a graphics processor: is there one, and what it gives."""

from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.simulation.lanes.buffer import RESULTS, KernelKind, Shared
from parkproof.simulation.trials import Trials

THREADS = 64
"""Threads a block: each has a buffer of its own in memory, and needs many registers."""

AT_ONCE = 1 << 17
"""Trials a launch: enough to fill a processor, few enough for its memory."""

Floats = NDArray[np.float64]


def check_gpu() -> None:
    """Check that there is a graphics processor, and what compiles for it.

    Raises
    ------
    InputError
        If something is missing, with what.

    Examples
    --------
    >>> check_gpu()
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: device = "cuda"...
    """
    from numba.core import config

    if not config.ENABLE_CUDASIM:
        require("numba_cuda", extra="gpu", purpose='device = "cuda"')
    from numba import cuda

    if not cuda.is_available():
        raise InputError(
            'device = "cuda": there is no NVIDIA graphics processor, or no driver for it; leave '
            "device out, and this computer's processor does the work"
        )


def carry_out_on_gpu(shared: Shared, trials: Trials, **kind: Unpack[KernelKind]) -> Floats:
    """Carry out trials that share an integration step.

    Parameters
    ----------
    shared : tuple
        A law's parameters, times, limits, and what measurements are like.
    trials : Trials
        In what the trials differ.
    **kind
        What the kernel is compiled for.

    Returns
    -------
    array
        The rows `RESULTS` × trials.

    Raises
    ------
    InputError
        If there is no graphics processor.

    Examples
    --------
    See `parkproof.simulation.ensemble.simulate_trials`, with ``device="cuda"``.
    """
    check_gpu()
    from parkproof.simulation.gpu.kernel import device_kernel

    kernel = device_kernel(**kind)
    parts = [
        _launch(kernel, shared, trials.some(slice(begin, begin + AT_ONCE)))
        for begin in range(0, len(trials), AT_ONCE)
    ]
    return np.hstack(parts)


def _launch(kernel: Any, shared: Shared, trials: Trials) -> Floats:
    """One launch."""
    from numba import cuda

    from parkproof.simulation.lanes.first import all_tones, kinds_of

    n, (_, _, _, sensing) = len(trials), shared
    tones = all_tones(trials.tones, trials.scale_tones)
    arrays = (
        trials.state, trials.in_chart, np.concatenate([trials.mean, trials.scale_mean]),
        tones.reshape(-1, n), kinds_of(tones), trials.adversary, trials.keys, trials.camera,
    )  # fmt: skip
    given = [cuda.to_device(np.ascontiguousarray(array)) for array in arrays]
    ring = cuda.device_array((1 if sensing.exact else sensing.delay + 1, 6, n), np.float64)
    out = cuda.device_array((len(RESULTS), n), np.float64)
    kernel[-(-n // THREADS), THREADS](*shared, *given, ring, out)
    rows: Floats = out.copy_to_host()
    return rows
