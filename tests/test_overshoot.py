"""The return: where the gains prove that x0 does not pass 0 on its way, and only there."""

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")

from flint import arb

from parkproof.bounds import Bounds
from parkproof.laws.gains import Gains
from parkproof.proof.checker.certificate import digest_of, why_not
from parkproof.proof.checker.chains import TwoChain
from parkproof.proof.checker.overshoot import never_passes_zero, reached
from parkproof.proof.whole_run import certify
from parkproof.report.measured import bounds_of, gains_of, start_at, switching_of
from parkproof.scenario import RunSettings, Scenario
from parkproof.simulation.run import simulate

Q = 7 / 9


def lowest_of_runs(k, *, lowest, highest, seed, count=400):
    """Least x of runs that begin with u >= 0, less min(x(0), 0), under gains that vary."""
    random = np.random.default_rng(seed)
    x, u = random.uniform(-1.0, 1.0, count), random.uniform(0.0, 1.0, count)
    floor, least, dt = np.minimum(x, 0.0), np.full(count, np.inf), 5e-4
    for step in range(12000):
        if step % 200 == 0:
            b = random.choice([lowest, highest], count)
            # what exceeds the nominal input is gamma and phi, which only help Theorem 1
            stronger = random.choice([1.0, 1.0, 3.0], count)
        xi = np.sign(u) * np.abs(u) ** (1.0 / Q) + k[0] ** (1.0 / Q) * x
        u = u - dt * stronger * k[1] * np.sign(xi) * np.abs(xi) ** (2.0 * Q - 1.0)
        x = x + dt * b * u
        least = np.minimum(least, x - floor)
    return least.min()


def test_what_is_proved_holds_in_runs_under_gains_that_vary():
    k = (1.5, 6.5)
    assert never_passes_zero(TwoChain("7/9", k, 2.6), arb("1.5"))
    assert lowest_of_runs(k, lowest=0.5, highest=1.5, seed=1) > -1e-3


def test_gains_that_pass_zero_are_not_proved():
    k = (1.5, 1.0)
    assert not never_passes_zero(TwoChain("7/9", k, 2.6), arb("1.5"))
    assert lowest_of_runs(k, lowest=0.5, highest=1.5, seed=1) < -0.05


def test_a_start_that_may_move_either_way_may_reach_both_sides():
    chain, x = TwoChain("7/9", (1.5, 6.5), 2.6), (arb("0.5"), arb(1))
    for u, said in (
        ((-1, 1), (-2, 2)),
        ((0, 1), (-0.25, 2)),
        ((-1, 0), (-2, 1)),
        ((0, 0), (-0.25, 1)),
    ):
        ends = tuple(arb(end) for end in u)
        low, high = reached(chain, arb("1.5"), arb(2), x, ends, rest=arb("0.25"))
        assert (float(low), float(high)) == pytest.approx(said)


def certified(u0):
    """Starts ahead of the goal with nothing to correct across, so that the law begins in Step 3."""
    gains = Gains(
        ellipsoid=(0.074812464, 0.066401839, 0.025390644, 0.079551713, 0.031872429, 0.018868936),
        feedback=(-3.8494493, -5.1332745, -2.6799631),
        lambda1=200.0,  # so that a run-up, which these starts do not need, is short
        direction="forward",
        return_steering=False,
    )
    starts = {"x0": (0.1, 0.3), "x1": (0.0, 0.0), "x2": (0.0, 0.0), "u0": u0, "u1": (0.0, 0.0)}
    found = certify(law="homogeneous", bounds=Bounds(), gains=gains, starts=starts)
    assert found.certificate is not None, found.reason
    return found.certificate


def test_a_robot_that_begins_the_return_at_rest_or_away_from_the_goal_stays_ahead():
    certificate = certified((0.0, 0.8))
    tolerance = certificate["law"]["tolerance"][1]
    assert -tolerance * 1.001 < certificate["claim"]["x0_range"][0] < 0.0


def test_a_robot_that_begins_the_return_toward_the_goal_is_not_taken_to_stay_ahead():
    certificate = certified((-2.0, 0.0))
    start = {"x0": 0.1, "x1": 0.0, "x2": 0.0, "u0": -2.0, "u1": 0.0}
    run = simulate(
        Scenario(
            law="homogeneous",
            bounds=bounds_of(certificate),
            gains=gains_of(certificate),
            switching=switching_of(certificate),
            start=start_at(start),
            run=RunSettings(duration=2.0, control_period=2e-3, discretisation="implicit"),
        )
    )
    passed = float(run.trajectory["x0"].min())
    low, high = certificate["claim"]["x0_range"]
    assert low < passed < -0.03
    # what the run contradicts is not proved, under a correct digest
    certificate["claim"]["x0_range"] = [0.9 * passed, high]
    certificate["digest"] = digest_of(certificate)
    assert why_not(certificate).startswith("x0_range")
