"""What all trials of an ensemble share, as kernels take it."""

import math

from parkproof.laws.parameters import law_parameters
from parkproof.scenario import Scenario
from parkproof.simulation.lanes.buffer import Clock, KernelKind, LaneLimits, Sensing, Shared
from parkproof.simulation.metrics import RESIDUAL_WINDOW


def shared_of(scenario: Scenario, *, plant_steps: int) -> Shared:
    """Take from a scenario what does not differ between trials.

    Parameters
    ----------
    scenario : Scenario
        Any of the trials.
    plant_steps : int
        Integration steps in one control period.

    Returns
    -------
    tuple
        A law's parameters, times, limits, and what measurements are like.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> scenario = Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)))
    >>> _, clock, _, sensing = shared_of(scenario, plant_steps=1)
    >>> clock.period, sensing.exact
    (0.001, True)
    """
    run, limits = scenario.run, scenario.limits
    p = law_parameters(
        bounds=scenario.bounds,
        gains=scenario.gains,
        switching=scenario.switching,
        control_period=run.control_period,
        discretisation=run.discretisation,
        saturation=limits.saturation,
    )
    end = run.samples * run.control_period
    none = math.inf
    lane_limits = LaneLimits(
        *(limits.tau or (none, none)),
        limits.speed or none,
        limits.turn_rate or none,
        *(limits.view or (-none, none, -none, none)),
    )
    clock = Clock(run.control_period, run.samples, plant_steps, end - RESIDUAL_WINDOW)
    return p, clock, lane_limits, Sensing(run.delay_samples, run.deviations)


def kind_of(scenario: Scenario, *, camera: bool) -> KernelKind:
    """Say which kernel carries a scenario out.

    Parameters
    ----------
    scenario : Scenario
        Any of the trials.
    camera : bool
        Whether trials have cameras of their own.

    Returns
    -------
    KernelKind
        What it is compiled for.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> scenario = Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)))
    >>> kind_of(scenario, camera=False)["robot"]
    'chained'
    """
    return {
        "law_name": scenario.law,
        "implicit": scenario.run.discretisation == "implicit",
        "exact": Sensing(scenario.run.delay_samples, scenario.run.deviations).exact,
        "robot": scenario.robot.kind,
        "camera": camera,
    }
