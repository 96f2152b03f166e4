"""Metrics of a run, computed from its samples."""

import math
from collections.abc import Mapping

import msgspec
import numpy as np
from numpy.typing import NDArray

RESIDUAL_WINDOW = 2.0
"""Seconds at the end of a run over which the residual is taken."""

STATE_NAMES = ("x0", "x1", "x2", "u0", "u1")

Columns = Mapping[str, NDArray[np.float64]]


class Metrics(msgspec.Struct, frozen=True, kw_only=True):
    """What a run is judged by.

    Attributes
    ----------
    residual : float
        Largest of |x0|, |x1|, |x2| over the last 2 s; |θ| in the place of |x2| in Step 0.
    residual_by_state : dict
        The same for each state by name, u0 and u1 included.
    peak_tau, rms_tau : list of 2 floats
        Largest and root-mean-square input of each channel.
    total_variation_tau : list of 2 floats
        Total variation of each input, per second: the chatter.
    excursion : float
        Largest distance from the goal in the image plane.
    path_length : float
        Length of the path in the image plane.
    least_distance_to_90_deg : float
        How close the heading came to ±90°, in degrees; negative beyond.
    max_speed, max_turn_rate : float
        Largest |v| and |ω|.
    x0_range : list of 2 floats
        Least and largest x0.
    max_abs, max_abs_after_step2 : dict
        Largest |state| by name, over the run and since Step 2 ended (null if it did not); x2, u0
        and u1 are taken outside Step 0 only.
    final : dict
        State at the end, by name.
    """

    residual: float
    residual_by_state: dict[str, float]
    peak_tau: list[float]
    rms_tau: list[float]
    total_variation_tau: list[float]
    excursion: float
    path_length: float
    least_distance_to_90_deg: float
    max_speed: float
    max_turn_rate: float
    x0_range: list[float]
    max_abs: dict[str, float]
    max_abs_after_step2: dict[str, float] | None
    final: dict[str, float]


def _where_defined(columns: Columns) -> dict[str, NDArray[np.float64]]:
    """x2, u0 and u1 outside Step 0: there they grow without bound as the heading passes ±90°."""
    charted = columns["step"] > 0
    return {name: np.where(charted, columns[name], np.nan) for name in ("x2", "u0", "u1")}


def _largest(values: NDArray[np.float64]) -> float:
    """Largest magnitude, passing over NaN: u0, u1, x2 do not exist outside the chart."""
    return float(np.fmax.reduce(np.abs(values), initial=0.0))


def metrics_of(columns: Columns, *, end_of_step2: float | None) -> Metrics:
    """Compute the metrics of a run from its samples.

    Parameters
    ----------
    columns : mapping of str to array
        One array a column of the trajectory, all of the same length n ≥ 1, a sample each control
        period.
    end_of_step2 : float or None
        When Step 2 first ended, in s.

    Returns
    -------
    Metrics
        See there.

    Examples
    --------
    >>> t = np.linspace(0.0, 4.0, 5)
    >>> zero = np.zeros(5)
    >>> names = ("x0", "x1", "x2", "u0", "u1", "v", "omega", "tau1", "tau2", "theta")
    >>> columns = dict.fromkeys(names, zero) | {"t": t, "xm": 4.0 - t, "ym": zero, "step": zero}
    >>> metrics_of(columns, end_of_step2=None).path_length
    4.0
    """
    t = columns["t"]
    columns = {**columns, **_where_defined(columns)}
    recent = t >= t[-1] - RESIDUAL_WINDOW
    residual = {name: _largest(columns[name][recent]) for name in STATE_NAMES}
    turning = recent & (columns["step"] == 0)
    residual["x2"] = max(residual["x2"], _largest(columns["theta"][turning]))
    tau = [columns["tau1"], columns["tau2"]]
    elapsed = float(t[-1] - t[0])
    xm, ym = columns["xm"], columns["ym"]
    after = None
    if end_of_step2 is not None:
        later = t >= end_of_step2
        after = {name: _largest(columns[name][later]) for name in STATE_NAMES}
    return Metrics(
        residual=max(residual[name] for name in ("x0", "x1", "x2")),
        residual_by_state=residual,
        peak_tau=[_largest(x) for x in tau],
        rms_tau=[float(np.sqrt(np.mean(np.square(x)))) for x in tau],
        total_variation_tau=[
            float(np.sum(np.abs(np.diff(x)))) / elapsed if elapsed > 0.0 else 0.0 for x in tau
        ],
        excursion=float(np.max(np.hypot(xm, ym))),
        path_length=float(np.sum(np.hypot(np.diff(xm), np.diff(ym)))),
        least_distance_to_90_deg=90.0 - math.degrees(_largest(columns["theta"])),
        max_speed=_largest(columns["v"]),
        max_turn_rate=_largest(columns["omega"]),
        x0_range=[float(np.min(columns["x0"])), float(np.max(columns["x0"]))],
        max_abs={name: _largest(columns[name]) for name in STATE_NAMES},
        max_abs_after_step2=after,
        final={name: float(columns[name][-1]) for name in STATE_NAMES},
    )
