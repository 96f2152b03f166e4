"""V with squares: enclosures contain, rates are proved, and what is false is not."""

import random

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")

from flint import arb

from parkproof.proof.checker.balls import exact
from parkproof.proof.checker.chains import ThreeChain
from parkproof.proof.checker.lemmas import level_of, prove_rate, prove_sizes, seconds
from parkproof.proof.checker.squares import ThreeChainWithSquares
from parkproof.proof.lyapunov import ChainLyapunov
from parkproof.proof.states import ChainTerms

PAPER = (2.0, 4.2, 21.0)
K, S = (5.28691, 592.843), (0.0198731, 0.000742136)


def chain(w=None, s=S):
    return ThreeChainWithSquares("9/11", PAPER, K, w, s)


@pytest.mark.parametrize("w", [None, 1.0])
@pytest.mark.parametrize("radius", [0.0, 1e-6, 0.02, 0.3])
def test_boxes_enclose_the_values_at_their_points(w, radius):
    draw = random.Random(f"{w}{radius}")
    loop, cubes = chain(w), ChainLyapunov(gains=PAPER, q=9 / 11, k=K)
    weights = np.array([1.0, 1 / K[0], 1 / K[1], *S])
    for _ in range(60):
        middle = [draw.choice([draw.uniform(-1, 1), 0.0, 1.0, -1.0]) for _ in range(3)]
        b1, b2 = draw.uniform(0.3, 2.0), draw.uniform(0.8, 1.25)
        box = tuple(arb(x, radius) for x in middle)
        value, rate = loop.value_and_rate(box, exact(b1), exact(b2))
        inside = [np.array([x + radius * draw.uniform(-1, 1)]) for x in middle]
        terms = ChainTerms(PAPER, 9 / 11, cubes.state_at(*inside), squares=True)
        plain = float((weights @ terms.values(b1 if w is None else None))[0])
        slope = float((weights @ terms.rates((b1, b2), constant=w is None))[0])
        assert value.overlaps(arb(plain, 1e-6))
        assert rate.overlaps(arb(slope, 1e-6))


def test_without_squares_it_is_the_papers():
    z = (arb(1), arb("0.3"), arb("-0.2"))
    plain = ThreeChain("9/11", PAPER, K, None).value_and_rate(z, arb("0.5"), arb(1))
    assert all(
        a.overlaps(b)
        for a, b in zip(
            plain, chain(s=(0.0, 0.0)).value_and_rate(z, arb("0.5"), arb(1)), strict=True
        )
    )


def test_the_value_is_the_same_on_boxes_and_at_states():
    z = (exact(1.0), exact(0.25), exact(-0.5))
    loop = chain()
    y, _ = loop.coordinates(z)
    assert loop.value(y, exact(0.5)).overlaps(loop.value_and_rate(z, exact(0.5), exact(1.0))[0])


def test_published_gains_settle_within_one_and_a_half_times_what_runs_take():
    """The slowest undisturbed run from (1, 0, 0) takes 4.9 s, at b1 = 0.5."""
    loop, rate = chain(), 1.65
    assert prove_rate(loop, rate, [(0.5, 1.5), (1.0, 1.0)]) > 0
    box = [(arb(-1), arb(1)), (arb(0), arb(0)), (arb(0), arb(0))]
    assert all(seconds(loop, rate, level_of(loop, box, b1), arb(0)) < 7.2 for b1 in (0.5, 1.5))


def test_a_rate_that_is_false_is_not_proved():
    assert prove_rate(chain(), 2.5, [(1.5, 1.5), (1.0, 1.0)]) == 0


def test_sizes_on_sublevel_sets_are_proved():
    assert prove_sizes(chain(), (4.0, 60.0, 4000.0, 3000.0), 1.5) > 0
    assert prove_sizes(chain(), (0.1, 60.0, 4000.0, 3000.0), 1.5) == 0
