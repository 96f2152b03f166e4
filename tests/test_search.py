import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parkproof.errors import InputError
from parkproof.proof.conditions import check_conditions, step2_parts, step3_parts
from parkproof.proof.gains import Step2Gains
from parkproof.proof.remark3 import SearchOutcome, remark3_search
from parkproof.proof.search import remark4_search, sequential_search

q1s = st.floats(0.67, 0.999)
slacks = st.tuples(*[st.floats(1e-2, 1e2)] * 6)


def plain_step_a(q, l, a, k):  # noqa: E741
    """(44)-(49) with equality in the sharpest of each three, as the paper prints them."""
    p, c, e = 2 ** (1 - q), 1 + q, 2 * q - 1
    k1 = max(
        (2 - q) * p * a * q * l ** (1 + 1 / q) / (c * k[0]),
        (a * (2 - q) * l ** (1 / q) * (p * l / c + p**2) + (2 - q) * p**2 / c) / k[1],
        e * p**2 / (c * k[2]),
    )
    front = (3 - 2 * q) * l ** (1 / e) / (q * c)
    k2 = max(
        (front * (1 - q) * (p**2 * l ** (1 / q) + p**4 * l ** (1 / q - 1))
         + a * (3 - 2 * q) * q * p**2 * l ** (1 + 1 / q + 1 / e) / c) / k[3],
        (a * (3 - 2 * q) * q * p**3 * l ** (1 / q + 1 / e) / c
         + front * (p**2 * l ** (1 / q) * e + 2 ** (2 - q) * q * l
                    + 2 ** (4 - 3 * q) * (1 - q))) / k[4],
        (front * (p**2 * l ** (1 / q) + 2 ** (2 - q) * l + 2 ** (5 - 4 * q) * q * l ** (1 / q - 1)
                  + 2 ** (5 - 3 * q) * q)
         + a * (3 - 2 * q) * l ** (1 / q + 1 / e) / c * (p**2 * l + p**3)) / k[5],
    )  # fmt: skip
    return k1, k2, p / c + k[0] + k[3], k1 * (p * q / c + k[1] + k[4])


def plain_remark3(q, l, a, k, limit=200):  # noqa: E741
    """The printed loop, cut off; returns the l it stopped at, or None."""
    for _ in range(limit):
        _, _, l1_bar, l2_bar = plain_step_a(q, l, a, k)
        if max(l1_bar, l2_bar) < l * (1 - 1e-9):  # 1e-9: not by rounding at a fixed point
            return l
        l = max(l1_bar, l2_bar)  # noqa: E741
        if l > 1e20:
            return None
    return None


def complete(l1, k1, l2, *, form, q1=13 / 15, alpha_max=1.5):
    """The smallest k2 and l3 for given l1, k1, l2; infinite if there are none."""
    parts = step2_parts(q1, l1, l2, alpha_max=alpha_max, form=form)
    (a15, b15, d15), (a16, b16, d16), (_, b17, d17) = parts
    room15, room16 = l1 - a15 - b15 / k1, l2 / k1 - a16 - b16 / k1
    if room15 <= 0 or room16 <= 0:
        return math.inf, math.inf
    k2 = max(d15 / room15, d16 / room16)
    return k2, k2 * b17 / k1 + d17


@pytest.mark.parametrize(("form", "k2", "l3"), [("sharp", 451.0, 206.0), ("printed", 650.0, 287.0)])
def test_gains_of_the_paper_notes_hold_and_are_near_their_bounds(form, k2, l3):
    gains = Step2Gains(q1=13 / 15, l1=0.79, l2=5.1, l3=l3, k1=3.2, k2=k2)
    found = check_conditions(gains, alpha_max=1.5, form=form)
    assert all(condition.holds for condition in found)
    least_k2, _ = complete(0.79, 3.2, 5.1, form=found[0].form)
    assert least_k2 < k2 < 1.06 * least_k2
    tight = Step2Gains(q1=13 / 15, l1=0.79, l2=5.1, l3=0.99 * l3, k1=3.2, k2=k2)
    assert not check_conditions(tight, alpha_max=1.5, form=form)[2].holds


@pytest.mark.parametrize(
    ("form", "expected"),
    [
        ("sharp", (0.7735, 3.162, 4.992, 428.0, 196.3)),
        ("printed", (0.7722, 3.051, 4.962, 545.3, 263.8)),
    ],
)
def test_sequential_search_reaches_the_smallest_l3(form, expected):
    # The expected gains were found by another optimiser, Nelder-Mead from three starts.
    gains = sequential_search(13 / 15, alpha_max=1.5, margin=1e-6, form=form).gains
    found = (gains.l1, gains.k1, gains.l2, gains.k2, gains.l3)
    assert found == pytest.approx(expected, rel=1e-3)


