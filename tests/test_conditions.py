import itertools
import math
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parkproof.errors import InputError
from parkproof.proof.conditions import Condition, check_conditions, step2_parts, step3_parts
from parkproof.proof.gains import Form, Step2Gains, Step3Gains

EXPONENTS1 = [0.6667 + 0.3332 * i / 59 for i in range(60)]
gain = st.floats(0.05, 50.0)
q1s = st.floats(0.667, 0.999)
q2s = st.floats(0.501, 0.999)
alphas = st.floats(1e-3, 10.0)
step2_gains = st.builds(Step2Gains, q1=q1s, l1=gain, l2=gain, l3=gain, k1=gain, k2=gain)
step3_gains = st.builds(Step3Gains, q2=q2s, k1_tilde=gain, k2_tilde=gain, k3_tilde=gain)


def plain_step2(q, l1, l2, l3, k1, k2, a, w):
    """(15)-(17) as theory.md section 0 writes them; w = 1 is the sharp form, 2^q the printed."""
    c, big1, big2, m = 1 + q, l1 ** (1 / q), l2 ** (1 / (2 * q - 1)), l1 ** (1 / q - 1)
    k = (3 - 2 * q) * big2 / (k2 * q * c)
    v15 = (
        -l1 + 2 ** (1 - q) / c + a * (2 - q) * 2 ** (1 - q) * l1 * big1 * q / (k1 * c)
        + a * (3 - 2 * q) * q * 2 ** (2 - 2 * q) * l1 * big1 * big2 / (k2 * c)
        + k * (1 - q) * m * (2 ** (2 - 2 * q) * l2 + 2 ** (4 - 4 * q))
    )  # fmt: skip
    v16 = (
        2 ** (1 - q) * q / c - l2 / k1
        + a * (2 - q) * (big1 / k1) * (2 ** (1 - q) * l1 / c + 2 ** (2 - 2 * q))
        + (2 - q) * 2 ** (2 - 2 * q) / (k1 * c)
        + a * (3 - 2 * q) * q * 2 ** (3 - 3 * q) * big1 * big2 / (k2 * c)
        + k * (2 ** (2 - 2 * q) * m * l2 * (2 * q - 1) + w * 2 ** (2 - 2 * q) * l2 * q
               + w * 2 ** (4 - 4 * q) * (1 - q))
    )  # fmt: skip
    v17 = (
        (2 * q - 1) * 2 ** (2 - 2 * q) / (k1 * c) - l3 / k2
        + a * (3 - 2 * q) * (big1 * big2 / (k2 * c)) * (2 ** (2 - 2 * q) * l1 + 2 ** (3 - 3 * q))
        + k * (2 ** (2 - 2 * q) * (m + w) * l2 + 2 * q * (m + w) * 2 ** (4 - 4 * q))
    )  # fmt: skip
    return v15, v16, v17


def plain_step3(q, a, w, k3, amax):
    """(18)(19) as paper.md section 3 writes them."""
    k = (2 - q) * a ** (1 + 1 / q) * amax * 2 ** (1 - q) / w
    v18 = -(3 / 4) * a + k / (4 * (2 - q))
    v19 = (
        (2 ** (1 - q) * q / (1 + q)) * (2 ** (3 - q) / ((1 + q) * a)) ** (1 / q)
        + (k / (1 + q)) * (4 * q * (2 - q) / (1 + q)) ** q
        + (2 - q) * a ** (1 / q) * amax * 2 ** (2 - 2 * q) / w - k3 / w
    )  # fmt: skip
    return v18, v19


def plain_step3_untuned(q, a, w, k3, amax):
    """(18')(19') as theory.md section 0 writes them."""
    c = 1 + q
    v18 = -a + 2 ** (1 - q) / c + amax * (2 - q) * 2 ** (1 - q) * a ** (1 + 1 / q) * q / (w * c)
    v19 = (
        2 ** (1 - q) * q / c - k3 / w
        + amax * (2 - q) * (a ** (1 / q) / w) * (2 ** (1 - q) * a / c + 2 ** (2 - 2 * q))
    )  # fmt: skip
    return v18, v19


def close(condition: Condition, expected: float) -> bool:
    size = sum(abs(term.value) for term in condition.terms)
    return abs(condition.value - expected) <= 1e-12 * size


def published2(q1, k2=17.5, scale=(1.0,) * 5):
    k1, k2, l1, l2, l3 = (
        s * value for s, value in zip(scale, (2.4, k2, 2.0, 4.2, 21.0), strict=True)
    )
    return Step2Gains(q1=q1, l1=l1, l2=l2, l3=l3, k1=k1, k2=k2)


def published3(q2):
    return Step3Gains(q2=q2, k1_tilde=1.5, k2_tilde=2.6, k3_tilde=6.5)


@given(gains=step2_gains, alpha_max=alphas, form=st.sampled_from(["sharp", "printed"]))
def test_step2_agrees_with_a_plain_transcription(gains, alpha_max, form):
    w = 1.0 if form == "sharp" else 2**gains.q1
    expected = plain_step2(gains.q1, gains.l1, gains.l2, gains.l3, gains.k1, gains.k2, alpha_max, w)
    found = check_conditions(gains, alpha_max=alpha_max, form=form)
    assert [condition.name for condition in found] == ["(15)", "(16)", "(17)"]
    assert all(map(close, found, expected))


