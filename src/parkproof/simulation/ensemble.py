"""Many runs of one scenario: starts and truths differ, everything else is shared."""

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from typing import Any, Literal, Unpack, get_args

import msgspec
import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.laws.parameters import law_parameters
from parkproof.scenario import Scenario
from parkproof.simulation.gpu.launch import carry_out_on_gpu
from parkproof.simulation.lanes.buffer import (
    BLOCK,
    LEFT_CHART,
    RESULTS,
    Clock,
    KernelKind,
    LaneLimits,
    Sensing,
    Shared,
)
from parkproof.simulation.metrics import RESIDUAL_WINDOW, STATE_NAMES
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.precision import check_precision, check_singles
from parkproof.simulation.run import HOLD, integration_steps
from parkproof.simulation.trials import Precision, Trials, trials_of

Floats = NDArray[np.float64]

Device = Literal["cpu", "cuda"]

_ONE_AT_A_TIME = Lock()
"""Threads that ask for one kernel at once would else each compile one."""


def _shared(scenario: Scenario) -> tuple[Any, ...]:
    """What all trials of an ensemble must have in common."""
    run = msgspec.structs.replace(scenario.run, seed=0) if scenario.run.seed else scenario.run
    return (
        scenario.law, scenario.bounds, scenario.gains, scenario.switching, run,
        scenario.robot, scenario.limits,
    )  # fmt: skip