@settings(max_examples=12, deadline=None)
@given(
    q1=q1s,
    alpha_max=st.floats(1e-3, 1e3),
    margin=st.floats(1e-6, 1.0),
    form=st.sampled_from(["sharp", "printed"]),
)
def test_sequential_search_satisfies_all_conditions(q1, alpha_max, margin, form):
    found = sequential_search(q1, alpha_max=alpha_max, margin=margin, form=form)
    assert found.conditions == check_conditions(found.gains, alpha_max=alpha_max, form=form)
    for condition in found.conditions:
        assert condition.holds
        assert condition.relative_margin >= margin * (1 - 1e-6)


@pytest.fixture(scope="module")
def smallest():
    return sequential_search(13 / 15, alpha_max=1.5, margin=1e-6, form="sharp").gains


@given(logs=st.tuples(*[st.floats(-1.0, 1.0)] * 3))
def test_no_other_gains_do_with_a_smaller_l3(smallest, logs):
    l1, k1, l2 = (
        value * math.exp(log)
        for value, log in zip((smallest.l1, smallest.k1, smallest.l2), logs, strict=True)
    )
    _, l3 = complete(l1, k1, l2, form="sharp")
    assert l3 >= smallest.l3 * (1 - 1e-5)


def test_sequential_search_is_deterministic():
    assert sequential_search(0.8, alpha_max=2.0) == sequential_search(0.8, alpha_max=2.0)


@pytest.mark.parametrize("q1", [0.67, 5 / 7, 7 / 9, 9 / 11, 13 / 15, 0.99])
@pytest.mark.parametrize("slack", [0.05, 0.6, 5.0])
def test_remark3_never_ends_for_the_paper_bounds(q1, slack):
    result = remark3_search(q1, alpha_max=1.5, slack=slack)
    assert result.outcome is SearchOutcome.DOES_NOT_TERMINATE
    assert result.found is None
    assert result.workable_l is None
    assert result.smallest_ratio > 1.0
    assert not result.some_slacks_work
    assert "no slacks change that" in result.reason
    assert result.passes[0].l == 4.5
    for one, following in zip(result.passes, result.passes[1:], strict=False):
        assert following.l == one.bound > one.l
    for one in result.passes:
        expected = plain_step_a(q1, one.l, 1.5, (slack,) * 6)
        assert (one.k1, one.k2, one.l1_bar, one.l2_bar) == pytest.approx(expected)
    *_, before, last = result.passes
    assert math.log(last.l2_bar / before.l2_bar) / math.log(last.l / before.l) == pytest.approx(
        result.growth_exponent, rel=0.02
    )


@settings(max_examples=60, deadline=None)
@given(q1=q1s, k=slacks, l=st.floats(0.1, 1e3), alpha_max=st.floats(1e-4, 3.0))
def test_remark3_agrees_with_the_printed_loop(q1, k, l, alpha_max):  # noqa: E741
    result = remark3_search(q1, alpha_max=alpha_max, slack=k, initial_l=l)
    stopped = plain_remark3(q1, l, alpha_max, k)
    assert (result.outcome is SearchOutcome.FEASIBLE) is (stopped is not None)
    if result.found is not None:
        assert stopped == l
        assert all(condition.holds for condition in result.found.conditions)
        assert result.workable_l is not None
        assert result.some_slacks_work
        assert result.workable_l[0] < l < result.workable_l[1]
    else:
        assert result.workable_l is None or not result.workable_l[0] * (
            1 + 1e-9
        ) < l < result.workable_l[1] * (1 - 1e-9)


def test_remark3_ends_for_a_small_alpha_and_a_fitting_first_l_only():
    low, high = remark3_search(13 / 15, alpha_max=0.01).workable_l
    assert (low, high) == pytest.approx((2.29568, 27.2355), rel=1e-5)
    for first in (1.001 * low, 4.5, 0.999 * high):
        result = remark3_search(13 / 15, alpha_max=0.01, initial_l=first)
        assert result.outcome is SearchOutcome.FEASIBLE
        assert len(result.passes) == 1
        assert all(condition.holds for condition in result.found.conditions)
    below = remark3_search(13 / 15, alpha_max=0.01, initial_l=0.5, max_passes=60)
    assert below.outcome is SearchOutcome.DOES_NOT_TERMINATE
    assert below.passes[-1].l == pytest.approx(low, rel=1e-6)
    assert "never exceeds 2.29568" in below.reason
    above = remark3_search(13 / 15, alpha_max=0.01, initial_l=1.001 * high, max_passes=60)
    assert above.outcome is SearchOutcome.DOES_NOT_TERMINATE
    assert "unbounded" in above.reason
    assert above.passes[-1].l > 1e3 * high
    # Here l1_bar is the larger bound: the loop lands on it, and an l1 between it and l is missing.
    stuck = remark3_search(9 / 11, alpha_max=0.01, slack=2.0)
    assert stuck.workable_l[0] == stuck.passes[-1].l == stuck.passes[-1].l1_bar
    assert stuck.outcome is SearchOutcome.DOES_NOT_TERMINATE