@given(gains=step3_gains, alpha_max=alphas, form=st.sampled_from(["printed", "untuned"]))
def test_step3_agrees_with_a_plain_transcription(gains, alpha_max, form):
    plain = plain_step3 if form == "printed" else plain_step3_untuned
    expected = plain(gains.q2, gains.k1_tilde, gains.k2_tilde, gains.k3_tilde, alpha_max)
    found = check_conditions(gains, alpha_max=alpha_max, form=form)
    assert all(map(close, found, expected))


def evaluate(formula: str, names: dict[str, float]) -> float:
    text = re.sub(r"(?<![a-zA-Z\d])(\d)q", r"\1*q", formula.replace("^", "**"))
    return eval(re.sub(r"(?<=[\w)]) (?=[\w(])", "*", text), {}, names)


@pytest.mark.parametrize("form", ["sharp", "printed", "untuned"])
def test_every_formula_evaluates_to_its_term(form):
    checks: list[tuple[Step2Gains | Step3Gains, dict[str, float]]] = []
    A = 1.3
    if form != "untuned":
        g = Step2Gains(q1=0.83, l1=1.7, l2=3.1, l3=11.0, k1=2.3, k2=17.0)
        q = g.q1
        names = {
            "q": q, "A": A, "p": 2 ** (1 - q), "c": 1 + q, "m": g.l1 ** (1 / q - 1),
            "L1": g.l1 ** (1 / q), "L2": g.l2 ** (1 / (2 * q - 1)), "l1": g.l1, "l2": g.l2,
            "l3": g.l3, "k1": g.k1, "k2": g.k2, "W": 2**q if form == "printed" else 1.0,
        }  # fmt: skip
        names["G"] = (3 - 2 * q) * names["L2"] / (q * names["c"])
        checks.append((g, names))
    if form != "sharp":
        h = Step3Gains(q2=0.71, k1_tilde=1.4, k2_tilde=2.9, k3_tilde=7.0)
        q = h.q2
        checks.append((h, {
            "q": q, "A": A, "p": 2 ** (1 - q), "c": 1 + q, "K1": h.k1_tilde ** (1 / q),
            "k1t": h.k1_tilde, "k2t": h.k2_tilde, "k3t": h.k3_tilde,
        }))  # fmt: skip
    for gains, values in checks:
        for condition in check_conditions(gains, alpha_max=A, form=form):
            for term in condition.terms:
                assert evaluate(term.formula, values) == pytest.approx(term.value)


def test_terms_make_up_the_condition():
    for condition in check_conditions(published2(9 / 11), alpha_max=1.5):
        negative, *positive = condition.terms
        assert negative.value < 0 < min(term.value for term in positive)
        total = math.fsum(term.value for term in positive)
        assert condition.value == pytest.approx(total + negative.value)
        assert condition.margin == -condition.value
        assert condition.relative_margin == pytest.approx(-negative.value / total - 1)
        assert condition.dominant.value == max(term.value for term in positive)
        assert condition.formula.count(" + ") >= len(positive)
        assert condition.holds is (condition.value < 0)


def test_parts_put_together_are_the_conditions():
    g = published2(9 / 11)
    for form in (Form.SHARP, Form.PRINTED):
        parts = step2_parts(g.q1, g.l1, g.l2, alpha_max=1.5, form=form)
        found = check_conditions(g, alpha_max=1.5, form=form)
        for (a, b, d), condition in zip(parts, found, strict=True):
            total = a + b / g.k1 + d / g.k2 + condition.terms[0].value
            assert condition.value == pytest.approx(total)
    h = published3(7 / 9)
    for form in (Form.PRINTED, Form.UNTUNED):
        pairs = step3_parts(h.q2, h.k1_tilde, alpha_max=1.5, form=form)
        for (a, b), condition in zip(
            pairs, check_conditions(h, alpha_max=1.5, form=form), strict=True
        ):
            total = a + b / h.k2_tilde + condition.terms[0].value
            assert condition.value == pytest.approx(total)


@pytest.mark.parametrize(
    ("alpha_max", "theory"), [(1.5, (38.0, 64.9, 134.8)), (1e-12, (6.1, 43.4, 77.1))]
)
def test_theory_d1_numbers_belong_to_k2_1_75_and_to_a_third_form(alpha_max, theory):
    # theory.md's w = 2^((1-q)^2/q) lies between the sharp form's 1 and the printed 2^q.
    q = 9 / 11
    third = plain_step2(q, 2.0, 4.2, 21.0, 2.4, 1.75, alpha_max, 2 ** ((1 - q) ** 2 / q))
    assert third == pytest.approx(theory, abs=0.05)
    sharp, printed = (
        [c.value for c in check_conditions(published2(q, 1.75), alpha_max=alpha_max, form=form)]
        for form in ("sharp", "printed")
    )
    assert sharp[0] == printed[0] == pytest.approx(third[0])
    assert sharp[1] < third[1] < printed[1]
    assert sharp[2] < third[2] < printed[2]


