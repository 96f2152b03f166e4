"""Proofs that no weights exist: found where there are none, refused where they prove nothing."""

import itertools
from dataclasses import replace

import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")
pytest.importorskip("scipy", reason="needs parkproof[proof]")

from parkproof.laws.gains import Gains
from parkproof.proof.lyapunov import ChainLyapunov
from parkproof.proof.not_certifiable import Witness, no_weights_exist, refute
from parkproof.proof.weights import best_weights

FIVE_SEVENTHS = Gains(q1="5/7")
TWO_STATES = (
    Witness((0.5625, 1.0, 0.0), 1.5, 1.0, 0.5625),
    Witness((0.0, 0.75, 1.0), 1.5, 1.0, 0.4375),
)


def test_two_states_rule_out_the_published_gains_at_five_sevenths():
    assert refute(TWO_STATES, FIVE_SEVENTHS, varies=False)


def test_at_one_of_the_two_states_v_grows_whatever_the_weights():
    for k in itertools.product((1e-3, 0.1, 1.0, 10.0, 1e3), (1e-3, 1.0, 1e3, 1e6)):
        V = ChainLyapunov(gains=FIVE_SEVENTHS.l, q=5 / 7, k=k)
        rates = [V.rate(*map(float, V.state_at(*w.cube)), alpha=w.b1) for w in TWO_STATES]
        assert max(rates) > 0.0


@pytest.mark.parametrize("varies", [False, True])
def test_no_weights_are_shown_not_to_exist_for_one_b1_or_many(varies):
    for b1 in ((1.0, 1.0), (0.5, 1.5)):
        witnesses = no_weights_exist(FIVE_SEVENTHS, b1=b1, varies=varies)
        assert 2 <= len(witnesses) <= 3
        assert refute(witnesses, FIVE_SEVENTHS, varies=varies)


def test_squares_do_not_rescue_five_sevenths():
    for b1 in ((1.0, 1.0), (1.5, 1.5)):
        witnesses = no_weights_exist(FIVE_SEVENTHS, b1=b1, varies=False, squares=True)
        assert 2 <= len(witnesses) <= 5
        assert refute(witnesses, FIVE_SEVENTHS, varies=False, squares=True)


def test_two_states_do_not_rule_out_squares():
    assert not refute(TWO_STATES, FIVE_SEVENTHS, varies=False, squares=True)


def test_published_gains_are_ruled_out_where_b2_is_uncertain():
    gains = Gains(q1="9/11")
    witnesses = no_weights_exist(gains, b1=(0.5, 1.5), b2=(0.8, 1.25), varies=False)
    assert witnesses
    assert {w.b2 for w in witnesses} == {0.8, 1.25}


@pytest.mark.parametrize("l3", [4.2, 4.5, 4.6, 5.0])
def test_weights_are_found_or_shown_not_to_exist(l3):
    gains = Gains(l=(1.0, 1.775, l3))
    _, rate = best_weights(gains, b1=(0.5, 1.5), varies=False)
    assert bool(no_weights_exist(gains, b1=(0.5, 1.5), varies=False)) == (rate < 0.0)


def test_witnesses_prove_nothing_for_gains_that_have_weights():
    assert not refute(TWO_STATES, Gains(q1="9/11"), varies=False)


@pytest.mark.parametrize(
    "change", [{"multiplier": 0.0}, {"multiplier": -1.0}, {"b1": 0.0}, {"b2": -1.0}, {"b1": 0.1}]
)
def test_a_changed_witness_is_refused(change):
    assert not refute(
        [replace(TWO_STATES[0], **change), TWO_STATES[1]], FIVE_SEVENTHS, varies=False
    )


def test_fewer_witnesses_or_none_are_refused():
    for few in ((), TWO_STATES[:1], TWO_STATES[1:]):
        assert not refute(few, FIVE_SEVENTHS, varies=False)
