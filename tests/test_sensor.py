"""Measurements with noise and latency: what they are, and that lanes have the same."""

import math
from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
import pytest

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.laws.controller import Controller, measured_pose
from parkproof.laws.gains import Gains, Switching
from parkproof.model.truth import Truth, channel
from parkproof.results import notes_of, summary_of
from parkproof.scenario import Robot, RunSettings, Scenario, Start
from parkproof.scenario_file.read import scenario_from_dict
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.noise import keys_of, mixed, standard_noise
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.plant import Plant
from parkproof.simulation.run import simulate
from parkproof.simulation.sensor import Sensor
from test_lanes import COARSE, same, trials, values_of

Make = Callable[..., Scenario]
SAMPLES = 20_000
LOOSE = Switching(tolerance=(0.05, 0.1, 0.1), hysteresis=3.0)


# ------------------------------------------------------------------------------------- the numbers


@pytest.fixture(scope="module")
def numbers() -> np.ndarray:
    """Noise of two seeds, by seed, sample and channel."""
    return np.array(
        [
            [[standard_noise(*keys_of(seed), k, i) for i in range(5)] for k in range(SAMPLES)]
            for seed in (0, 1)
        ]
    )


def test_noise_has_mean_0_and_deviation_1(numbers: np.ndarray) -> None:
    assert np.abs(numbers.mean(axis=1)).max() < 4.0 / math.sqrt(SAMPLES)
    assert np.abs(numbers.std(axis=1) - 1.0).max() < 4.0 / math.sqrt(2.0 * SAMPLES)


def test_noise_is_nearly_gaussian(numbers: np.ndarray) -> None:
    values = np.sort(numbers.ravel())
    gaussian = 0.5 * (1.0 + np.array([math.erf(x / math.sqrt(2.0)) for x in values]))
    assert np.abs(gaussian - np.arange(values.size) / values.size).max() < 6e-3
    assert np.abs(values).max() < 6.0


def test_seeds_samples_and_channels_are_unrelated(numbers: np.ndarray) -> None:
    columns = np.concatenate([numbers[0], numbers[1], np.roll(numbers[0], 1, axis=0)], axis=1)
    related = np.corrcoef(columns.T) - np.eye(15)
    assert np.abs(related).max() < 5.0 / math.sqrt(SAMPLES)


def test_no_two_words_are_mixed_into_one() -> None:
    words = [*range(50_000), *range(2**32 - 50_000, 2**32)]
    answers = {mixed(word) for word in words}
    assert len(answers) == len(words)
    assert 0 <= min(answers) <= max(answers) < 2**32


# --------------------------------------------------------------------------- what a controller sees


def test_noise_in_the_chart_is_that_of_the_states_and_outside_it_that_of_the_pose() -> None:
    deviations = (0.1, 0.2, 0.3, 0.4, 0.5)
    sensor = Sensor(RunSettings(noise=deviations, seed=4))
    true = measured_pose(0.0, 1.0, 2.0, 0.3, v=0.5, omega=-0.2)
    off = [d * standard_noise(*keys_of(4), 7, i) for i, d in enumerate(deviations)]
    states = sensor.seen(7, true, in_chart=True)
    for i, name in enumerate(("x0", "x1", "x2", "u0", "u1")):
        assert getattr(states, name) == getattr(true, name) + off[i]
    pose = sensor.seen(7, true, in_chart=False)
    for i, name in enumerate(("x0", "x1", "theta", "v", "omega")):
        assert getattr(pose, name) == getattr(true, name) + off[i]


def test_one_deviation_counts_for_all_five_states() -> None:
    one, five = RunSettings(noise=0.1), RunSettings(noise=(0.1,) * 5)
    assert one == five
    assert one.deviations == (0.1,) * 5


@pytest.mark.parametrize(
    ("latency", "samples"), [(0.0, 0), (1e-9, 1), (0.014, 1), (0.016, 2), (0.05, 5)]
)
def test_latency_is_rounded_to_whole_periods_but_never_to_none(
    latency: float, samples: int
) -> None:
    run = RunSettings(latency=latency, control_period=0.01)
    assert run.delay_samples == samples
    assert run.delay == pytest.approx(0.01 * samples)


