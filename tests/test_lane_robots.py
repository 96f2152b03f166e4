"""Lanes of torque- and velocity-commanded robots, and of cameras, against the plain run."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from parkproof.bounds import Limits
from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.model.overhead import Overhead, PinholeTable
from parkproof.scenario import Scenario, Start
from parkproof.simulation.ensemble import simulate_ensemble, simulate_trials
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import Run, simulate
from parkproof.simulation.trials import trials_of
from robot_scenarios import CAMERAS, COMBINATIONS, PERIOD, TILTED, TRUTHS, scenario, trials


def values_of(run: Run) -> dict[str, float | None]:
    m, ends = run.metrics, run.settling_time.steps
    return {
        "total": run.settling_time.total,
        **{f"end{i}": ends.get(str(i)) for i in range(4)},
        "returns": run.returns,
        "residual": m.residual if run.ended == run.scenario.run.duration else math.nan,
        **{f"peak_tau{i + 1}": m.peak_tau[i] for i in range(2)},
        **{f"rms_tau{i + 1}": m.rms_tau[i] for i in range(2)},
        **{f"total_variation_tau{i + 1}": m.total_variation_tau[i] for i in range(2)},
        "ended": run.ended,
        **{f"max_{name}": value for name, value in m.max_abs.items()},
        "excursion": m.excursion,
        "max_speed": m.max_speed,
        "max_turn_rate": m.max_turn_rate,
        "max_heading": math.radians(90.0 - m.least_distance_to_90_deg),
        "least_x0": m.x0_range[0],
        "largest_x0": m.x0_range[1],
        **m.final,
    }


@pytest.mark.parametrize("combination", COMBINATIONS)
def test_short_lanes_are_the_plain_run_pointwise(combination: Any) -> None:
    given = trials(*combination)
    lanes = simulate_ensemble(given)
    for i, one in enumerate(given):
        run = simulate(one)
        assert lanes["outcome"][i] is run.outcome
        turning = run.trajectory["step"][-1] == 0
        for name, value in values_of(run).items():
            # outside the chart the final state is x, y, θ, v, ω
            if turning and name in ("x2", "u0", "u1"):
                continue
            expected = math.nan if value is None else value
            assert lanes[name][i] == pytest.approx(expected, rel=1e-9, abs=1e-9, nan_ok=True), (
                name, i,
            )  # fmt: skip
        if turning:
            last = [float(run.trajectory[name][-1]) for name in ("theta", "v")]
            assert [lanes[name][i] for name in ("x2", "u0")] == pytest.approx(last, rel=1e-9)
        assert lanes["path_length"][i] == pytest.approx(run.metrics.path_length, rel=1e-2)


@pytest.mark.parametrize("combination", COMBINATIONS)
def test_long_lanes_end_as_the_plain_run_does(combination: Any) -> None:
    given = trials(*combination, duration=6.0)
    lanes = simulate_ensemble(given)
    compared = 0
    for i, one in enumerate(given):
        run = simulate(one)
        assert lanes["outcome"][i] is run.outcome
        assert lanes["ended"][i] == pytest.approx(run.ended, abs=1.01 * PERIOD)
        for step in range(4):
            end = run.settling_time.steps.get(str(step))
            assert math.isnan(lanes[f"end{step}"][i]) == (end is None)
            if end is not None:
                compared += 1
                assert lanes[f"end{step}"][i] == pytest.approx(end, abs=1.01 * PERIOD)
    assert compared >= 2


# ------------------------------------------------------------------------------- outcomes


def test_leaving_the_picture_ends_a_lane_as_it_ends_the_plain_run() -> None:
    """Under two cameras of three the run-up leads out of the picture."""
    start = Start(pose=(0.8, 0.5, 2.5))
    reached = set()
    for combination in (COMBINATIONS[2], COMBINATIONS[4]):
        robot, _, law, form, noisy = combination
        given = [
            scenario(robot, camera, law, form, noisy, start=start, gains=Gains(), duration=8.0)
            for camera in CAMERAS
        ]
        lanes = simulate_ensemble(given)
        runs = [simulate(one) for one in given]
        assert list(lanes["outcome"]) == [run.outcome for run in runs]
        assert lanes["ended"] == pytest.approx([run.ended for run in runs], abs=1.01 * PERIOD)
        reached |= set(lanes["outcome"])
    assert reached == {Outcome.OUT_OF_VIEW, Outcome.STILL_MOVING, Outcome.PARKED}


@pytest.mark.parametrize(
    ("limits", "outcome"),
    [
        (Limits(turn_rate=0.3), Outcome.SPEED_LIMIT),
        (Limits(speed=0.45), Outcome.SPEED_LIMIT),
        (Limits(tau=(9.0, 9.0)), Outcome.INPUT_LIMIT),
        (Limits(tau=(9.0, 9.0), saturate=True), Outcome.STILL_MOVING),
    ],
)
def test_limits_hold_for_the_robot_s_own_speeds(limits: Limits, outcome: Outcome) -> None:
    """A turn rate is the robot's, not that of its heading in the image."""
    given = [
        scenario("velocity", camera, "corrected", "implicit", False, start=start, limits=limits,
                 duration=1.5)
        for camera in CAMERAS
        for start in (Start(pose=(-0.4, 0.2, 0.2)), Start(pose=(-0.4, 0.2, 1.6)))
    ]  # fmt: skip
    lanes = simulate_ensemble(given)
    runs = [simulate(one) for one in given]
    assert list(lanes["outcome"]) == [run.outcome for run in runs]
    assert lanes["ended"] == pytest.approx([run.ended for run in runs])
    assert outcome in lanes["outcome"]


