"""Weights of the Lyapunov functions: found where there are any, and as good as is said."""

import itertools

import numpy as np
import pytest

pytest.importorskip("scipy", reason="needs parkproof[proof]")

from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.proof.lyapunov import ChainLyapunov, settling_bound, step3_lyapunov
from parkproof.proof.sphere import worst_ratio
from parkproof.proof.states import ChainTerms, SampledSphere
from parkproof.proof.weights import (
    best_weights,
    best_weights_two_chain,
    best_weights_with_squares,
)

PAPER = (2.0, 4.2, 21.0)


def step2(q1, weights, *, varies=False, gains=PAPER):
    exponent = Gains(q1=q1).exponents[1]
    return ChainLyapunov(gains=gains, q=exponent, k=weights, constant_alpha=not varies)


@pytest.mark.parametrize("constant", [True, False])
def test_terms_sum_to_the_lyapunov_function_and_its_rate(constant):
    state = np.random.default_rng(1).uniform(-2.0, 2.0, (3, 50))
    terms = ChainTerms(PAPER, 9 / 11, state)
    V = step2("9/11", (4.28, 311.0), varies=not constant)
    inverses = np.array([1.0, 1 / 4.28, 1 / 311.0])
    value = inverses @ terms.values(0.7 if constant else None)
    np.testing.assert_allclose(value, V.value(*state, alpha=0.7), rtol=1e-12)
    rate = inverses @ terms.rates((0.7, 1.0), constant=constant)
    np.testing.assert_allclose(rate, V.rate(*state, alpha=0.7), rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("constant", [True, False])
def test_the_rate_is_the_derivative_along_the_flow_when_b2_is_not_one(constant):
    q, b1, b2, h = 9 / 11, 0.7, 1.25, 1e-6
    rng = np.random.default_rng(2)
    x = rng.uniform(0.2, 2.0, (3, 40)) * rng.choice([-1.0, 1.0], (3, 40))
    L1, L2 = PAPER[0] ** (1 / q), PAPER[1] ** (1 / (2 * q - 1))

    def power(s, p):
        return np.copysign(np.abs(s) ** p, s)

    xi2 = power(x[2], 1 / (2 * q - 1)) + L2 * (power(x[1], 1 / q) + L1 * x[0])
    flow = np.array([b1 * x[1], b2 * x[2], -PAPER[2] * power(xi2, 3 * q - 2)])
    given = b1 if constant else None
    ahead, behind = (
        ChainTerms(PAPER, q, x + s * flow, squares=True).values(given) for s in (h, -h)
    )
    rates = ChainTerms(PAPER, q, x, squares=True).rates((b1, b2), constant=constant)
    assert len(rates) == 5
    for slope, row in zip((ahead - behind) / (2 * h), rates, strict=True):
        np.testing.assert_allclose(slope, row, rtol=1e-4, atol=1e-6 * np.abs(row).max())


@pytest.mark.parametrize(("q1", "rate"), [("7/9", 0.230), ("9/11", 1.24), ("13/15", 1.77)])
def test_the_published_gains_get_the_rates_of_the_notes_and_a_denser_search_agrees(q1, rate):
    weights, found = best_weights(Gains(q1=q1), b1=(0.5, 1.5), varies=False)
    assert found >= rate
    assert -worst_ratio(step2(q1, weights), alpha=(0.5, 1.5)).ratio == pytest.approx(
        found, rel=2e-3
    )


def test_weights_are_found_for_a_b1_that_varies_thirtyfold():
    weights, found = best_weights(Gains(q1="9/11"), b1=(0.05, 1.5), varies=True)
    assert found > 0.18
    V = step2("9/11", weights, varies=True)
    assert -worst_ratio(V, alpha=(0.05, 1.5)).ratio == pytest.approx(found, rel=2e-3)


def test_weights_are_found_where_they_are_a_narrow_set():
    """l3 = 4.57 is about the smallest gain that has any (l1 = 1, l2 = 1.78)."""
    _, found = best_weights(Gains(l=(1.0, 1.78, 4.57)), b1=(0.5, 1.5), varies=False)
    assert 0.0 < found < 0.02
    _, found = best_weights(Gains(l=(1.0, 1.78, 4.4)), b1=(0.5, 1.5), varies=False)
    assert found < 0.0


def test_published_gains_have_no_weights_where_b2_is_uncertain():
    _, found = best_weights(Gains(q1="9/11"), b1=(0.5, 1.5), b2=(0.8, 1.25), varies=False)
    assert found < 0.0


def test_the_rate_holds_inside_the_ranges_at_states_of_all_sizes():
    gains, b2 = Gains(q1="13/15"), (0.8, 1.25)
    weights, found = best_weights(gains, b1=(0.5, 1.5), b2=b2, varies=False)
    assert found > 0.1
    rng = np.random.default_rng(3)
    state = rng.normal(size=(3, 2000)) * 10.0 ** rng.uniform(-3, 3, 2000)
    q = gains.exponents[1]
    terms, inverses = ChainTerms(gains.l, q, state), np.array([1.0, *(1 / k for k in weights)])
    for b1, x in itertools.product((0.5, 0.8, 1.5), (0.8, 1.0, 1.25)):
        value = inverses @ terms.values(b1)
        rate = inverses @ terms.rates((b1, x), constant=True)
        assert (rate <= -0.999 * found * value ** (0.5 * (1 + q))).all()


def test_each_aim_is_reached_better_by_its_own_weights():
    def of(start):
        weights, rate = best_weights(Gains(q1="9/11"), b1=(0.5, 1.5), varies=False, start=start)
        V = step2("9/11", weights)
        return settling_bound(V.value(1.0, 0.0, 0.0, alpha=0.5), c=rate, exponent=V.exponent), rate

    (time, rate), (other_time, other_rate) = of((1.0, 0.0, 0.0)), of(None)
    assert time <= 1.0005 * other_time
    assert other_rate >= 0.9995 * rate
    assert time < 9.75


def test_a_start_at_rest_at_zero_asks_for_the_rate():
    found = [
        best_weights(Gains(), b1=(1.0, 1.0), varies=False, start=start)
        for start in (None, (0.0, 0.0, 0.0))
    ]
    assert found[0] == found[1]


@pytest.mark.parametrize("q", [3 / 5, 7 / 9])
def test_the_two_chains_weight_beats_others_near_and_far(q):
    k2, rate = best_weights_two_chain(k=(1.5, 6.5), q=q, a=(0.5, 1.5))
    assert rate > 1.0
    gains = Gains(q2=q, k=(1.5, 6.5))
    for factor in (0.5, 0.95, 1.05, 2.0):
        V = step3_lyapunov(gains, k=factor * k2, constant_alpha=False)
        assert -worst_ratio(V, alpha=(0.5, 1.5), points=401).ratio <= 1.001 * rate
    V = step3_lyapunov(gains, k=k2, constant_alpha=False)
    assert -worst_ratio(V, alpha=(0.5, 1.5), points=401).ratio == pytest.approx(rate, rel=1e-3)


@pytest.mark.parametrize(
    ("q1", "b2", "seconds"),
    [("9/11", (1.0, 1.0), 6.75), ("7/9", (1.0, 1.0), 9.3), ("9/11", (0.8, 1.25), 10.0)],
)
def test_squares_shorten_the_time_of_the_published_gains(q1, b2, seconds):
    q = Gains(q1=q1).exponents[1]
    found = best_weights_with_squares(Gains(q1=q1), b1=(0.5, 1.5), b2=b2, varies=False)
    start = ChainTerms(PAPER, q, [np.array([x]) for x in (1.0, 0.0, 0.0)], squares=True)
    value = np.array([1.0, 1 / found.k[0], 1 / found.k[1], *found.s]) @ start.values(0.5)
    assert settling_bound(float(value[0]), c=found.rate, exponent=0.5 * (1 + q)) < seconds


def test_squares_never_make_the_rate_worse():
    for q1, varies in itertools.product(("7/9", "19/21"), (False, True)):
        given = {"b1": (0.5, 1.5), "varies": varies, "start": None}
        plain = best_weights(Gains(q1=q1), **given)[1]
        assert best_weights_with_squares(Gains(q1=q1), **given).rate > 0.999 * plain


def test_zooming_never_loses_a_state():
    sphere = SampledSphere(step2("9/11", (1.0, 1.0)), [(0.5, 1.0), (1.5, 1.0)])
    count, inverses = sphere.cube.shape[1], np.array([1.0, 1 / 4.28, 1 / 311.0])
    before, after = sphere.add_worse(inverses)
    assert before <= after == sphere.worst(inverses)
    assert sphere.cube.shape[1] > count


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"b1": (1.5, 0.5)}, "crossed"),
        ({"b1": (0.0, 1.5)}, "b1's lower bound"),
        ({"b2": (-1.0, 1.0)}, "b2's lower bound"),
        ({"start": (1.0, 0.0)}, "three numbers"),
        ({"start": (1.0, float("nan"), 0.0)}, "start"),
    ],
)
def test_bad_ranges_and_starts_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        best_weights(Gains(), **{"b1": (0.5, 1.5), "varies": False, **change})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q": 0.5}, "q = 0.5"),
        ({"k": (1.5, -1.0)}, "gains"),
        ({"a": (0.0, 1.0)}, "a's lower bound"),
        ({"start": (1.0,)}, "two numbers"),
    ],
)
def test_bad_two_chains_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        best_weights_two_chain(**{"k": (1.5, 6.5), "q": 7 / 9, "a": (0.5, 1.5), **change})
