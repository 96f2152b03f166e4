"""A trial of an ensemble with every sample: carried out once more, in lanes that keep them."""

import math

import numpy as np

from parkproof.laws.controller import Command, Measurement, measured_pose, measured_state
from parkproof.model.chained import ChainedState
from parkproof.scenario import Scenario
from parkproof.simulation.lane_results import results_of
from parkproof.simulation.lanes.buffer import BLOCK, RESULTS
from parkproof.simulation.lanes.trace import ROWS_TRACED
from parkproof.simulation.plant import plant_of
from parkproof.simulation.run import Recorder, Run, plant_steps
from parkproof.simulation.shared import kind_of, shared_of
from parkproof.simulation.trials import Precision, trials_of


def traced_run(scenario: Scenario, *, precision: Precision = "double") -> Run:
    """Carry a trial out in lanes that keep its samples.

    Parameters
    ----------
    scenario : Scenario
        The trial.
    precision : "double" or "single"
        That of its ensemble.

    Returns
    -------
    Run
        The trial, to the last bit as in any ensemble; the columns of its trajectory are worked out
        from what the lane had at each sample.

    Examples
    --------
    >>> from parkproof.scenario import RunSettings, Start
    >>> trial = Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)),
    ...                  run=RunSettings(duration=12.0, control_period=0.01))
    >>> traced_run(trial).trajectory["t"].size
    1201
    """
    from parkproof.simulation.lanes.kernel import kernel_of

    trials = trials_of([scenario])
    kind = kind_of(scenario, camera=trials.have_cameras)
    kernel = kernel_of(**kind, single=precision == "single", traced=True)
    shared = shared_of(scenario, plant_steps=plant_steps(scenario))
    # a block is full, if only of copies
    copies = [np.repeat(numbers, BLOCK, axis=-1) for numbers in trials.arrays]
    rows = np.empty((len(RESULTS), BLOCK))
    trace = np.full((ROWS_TRACED, scenario.run.samples + 1), math.nan)
    kernel(*shared, *copies, rows, trace)
    results = results_of(dict(zip(RESULTS, rows[:, :1], strict=True)), scenario)
    recorder, period = Recorder(scenario), scenario.run.control_period
    for k, sample in enumerate(trace.T.tolist()):
        if not math.isnan(sample[0]):
            recorder.record(*_sample(k * period, sample))
        elif k == 0:
            # noise has ended the trial before its first input: where it started, without one
            recorder.record(plant_of(scenario).measurement(0.0), Command(1, 0.0, 0.0))
        else:
            break
    return recorder.finish(results["outcome"][0], float(results["ended"][0]))


def _sample(t: float, sample: list[float]) -> tuple[Measurement, Command]:
    """What a lane had at a sample, in the terms of a run."""
    step, x, y, third, fourth, fifth, charted, tau1, tau2, beta = sample
    if charted == 1.0:
        measured = measured_state(t, ChainedState(x, y, third, fourth, fifth), beta)
    else:
        measured = measured_pose(t, x, y, third, v=fourth, omega=fifth, beta=beta)
    return measured, Command(int(step), tau1, tau2)
