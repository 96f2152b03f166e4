"""One run, in plain Python: the reference that the compiled lanes are tested against."""

import math
from array import array
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from parkproof.laws.controller import Command, Controller, Measurement
from parkproof.model.signals import Square, Switched
from parkproof.scenario import DIVERGED_AT, RunSettings, Scenario
from parkproof.simulation.metrics import Metrics, metrics_of
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.plant import plant_of
from parkproof.simulation.sensor import Sensor

COLUMNS = (
    "t", "x0", "x1", "x2", "u0", "u1", "v", "omega", "tau1", "tau2", "xm", "ym", "theta", "step",
)  # fmt: skip
"""Columns of a trajectory; in Step 0, where the chart may not exist, x2, u0, u1 may be NaN."""

HOLD = 4
"""The last step: holding (corrected) or stopped (published)."""


class SettlingTime(msgspec.Struct, frozen=True, kw_only=True):
    """When the steps ended.

    Attributes
    ----------
    total : float or None
        When the last step before holding ended, in s, if the run ended parked.
    steps : dict
        "0" (if the run turned), "1", "2", "3": when each step last ended, null where it did not.
    """

    total: float | None
    steps: dict[str, float | None]


class Run(msgspec.Struct, frozen=True, kw_only=True):
    """A run that has been carried out.

    Attributes
    ----------
    scenario : Scenario
        What was run.
    outcome : Outcome
        How it ended.
    ended : float
        When it ended, in s.
    settling_time : SettlingTime
        When the steps ended.
    returns : int
        How often the law went back to an earlier step.
    metrics : Metrics
        Residual, inputs, chatter, excursion and so on.
    trajectory : dict of str to array
        Every sample; see `COLUMNS`.
    """

    scenario: Scenario
    outcome: Outcome
    ended: float
    settling_time: SettlingTime
    returns: int
    metrics: Metrics
    trajectory: dict[str, NDArray[np.float64]]


def plant_steps(scenario: Scenario) -> int:
    """Number of integration steps of the plant in one control period.

    Parameters
    ----------
    scenario : Scenario
        ``run.plant_step``, or by default 1 ms, and 0.2 ms where a signal jumps.

    Returns
    -------
    int
        At least 1.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> plant_steps(Scenario(law="corrected", start=Start(pose=(0, 0, 0)),
    ...                      run=RunSettings(control_period=0.01)))
    10
    """
    jumps = any(isinstance(signal, Square | Switched) for signal in scenario.truth.signals)
    return integration_steps(scenario.run, jumps=jumps)


def integration_steps(run: RunSettings, *, jumps: bool) -> int:
    """Number of integration steps of the plant in one control period.

    Parameters
    ----------
    run : RunSettings
        With ``plant_step``, or without.
    jumps : bool
        Whether a signal jumps.

    Returns
    -------
    int
        At least 1.

    Examples
    --------
    >>> run = RunSettings(control_period=0.01)
    >>> integration_steps(run, jumps=False), integration_steps(run, jumps=True)
    (10, 50)
    """
    step = run.plant_step or (2e-4 if jumps else 1e-3)
    return max(1, math.ceil(run.control_period / step - 1e-9))


