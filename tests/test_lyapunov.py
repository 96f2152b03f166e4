import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parkproof.errors import InputError
from parkproof.laws.chains import power_integrator_law
from parkproof.laws.gains import Gains
from parkproof.proof.integrals import power_integrals
from parkproof.proof.lyapunov import (
    ChainLyapunov,
    settling_bound,
    step2_lyapunov,
    step3_lyapunov,
)
from parkproof.proof.sphere import worst_ratio

ALPHA = (0.5, 1.5)
PASSING = {"9/11": (4.28, 311.0), "13/15": (2.71, 79.6)}
PUBLISHED = Gains(q1="9/11", q2="3/5", l=(2.0, 4.2, 21.0), k=(1.5, 6.5))
V3 = step2_lyapunov(PUBLISHED, k=PASSING["9/11"])
V_STEP3 = step3_lyapunov(PUBLISHED, k=2.6)

entry = st.one_of(st.just(0.0), st.floats(-20.0, 20.0).filter(lambda x: abs(x) > 1e-3))
scales = st.floats(-6.0, 6.0).map(math.exp)
alphas = st.floats(*ALPHA)
chains = st.sampled_from(
    [V3, V_STEP3, step2_lyapunov(PUBLISHED, k=(2.4, 1.75), constant_alpha=False)]
)


def step2(q, k):
    return step2_lyapunov(Gains(q1=q, l=(2.0, 4.2, 21.0)), k=k)


def spow(x, p):
    return math.copysign(abs(x) ** p, x)


