"""Trials of a campaign's distributions that say which of what is drawn matters most."""

import numpy as np
from numpy.typing import NDArray

from parkproof.campaign.draw import values_at
from parkproof.campaign.ensembles import ensembles
from parkproof.campaign.prepare import Prepared
from parkproof.report.deciders import QUESTIONS, outputs_of
from parkproof.report.sensitivity import Sensitivity, points_for, sensitivity_of
from parkproof.simulation.ensemble import simulate_trials

Array = NDArray[np.float64]


def drawn_keys(prepared: Prepared) -> tuple[str, ...]:
    """What a campaign draws.

    Parameters
    ----------
    prepared : Prepared
        The campaign.

    Returns
    -------
    tuple of str
        Keys of the scenario, in the order of the campaign.
    """
    return tuple(quantity.key for quantity in prepared.campaign.quantities if quantity.drawn)


def study_of(prepared: Prepared, *, trials: int, threads: int = 1) -> Sensitivity:
    """Carry out a study of at most about so many trials.

    Where measurements are noisy, trials that are compared have the same noise.

    Parameters
    ----------
    prepared : Prepared
        The campaign; it draws two quantities or more.
    trials : int
        At most about so many.
    threads : int
        For the trials.

    Returns
    -------
    Sensitivity
        Of `parkproof.report.deciders.QUESTIONS`.
    """
    inputs, campaign = drawn_keys(prepared), prepared.campaign

    def outputs(points: Array) -> Array:
        found = np.empty((len(QUESTIONS), len(points)))
        drawn = values_at(campaign, np.ascontiguousarray(points.T))
        # numbers that no trial of the campaign has, so that noise is new, too
        numbers = campaign.trials + np.arange(len(points))
        for members, scenario, some in ensembles(prepared, drawn, numbers, size=len(points)):
            rows = simulate_trials(scenario, some, threads=threads, precision=campaign.precision)
            duration = scenario.run.samples * scenario.run.control_period
            found[:, members] = outputs_of(rows, duration)
        return found

    points = points_for(len(inputs), trials)
    return sensitivity_of(outputs, inputs, points=points, seed=campaign.seed)