def simulate_ensemble(
    scenarios: Sequence[Scenario],
    *,
    threads: int = 1,
    device: Device = "cpu",
    precision: Precision = "double",
) -> dict[str, Any]:
    """Carry out many runs in compiled lanes.

    Parameters
    ----------
    scenarios : sequence of Scenario
        Trials. They may differ in start, truth, camera and ``run.seed`` only, and have a camera all
        or none.
    threads : int
        Number of threads; a trial's result does not depend on it.
    device : "cpu" or "cuda"
        What computes: this computer's processor, or its NVIDIA graphics processor, where results
        agree to rounding.
    precision : "double" or "single"
        Singles take two thirds to three quarters of the time. They are for statistics: settling
        times of some trials are some periods off (docs/numerics.md says how many). On this
        computer's processor only.

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
        If there are no trials, or they differ in more than that, or there is no such device or
        precision, or not for these numbers.

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
            "the trials of an ensemble differ in more than start and truth, camera and run.seed: "
            "run an ensemble for each law, gains, bounds and run settings"
        )
    return simulate_trials(
        first, trials_of(scenarios), threads=threads, device=device, precision=precision
    )


def simulate_trials(
    scenario: Scenario,
    trials: Trials,
    *,
    threads: int = 1,
    device: Device = "cpu",
    precision: Precision = "double",
) -> dict[str, Any]:
    """Carry out many runs in compiled lanes, their starts and truths given as arrays.

    Parameters
    ----------
    scenario : Scenario
        What all trials share: law, bounds, gains, switching, run (but for its seed), robot and
        limits. Its own start, truth and camera do not matter.
    trials : Trials
        In what they differ.
    threads : int
        Number of threads; a trial's result does not depend on it.
    device : "cpu" or "cuda"
        What computes.
    precision : "double" or "single"
        As for `simulate_ensemble`.

    Returns
    -------
    dict of str to array
        As from `simulate_ensemble`.

    Raises
    ------
    InputError
        If there is no such device or precision, or not for these numbers.

    Examples
    --------
    >>> from parkproof.scenario import RunSettings, Start
    >>> scenario = Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)),
    ...                     run=RunSettings(duration=12.0, control_period=0.01))
    >>> simulate_trials(scenario, trials_of([scenario]))["outcome"][0].value
    'parked'
    """
    if device not in get_args(Device):
        raise InputError(f'device = "{device}": there is no such device; write "cpu" or "cuda"')
    check_precision(precision, device)
    run, limits = scenario.run, scenario.limits
    sensing = Sensing(run.delay_samples, run.deviations)
    p = law_parameters(
        bounds=scenario.bounds,
        gains=scenario.gains,
        switching=scenario.switching,
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
    if precision == "single":
        check_singles((p, clock, lane_limits, sensing), trials)
    out = np.empty((len(RESULTS), len(trials)))
    smooth, jumping = (integration_steps(run, jumps=jumps) for jumps in (False, True))
    sizes = np.where(trials.jump, jumping, smooth)
    kind: KernelKind = {
        "law_name": scenario.law,
        "implicit": run.discretisation == "implicit",
        "exact": sensing.exact,
        "robot": scenario.robot.kind,
        "camera": trials.have_cameras,
    }
    # signals that jump ask for smaller steps: lanes of one block share theirs
    for size in sorted({smooth, jumping}):
        alike = np.flatnonzero(sizes == size)
        if alike.size:
            shared = (p, clock._replace(plant_steps=size), lane_limits, sensing)
            some = trials if alike.size == len(trials) else trials.some(alike)
            out[:, alike] = (
                carry_out_on_gpu(shared, some, **kind)
                if device == "cuda"
                else _carry_out(shared, some, threads, single=precision == "single", **kind)
            )
    return _results(dict(zip(RESULTS, out, strict=True)), scenario, clock)


def _carry_out(
    shared: Shared, trials: Trials, threads: int, *, single: bool, **kind: Unpack[KernelKind]
) -> Floats:
    """The kernel's rows of trials that share an integration step, block by block."""
    from parkproof.simulation.lanes.kernel import kernel_of

    with _ONE_AT_A_TIME:
        kernel = kernel_of(**kind, single=single)
    arrays, order = trials.arrays, _side_by_side(trials)

    def block(begin: int) -> Floats:
        # the last block is filled up with its last trial
        lanes = order[np.minimum(np.arange(begin, begin + BLOCK), len(trials) - 1)]
        parts = [np.ascontiguousarray(a[..., lanes]) for a in arrays]
        rows = np.empty((len(RESULTS), BLOCK))
        kernel(*shared, *parts, rows)
        return rows

    begins = range(0, len(trials), BLOCK)
    if threads == 1:  # a thread of its own would have to be waited for, block by block
        blocks = [block(begin) for begin in begins]
    else:
        with ThreadPoolExecutor(threads) as pool:
            blocks = list(pool.map(block, begins))
    rows = np.empty((len(RESULTS), len(trials)))
    rows[:, order] = np.hstack(blocks)[:, : len(trials)]
    return rows


def _side_by_side(trials: Trials) -> NDArray[np.intp]:
    """An order in which neighbours are mostly in the same step; results do not depend on it.

    Those that will turn come last, and then it is |y| that says how long the approach takes.
    """
    turns = (trials.in_chart == 0.0) & (np.abs(trials.state[2]) > OFTEN_TURNED)
    return np.lexsort((np.abs(trials.state[1]), turns))


OFTEN_TURNED = math.radians(80.0)
"""Headings beyond this are turned first, unless a scenario sets another limit of the chart."""

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
    early = rows["ended"] > 0
    at_the_end = np.where(finished, np.where(inside, _PARKED, _MISSED), _STILL_MOVING)
    outcome = _ENDS[np.where(early, rows["ended"], at_the_end).astype(int)]
    # a time in single precision is that of the nearest sample
    times = {name: np.round(rows[name] / clock.period) * clock.period for name in _TIMES}
    elapsed = np.where(early, times["ended_at"], clock.samples * clock.period)
    # a trial that could not go on from a sample was not recorded there; one over a limit was
    unrecorded = early & (rows["ended"] <= LEFT_CHART)
    samples = np.maximum(np.round(elapsed / clock.period) + np.where(unrecorded, 0, 1), 1)
    ends = {name: np.where(rows[name] < 0, np.nan, times[name]) for name in _TIMES[1:]}
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