@pytest.mark.parametrize(("noise", "omega"), [(1e-9, (0.0, 0.5, 3.0)), (0.1, (0.0, 0.0, 0.0))])
def test_a_law_that_cannot_turn_ends_where_a_robot_leaves_the_chart(
    noise: float, omega: tuple[float, ...]
) -> None:
    """Truly, or by a noisy measurement."""
    given = [
        scenario(
            "torque", TILTED, "published", "implicit", True, noise=noise, seed=seed, duration=0.5,
            start=Start(pose=(-0.4, 0.1, 0.5 * math.pi - 1e-2), velocity=(0.0, rate)),
        )
        for seed, rate in enumerate(omega)
    ]  # fmt: skip
    lanes = simulate_ensemble(given)
    runs = [simulate(one) for one in given]
    assert list(lanes["outcome"]) == [run.outcome for run in runs]
    assert lanes["ended"] == pytest.approx([run.ended for run in runs])
    assert Outcome.LEFT_CHART in lanes["outcome"]


def test_a_start_in_chained_form_is_that_pose_for_every_robot() -> None:
    start = Start(state=(-0.4, 0.1, 0.5, 0.3, 1.0))
    for combination in (COMBINATIONS[0], COMBINATIONS[2]):
        robot, seen, law, form, noisy = combination
        given = scenario(robot, TILTED if seen else None, law, form, noisy, start=start)
        lanes, run = simulate_ensemble([given]), simulate(given)
        for name in ("x0", "x1", "x2", "u0", "u1"):
            assert lanes[name][0] == pytest.approx(run.metrics.final[name], rel=1e-9)


# ------------------------------------------------------------------- a lane is a lane everywhere


def crowd(robot: str, law: str, form: str, noisy: bool) -> list[Scenario]:
    """More than a block of trials under many cameras."""
    rng = np.random.default_rng(4)
    made = []
    while len(made) < 70:
        x, y, theta = rng.uniform([-0.8, -0.4, -3.1], [0.8, 0.4, 3.1])
        camera = PinholeTable(
            height=3.0,
            focal_length=float(rng.uniform(250.0, 380.0)),
            tilt_deg=float(rng.uniform(0.0, 15.0)),
            roll_deg=float(rng.uniform(-180.0, 180.0)),
            unit=100.0,
            goal=(0.1, 0.1, 0.3),
        )
        truth, start = TRUTHS[len(made) % 3], Start(pose=(x, y, theta), velocity=(0.1, 0.1))
        made.append(
            scenario(robot, camera, law, form, noisy, truth=truth, start=start, seed=len(made),
                     duration=1.0)
        )  # fmt: skip
    return made


def differing(one: dict[str, Any], other: dict[str, Any], places: Any) -> list[str]:
    """Names of the results that differ in any bit."""
    names = [name for name in one if name != "outcome"]
    found = [n for n in names if not np.array_equal(one[n], other[n][places], equal_nan=True)]
    return found + ([] if list(one["outcome"]) == list(other["outcome"][places]) else ["outcome"])


@pytest.mark.parametrize(
    ("robot", "law", "form", "noisy"),
    [
        ("velocity", "corrected", "implicit", False),
        ("chained", "homogeneous", "implicit", True),
        ("chained", "corrected", "explicit", True),
    ],
)
def test_a_lane_depends_neither_on_its_place_nor_on_its_company(
    robot: str, law: str, form: str, noisy: bool
) -> None:
    given = crowd(robot, law, form, noisy)
    results = simulate_ensemble(given, threads=2)
    order = np.random.default_rng(6).permutation(len(given))
    assert differing(simulate_ensemble([given[i] for i in order]), results, order) == []
    for i in (0, 3, 65):
        assert differing(simulate_ensemble([given[i]]), results, [i]) == []


def test_the_largest_heading_of_a_robot_does_not_depend_on_its_company() -> None:
    """With noise and latency a robot drives while its heading is still beyond 90 degrees."""
    given = [
        scenario("velocity", None, "homogeneous", "implicit", True, seed=i, duration=0.05,
                 start=Start(pose=(-0.5, 0.1, 1.5 + 0.001 * i), velocity=(0.1, 2.0)))
        for i in range(64)
    ]  # fmt: skip
    together = simulate_ensemble(given)
    assert max(together["max_heading"]) > 0.5 * math.pi
    alone = [simulate_ensemble([one])["max_heading"][0] for one in given]
    assert alone == list(together["max_heading"])


# ------------------------------------------------------------------------------- trials


def test_trials_carry_a_camera_each() -> None:
    given = trials(*COMBINATIONS[4])
    both = trials_of(given)
    assert both.camera.shape == (17, len(given))
    assert both.have_cameras
    some = both.some(np.array([2, 0]))
    results = simulate_trials(given[0], some)
    assert differing(results, simulate_ensemble(given), [2, 0]) == []


def test_trials_with_and_without_a_camera_are_refused() -> None:
    make: Callable[[Overhead | None], Scenario] = lambda camera: scenario(  # noqa: E731
        "chained", camera, "corrected", "explicit", False, start=Start(pose=(-0.4, 0.1, 0.1))
    )
    with pytest.raises(InputError, match=r"1 of 2 trials have a \[camera\]: all .* or none"):
        simulate_ensemble([make(TILTED), make(None)])