@pytest.mark.parametrize(("q1", "alpha_max"), [(13 / 15, 0.18), (0.99, 0.3), (0.75, 0.1)])
def test_some_slacks_do_work_when_the_result_says_so(q1, alpha_max):
    assert remark3_search(q1, alpha_max=alpha_max).some_slacks_work
    edge = 2 ** (1 - q1) / (1 + q1)
    tiny, best = 1e-6, []
    for i in range(1, 4000):
        first = edge * (1 + 0.002 * i)
        (_, b15, _), (_, b16, _), _ = step2_parts(
            q1, first, first, alpha_max=alpha_max, form="printed"
        )
        k11 = (first - edge) * (1 - 1e-4)
        best.append((first, (k11, b16 * k11 / b15, 1e3, tiny, tiny, 1.0)))
    assert any(plain_remark3(q1, first, alpha_max, k, limit=1) is not None for first, k in best)
    first, k = next(
        (first, k) for first, k in best if plain_remark3(q1, first, alpha_max, k, limit=1)
    )
    result = remark3_search(q1, alpha_max=alpha_max, slack=k, initial_l=first)
    assert result.outcome is SearchOutcome.FEASIBLE


@pytest.mark.parametrize("q1", [0.667, 0.7, 0.8, 0.9, 0.999])
@pytest.mark.parametrize("alpha_max", [0.5, 1.0, 1.5])
def test_no_slacks_work_from_alpha_one_half_on(q1, alpha_max):
    assert not remark3_search(q1, alpha_max=alpha_max).some_slacks_work


@settings(max_examples=50)
@given(
    q2=st.floats(0.501, 0.999),
    k1_tilde=st.floats(0.1, 20.0),
    alpha_max=st.floats(1e-2, 10.0),
    margin=st.floats(1e-6, 1.0),
)
def test_remark4_satisfies_18_and_19(q2, k1_tilde, alpha_max, margin):
    found = remark4_search(q2, k1_tilde, alpha_max=alpha_max, margin=margin)
    for condition in found.conditions:
        assert condition.holds
        assert condition.relative_margin == pytest.approx(margin, rel=1e-6, abs=1e-12)


def test_remark4_in_the_untuned_form_needs_a_k1_tilde_above_its_bound():
    found = remark4_search(7 / 9, 1.5, alpha_max=1.5, form="untuned")
    assert all(condition.holds for condition in found.conditions)
    (a18, _), _ = step3_parts(7 / 9, 1.5, alpha_max=1.5, form=found.conditions[0].form)
    with pytest.raises(InputError, match=r"k1_tilde = 0.6: .* k1_tilde = 1.33"):
        remark4_search(7 / 9, 0.6, alpha_max=1.5, form="untuned")
    assert a18 == pytest.approx(2 ** (2 / 9) / (16 / 9))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q1": 0.6}, "q1 = 0.6"),
        ({"q1": math.nan}, "q1 = nan"),
        ({"alpha_max": 0.0}, "alpha_max = 0.0"),
        ({"alpha_max": 1e7}, "alpha_max = .* between 1e-06 and 1e"),
        ({"slack": -0.6}, "slack k11 = -0.6"),
        ({"slack": (0.6, 0.6)}, "must be one number or six"),
        ({"initial_l": math.inf}, "initial_l = inf"),
    ],
)
def test_remark3_refuses_bad_input(change, message):
    with pytest.raises(InputError, match=message) as caught:
        remark3_search(**{"q1": 9 / 11, "alpha_max": 1.5, **change})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q1": 1.0}, "q1 = 1.0"),
        ({"alpha_max": -1.0}, "alpha_max = -1.0"),
        ({"margin": 0.0}, "margin = 0.0"),
        ({"form": "untuned"}, "form = 'untuned'"),
    ],
)
def test_sequential_search_refuses_bad_input(change, message):
    with pytest.raises(InputError, match=message):
        sequential_search(**{"q1": 9 / 11, "alpha_max": 1.5, **change})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q2": 0.5}, "q2 = 0.5"),
        ({"k1_tilde": 0.0}, "k1_tilde = 0.0"),
        ({"alpha_max": math.nan}, "alpha_max = nan"),
        ({"margin": -0.1}, "margin = -0.1"),
        ({"form": "sharp"}, "form = 'sharp'"),
    ],
)
def test_remark4_refuses_bad_input(change, message):
    with pytest.raises(InputError, match=message):
        remark4_search(**{"q2": 7 / 9, "k1_tilde": 1.5, "alpha_max": 1.5, **change})