@pytest.mark.parametrize("form", ["sharp", "printed"])
def test_published_gains_violate_16_for_every_exponent_and_reading(form):
    for q1, k1, k2 in itertools.product(EXPONENTS1, (0.1, 1.0, 10.0), (0.1, 1.0, 10.0)):
        gains = published2(q1, scale=(k1, k2, 1.0, 1.0, 1.0))
        condition = check_conditions(gains, alpha_max=1.5, form=form)[1]
        assert condition.value > 0.7


def test_no_decimal_point_reading_of_the_published_gains_satisfies_15_to_17():
    for scale in itertools.product((0.1, 1.0, 10.0), repeat=5):
        for q1 in EXPONENTS1[::3]:
            for k2 in (1.75, 17.5):
                found = check_conditions(published2(q1, k2, scale), alpha_max=1.5, form="sharp")
                assert not all(condition.holds for condition in found)


def test_published_gains_satisfy_18_and_violate_19_for_every_exponent():
    for q2 in [0.55 + 0.01 * i for i in range(45)]:
        first, second = check_conditions(published3(q2), alpha_max=1.5)
        assert first.holds
        assert second.value > 0.3


def test_untuned_form_judges_the_published_gains_differently():
    values = [c.value for c in check_conditions(published3(0.6), alpha_max=1.5, form="untuned")]
    assert values == pytest.approx([0.50, 2.72], abs=0.005)
    first, second = check_conditions(published3(0.95), alpha_max=1.5, form="untuned")
    assert first.name == "(18')"
    assert first.holds
    assert second.holds


@given(gains=step2_gains, alpha_max=alphas, more=st.floats(1.01, 10.0))
def test_l3_lowers_17_alone_and_alpha_raises_all(gains, alpha_max, more):
    fields = {name: getattr(gains, name) for name in ("q1", "l1", "l2", "k1", "k2")}
    larger = Step2Gains(l3=more * gains.l3, **fields)
    base = check_conditions(gains, alpha_max=alpha_max)
    with_l3 = check_conditions(larger, alpha_max=alpha_max)
    assert with_l3[:2] == base[:2]
    assert with_l3[2].value <= base[2].value
    for worse, better in zip(
        check_conditions(gains, alpha_max=more * alpha_max), base, strict=True
    ):
        assert worse.value >= better.value


@settings(max_examples=50)
@given(gains=step2_gains, alpha_max=alphas)
def test_sharp_is_never_above_printed(gains, alpha_max):
    for sharp, printed in zip(
        check_conditions(gains, alpha_max=alpha_max, form="sharp"),
        check_conditions(gains, alpha_max=alpha_max),
        strict=True,
    ):
        assert sharp.value <= printed.value


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("q1", 2 / 3), ("q1", 1.0), ("q1", math.nan), ("l1", 0.0), ("l2", -1.0), ("l3", math.inf),
        ("k1", math.nan), ("k2", "much"),
    ],
)  # fmt: skip
def test_bad_step2_gains_are_refused(field, value):
    good = {"q1": 9 / 11, "l1": 2.0, "l2": 4.2, "l3": 21.0, "k1": 2.4, "k2": 17.5}
    with pytest.raises(InputError, match=f"^{field} = "):
        Step2Gains(**{**good, field: value})


@pytest.mark.parametrize(
    ("field", "value"),
    [("q2", 0.5), ("q2", 1.0), ("k1_tilde", 0.0), ("k2_tilde", -2.0), ("k3_tilde", math.nan)],
)
def test_bad_step3_gains_are_refused(field, value):
    good = {"q2": 7 / 9, "k1_tilde": 1.5, "k2_tilde": 2.6, "k3_tilde": 6.5}
    with pytest.raises(InputError, match=f"^{field} = "):
        Step3Gains(**{**good, field: value})


@pytest.mark.parametrize(
    ("alpha_max", "form", "message"),
    [
        (0.0, "printed", "alpha_max = 0"),
        (math.nan, "printed", "alpha_max = nan"),
        (1.5, "untuned", 'Step 2 has the forms "printed" and "sharp"'),
        (1.5, "best", "form = 'best'"),
    ],
)
def test_bad_arguments_are_refused(alpha_max, form, message):
    with pytest.raises(InputError, match=message) as caught:
        check_conditions(published2(9 / 11), alpha_max=alpha_max, form=form)
    assert "\n" not in str(caught.value)


def test_step3_has_no_sharp_form():
    with pytest.raises(InputError, match="untuned"):
        check_conditions(published3(7 / 9), alpha_max=1.5, form="sharp")


@pytest.mark.parametrize("size", [1e200, 1e-300])
def test_gains_beyond_the_range_of_floats_are_refused(size):
    gains = Step2Gains(q1=9 / 11, l1=1e5, l2=1e200, l3=1.0, k1=size, k2=size)
    with pytest.raises(InputError, match="exceeds the largest float"):
        check_conditions(gains, alpha_max=1.5)
