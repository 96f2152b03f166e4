"""What trials in single precision cannot have: too many samples, and numbers beyond singles."""

from collections.abc import Iterator
from typing import Any, get_args

import numpy as np

from parkproof.errors import InputError
from parkproof.simulation.lanes.buffer import Shared
from parkproof.simulation.trials import Precision, Trials

MOST_SAMPLES = 2**22
"""Beyond them a time in single precision is no longer nearest to its own sample."""

LARGEST = float(np.finfo(np.float32).max)


def check_precision(precision: Precision, device: str) -> None:
    """Check that a precision exists, on a device.

    Parameters
    ----------
    precision : str
        Any.
    device : "cpu" or "cuda"
        What computes.

    Raises
    ------
    InputError
        If it does not.

    Examples
    --------
    >>> check_precision("half", "cpu")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: precision = "half": must be "double" or "single"; write one
    """
    if precision not in get_args(Precision):
        raise InputError(f'precision = "{precision}": must be "double" or "single"; write one')
    if precision == "single" and device != "cpu":
        raise InputError(
            'precision = "single" with device = "cuda": a graphics processor computes in double '
            "precision only; leave one of them out"
        )


def check_singles(shared: Shared, trials: Trials) -> None:
    """Check that trials can be carried out in single precision.

    Parameters
    ----------
    shared : tuple
        What all of them share.
    trials : Trials
        In what they differ.

    Raises
    ------
    InputError
        If a number is beyond single precision, or there are too many samples.

    Examples
    --------
    See `parkproof.simulation.ensemble.simulate_trials`, with ``precision="single"``.
    """
    _, clock, _, _ = shared
    if clock.samples > MOST_SAMPLES:
        raise InputError(
            f'{clock.samples:,} samples in precision = "single": its times tell at most '
            f'{MOST_SAMPLES:,} apart; write a shorter duration, or precision = "double"'
        )
    for name, numbers in _numbers(shared, trials):
        sizes = np.abs(np.asarray(numbers, dtype=float))
        beyond = sizes[np.isfinite(sizes) & (sizes > LARGEST)]
        if beyond.size:
            raise InputError(
                f'{name} has the number {beyond[0]:.3g}, and precision = "single" has none beyond '
                f'{LARGEST:.3g}; write precision = "double"'
            )


def _numbers(shared: Shared, trials: Trials) -> Iterator[tuple[str, Any]]:
    """All numbers that become singles, and what they are."""
    p, _, limits, sensing = shared
    yield "what follows from bounds and gains", tuple(p)
    yield "limits", tuple(limits)
    yield "run.noise", sensing.deviations
    yield "start", trials.state
    yield "truth", np.concatenate([part.ravel() for part in (
        trials.mean, trials.scale_mean, trials.tones, trials.scale_tones, trials.adversary
    )])  # fmt: skip
    yield "camera", trials.camera
