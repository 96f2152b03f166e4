"""The return: x0 stays on its side of 0 where the gains prove it, and only there."""

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")

from flint import arb

from parkproof.proof.checker.chains import TwoChain
from parkproof.proof.checker.overshoot import never_passes_zero, reached

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
