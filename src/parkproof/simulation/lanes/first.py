"""What a block of lanes begins with."""

import numpy as np
from numpy.typing import NDArray

from parkproof.laws.parameters import LawParameters

from .buffer import (
    BEFORE,
    BLOCK,
    CHART,
    END,
    END0,
    ENDED_AT,
    HIGH0,
    LOW0,
    MEAN,
    MIDDLE,
    PLACE,
    ROWS,
    S0,
    SIGNALS,
    SINES,
    SQUARES,
    START,
    STEP,
    TONE_ROWS,
    TURN_SQUARE,
    UNUSED,
    WAY,
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


def all_tones(tones: Floats, scale_tones: Floats) -> Floats:
    """Put the tones of γ1, γ2, φ1, φ2 and those of α1, α2, b2 into one array, with room for waves.

    Parameters
    ----------
    tones, scale_tones : array
        Signals × tones × (amplitude, omega, phase, square) × lanes.

    Returns
    -------
    array
        The same, for seven signals, and as many rows again, `TONE_ROWS` in all.

    Examples
    --------
    >>> all_tones(np.zeros((4, 8, 4, 2)), np.zeros((3, 0, 4, 2))).shape
    (7, 8, 8, 2)
    """
    most = max(tones.shape[1], scale_tones.shape[1])
    both = np.zeros((SIGNALS, most, TONE_ROWS, tones.shape[-1]))
    both[:4, : tones.shape[1], : tones.shape[2]] = tones
    both[4:, : scale_tones.shape[1], : scale_tones.shape[2]] = scale_tones
    return both


def first_buffer(state: Floats, in_chart: Floats, mean: Floats, scale_mean: Floats) -> Floats:
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

    def put(first: int, values: Floats | float, count: int = 1) -> None:
        rows[first // BLOCK : first // BLOCK + count] = values

    put(S0, state, 5)
    put(CHART, in_chart)
    put(STEP, BEFORE)
    put(WAY, 1.0)
    put(LOW0, state[0])
    put(HIGH0, state[0])
    put(END0, -1.0, 4)
    put(ENDED_AT, -1.0)
    put(TURN_SQUARE, 1.0)
    put(PLACE, np.arange(BLOCK))
    for first in (MEAN, START, MIDDLE, END):
        put(first, np.concatenate([mean, scale_mean]), SIGNALS)
    return rows.reshape(-1)


def with_times_below(p: LawParameters) -> LawParameters:
    """Round given times of switching down to singles: rounded up, they would come a sample late.

    Parameters
    ----------
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    LawParameters
        With other ``to_step2`` and ``to_step3``.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> p = with_times_below(default_parameters()._replace(to_step2=0.3))
    >>> 0.3 - 1e-7 < p.to_step2 <= 0.3
    True
    """

    def below(time: float) -> float:
        single = np.float32(time)
        return float(np.nextafter(single, np.float32(-1.0)) if float(single) > time else single)

    return p._replace(to_step2=below(p.to_step2), to_step3=below(p.to_step3))
