"""Runs of an ensemble with every sample: what the lanes went through, as a plain run has it."""

import math
from typing import Any

import numpy as np
import pytest

from parkproof.bounds import Limits
from parkproof.errors import InputError
from parkproof.scenario import RunSettings, Scenario, Start
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.metrics import STATE_NAMES
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import COLUMNS, Run, simulate
from robot_scenarios import COMBINATIONS, PERIOD, scenario, trials

STARTS = [Start(pose=pose) for pose in ((-0.8, 0.3, 0.2), (0.5, -0.3, -0.7), (-0.5, 0.2, 2.0))]


def long_trials(form: str, **changes: Any) -> list[Scenario]:
    one = ("chained", None, "corrected", form, False)
    return [scenario(*one, start=start, duration=9.0, **changes) for start in STARTS]


@pytest.mark.parametrize("combination", COMBINATIONS)
def test_samples_over_a_short_time_are_those_of_the_plain_run(combination: Any) -> None:
    given = trials(*combination, duration=20 * PERIOD)
    chosen = [0, len(given) - 1]
    results = simulate_ensemble(given, runs=chosen)
    for i, run in enumerate(results["run"]):
        if i not in chosen:
            assert run is None
            continue
        plain = simulate(given[i])
        assert (run.outcome, run.ended, run.scenario) == (plain.outcome, plain.ended, given[i])
        for name in COLUMNS:
            expected = plain.trajectory[name]
            assert run.trajectory[name] == pytest.approx(expected, rel=1e-9, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("form", ["explicit", "implicit"])
@pytest.mark.parametrize("precision", ["double", "single"])
def test_a_run_has_the_metrics_of_its_row_to_the_last_bit(form: str, precision: Any) -> None:
    """Sums apart, as lanes add them up as they go."""
    given = long_trials(form)
    results = simulate_ensemble(given, precision=precision, runs=range(len(given)))
    for i, run in enumerate(results["run"]):
        row = {name: values[i] for name, values in results.items()}
        times = [run.settling_time.steps[str(step)] for step in (1, 2, 3)]
        assert run.outcome is row["outcome"] is Outcome.PARKED
        assert run.settling_time.total == pytest.approx(row["total"], abs=1e-9)
        assert times == pytest.approx([row[f"end{step}"] for step in (1, 2, 3)], abs=1e-9)
        assert run.returns == row["returns"]
        assert run.metrics.peak_tau == [row["peak_tau1"], row["peak_tau2"]]
        assert run.metrics.residual == row["residual"]
        assert run.metrics.final == {name: row[name] for name in STATE_NAMES}
        assert run.metrics.x0_range == [row["least_x0"], row["largest_x0"]]
        for name in STATE_NAMES:
            assert run.metrics.max_abs[name] == row[f"max_{name}"]
        rms = [row["rms_tau1"], row["rms_tau2"]]
        assert run.metrics.rms_tau == pytest.approx(
            rms, rel=1e-5 if precision == "single" else 1e-9
        )


@pytest.mark.parametrize("combination", [COMBINATIONS[2], COMBINATIONS[5]])
def test_so_has_a_run_under_a_camera_with_noise_or_of_another_robot(
    combination: Any,
) -> None:
    given = trials(*combination, duration=1.0)[:3]
    results = simulate_ensemble(given, runs=range(len(given)))
    for i, run in enumerate(results["run"]):
        row = {name: values[i] for name, values in results.items()}
        assert (run.outcome, run.ended) == (row["outcome"], row["ended"])
        assert run.metrics.peak_tau == [row["peak_tau1"], row["peak_tau2"]]
        assert run.metrics.x0_range == [row["least_x0"], row["largest_x0"]]
        assert run.returns == row["returns"]


def test_a_run_does_not_depend_on_which_others_are_asked_for() -> None:
    given = long_trials("explicit")
    both = simulate_ensemble(given, runs=[2, 0], threads=2)["run"]
    alone = simulate_ensemble(given[2:], runs=[0])["run"][0]
    for name in COLUMNS:
        assert np.array_equal(both[2].trajectory[name], alone.trajectory[name], equal_nan=True)


def test_a_trial_that_ends_early_has_the_samples_until_then() -> None:
    given = long_trials("explicit", limits=Limits(tau=(4.0, 400.0)))
    results = simulate_ensemble(given, runs=[0])
    run: Run = results["run"][0]
    assert run.outcome is results["outcome"][0] is Outcome.INPUT_LIMIT
    assert run.trajectory["t"][-1] == pytest.approx(run.ended) == simulate(given[0]).ended
    assert abs(run.trajectory["tau1"][-1]) > 4.0


def test_a_trial_that_noise_ends_at_once_has_one_sample() -> None:
    """The published law is not for a heading beyond 90 degrees, as which noise shows this one."""
    run: dict[str, Any] = {"duration": 1.0, "control_period": PERIOD, "noise": 0.2}
    given = [
        Scenario(law="published", start=Start(pose=(-1.0, 0.1, 1.5)),
                 run=RunSettings(**run, seed=seed))
        for seed in range(8)
    ]  # fmt: skip
    results = simulate_ensemble(given, runs=range(len(given)))
    at_once = [run for run in results["run"] if run.ended == 0.0]
    assert at_once
    for run in at_once:
        plain = simulate(run.scenario)
        assert run.outcome is plain.outcome
        assert run.trajectory["t"].tolist() == plain.trajectory["t"].tolist() == [0.0]
        assert math.isfinite(run.metrics.excursion)


def test_runs_that_there_are_not_are_refused() -> None:
    given = long_trials("explicit")
    for wrong in (3, -1):
        with pytest.raises(InputError, match=r"must be numbers of trials, from 0 to 2"):
            simulate_ensemble(given, runs=[0, wrong])
    with pytest.raises(InputError, match=r"leave runs out"):
        simulate_ensemble(given, runs=[0], device="cuda")
    assert "run" not in simulate_ensemble(given)
