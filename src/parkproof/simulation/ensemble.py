"""Many runs of one scenario: starts and truths differ, everything else is shared."""

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from operator import index
from typing import Any, Literal, Unpack, get_args

import msgspec
import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.scenario import Scenario
from parkproof.simulation.gpu.launch import carry_out_on_gpu
from parkproof.simulation.lane_results import results_of
from parkproof.simulation.lanes.buffer import (
    BLOCK,
    RESULTS,
    KernelKind,
    Shared,
)
from parkproof.simulation.precision import check_precision, check_singles
from parkproof.simulation.run import integration_steps
from parkproof.simulation.shared import kind_of, shared_of
from parkproof.simulation.traced import traced_run
from parkproof.simulation.trials import Precision, Trials, trials_of

Floats = NDArray[np.float64]

Device = Literal["cpu", "cuda"]


def _in_common(scenario: Scenario) -> tuple[Any, ...]:
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
    runs: Sequence[int] = (),
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
        Singles take half to three quarters of the time. They are for statistics: settling
        times of some trials are some periods off (docs/numerics.md says how many). On this
        computer's processor only.
    runs : sequence of int
        Numbers of the trials whose every sample is wanted, from 0. Each is carried out once more,
        which takes some tenths of a second, and the first time a kernel is compiled that keeps
        samples. On this computer's processor only.

    Returns
    -------
    dict of str to array
        A value a trial: ``outcome`` (`Outcome`), ``total`` and ``end0`` … ``end3`` (settling times
        in s, NaN where there is none), ``returns``, ``residual`` (NaN where the run ended early),
        ``peak_tau1``, ``peak_tau2``, ``rms_tau1``, ``rms_tau2``, ``total_variation_tau1``,
        ``total_variation_tau2``, ``excursion``, ``path_length``, ``ended``, the largest magnitudes
        ``max_x0`` … ``max_u1`` (x2, u0 and u1 outside Step 0 only), ``max_speed``,
        ``max_turn_rate`` and ``max_heading`` (|θ|), the range ``least_x0``, ``largest_x0``, and
        the final state ``x0`` … ``u1`` (or x, y, θ, v, ω where a trial ended turning). With
        ``runs``, also ``run``: the `Run` of each of those trials, None for the others.

    Raises
    ------
    InputError
        If there are no trials, or they differ in more than that, or there is no such device,
        precision or trial, or not for these numbers.

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
    if any(_in_common(s) != _in_common(first) for s in scenarios[1:]):
        raise InputError(
            "the trials of an ensemble differ in more than start and truth, camera and run.seed: "
            "run an ensemble for each law, gains, bounds and run settings"
        )
    wanted = _checked(runs, len(scenarios), device)
    results = simulate_trials(
        first, trials_of(scenarios), threads=threads, device=device, precision=precision
    )
    if wanted:
        results["run"] = np.full(len(scenarios), None, dtype=object)
    for i in wanted:
        results["run"][i] = traced_run(scenarios[i], precision=precision)
    return results


def _checked(runs: Sequence[int], count: int, device: Device) -> list[int]:
    """Numbers of trials, if there are such, and what computes keeps samples."""
    _check_device(device)
    if len(runs) and device != "cpu":
        raise InputError(
            f'runs = {list(runs)} with device = "{device}": samples are kept on this computer\'s '
            'processor only; write device="cpu", or leave runs out'
        )
    try:
        wanted = [index(i) for i in runs]
    except TypeError as error:
        raise InputError(f"runs = {list(runs)}: must be whole numbers; write runs=[0]") from error
    wrong = next((i for i in wanted if not 0 <= i < count), None)
    if wrong is not None:
        raise InputError(
            f"runs = [{wrong}]: must be numbers of trials, from 0 to {count - 1}; write for "
            "example runs=[0]"
        )
    return wanted


def _check_device(device: Device) -> None:
    """Raise if there is no such device."""
    if device not in get_args(Device):
        raise InputError(f'device = "{device}": there is no such device; write "cpu" or "cuda"')


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
    _check_device(device)
    check_precision(precision, device)
    run = scenario.run
    if precision == "single":
        check_singles(shared_of(scenario, plant_steps=1), trials)
    out = np.empty((len(RESULTS), len(trials)))
    smooth, jumping = (integration_steps(run, jumps=jumps) for jumps in (False, True))
    sizes = np.where(trials.jump, jumping, smooth)
    kind = kind_of(scenario, camera=trials.have_cameras)
    # signals that jump ask for smaller steps: lanes of one block share theirs
    for size in sorted({smooth, jumping}):
        alike = np.flatnonzero(sizes == size)
        if alike.size:
            shared = shared_of(scenario, plant_steps=size)
            some = trials if alike.size == len(trials) else trials.some(alike)
            out[:, alike] = (
                carry_out_on_gpu(shared, some, **kind)
                if device == "cuda"
                else _carry_out(shared, some, threads, single=precision == "single", **kind)
            )
    return results_of(dict(zip(RESULTS, out, strict=True)), scenario)


def _carry_out(
    shared: Shared, trials: Trials, threads: int, *, single: bool, **kind: Unpack[KernelKind]
) -> Floats:
    """The kernel's rows of trials that share an integration step, block by block."""
    from parkproof.simulation.lanes.kernel import kernel_of

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