def integral_of(function, a, b, breaks):
    """Gauss-Legendre on a mesh that narrows towards the ends and towards the breaks."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    edges = np.sort(np.r_[0.0, 0.5 ** np.arange(60), 1.0 - 0.5 ** np.arange(1, 50)])
    marks = sorted({a, b, *(x for x in breaks if min(a, b) < x < max(a, b))})
    total = 0.0
    for low, high in itertools.pairwise(marks):
        left, right = low + (high - low) * edges[:-1, None], low + (high - low) * edges[1:, None]
        total += float((function((left + right + (right - left) * nodes) / 2.0)
                        * weights * (right - left) / 2.0).sum())  # fmt: skip
    return total if b > a else -total


def plain_value(state, alpha, q, l, k):  # noqa: E741
    """V as paper.md section 3 prints it, for two or three integrators."""

    def power(x, p):
        return np.sign(x) * np.abs(x) ** p

    target = -l[0] * spow(state[0], q)
    value = state[0] ** 2 / (2 * alpha) + (1 / k[0]) * integral_of(
        lambda s: power(power(s, 1 / q) - spow(target, 1 / q), 2 - q), target, state[1], (0.0,)
    )
    if len(state) == 2:
        return value
    e = 2 * q - 1
    target = -l[1] * spow(spow(state[1], 1 / q) + l[0] ** (1 / q) * state[0], e)
    return value + (1 / k[1]) * integral_of(
        lambda s: power(power(s, 1 / e) - spow(target, 1 / e), 3 - 2 * q), target, state[2], (0.0,)
    )


def flow(lyapunov, state, alpha, h):
    """One step of order 4 of the nominal loop."""
    law = power_integrator_law(lyapunov.gains, q=lyapunov.q)

    def field(z):
        return [alpha * z[1], *z[2:], law(z)]

    def ahead(rate, by):
        return [x + by * r for x, r in zip(state, rate, strict=True)]

    k1 = field(state)
    k2 = field(ahead(k1, h / 2))
    k3 = field(ahead(k2, h / 2))
    k4 = field(ahead(k3, h))
    return ahead([a + 2 * b + 2 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True)], h / 6)


def run(lyapunov, state, alpha, *, duration, h=1e-3):
    rows = [list(state)]
    for _ in range(round(duration / h)):
        rows.append(flow(lyapunov, rows[-1], alpha, h))
    return np.array(rows).T


def dilated(lyapunov, state, scale):
    weights = [1.0, lyapunov.q, 2 * lyapunov.q - 1]
    return [x * scale**w for x, w in zip(state, weights, strict=False)]


@pytest.mark.parametrize("n", [0.35, 7 / 11, 0.95])
@pytest.mark.parametrize(
    "ends", [(-1.0, 2.0), (0.3, 1e-7), (1e-7, 5.0), (-3.0, -2.9), (2.0, 0.0), (-1e-6, 1.0)]
)
def test_integrals_agree_with_graded_gauss_quadrature(n, ends):
    start, end = ends
    low, high = spow(start, n), spow(end, n)
    breaks = (0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)

    def offset(s):
        return np.abs(np.sign(s) * np.abs(s) ** (1 / n) - start)

    first, second = power_integrals(np.array(start), np.array(end), n)
    expected = integral_of(lambda s: offset(s) ** (2 - n), low, high, breaks)
    assert first == pytest.approx(abs(expected), rel=1e-10)
    expected = integral_of(lambda s: offset(s) ** (1 - n), low, high, breaks)
    assert second == pytest.approx(expected, rel=1e-10)


@settings(max_examples=40, deadline=None)
@given(state=st.tuples(entry, entry, entry), alpha=alphas, three=st.booleans())
def test_value_is_the_paper_s_formula(state, alpha, three):
    lyapunov, given_state = (V3, state) if three else (V_STEP3, state[:2])
    expected = plain_value(given_state, alpha, lyapunov.q, lyapunov.gains, lyapunov.k)
    assert lyapunov.value(*given_state, alpha=alpha) == pytest.approx(expected, rel=1e-10)


@given(lyapunov=chains, state=st.tuples(entry, entry, entry), alpha=alphas)
def test_value_is_positive_away_from_the_origin_and_zero_there(lyapunov, state, alpha):
    state = state[: len(lyapunov.gains)]
    value = lyapunov.value(*state, alpha=alpha)
    assert value > 0.0 if any(state) else value == 0.0


@given(lyapunov=chains, state=st.tuples(entry, entry, entry), alpha=alphas, scale=scales)
def test_value_is_homogeneous_of_degree_2_and_rate_of_degree_1_plus_q(
    lyapunov, state, alpha, scale
):
    state = state[: len(lyapunov.gains)]
    far = dilated(lyapunov, state, scale)
    value = lyapunov.value(*state, alpha=alpha)
    rate = lyapunov.rate(*state, alpha=alpha)
    assert lyapunov.value(*far, alpha=alpha) == pytest.approx(scale**2 * value, rel=1e-9)
    assert lyapunov.rate(*far, alpha=alpha) == pytest.approx(
        scale ** (1 + lyapunov.q) * rate,
        rel=1e-8,
        abs=1e-8 * scale ** (1 + lyapunov.q) * value**lyapunov.exponent,
    )


@given(lyapunov=chains, state=st.tuples(entry, entry, entry), alpha=alphas)
def test_value_and_rate_are_even(lyapunov, state, alpha):
    state = state[: len(lyapunov.gains)]
    opposite = [-x for x in state]
    assert lyapunov.value(*opposite, alpha=alpha) == lyapunov.value(*state, alpha=alpha)
    assert lyapunov.rate(*opposite, alpha=alpha) == lyapunov.rate(*state, alpha=alpha)


@pytest.mark.parametrize("constant_alpha", [True, False])
@pytest.mark.parametrize(
    ("make", "weights", "size"), [(step2_lyapunov, (4.28, 3.11), 3), (step3_lyapunov, 2.6, 2)]
)
def test_rate_is_the_slope_of_the_value_along_the_flow(make, weights, size, constant_alpha):
    lyapunov = make(PUBLISHED, k=weights, constant_alpha=constant_alpha)
    random, h = np.random.default_rng(3), 2e-5
    for _ in range(30):
        state, alpha = list(random.uniform(-2.0, 2.0, size)), random.uniform(*ALPHA)
        after, before = (
            lyapunov.value(*flow(lyapunov, state, alpha, step), alpha=alpha) for step in (h, -h)
        )
        rate = lyapunov.rate(*state, alpha=alpha)
        assert (after - before) / (2 * h) == pytest.approx(rate, rel=1e-4, abs=1e-4)


def test_published_weights_let_the_value_grow_at_the_known_counterexample():
    assert step2("9/11", (2.4, 1.75)).rate(1.0, -2.0, -2.0, alpha=1.5) == pytest.approx(
        49.5, abs=0.05
    )


@pytest.mark.parametrize(("k2", "least"), [(1.75, 23.0), (17.5, 0.2)])
@pytest.mark.parametrize("q", ["5/7", "7/9", "9/11", "13/15", "17/19", "19/21"])
def test_published_weights_let_the_value_grow_somewhere(q, k2, least):
    lyapunov = step2(q, (2.4, k2))
    found = worst_ratio(lyapunov, alpha=ALPHA)
    assert found.ratio > least
    assert lyapunov.rate(*found.state, alpha=found.alpha) > 0.0


def test_published_weights_pass_for_larger_exponents():
    assert worst_ratio(step2("21/23", (2.4, 17.5)), alpha=ALPHA).ratio < 0.0


@pytest.mark.parametrize(
    ("q", "k", "ratio"),
    [
        ("7/9", (9.34, 1153.0), -0.2315),
        ("9/11", PASSING["9/11"], -1.2413),
        ("11/13", (3.01, 143.7), -1.5962),
        ("13/15", PASSING["13/15"], -1.7668),
        ("19/21", (3.52, 58.9), -1.9405),
    ],
)
def test_published_gains_pass_with_other_weights(q, k, ratio):
    assert worst_ratio(step2(q, k), alpha=ALPHA).ratio == pytest.approx(ratio, abs=2e-4)


def test_no_random_state_is_worse_than_the_worst_found():
    found = worst_ratio(V3, alpha=ALPHA)
    random = np.random.default_rng(5)
    cube = random.uniform(-1.0, 1.0, (3, 40_000))
    ratios = V3.decay_ratio(*V3.state_at(*cube), alpha=np.array([[0.5], [1.0], [1.5]]))
    assert found.ratio - 0.05 < ratios.max() <= found.ratio


def test_worst_ratio_hardly_depends_on_the_grid():
    coarse, dense = (worst_ratio(V3, alpha=ALPHA, points=n).ratio for n in (15, 81))
    assert coarse == pytest.approx(dense, abs=1e-6)


def test_worst_ratio_for_a_varying_alpha_agrees_with_the_theory():
    # The theory weighs x1²/2 by 20.6 and 1/k by (0.135, 11.4), where it proves c = 1.662.
    lyapunov = step2_lyapunov(PUBLISHED, k=(20.6 * 0.135, 20.6 * 11.4), constant_alpha=False)
    c = -worst_ratio(lyapunov, alpha=ALPHA).ratio * 20.6 ** (1.0 - lyapunov.exponent)
    assert 1.662 < c < 1.68


@pytest.mark.parametrize(("q2", "c"), [("3/5", 1.4967), ("7/9", 1.4853)])
def test_published_gains_of_step_3_pass_with_the_published_weight(q2, c):
    lyapunov = step3_lyapunov(Gains(q2=q2), k=2.6)
    assert worst_ratio(lyapunov, alpha=ALPHA).ratio == pytest.approx(-c, abs=1e-4)


@pytest.mark.parametrize(("u0", "bound"), [(0.0, 13.7), (1.0, 13.9)])
def test_bound_of_step_3_from_25_units(u0, bound):
    c = -worst_ratio(V_STEP3, alpha=ALPHA).ratio
    times = [
        settling_bound(V_STEP3.value(25.0, u0, alpha=alpha), c=c, exponent=V_STEP3.exponent)
        for alpha in ALPHA
    ]
    assert max(times) == pytest.approx(bound, abs=0.05)


@pytest.mark.parametrize(("q", "bound"), [("9/11", 9.7), ("13/15", 9.3)])
def test_bound_from_one_unit_agrees_with_the_theory(q, bound):
    lyapunov = step2(q, PASSING[q])
    c = -worst_ratio(lyapunov, alpha=ALPHA).ratio
    value = lyapunov.value(1.0, 0.0, 0.0, alpha=0.5)
    # The theory's bounds rest on its certified c, about half a percent below the sampled one.
    time = settling_bound(value, c=c, exponent=lyapunov.exponent)
    assert bound - 0.1 < time <= bound + 0.05


@pytest.mark.parametrize(("alpha", "settling_time"), [(0.5, 5.0), (1.0, 2.5), (1.5, 2.7)])
def test_nominal_step_2_settles_within_its_bound_and_the_value_decreases(alpha, settling_time):
    rows = run(V3, (1.0, 0.0, 0.0), alpha, duration=6.0)
    values = V3.value(*rows, alpha=alpha)
    # Below this size of V the sampling of the run, not the law, sets the rate.
    unsettled = int(np.flatnonzero(values > 1e-12)[-1]) + 1
    assert (np.diff(values[:unsettled]) < 0.0).all()
    ratios = V3.decay_ratio(*rows[:, :unsettled], alpha=alpha)
    c = -worst_ratio(V3, alpha=ALPHA).ratio
    assert ratios.max() <= -c
    settled = float(np.flatnonzero(np.abs(rows).max(axis=0) > 1e-4)[-1]) * 1e-3
    assert settled == pytest.approx(settling_time, abs=0.1)
    assert settled < settling_bound(values[0], c=c, exponent=V3.exponent)


def test_arrays_give_what_single_states_give():
    states = np.random.default_rng(7).uniform(-3.0, 3.0, (3, 5000))
    values, rates = V3.value(*states, alpha=1.5), V3.rate(*states, alpha=1.5)
    for at in (0, 4095, 4096, 4999):
        one = [float(x) for x in states[:, at]]
        assert isinstance(V3.value(*one, alpha=1.5), float)
        assert values[at] == pytest.approx(V3.value(*one, alpha=1.5), rel=1e-14)
        assert rates[at] == pytest.approx(V3.rate(*one, alpha=1.5), rel=1e-12)


def test_a_state_has_the_coordinates_it_was_made_from():
    x1, x2, u1 = V3.state_at(0.3, -0.7, 0.2)
    L1, L2 = 2.0 ** (11 / 9), 4.2 ** (11 / 7)
    xi1 = spow(float(x2), 11 / 9) + L1 * x1
    xi2 = spow(float(u1), 11 / 7) + L2 * xi1
    assert (x1, xi1 / L1, xi2 / (L1 * L2)) == pytest.approx((0.3, -0.7, 0.2))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: step2_lyapunov(PUBLISHED, k=(2.4, -1.0)), "k = -1.0: must be greater than 0"),
        (lambda: step2_lyapunov(PUBLISHED, k=(2.4,)), "3 gains and 1 weights"),
        (lambda: ChainLyapunov(gains=(2.0, 4.2, 21.0), q=0.6, k=(1.0, 1.0)), "must lie in (2/3"),
        (lambda: V3.value(1.0, 0.0, alpha=1.0), "state of 2 numbers"),
        (lambda: V3.value(math.nan, 0.0, 0.0, alpha=1.0), "give finite numbers"),
        (lambda: V3.rate(0.0, 0.0, 1e300, alpha=1.0), "give finite numbers"),
        (lambda: V3.value(1.0, 0.0, 0.0, alpha=0.0), "alpha = 0.0"),
        (lambda: V3.decay_ratio(0.0, 0.0, 0.0, alpha=1.0), "not defined at the origin"),
        (lambda: settling_bound(-1.0, c=1.0, exponent=0.5), "must not be negative"),
        (lambda: settling_bound(1.0, c=0.0, exponent=0.5), "c = 0.0"),
        (lambda: settling_bound(1.0, c=1.0, exponent=1.0), "must lie in (0, 1)"),
        (lambda: worst_ratio(V3, alpha=(1.5, 0.5)), "crossed"),
        (lambda: worst_ratio(V3, alpha=(0.0, 0.5)), "must be greater than 0"),
        (lambda: worst_ratio(V3, alpha=ALPHA, points=2), "points = 2"),
    ],
)
def test_bad_input_is_refused_in_one_line(call, words):
    with pytest.raises(InputError) as caught:
        call()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
