"""Certificates of random gains against ten thousand random trajectories within their bounds.

Proofs speak of continuous time, runs are sampled. No allowance is made for that: by what sampling
lets u0 and u1 stray (`sampling_bands`), and by a period for each step that ends late, runs stay
further from what is proved than these would take them.
"""

import json
import random
from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

import msgspec
import numpy as np
import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")
pytest.importorskip("scipy", reason="needs parkproof[proof]")
pytest.importorskip("clarabel", reason="needs parkproof[proof]")

from parkproof.bounds import Bounds
from parkproof.laws.gains import Gains, Switching
from parkproof.model.signals import Adversary, Constant, Sine, Square
from parkproof.model.truth import Truth
from parkproof.proof import find_links
from parkproof.proof.lmi import homogeneous_gains
from parkproof.proof.whole_run import certify
from parkproof.report.measured import compare, stressed_runs
from parkproof.scenario import Scenario
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.outcome import Outcome

Certificate = dict[str, Any]
Law = Literal["corrected", "homogeneous"]
Pair = tuple[float, float]

PERIOD, PLANT_STEP = 8e-3, 4e-3


class Case(NamedTuple):
    """A law, whether starts are poses of every heading, and the number of runs."""

    law: Law
    turns: bool
    runs: int


CASES = (
    Case("corrected", False, 2800),
    Case("corrected", True, 2800),
    Case("corrected", False, 2800),
    Case("homogeneous", False, 800),
    Case("homogeneous", True, 800),
)

SHARE = 0.7
"""Share of a sampled rate that is quickly proved."""


class Tried(NamedTuple):
    """A certificate, and runs within its bounds."""

    certificate: Certificate
    runs: list[Scenario]
    rows: dict[str, Any]


def around_one(draw: random.Random, widest: float) -> Pair:
    """A range about a number near 1, as far as a factor to either side."""
    middle, factor = draw.uniform(0.9, 1.1), draw.uniform(1.02, widest)
    return middle / factor, middle * factor


def around_zero(draw: random.Random, widest: float) -> Pair:
    return -draw.uniform(0.2, widest), draw.uniform(0.2, widest)


def step_2_of(law: Law, draw: random.Random, bounds: Bounds, speed: float) -> dict[str, Any]:
    """Random gains of Step 2: near the published ones, or for a random limit of the input."""
    if law == "corrected":
        l1, l2, l3 = draw.uniform(1.8, 2.2), draw.uniform(3.9, 5.5), draw.uniform(20.0, 35.0)
        return {"q1": draw.choice(("9/11", "11/13", "13/15", "19/21")), "l": (l1, l2, l3)}
    low, high = bounds.alpha_of(1)
    found = homogeneous_gains(
        b1=(0.9 * speed * low, 1.1 * speed * high),
        b2=bounds.b2,
        gamma=bounds.gamma_of(1),
        disturbance=bounds.disturbance_of(1),
        tau_max=draw.uniform(8.0, 25.0),
        starts=[(0.5, x2, u1) for x2 in (-0.6, 0.6) for u1 in (-0.6, 0.6)],
    )
    assert found is not None
    return {"ellipsoid": found.ellipsoid, "feedback": found.feedback}


def certificate_of(number: int) -> Certificate:
    """Prove what random gains do under random bounds, from random starts."""
    law, turns, _ = CASES[number]
    draw = random.Random(f"a certificate of random gains {number}")
    speed = draw.uniform(0.9, 1.1)
    bounds = Bounds(
        alpha=(around_one(draw, 1.12), around_one(draw, 1.1)),
        gamma=(around_one(draw, 1.2), around_one(draw, 1.2)),
        disturbance=(draw.uniform(0.1, 0.5), draw.uniform(0.1, 0.5)),
        b2=around_one(draw, 1.06),
    )
    gains = Gains(
        lambda1=draw.uniform(0.9, 1.5),
        k=(draw.uniform(1.2, 1.6), draw.uniform(6.5, 8.0)),
        hold=(draw.uniform(1.2, 1.6), draw.uniform(6.5, 8.0)),
        runup_speed=speed,
        direction=draw.choice(("auto", "toward", "forward", "backward")),
        return_steering=False,
        **step_2_of(law, draw, bounds, speed),
    )
    wide = {name: around_zero(draw, 0.3) for name in ("x0", "x1", "x2", "u0", "u1")}
    if not turns:
        found = certify(law=law, bounds=bounds, gains=gains, starts=wide)
    else:
        x, y, _, v, omega = wide.values()
        starts = {"x": x, "y": y, "theta": (-3.1415, 3.1415), "v": v, "omega": omega}
        switching = Switching(
            tolerance=(0.1 * speed, 0.01, 0.01),
            hysteresis=20.0,
            turn_tolerance=0.01,
            chart_limit=25.0,
        )
        found = certify(law=law, bounds=bounds, gains=gains, starts=starts, switching=switching)
    assert found.certificate is not None, found.reason
    return found.certificate