def simulate(scenario: Scenario, *, progress: Callable[[float], None] | None = None) -> Run:
    """Carry out one run.

    Parameters
    ----------
    scenario : Scenario
        What to run.
    progress : callable, optional
        Called now and then with the fraction done, 0 to 1.

    Returns
    -------
    Run
        Outcome, metrics and every sample.

    Examples
    --------
    >>> from parkproof.scenario import RunSettings, Start
    >>> run = simulate(Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)),
    ...                         run=RunSettings(duration=12.0, control_period=0.01)))
    >>> run.outcome.value
    'parked'
    """
    controller = Controller(
        law=scenario.law,
        bounds=scenario.bounds,
        gains=scenario.gains,
        switching=scenario.switching,
        control_period=scenario.run.control_period,
        discretisation=scenario.run.discretisation,
        robot=scenario.robot.kind,
        saturation=scenario.limits.saturation,
    )
    plant = plant_of(scenario)
    controller.hold_velocity(*scenario.start_velocity)
    recorder, sensor = Recorder(scenario), Sensor(scenario.run)
    h, n, steps = scenario.run.control_period, scenario.run.samples, plant_steps(scenario)
    report_every = max(1, n // 200)
    for k in range(n + 1):
        t = k * h
        measurement = plant.measurement(t)
        seen = sensor.seen(k, measurement, in_chart=plant.in_chart)
        if (ended := recorder.end_before(measurement, seen)) is not None:
            if k == 0:  # noise, as no start is accepted that would end the run
                recorder.record(measurement, Command(1, 0.0, 0.0))
            return recorder.finish(ended, t)
        try:
            command = controller.step(seen)
            if plant.is_misled(command):
                if k == 0:
                    recorder.record(measurement, command)
                return recorder.finish(Outcome.LEFT_CHART, t)
            recorder.record(measurement, command)
            if (ended := recorder.end_after(command, measurement)) is not None:
                return recorder.finish(ended, t)
            if k < n:
                plant.advance(command, t, (k + 1) * h - t, steps)
        except ArithmeticError:  # beyond the floats, or beyond the horizon of the camera
            papers = scenario.camera is None
            return recorder.finish(Outcome.DIVERGED if papers else Outcome.OUT_OF_VIEW, t)
        if progress is not None and k % report_every == 0:
            progress(k / n)
    return recorder.finish(None, n * h)


class Recorder:
    """Keeps the samples of a run, watches its limits, and sums it up.

    Parameters
    ----------
    scenario : Scenario
        What is being run.

    Examples
    --------
    See `simulate`.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._limits = scenario.limits
        self._sees = None if scenario.camera is None else scenario.camera.view.sees
        self._columns = {name: array("d") for name in COLUMNS}
        self._appends = [self._columns[name].append for name in COLUMNS]
        self._last_step: int | None = None
        self._ends: dict[int, float] = {}
        self._first_end_of_step2: float | None = None
        self._returns = 0

    def end_before(self, m: Measurement, seen: Measurement) -> Outcome | None:
        """The outcome if the run cannot go on from what is true or seen, else None."""
        size = max(abs(m.x0), abs(m.x1), abs(m.v), abs(m.omega))
        if not size < DIVERGED_AT:
            return Outcome.DIVERGED
        view = self._limits.view
        if view is not None and not (view[0] <= m.x0 <= view[1] and view[2] <= m.x1 <= view[3]):
            return Outcome.OUT_OF_VIEW
        if self._sees is not None and not self._sees(m.x0, m.x1):
            return Outcome.OUT_OF_VIEW
        if self._scenario.law == "published" and not max(abs(m.x2), abs(seen.x2)) < DIVERGED_AT:
            return Outcome.LEFT_CHART
        return None

    def end_after(self, command: Command, m: Measurement) -> Outcome | None:
        """The outcome if the command or the speed breaks a limit, else None."""
        tau = self._limits.tau
        if tau is not None and (abs(command.tau1) > tau[0] or abs(command.tau2) > tau[1]):
            return Outcome.INPUT_LIMIT
        too_fast = self._limits.speed is not None and abs(m.v) > self._limits.speed
        turn_rate = self._limits.turn_rate
        if too_fast or (turn_rate is not None and abs(m.omega / m.beta) > turn_rate):
            return Outcome.SPEED_LIMIT
        return None

    def record(self, m: Measurement, command: Command) -> None:
        """Keep a sample, and note when steps end."""
        step = command.step
        x2, u0, u1 = (m.x2, m.u0, m.u1) if math.isfinite(m.x2) else (math.nan,) * 3
        row = (
            m.t, m.x0, m.x1, x2, u0, u1, m.v, m.omega / m.beta,
            command.tau1, command.tau2, m.x0, m.x1, m.theta, step,
        )  # fmt: skip
        for append, value in zip(self._appends, row, strict=True):
            append(value)
        last = self._last_step
        if last is not None and step != last:
            if step > last:
                self._ends[last] = round(m.t, 9)
                if last == 2 and self._first_end_of_step2 is None:
                    self._first_end_of_step2 = self._ends[last]
            else:
                self._returns += 1
                self._ends = {i: t for i, t in self._ends.items() if i < step}
        self._last_step = step

    def finish(self, ended: Outcome | None, t: float) -> Run:
        """Sum the run up."""
        columns: dict[str, Any] = {
            name: np.frombuffer(values, dtype=np.float64).copy()
            for name, values in self._columns.items()
        }
        columns["step"] = columns["step"].astype(np.int32)
        outcome = ended or self._judge(columns)
        steps: dict[str, float | None] = {
            str(i): self._ends.get(i) for i in range(HOLD) if i > 0 or 0 in self._ends
        }
        return Run(
            scenario=self._scenario,
            outcome=outcome,
            ended=t,
            settling_time=SettlingTime(
                total=self._ends.get(HOLD - 1) if outcome is Outcome.PARKED else None, steps=steps
            ),
            returns=self._returns,
            metrics=metrics_of(columns, end_of_step2=self._first_end_of_step2),
            trajectory=columns,
        )

    def _judge(self, columns: dict[str, Any]) -> Outcome:
        """Parked if all of the pose stayed inside its tolerance since holding began."""
        if self._last_step != HOLD:
            return Outcome.STILL_MOVING
        switching = self._scenario.switching
        recent = columns["t"] >= self._ends[HOLD - 1] - 1e-9  # times of steps are rounded
        _, across, along = switching.tolerance
        factor = switching.hysteresis
        inside = all(
            float(np.max(np.abs(columns[name][recent]))) <= factor * tolerance
            for name, tolerance in (("x0", along), ("x1", across), ("x2", across))
        )
        return Outcome.PARKED if inside else Outcome.MISSED
