"""What is measured beside a proof: stressed runs, and the comparison with what is proven."""

import json
import math

import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")
pytest.importorskip("scipy", reason="needs parkproof[proof]")

from parkproof.bounds import Bounds
from parkproof.laws.gains import Gains
from parkproof.proof.whole_run import certify
from parkproof.report.measured import (
    compare,
    measured_of,
    sampling_bands,
    stressed_runs,
)
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.outcome import Outcome

COARSE = 4e-3
STARTS = {"x0": (-0.1, 0.1), "x1": (0.0, 0.1), "x2": (0.0, 0.1), "u0": (0, 0), "u1": (0, 0)}


@pytest.fixture(scope="module")
def certificate():
    known = Bounds(alpha=(0.9, 1.1), disturbance=0.5)
    gains = Gains(q1="19/21", direction="toward")
    found = certify(law="corrected", bounds=known, gains=gains, starts=STARTS)
    assert found.certificate is not None, found.reason
    return found.certificate


@pytest.fixture(scope="module")
def rows(certificate):
    trials = stressed_runs(certificate, count=256, seed=0, control_period=COARSE)
    return simulate_ensemble(trials, threads=2)


def beyond(certificate, rows):
    return [one.name for one in compare(certificate, rows) if not one.within]


def test_stressed_runs_stay_within_every_proven_number(certificate, rows):
    assert beyond(certificate, rows) == []
    # bounds that runs come nowhere near would say little
    ratios = {one.name: one.ratio for one in compare(certificate, rows)}
    assert ratios["total_time"] > 0.3
    assert ratios["max_tau 1"] > 0.3


def test_every_number_of_a_claim_is_compared(certificate, rows):
    names = {one.name.partition(" ")[0] for one in compare(certificate, rows)}
    assert names == set(certificate["claim"])


@pytest.mark.parametrize(
    ("key", "index", "name"),
    [
        ("total_time", None, "total_time"),
        ("max_tau", 1, "max_tau 2"),
        ("max_abs_state", 2, "max_abs_state x2"),
        ("max_speed", None, "max_speed"),
        ("max_turn_rate", None, "max_turn_rate"),
        ("max_heading", None, "max_heading"),
        ("x0_range", 0, "x0_range -"),
        ("x0_range", 1, "x0_range +"),
        ("x1_at_rest", None, "x1_at_rest"),
    ],
)
def test_a_number_below_the_worst_run_is_named(certificate, rows, key, index, name):
    worst = next(one.worst for one in compare(certificate, rows) if one.name == name)
    changed = json.loads(json.dumps(certificate))
    smaller = 0.99 * worst * (-1.0 if name == "x0_range -" else 1.0)
    if index is None:
        changed["claim"][key] = smaller
    else:
        changed["claim"][key][index] = smaller
    assert beyond(changed, rows) == [name]


def test_a_run_that_does_not_park_contradicts_every_time(certificate, rows):
    outcome = rows["outcome"].copy()
    outcome[7] = Outcome.MISSED
    (time,) = [one for one in compare(certificate, rows | {"outcome": outcome}) if not one.within]
    assert (time.name, time.worst) == ("total_time", math.inf)


def test_a_stressed_run_depends_on_the_seed_and_its_own_number_only(certificate):
    few, many = (
        stressed_runs(certificate, count=count, seed=3, control_period=COARSE) for count in (5, 9)
    )
    assert few == many[:5]
    assert few != stressed_runs(certificate, count=5, seed=4, control_period=COARSE)


def test_starts_and_truths_are_those_of_the_certificate(certificate):
    box = certificate["assumptions"]["starts"]
    for run in stressed_runs(certificate, count=64, seed=1, control_period=COARSE):
        assert all(
            low <= value <= high
            for value, (low, high) in zip(run.start.state, box.values(), strict=True)
        )
        run.truth.check(run.bounds)


def test_sampling_lets_inputs_stray_in_proportion_to_the_period(certificate):
    assert sampling_bands(certificate, 2e-3) == pytest.approx((1e-3, 1e-3))
    assert sampling_bands(certificate, 4e-3) == pytest.approx((2e-3, 2e-3))


def test_noise_and_latency_reach_the_runs_and_widen_the_band(certificate):
    exact, poor = (
        measured_of(certificate, control_period=COARSE, count=64, noise=noise, latency=latency)
        for noise, latency in ((0.0, 0.0), (0.01, 0.013))
    )
    assert poor["noise"] == 0.01
    assert poor["latency"] == 3 * COARSE, "as it was carried out, in whole periods"
    assert poor["residual"] > exact["residual"]


def test_what_is_measured_says_how(certificate):
    found = measured_of(certificate, control_period=COARSE, count=16)
    assert found["parked"] == found["runs"] == 16
    assert (found["control_period"], found["noise"], found["latency"]) == (COARSE, 0.0, 0.0)
    assert found["slowest"] <= certificate["claim"]["total_time"]
