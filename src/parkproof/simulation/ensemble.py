"""Many runs of one scenario: starts and truths differ, everything else is shared."""

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.laws.parameters import LawParameters, law_parameters
from parkproof.model.truth import Resolved, channel, scales
from parkproof.scenario import Scenario
from parkproof.simulation.lanes.buffer import (
    BLOCK,
    LEFT_CHART,
    RESULTS,
    Clock,
    LaneLimits,
    Sensing,
)
from parkproof.simulation.metrics import RESIDUAL_WINDOW, STATE_NAMES
from parkproof.simulation.noise import keys_of
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import HOLD, plant_steps

Floats = NDArray[np.float64]


def _shared(scenario: Scenario) -> tuple[Any, ...]:
    """What all trials of an ensemble must have in common."""
    run = msgspec.structs.replace(scenario.run, seed=0) if scenario.run.seed else scenario.run
    return (
        scenario.law, scenario.bounds, scenario.gains, scenario.switching, run,
        scenario.robot, scenario.limits,
    )  # fmt: skip


def _signals(trials: Sequence[Sequence[Resolved]], lanes: int, least: int) -> tuple[Floats, Floats]:
    """Means and tones of each trial's signals, with room for at least so many tones."""
    most = max(least, *(len(tones) for signals in trials for _, tones in signals))
    means, waves = np.empty((len(trials[0]), lanes)), np.zeros((len(trials[0]), most, 4, lanes))
    for j in range(lanes):
        for i, (mean, tones) in enumerate(trials[min(j, len(trials) - 1)]):
            means[i, j] = mean
            for m, tone in enumerate(tones):
                waves[i, m, :, j] = tone
    return means, waves