@pytest.mark.parametrize("robot", ["chained", "torque", "velocity"])
def test_a_run_with_latency_is_a_loop_that_hands_on_old_measurements(
    section4: Make, robot: str
) -> None:
    late = 7
    scenario = section4(
        robot=Robot(kind=robot),  # type: ignore[arg-type]  # names of kinds
        bounds=Bounds(alpha=(0.5, 1.5)),
        truth=Truth(alpha=(0.8, 1.2)),
        start=Start(pose=(-1.0, 0.3, 2.0)),
        duration=3.0,
        control_period=0.01,
        latency=0.07,
    )
    run = simulate(scenario)
    controller = Controller(
        law="corrected", bounds=scenario.bounds, control_period=0.01, robot=scenario.robot.kind
    )
    plant = Plant(
        robot=scenario.robot.kind,
        channels=(
            channel(0, scenario.truth, scenario.bounds),
            channel(1, scenario.truth, scenario.bounds),
        ),
        scales=((0.8, ()), (1.2, ()), (1.0, ())),
        pose=(-1.0, 0.3, 2.0),
        velocity=(0.0, 0.0),
    )
    past = []
    for k in range(301):
        past.append(plant.measurement(0.01 * k))
        assert past[-1].x0 == run.trajectory["x0"][k]
        command = controller.step(past[max(0, k - late)]._replace(t=0.01 * k))
        assert command.tau2 == run.trajectory["tau2"][k]
        plant.advance(command, 0.01 * k, 0.01 * (k + 1) - 0.01 * k, 10)
    assert {0, 1} <= set(run.trajectory["step"].tolist())


def test_without_noise_the_seed_changes_nothing(section4: Make) -> None:
    one, other = (simulate(section4(duration=1.0, seed=seed, **COARSE)) for seed in (0, 9))
    for name, values in one.trajectory.items():
        assert np.array_equal(values, other.trajectory[name], equal_nan=True)


def test_a_seed_repeats_a_run_and_another_does_not(section4: Make) -> None:
    runs = [simulate(section4(duration=0.5, noise=1e-3, seed=s, **COARSE)) for s in (1, 1, 2)]
    first, again, other = (run.trajectory["tau1"] for run in runs)
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@pytest.mark.parametrize("robot", ["torque", "velocity"])
def test_robots_park_at_30_hz_with_some_noise_and_a_late_picture(
    section4: Make, robot: str
) -> None:
    scenario = section4(
        robot=Robot(kind=robot),  # type: ignore[arg-type]  # names of kinds
        bounds=Bounds(alpha=(0.5, 1.5)),
        truth=Truth(alpha=(0.8, 1.2)),
        start=Start(pose=(-1.0, 0.3, 0.4)),
        gains=Gains(runup_speed=0.3),
        switching=LOOSE,
        duration=30.0,
        control_period=1.0 / 30.0,
        discretisation="implicit",
        noise=1e-3,
        latency=1.0 / 30.0,
    )
    run = simulate(scenario)
    assert run.outcome is Outcome.PARKED
    assert 1e-4 < run.metrics.residual < 0.2


def test_a_law_that_cannot_turn_ends_where_it_is_told_of_a_heading_beyond_90_degrees(
    section4: Make,
) -> None:
    start = Start(pose=(-1.0, 0.3, 0.5 * math.pi - 1e-4))
    given = [
        section4(
            "published", start=start, noise=0.1, seed=s, duration=0.1, discretisation="implicit"
        )
        for s in range(8)
    ]
    runs = [simulate(scenario) for scenario in given]
    lanes = simulate_ensemble(given)
    outcomes = [run.outcome for run in runs]
    assert list(lanes["outcome"]) == outcomes
    assert set(outcomes) == {Outcome.LEFT_CHART, Outcome.STILL_MOVING}
    for run, ended in zip(runs, lanes["ended"].tolist(), strict=True):
        assert ended == pytest.approx(run.ended)
        assert len(run.trajectory["t"]) >= 1


def test_a_law_that_is_misled_about_a_heading_beyond_90_degrees_ends(section4: Make) -> None:
    """The chart has no such headings; entering it would turn the robot round."""
    start = Start(pose=(-1.0, 0.3, 2.0))
    changes = {"noise": (0, 0, 1.5, 0, 0), "duration": 0.2, "discretisation": "implicit"}
    given = [section4(start=start, seed=seed, **changes) for seed in range(12)]
    runs = [simulate(scenario) for scenario in given]
    lanes = simulate_ensemble(given)
    outcomes = [run.outcome for run in runs]
    assert list(lanes["outcome"]) == outcomes
    assert Outcome.LEFT_CHART in outcomes
    assert lanes["ended"].tolist() == pytest.approx([run.ended for run in runs])


