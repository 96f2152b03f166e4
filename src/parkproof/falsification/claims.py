"""What a search tries to break: numbers that no run may exceed, and how near each comes."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.report.measured import Proven
from parkproof.scenario import Scenario
from parkproof.simulation.metrics import STATE_NAMES
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import Run

Floats = NDArray[np.float64]

TIME = "total_time"
"""The claim that a run parks, and when."""


def claims_of(scenario: Scenario) -> list[Proven]:
    """What a scenario asks of every run: to park within its duration, and to keep to its limits.

    Parameters
    ----------
    scenario : Scenario
        The scenario.

    Returns
    -------
    list of Proven
        Infinite where the scenario has no limit.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> claims = claims_of(Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0))))
    >>> [claim.name for claim in claims if claim.bound < math.inf]
    ['total_time']
    """
    limits, none = scenario.limits, math.inf
    tau = limits.tau if limits.tau is not None and not limits.saturate else (none, none)
    x_min, x_max, y_min, y_max = limits.view or (-none, none, -none, none)
    return [
        Proven(TIME, scenario.run.duration, "total"),
        Proven("max_tau 1", tau[0], "peak_tau1"),
        Proven("max_tau 2", tau[1], "peak_tau2"),
        Proven("max_speed", limits.speed or none, "max_speed"),
        Proven("max_turn_rate", limits.turn_rate or none, "max_turn_rate"),
        Proven("x0_range -", -x_min, "least_x0", sign=-1.0),
        Proven("x0_range +", x_max, "largest_x0"),
        Proven("max_abs_state x1", max(-y_min, y_max), "max_x1"),
        Proven("excursion", none, "excursion"),
    ]


def chosen(claims: Sequence[Proven], names: Sequence[str]) -> list[Proven]:
    """Claims by name.

    Parameters
    ----------
    claims : sequence of Proven
        All.
    names : sequence of str
        Which; "_" may stand for a blank. None: all that have a bound.

    Returns
    -------
    list of Proven
        In the order of the names.

    Raises
    ------
    InputError
        If a name is unknown.

    Examples
    --------
    >>> [claim.name for claim in chosen([Proven("max_tau 1", 2.0, "peak_tau1")], ["max_tau_1"])]
    ['max_tau 1']
    """
    if not names:
        return [claim for claim in claims if claim.bound < math.inf]
    known = {word(claim): claim for claim in claims}
    for name in names:
        if name.replace(" ", "_") not in known:
            raise InputError(f'no claim is called "{name}"; choose of: {", ".join(known)}')
    return [known[name.replace(" ", "_")] for name in dict.fromkeys(names)]


def word(claim: Proven) -> str:
    """Name of a claim as one word.

    Parameters
    ----------
    claim : Proven
        The claim.

    Returns
    -------
    str
        Its name with "_" for blanks.

    Examples
    --------
    >>> word(Proven("x0_range -", 2.0, "least_x0", sign=-1.0))
    'x0_range_-'
    """
    return claim.name.replace(" ", "_")


def sizes_of(claims: Sequence[Proven], rows: Mapping[str, Any]) -> Floats:
    """What each run comes to, one row a claim.

    Parameters
    ----------
    claims : sequence of Proven
        The claims.
    rows : mapping
        From `simulate_trials`.

    Returns
    -------
    array
        Infinite for the time of a run that did not park.

    Examples
    --------
    >>> rows = {"outcome": np.array([Outcome.PARKED, Outcome.MISSED]),
    ...         "total": np.array([3.0, np.nan])}
    >>> sizes_of([Proven("total_time", 5.0, "total")], rows).tolist()
    [[3.0, inf]]
    """
    parked = rows["outcome"] == Outcome.PARKED
    return np.array(
        [
            np.where(parked, rows["total"], math.inf)
            if claim.name == TIME
            else claim.sizes(np.asarray(rows[claim.column], dtype=np.float64))
            for claim in claims
        ]
    )


def scores_of(claims: Sequence[Proven], sizes: Floats, rows: Mapping[str, Any]) -> Floats:
    """How near each run comes to each bound: above 1 where it breaks it, always finite.

    Of runs that do not park, the one that ends farther from the goal has the larger score, so that
    a search has a slope to follow.

    Parameters
    ----------
    claims : sequence of Proven
        The claims.
    sizes : array
        From `sizes_of`.
    rows : mapping
        From `simulate_trials`.

    Returns
    -------
    array
        One row a claim.
    """
    scores = np.empty_like(sizes)
    for i, claim in enumerate(claims):
        scale = claim.bound if 0.0 < claim.bound < math.inf else 1.0
        scores[i] = sizes[i] / scale
        if claim.name == TIME:
            away = sum(np.abs(np.asarray(rows[name], dtype=np.float64)) for name in STATE_NAMES)
            missed = 2.0 - 1.0 / (1.0 + np.nan_to_num(away, nan=1e6, posinf=1e6))
            scores[i] = np.where(np.isfinite(sizes[i]), scores[i], missed)
    return np.nan_to_num(scores, nan=-1e9, posinf=1e9, neginf=-1e9)


def size_in(claim: Proven, run: Run) -> float:
    """What a plain run comes to.

    Parameters
    ----------
    claim : Proven
        The claim.
    run : Run
        From `parkproof.simulation.run.simulate`.

    Returns
    -------
    float
        As `sizes_of` has it of the lanes.
    """
    m = run.metrics
    total = run.settling_time.total
    row: dict[str, float] = {
        "total": math.inf if total is None else total,
        "peak_tau1": m.peak_tau[0],
        "peak_tau2": m.peak_tau[1],
        **{f"max_{name}": m.max_abs[name] for name in STATE_NAMES},
        "max_speed": m.max_speed,
        "max_turn_rate": m.max_turn_rate,
        "max_heading": math.radians(90.0 - m.least_distance_to_90_deg),
        "least_x0": m.x0_range[0],
        "largest_x0": m.x0_range[1],
        "excursion": m.excursion,
        "x1": m.final["x1"],
    }
    return float(claim.sizes(np.array([row[claim.column]]))[0])