def runs_of(certificate: Certificate, count: int, seed: int) -> list[Scenario]:
    """Stressed runs, integrated in as many steps whether or not their signals jump."""
    runs = stressed_runs(certificate, count=count, seed=seed, control_period=PERIOD, extra=0.5)
    replace = msgspec.structs.replace
    return [replace(one, run=replace(one.run, plant_step=PLANT_STEP)) for one in runs]


@pytest.fixture(scope="module")
def tried() -> list[Tried]:
    """Every case, carried out."""
    every = []
    for number, case in enumerate(CASES):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(find_links, "SHARES", (SHARE,))
            certificate = certificate_of(number)
        runs = runs_of(certificate, case.runs, number)
        every.append(Tried(certificate, runs, simulate_ensemble(runs)))
    return every


def beyond(certificate: Certificate, rows: Mapping[str, Any]) -> list[str]:
    return [one.name for one in compare(certificate, rows) if not one.within]


def test_no_certificate_of_random_gains_is_contradicted_by_ten_thousand_runs(
    tried: list[Tried],
) -> None:
    assert sum(len(one.runs) for one in tried) == 10_000
    for number, (certificate, _, rows) in enumerate(tried):
        assert beyond(certificate, rows) == [], (CASES[number], number)
        assert all(outcome is Outcome.PARKED for outcome in rows["outcome"])


def test_the_runs_come_near_enough_to_contradict_a_claim_that_is_too_strong(
    tried: list[Tried],
) -> None:
    for certificate, _, rows in tried:
        worst = {one.name: one.worst for one in compare(certificate, rows)}
        for name, key, index in (
            ("total_time", "total_time", None),
            ("max_tau 1", "max_tau", 0),
            ("max_abs_state x1", "max_abs_state", 1),
            ("max_turn_rate", "max_turn_rate", None),
            ("x1_at_rest", "x1_at_rest", None),
        ):
            stronger = json.loads(json.dumps(certificate))
            if index is None:
                stronger["claim"][key] = 0.999 * worst[name]
            else:
                stronger["claim"][key][index] = 0.999 * worst[name]
            assert beyond(stronger, rows) == [name]
        # the slowest run takes a good part of the proven time
        assert worst["total_time"] > 0.2 * certificate["claim"]["total_time"]


def test_what_lies_outside_the_bounds_contradicts_a_certificate(tried: list[Tried]) -> None:
    """With b2 and α far below their ranges some runs are slower than the slowest inside them."""
    certificate, runs, rows = tried[0]
    slow = Truth(alpha=(0.2, 0.2), b2=0.2, outside_bounds=True)
    given = [msgspec.structs.replace(run, truth=slow) for run in runs[:64]]
    assert beyond(certificate, simulate_ensemble(given)) != []
    assert beyond(certificate, {name: values[:64] for name, values in rows.items()}) == []


def test_every_gain_is_at_either_end_and_varies_in_some_runs(tried: list[Tried]) -> None:
    for certificate, runs, _ in tried:
        given = certificate["assumptions"]
        for name, (low, high) in (("b2", given["b2"]), ("alpha", given["alpha"][1])):
            drawn = [run.truth.b2 if name == "b2" else run.truth.alpha[1] for run in runs]
            constants = {signal.value for signal in drawn if isinstance(signal, Constant)}
            assert constants == {low, high}
            for kind in (Sine, Square, Adversary):
                assert sum(isinstance(signal, kind) for signal in drawn) > 0.1 * len(runs)
            waves = [signal for signal in drawn if isinstance(signal, Sine | Square)]
            assert all(wave.range == pytest.approx((low, high)) for wave in waves)


def test_a_run_can_be_replayed_alone(tried: list[Tried]) -> None:
    certificate, runs, rows = tried[0]
    again = runs_of(certificate, 8, 0)
    assert again == runs[:8]
    alone = simulate_ensemble([again[5]])
    for name in ("total", "peak_tau1", "max_x2", "x1"):
        assert np.array_equal(alone[name], rows[name][5:6], equal_nan=True), name