def _lanes(scenarios: Sequence[Scenario]) -> tuple[NDArray[Any], ...]:
    """Arrays of starts, truths and keys of noise, padded to whole blocks with the last trial."""
    channels = [[channel(i, s.truth, s.bounds) for i in range(2)] for s in scenarios]
    n = -(-len(scenarios) // BLOCK) * BLOCK
    state, in_chart, adversary = np.empty((5, n)), np.empty(n), np.empty((2, n))
    keys = np.empty((2, n), dtype=np.int64)
    for j in range(n):
        k = min(j, len(scenarios) - 1)
        scenario, (one, two) = scenarios[k], channels[k]
        chained = scenario.start.chained
        state[:, j] = chained or (*scenario.start_pose, *scenario.start_velocity)
        in_chart[j] = 1.0 if chained else 0.0
        keys[:, j] = keys_of(scenario.run.seed)
        adversary[:, j] = one.phi_adversary, two.phi_adversary
    inputs = [
        (*((c.gamma_mean, c.gamma_tones) for c in two), *((c.phi_mean, c.phi_tones) for c in two))
        for two in channels
    ]
    # where no α and no b2 varies there are no tones, and the kernel is done with them at once
    gains = _signals([scales(s.truth, s.bounds) for s in scenarios], n, 0)
    return state, in_chart, *gains, *_signals(inputs, n, 1), adversary, keys


def simulate_ensemble(scenarios: Sequence[Scenario], *, threads: int = 1) -> dict[str, Any]:
    """Carry out many runs in compiled lanes.

    Parameters
    ----------
    scenarios : sequence of Scenario
        Trials of robots of kind "chained". They may differ in start, truth and
        ``run.seed`` only.
    threads : int
        Number of threads; a trial's result does not depend on it.

    Returns
    -------
    dict of str to array
        A value a trial: ``outcome`` (`Outcome`), ``total`` and ``end0`` … ``end3`` (settling times
        in s, NaN where there is none), ``returns``, ``residual`` (NaN where the run ended early),
        ``peak_tau1``, ``peak_tau2``, ``rms_tau1``, ``rms_tau2``, ``total_variation_tau1``,
        ``total_variation_tau2``, ``excursion``, ``path_length``, ``ended``, the largest magnitudes
        ``max_x0`` … ``max_u1`` (x2, u0 and u1 outside Step 0 only), ``max_speed``,
        ``max_turn_rate`` and ``max_heading`` (|θ|), the range ``least_x0``, ``largest_x0``, and
        the final state ``x0`` … ``u1`` (or x, y, θ, v, ω where a trial ended turning).

    Raises
    ------
    InputError
        If there are no trials, or they differ in more than that.

    Examples
    --------
    >>> from parkproof.scenario import RunSettings, Start
    >>> trials = [Scenario(law="corrected", start=Start(pose=(x, 0.1, 0.0)),
    ...                    run=RunSettings(duration=12.0, control_period=0.01))
    ...           for x in (-2.0, -1.0, 1.0)]
    >>> [outcome.value for outcome in simulate_ensemble(trials)["outcome"]]
    ['parked', 'parked', 'parked']
    """
    if not scenarios:
        raise InputError("no trials: an ensemble needs at least one scenario; give some")
    first = scenarios[0]
    if any(_shared(s) != _shared(first) for s in scenarios[1:]):
        raise InputError(
            "the trials of an ensemble differ in more than start and truth (and run.seed): "
            "run an ensemble for each law, gains, bounds and run settings"
        )
    if any(s.camera is not None for s in scenarios):
        raise InputError(
            "lanes carry out scenarios under the paper's camera only: leave out [camera], or use "
            "simulate()"
        )
    if first.robot.kind != "chained":
        raise InputError(
            f'robot.kind = "{first.robot.kind}": lanes carry out robots of kind "chained" only; '
            "use simulate() for this one"
        )
    from parkproof.simulation.lanes.kernel import kernel_of

    run, limits = first.run, first.limits
    sensing = Sensing(run.delay_samples, run.deviations)
    kernel = kernel_of(
        first.law,
        implicit=run.discretisation == "implicit",
        exact=sensing.delay == 0 and not any(sensing.deviations),
    )
    p = law_parameters(
        bounds=first.bounds,
        gains=first.gains,
        switching=first.switching,
        control_period=run.control_period,
        discretisation=run.discretisation,
        saturation=limits.saturation,
    )
    end = run.samples * run.control_period
    clock = Clock(run.control_period, run.samples, 1, end - RESIDUAL_WINDOW)
    none = math.inf
    lane_limits = LaneLimits(
        *(limits.tau or (none, none)),
        limits.speed or none,
        limits.turn_rate or none,
        *(limits.view or (-none, none, -none, none)),
    )
    out = np.empty((len(RESULTS), len(scenarios)))
    # signals that jump ask for smaller steps: lanes of one block share theirs
    steps = np.array([plant_steps(scenario) for scenario in scenarios])
    with ThreadPoolExecutor(threads) as pool:
        for size in np.unique(steps).tolist():
            alike = np.flatnonzero(steps == size)
            some = [scenarios[i] for i in alike.tolist()]
            shared = (p, clock._replace(plant_steps=size), lane_limits, sensing)
            out[:, alike] = _carry_out(kernel, shared, some, pool)
    return _results(dict(zip(RESULTS, out, strict=True)), first, clock)


def _carry_out(
    kernel: Callable[..., None],
    shared: tuple[LawParameters, Clock, LaneLimits, Sensing],
    scenarios: Sequence[Scenario],
    pool: ThreadPoolExecutor,
) -> Floats:
    """The kernel's rows of trials that share an integration step, block by block."""
    arrays = _lanes(scenarios)

    def block(begin: int) -> Floats:
        lanes = slice(begin, begin + BLOCK)
        parts = [np.ascontiguousarray(a[..., lanes]) for a in arrays]
        rows = np.empty((len(RESULTS), BLOCK))
        kernel(*shared, *parts, rows)
        return rows

    blocks = list(pool.map(block, range(0, arrays[0].shape[1], BLOCK)))
    return np.hstack(blocks)[:, : len(scenarios)]


_ENDS = (
    None,
    Outcome.DIVERGED,
    Outcome.OUT_OF_VIEW,
    Outcome.LEFT_CHART,
    Outcome.INPUT_LIMIT,
    Outcome.SPEED_LIMIT,
)


def _results(rows: dict[str, Floats], scenario: Scenario, clock: Clock) -> dict[str, Any]:
    """Outcomes and metrics from the kernel's rows."""
    _, across, along = scenario.switching.tolerance
    factor = scenario.switching.hysteresis
    finished = rows["step"] == HOLD
    inside = (
        (rows["held0"] <= factor * along)
        & (rows["held1"] <= factor * across)
        & (rows["held2"] <= factor * across)
    )
    outcome = np.array(
        [
            _ENDS[int(code)]
            or ((Outcome.PARKED if kept else Outcome.MISSED) if done else Outcome.STILL_MOVING)
            for code, done, kept in zip(rows["ended"], finished, inside, strict=True)
        ],
        dtype=object,
    )
    early = rows["ended"] > 0
    elapsed = np.where(early, rows["ended_at"], clock.samples * clock.period)
    # a trial that could not go on from a sample was not recorded there; one over a limit was
    unrecorded = early & (rows["ended"] <= LEFT_CHART)
    samples = np.maximum(np.round(elapsed / clock.period) + np.where(unrecorded, 0, 1), 1)
    ends = {f"end{i}": np.where(rows[f"end{i}"] < 0, np.nan, rows[f"end{i}"]) for i in range(4)}
    residual = np.maximum.reduce([rows["residual0"], rows["residual1"], rows["residual2"]])
    recorded = np.maximum(samples - 1, 1) * clock.period
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
