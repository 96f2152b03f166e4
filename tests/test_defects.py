"""Defects of the published law, each beside the corrected law in the same setting."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from parkproof.bounds import Bounds, Limits
from parkproof.errors import InputError
from parkproof.laws.gains import Gains, Switching
from parkproof.model.signals import Adversary, Constant, Sine
from parkproof.model.truth import Truth
from parkproof.scenario import Robot, Scenario, Start
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import Run, simulate

Make = Callable[..., Scenario]
H = 2e-3
FORWARD = Gains(direction="forward")


def run_of(section4: Make, law: str, **changes: object) -> Run:
    settings = {"control_period": H, "plant_step": H, "duration": 12.0, "gains": FORWARD}
    return simulate(section4(law, **(settings | changes)))


def x1_after_step2(run: Run) -> float:
    assert run.metrics.max_abs_after_step2 is not None
    return run.metrics.max_abs_after_step2["x1"]


# ------------------------------------------------------------------ D3: Step 3 as printed diverges


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_d3_published_step_3_drives_x1_away_however_small_it_was(
    section4: Make, tolerance: float
) -> None:
    switching = Switching(tolerance=(1e-3, tolerance, 1e-2))
    run = run_of(section4, "published", switching=switching)
    columns = run.trajectory
    at_switch = int(np.argmax(columns["step"] == 3))
    assert abs(columns["x1"][at_switch]) <= tolerance
    assert abs(run.metrics.final["x1"]) > 1.0
    assert run.outcome is Outcome.MISSED


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_d3_corrected_step_3_keeps_x1_small_in_the_same_setting(
    section4: Make, tolerance: float
) -> None:
    switching = Switching(tolerance=(1e-3, tolerance, 1e-2))
    run = run_of(section4, "corrected", switching=switching)
    assert x1_after_step2(run) < 3e-3
    assert abs(run.metrics.final["x1"]) < 1e-4


@pytest.mark.parametrize("discretisation", ["explicit", "implicit"])
def test_d3_is_no_artefact_of_the_control_period(section4: Make, discretisation: str) -> None:
    for period in (1e-3, 4e-3):
        run = run_of(
            section4,
            "published",
            control_period=period,
            discretisation=discretisation,
            switching=Switching(tolerance=(1e-2, 1e-2, 1e-2)),
        )
        assert x1_after_step2(run) > 1.0


def test_d3_with_the_switch_at_25_s_as_in_the_figures(section4: Make) -> None:
    switching = Switching(to_step3=25.0, tolerance=(1e-2, 2e-2, 2e-2))
    period = {"control_period": 4e-3, "plant_step": 4e-3}
    settings = {"duration": 35.0, "switching": switching, **period}
    published = run_of(section4, "published", **settings)
    corrected = run_of(section4, "corrected", **settings)
    assert published.settling_time.steps["2"] == pytest.approx(25.0)
    assert x1_after_step2(published) > 1.0
    assert corrected.settling_time.steps["2"] == pytest.approx(25.0, abs=0.1)
    assert corrected.outcome is Outcome.PARKED


def test_d3_vanishes_only_on_the_exactly_zero_branch(section4: Make) -> None:
    """x1 = x2 = u1 = 0 without disturbance stays 0 in Step 3; 1e-9 does not."""
    ends = {}
    for seed in (0.0, 1e-9):
        run = run_of(
            section4,
            "published",
            truth=Truth(),
            start=Start(state=(10.0, seed, 0.0, 1.0, 0.0)),
            switching=Switching(tolerance=(1e-2, 1e-2, 1e-2)),
        )
        ends[seed] = x1_after_step2(run)
    assert ends[0.0] == 0.0
    assert ends[1e-9] > 1.0


# ---------------------------------------------------------------------- "then stop" does not hold


def test_stopping_lets_a_disturbance_drive_the_robot_away_and_holding_does_not(
    section4: Make,
) -> None:
    settings = {
        "truth": Truth(disturbance=(Constant(2.5), Constant(0.0))),
        "start": Start(state=(-0.5, 0.0, 0.0, 0.0, 0.0)),
        "duration": 10.0,
    }
    published = run_of(section4, "published", **settings)
    assert published.outcome is Outcome.MISSED
    assert published.settling_time.steps["3"] is not None
    stopped = published.trajectory["step"] == 4
    assert not published.trajectory["tau1"][stopped].any()
    assert not published.trajectory["tau2"][stopped].any()
    # ½ φ t² from where it stopped
    rest = 10.0 - published.settling_time.steps["3"]
    assert published.metrics.final["x0"] == pytest.approx(1.25 * rest**2, rel=0.05)
    corrected = run_of(section4, "corrected", **settings)
    assert corrected.outcome is Outcome.PARKED
    assert corrected.metrics.residual < 2e-3


# ----------------------------------------------------------- D5: the chart and the field of view


def test_d5_published_law_has_no_answer_to_a_heading_beyond_90_degrees(section4: Make) -> None:
    behind = Start(pose=(-1.0, 0.3, 2.0))
    with pytest.raises(InputError, match="turns first"):
        section4("published", start=behind)
    run = run_of(section4, "corrected", start=behind, gains=Gains())
    assert run.outcome is Outcome.PARKED


def test_d5_driving_on_for_25_s_leaves_the_picture(section4: Make) -> None:
    view = Limits(view=(-4.0, 4.0, -3.0, 3.0))
    late = Switching(to_step3=25.0)
    whole = run_of(section4, "published", switching=late, duration=25.0)
    assert whole.metrics.excursion > 20.0
    seen = run_of(section4, "published", switching=late, limits=view)
    assert seen.outcome is Outcome.OUT_OF_VIEW
    assert seen.ended < 5.0
    # settled switches, in the better direction
    better = run_of(section4, "corrected", limits=view, gains=Gains())
    assert better.outcome is Outcome.PARKED
    assert better.metrics.excursion < 3.0


# -------------------------------------------------------- D7: the quadratic terms of a real robot


def test_d7_feed_forward_makes_the_torque_robot_the_chained_one(section4: Make) -> None:
    """Exactly, but for holding the command over a period: halving the period halves the gap."""
    gaps = []
    for period in (4e-3, 2e-3, 1e-3):
        settings = {
            "bounds": Bounds(),  # no disturbance: no sign terms, which would chatter
            "truth": "undisturbed",
            "duration": 0.4,
            "control_period": period,
            "plant_step": 5e-4,
        }
        chained, torque = (
            run_of(section4, "corrected", robot=Robot(kind=kind), **settings).trajectory
            for kind in ("chained", "torque")
        )
        gaps.append(
            max(abs(float(chained[n][-1] - torque[n][-1])) for n in ("x0", "x1", "x2", "u0", "u1"))
        )
    assert gaps[2] < 2e-2
    assert gaps[1] < 0.65 * gaps[0]
    assert gaps[2] < 0.65 * gaps[1]


# --------------------------------------------------------------------- D8: Step 1 leaves u1 alone


def test_d8_published_step_1_lets_u1_drift_and_the_corrected_one_holds_it(section4: Make) -> None:
    slow = Truth(
        gamma=(Adversary(), Constant(1.0)),
        disturbance=(Adversary(), Sine(amplitude=2.5, omega=0.3)),
    )
    largest = {}
    for law in ("published", "corrected"):
        run = run_of(
            section4, law, truth=slow, start=Start(state=(0.0, 0.3, 0.0, 5.6, 0.0)), duration=6.0
        )
        end = run.settling_time.steps["1"]
        assert end is not None
        first = run.trajectory["t"] <= end
        largest[law] = {n: float(np.abs(run.trajectory[n][first]).max()) for n in ("x2", "u1")}
        if law == "published":
            # the drift is the integral of φ2
            drift = 2.5 / 0.3 * (1.0 - math.cos(0.3 * end))
            assert largest[law]["u1"] == pytest.approx(drift, rel=1e-6)
    assert largest["published"]["u1"] > 5.0
    assert largest["published"]["x2"] > 5.0
    assert largest["corrected"]["u1"] < 0.02
    assert largest["corrected"]["x2"] < 0.002
