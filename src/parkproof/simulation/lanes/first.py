"""What a block of lanes begins with."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.simulation.lanes.buffer import (
    ALPHA1,
    ALPHA1_END,
    ALPHA1_MEAN,
    ALPHA1_MID,
    BLOCK,
    CHART,
    END0,
    ENDED_AT,
    GAMMA1,
    GAMMA1_END,
    GAMMA1_MEAN,
    GAMMA1_MID,
    HIGH0,
    LOW0,
    ROWS,
    S0,
    SINES,
    SQUARES,
    TURN_SQUARE,
    UNUSED,
)

Floats = NDArray[np.float64]


def kinds_of(tones: Floats) -> NDArray[np.int64]:
    """Say of each tone of each signal what the lanes have of it.

    Parameters
    ----------
    tones : array
        Signals × tones × (amplitude, omega, phase, square) × lanes.

    Returns
    -------
    array
        `UNUSED`, `SINES` or `SQUARES`, signals × tones.

    Examples
    --------
    >>> tones = np.zeros((1, 2, 4, BLOCK))
    >>> tones[0, 0, 0, 5] = 2.5
    >>> kinds_of(tones).tolist()
    [[1, 0]]
    """
    used = tones[:, :, 0] != 0.0
    squares = used & (tones[:, :, 3] > 0.0)
    kinds: NDArray[np.int64] = np.where(
        squares.any(axis=-1), SQUARES, np.where(used.any(axis=-1), SINES, UNUSED)
    )
    if kinds.size:  # the first tone is added to the mean, the others to what is then there
        kinds[:, 0] = np.maximum(kinds[:, 0], kinds.any(axis=1) * SINES)
    return kinds


def first_buffer(state: Floats, in_chart: Floats, mean: Floats, scale_mean: Floats) -> Any:
    """Make the buffer of a block of lanes.

    Parameters
    ----------
    state, in_chart : array
        Five states × lanes; 1 where they are x0, x1, x2, u0, u1, and 0 where x, y, θ, v, ω.
    mean, scale_mean : array
        Means of γ1, γ2, φ1, φ2 and of α1, α2, b2.

    Returns
    -------
    array
        The buffer, flat.

    Examples
    --------
    >>> first_buffer(*(np.ones((n, BLOCK)) for n in (5, 1, 4, 3))).size == BLOCK * len(ROWS)
    True
    """
    rows = np.zeros((len(ROWS), BLOCK))

    def put(first: int, values: Any, count: int = 1) -> None:
        rows[first // BLOCK : first // BLOCK + count] = values

    put(S0, state, 5)
    put(CHART, in_chart)
    put(LOW0, state[0])
    put(HIGH0, state[0])
    put(END0, -1.0, 4)
    put(ENDED_AT, -1.0)
    put(TURN_SQUARE, 1.0)
    for first in (GAMMA1_MEAN, GAMMA1, GAMMA1_MID, GAMMA1_END):
        put(first, mean, 4)
    for first in (ALPHA1_MEAN, ALPHA1, ALPHA1_MID, ALPHA1_END):
        put(first, scale_mean, 3)
    return rows.reshape(-1)