# ------------------------------------------------------------------------------------------- lanes

MEASUREMENTS: dict[str, dict[str, Any]] = {
    "noise": {"noise": (1e-3, 2e-3, 1e-3, 3e-3, 1e-3)},
    "latency": {"latency": 0.01},
    "both": {"noise": 1e-3, "latency": 0.006},
}


def seeded(scenarios: list[Scenario]) -> list[Scenario]:
    """The same with a seed each."""
    return [
        msgspec.structs.replace(s, run=msgspec.structs.replace(s.run, seed=i))
        for i, s in enumerate(scenarios)
    ]


@pytest.mark.parametrize("law", ["published", "corrected", "homogeneous"])
@pytest.mark.parametrize("kind", MEASUREMENTS)
def test_lanes_see_what_the_plain_run_sees(
    section4: Make, truths: dict[str, Truth], law: str, kind: str
) -> None:
    changes = {"duration": 2.5, "discretisation": "implicit"} | MEASUREMENTS[kind]
    given = seeded(trials(section4, truths, law, **changes)[1::3])
    given = [s for s in given if s.truth.gamma != truths["squares"].gamma]
    lanes = simulate_ensemble(given)
    left_the_turn = False
    for i, scenario in enumerate(given):
        run = simulate(scenario)
        assert lanes["outcome"][i] is run.outcome
        steps = run.trajectory["step"]
        left_the_turn = left_the_turn or (steps[0] == 0 and steps[-1] > 0)
        for name, value in values_of(run).items():
            if steps[-1] == 0 and name in ("x2", "u0", "u1"):
                continue  # outside the chart lanes give θ, v, ω
            expected = math.nan if value is None else value
            assert lanes[name][i] == pytest.approx(expected, rel=1e-7, abs=1e-7, nan_ok=True), name
    assert left_the_turn == (law != "published")


def test_a_trial_can_be_replayed_alone(section4: Make, truths: dict[str, Truth]) -> None:
    changes = {"duration": 0.5, "discretisation": "implicit"} | MEASUREMENTS["both"]
    given = seeded(trials(section4, truths, "corrected", **changes) * 4)
    together = simulate_ensemble(given, threads=2)
    assert len(set(together["rms_tau1"].tolist())) == len(given)
    for i in (0, 3, 50, 95):
        assert same(simulate_ensemble([given[i]]), together, [i]) == []


# --------------------------------------------------------------------------- files, sums, refusals


def test_a_scenario_file_may_give_one_deviation_or_five() -> None:
    start = {"law": "corrected", "start": {"pose": [0.0, 0.0, 0.0]}}
    one = scenario_from_dict(start | {"run": {"noise": 0.01, "latency": 0.03}}, where="file")
    five = scenario_from_dict(
        start | {"run": {"noise": [0.01] * 5, "latency": 0.03, "seed": 0}}, where="file"
    )
    assert one == five
    with pytest.raises(InputError, match="noise"):
        scenario_from_dict(start | {"run": {"noise": [0.01] * 4}}, where="file")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"noise": -1.0}, "noise = -1.0: must not be negative"),
        ({"noise": (0.0, 0.0, math.inf, 0.0, 0.0)}, "noise"),
        ({"noise": 1e7}, "must be below 1e\\+06"),
        ({"latency": -0.1}, "latency = -0.1: must not be negative"),
        ({"latency": 36.0}, "longer than duration = 35"),
        ({"seed": -1}, "seed = -1"),
    ],
)
def test_what_no_sensor_can_do_is_refused(change: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        RunSettings(**change)


def test_a_summary_says_what_was_measured_how_and_that_nothing_is_promised(section4: Make) -> None:
    summary = summary_of(simulate(section4(duration=0.1, noise=1e-3, latency=0.0034)))
    assert summary["noise"] == (1e-3,) * 5 or summary["noise"] == [1e-3] * 5
    assert summary["latency"] == 0.003
    assert summary["assumptions"].startswith("outside the guarantee: run.noise or run.latency")
    assert any("3 ms late" in note for note in notes_of(section4(latency=0.0034)))
