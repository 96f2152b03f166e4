"""Trials of an ensemble with every sample, as the lanes themselves went through them."""

import math

import numpy as np

from parkproof.laws.controller import Command, Measurement, measured_pose, measured_state
from parkproof.model.chained import ChainedState
from parkproof.scenario import Scenario
from parkproof.simulation.lanes.buffer import BLOCK, RESULTS
from parkproof.simulation.lanes.trace import TRACED
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import Recorder, Run, plant_of, plant_steps
from parkproof.simulation.shared import kind_of, shared_of
from parkproof.simulation.trials import Precision, trials_of


def traced_run(
    scenario: Scenario, *, outcome: Outcome, ended: float, precision: Precision = "double"
) -> Run:
    """Carry a trial out again in lanes, and keep its samples.

    Parameters
    ----------
    scenario : Scenario
        The trial.
    outcome : Outcome
        How it ended in its ensemble.
    ended : float
        When, in s.
    precision : "double" or "single"
        That of the ensemble.

    Returns
    -------
    Run
        The trial; its columns are worked out from what the lane had at each sample, which is the
        same to the last bit as in the ensemble.

    Examples
    --------
    >>> from parkproof.scenario import RunSettings, Start
    >>> trial = Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)),
    ...                  run=RunSettings(duration=12.0, control_period=0.01))
    >>> traced_run(trial, outcome=Outcome.PARKED, ended=12.0).trajectory["t"].size
    1201
    """
    from parkproof.simulation.lanes.kernel import kernel_of

    trials = trials_of([scenario])
    kind = kind_of(scenario, camera=trials.have_cameras)
    kernel = kernel_of(**kind, single=precision == "single", traced=True)
    shared = shared_of(scenario, plant_steps=plant_steps(scenario))
    # a block is full, if only of copies
    copies = [np.repeat(numbers, BLOCK, axis=-1) for numbers in trials.arrays]
    trace = np.full((len(TRACED), scenario.run.samples + 1, 1), math.nan)
    kernel(*shared, *copies, np.empty((len(RESULTS), BLOCK)), trace)
    recorder, period = Recorder(scenario), scenario.run.control_period
    for k, sample in enumerate(trace[:, :, 0].T.tolist()):
        if not math.isnan(sample[0]):
            recorder.record(*_sample(k * period, sample))
        elif k == 0:  # noise, as no start is accepted that would end the run
            recorder.record(plant_of(scenario).measurement(0.0), Command(1, 0.0, 0.0))
        else:
            break
    return recorder.finish(outcome, ended)


def _sample(t: float, sample: list[float]) -> tuple[Measurement, Command]:
    """What a lane had at a sample, in the terms of a run."""
    step, x, y, third, fourth, fifth, charted, tau1, tau2, beta = sample
    if charted == 1.0:
        measured = measured_state(t, ChainedState(x, y, third, fourth, fifth), beta)
    else:
        measured = measured_pose(t, x, y, third, v=fourth, omega=fifth, beta=beta)
    return measured, Command(int(step), tau1, tau2)
