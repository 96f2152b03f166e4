"""Outcomes and metrics of trials from the rows that a kernel returns."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.scenario import Scenario
from parkproof.simulation.lanes.buffer import LEFT_CHART
from parkproof.simulation.metrics import STATE_NAMES
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import HOLD

Floats = NDArray[np.float64]

_ENDS = np.array(
    [
        None,  # a trial that ran to its end, whose last step and pose then decide
        Outcome.DIVERGED,
        Outcome.OUT_OF_VIEW,
        Outcome.LEFT_CHART,
        Outcome.INPUT_LIMIT,
        Outcome.SPEED_LIMIT,
        Outcome.PARKED,
        Outcome.MISSED,
        Outcome.STILL_MOVING,
    ],
    dtype=object,
)
_PARKED, _MISSED, _STILL_MOVING = 6, 7, 8

_TIMES = ("ended_at", "end0", "end1", "end2", "end3")


def results_of(rows: dict[str, Floats], scenario: Scenario) -> dict[str, Any]:
    """Work out outcomes and metrics.

    Parameters
    ----------
    rows : dict of str to array
        The rows `parkproof.simulation.lanes.buffer.RESULTS`, a number a trial.
    scenario : Scenario
        Any of the trials.

    Returns
    -------
    dict of str to array
        As from `parkproof.simulation.ensemble.simulate_ensemble`.

    Examples
    --------
    See `parkproof.simulation.ensemble.simulate_ensemble`.
    """
    period = scenario.run.control_period
    _, across, along = scenario.switching.tolerance
    factor = scenario.switching.hysteresis
    finished = rows["step"] == HOLD
    inside = (
        (rows["held0"] <= factor * along)
        & (rows["held1"] <= factor * across)
        & (rows["held2"] <= factor * across)
    )
    early = rows["ended"] > 0
    at_the_end = np.where(finished, np.where(inside, _PARKED, _MISSED), _STILL_MOVING)
    outcome = _ENDS[np.where(early, rows["ended"], at_the_end).astype(int)]
    # a time in single precision is that of the nearest sample
    times = {name: np.round(rows[name] / period) * period for name in _TIMES}
    elapsed = np.where(early, times["ended_at"], scenario.run.samples * period)
    # a trial that could not go on from a sample was not recorded there; one over a limit was
    unrecorded = early & (rows["ended"] <= LEFT_CHART)
    samples = np.maximum(np.round(elapsed / period) + np.where(unrecorded, 0, 1), 1)
    ends = {name: np.where(rows[name] < 0, np.nan, times[name]) for name in _TIMES[1:]}
    residual = np.maximum.reduce([rows["residual0"], rows["residual1"], rows["residual2"]])
    recorded = np.maximum(samples - 1, 1) * period
    variation = {i: rows[f"variation{i}"] / recorded for i in (1, 2)}
    return {
        "outcome": outcome,
        "total": np.where(outcome == Outcome.PARKED, ends["end3"], np.nan),
        **ends,
        "returns": rows["returns"].astype(int),
        "ended": elapsed,
        "residual": np.where(early, np.nan, residual),
        **{f"peak_tau{i}": rows[f"peak{i}"] for i in (1, 2)},
        **{f"rms_tau{i}": np.sqrt(rows[f"square{i}"] / samples) for i in (1, 2)},
        **{f"total_variation_tau{i}": variation[i] for i in (1, 2)},
        "excursion": np.sqrt(rows["excursion2"]),
        "path_length": rows["path"],
        **{f"max_{name}": rows[f"max{i}"] for i, name in enumerate(STATE_NAMES)},
        "max_speed": rows["speed"],
        "max_turn_rate": rows["turn_rate"],
        "max_heading": np.maximum(np.arctan(rows["max2"]), rows["heading"]),
        "least_x0": rows["low0"],
        "largest_x0": rows["high0"],
        **{name: rows[f"s{i}"] for i, name in enumerate(STATE_NAMES)},
    }
