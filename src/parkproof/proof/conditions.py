"""The paper's sufficient conditions on the gains: (15)-(17) of Step 2 and (18)-(19) of Step 3.

Each condition is ``value < 0``. Its value is a sum of positive terms and of one negative term,
which alone rests on the gain chosen last: −l1 in (15), −l2/k1 in (16), −l3/k2 in (17), −3k̃1/4 in
(18), −k̃3/k̃2 in (19). The weights k1, k2 and k̃2 occur in the Lyapunov functions alone, not in the
laws. Values are computed in floating point, so a relative margin near 1e-15 says nothing.

Abbreviations in the formulas: q is q1 in Step 2 and q2 in Step 3, A = alpha_max, p = 2^(1-q),
c = 1+q, m = l1^(1/q-1), L1 = l1^(1/q), L2 = l2^(1/(2q-1)), G = (3-2q) L2/(q c), K1 = k1t^(1/q),
W = 2^q as printed and 1 in the sharp form; k1t, k2t, k3t are k̃1, k̃2, k̃3.
"""

import math
from dataclasses import dataclass

from parkproof.errors import InputError
from parkproof.proof.gains import Form, Step2Gains, Step3Gains
from parkproof.validate import positive

Parts = tuple[float, float, float]
"""(a, b, d) of a sum a + b/k1 + d/k2."""

Row = tuple[float, ...]
Table = tuple[tuple[str, str, str, tuple[tuple[str, str], ...]], ...]


@dataclass(frozen=True)
class Term:
    """One term of a condition.

    Parameters
    ----------
    formula : str
        The term in the abbreviations of this module.
    value : float
        Its value.

    Examples
    --------
    >>> from parkproof.proof.conditions import Term
    >>> Term("-l1", -2.0).value
    -2.0
    """

    formula: str
    value: float


@dataclass(frozen=True)
class Condition:
    """One sufficient condition, value < 0, with its terms.

    Parameters
    ----------
    name : str
        The paper's equation number, for example ``(15)``.
    meaning : str
        What the value is in the proof.
    form : Form
        The form it was evaluated in.
    terms : tuple of Term
        Its terms, the negative one first.

    Examples
    --------
    >>> from parkproof.proof.conditions import Condition, Term
    >>> from parkproof.proof.gains import Form
    >>> two = Condition("(0)", "an example", Form.SHARP, (Term("-a", -3.0), Term("b", 2.0)))
    >>> two.formula, two.value, two.holds, two.margin, two.relative_margin
    ('-a + b', -1.0, True, 1.0, 0.5)
    """

    name: str
    meaning: str
    form: Form
    terms: tuple[Term, ...]

    @property
    def formula(self) -> str:
        """The value as a formula, in the abbreviations of this module."""
        return " + ".join(term.formula for term in self.terms)

    @property
    def value(self) -> float:
        """Sum of the terms; the condition asks that it be negative."""
        return math.fsum(term.value for term in self.terms)

    @property
    def holds(self) -> bool:
        """Whether value < 0."""
        return self.value < 0.0

    @property
    def margin(self) -> float:
        """−value: positive if the condition holds."""
        return -self.value

    @property
    def relative_margin(self) -> float:
        """The margin over the sum of the positive terms: how much these could grow together."""
        return self.margin / math.fsum(term.value for term in self.terms[1:])

    @property
    def dominant(self) -> Term:
        """The largest positive term."""
        return max(self.terms[1:], key=lambda term: term.value)


# Per condition: number, meaning, negative term, and each positive term with what divides it.
_STEP2: Table = (
    ("(15)", "coefficient of |x1|^(1+q1) in the bound on dV3/dt", "-l1", (
        ("p/c", ""), ("A q (2-q) p l1 L1/c", "k1"), ("A q (3-2q) p^2 l1 L1 L2/c", "k2"),
        ("G (1-q) p^2 m l2", "k2"), ("G (1-q) p^4 m", "k2"),
    )),
    ("(16)", "coefficient of |xi1|^(1+q1) in the bound on dV3/dt", "-l2/k1", (
        ("p q/c", ""), ("A (2-q) L1 p l1/c", "k1"), ("A (2-q) L1 p^2", "k1"),
        ("(2-q) p^2/c", "k1"), ("A q (3-2q) p^3 L1 L2/c", "k2"), ("G (2q-1) p^2 m l2", "k2"),
        ("W G q p^2 l2", "k2"), ("W G (1-q) p^4", "k2"),
    )),
    ("(17)", "coefficient of |xi2|^(1+q1) in the bound on dV3/dt", "-l3/k2", (
        ("(2q-1) p^2/c", "k1"), ("A (3-2q) L1 L2 p^2 l1/c", "k2"),
        ("A (3-2q) L1 L2 p^3/c", "k2"), ("G p^2 m l2", "k2"), ("W G p^2 l2", "k2"),
        ("2q G p^4 m", "k2"), ("2q W G p^4", "k2"),
    )),
)  # fmt: skip
_X0 = "coefficient of |x0|^(1+q2) in the bound on Step 3's dV/dt"
_XI = "coefficient of |xi|^(1+q2) in the bound on Step 3's dV/dt"
_STEP3: Table = (
    ("(18)", _X0, "-(3/4) k1t", (("A p k1t K1/4", "k2t"),)),
    ("(19)", _XI, "-k3t/k2t", (
        ("(p q/c) (2^(3-q)/(c k1t))^(1/q)", ""),
        ("A (2-q) p k1t K1 (4 q (2-q)/c)^q/c", "k2t"), ("A (2-q) p^2 K1", "k2t"),
    )),
)  # fmt: skip
_STEP3_UNTUNED: Table = (
    ("(18')", _X0, "-k1t", (("p/c", ""), ("A q (2-q) p k1t K1/c", "k2t"))),
    ("(19')", _XI, "-k3t/k2t", (
        ("p q/c", ""), ("A (2-q) p k1t K1/c", "k2t"), ("A (2-q) p^2 K1", "k2t"),
    )),
)  # fmt: skip


def _step2_rows(q: float, l1: float, l2: float, A: float, form: Form) -> tuple[Row, Row, Row]:
    """Positive terms of (15)-(17) without the division by k1 or k2, in the order of _STEP2."""
    p, c, r = 2.0 ** (1.0 - q), 1.0 + q, 3.0 - 2.0 * q
    # W stands on the xi1 part of |x2|^(1/q-1): subadditivity gives 1, the paper prints 2^q.
    W = 2.0**q if form == Form.PRINTED else 1.0
    m, L1, L2 = l1 ** (1.0 / q - 1.0), l1 ** (1.0 / q), l2 ** (1.0 / (2.0 * q - 1.0))
    p2, G = p * p, r * L2 / (q * c)
    return (
        (p / c, A * q * (2.0 - q) * p * l1 * L1 / c, A * q * r * p2 * l1 * L1 * L2 / c,
         G * (1.0 - q) * p2 * m * l2, G * (1.0 - q) * p2 * p2 * m),
        (p * q / c, A * (2.0 - q) * L1 * p * l1 / c, A * (2.0 - q) * L1 * p2,
         (2.0 - q) * p2 / c, A * q * r * p2 * p * L1 * L2 / c,
         G * (2.0 * q - 1.0) * p2 * m * l2, W * G * q * p2 * l2, W * G * (1.0 - q) * p2 * p2),
        ((2.0 * q - 1.0) * p2 / c, A * r * L1 * L2 * p2 * l1 / c, A * r * L1 * L2 * p2 * p / c,
         G * p2 * m * l2, W * G * p2 * l2, 2.0 * q * G * p2 * p2 * m,
         2.0 * q * W * G * p2 * p2),
    )  # fmt: skip


def _step3_rows(q: float, k1t: float, A: float, form: Form) -> tuple[Row, Row]:
    """Positive terms of (18)-(19) without the division by k̃2, in the order of their table."""
    p, c, K1 = 2.0 ** (1.0 - q), 1.0 + q, k1t ** (1.0 / q)
    cross, last = A * (2.0 - q) * p * k1t * K1, A * (2.0 - q) * p * p * K1
    if form == Form.UNTUNED:
        return (p / c, q * cross / c), (p * q / c, cross / c, last)
    young = (2.0 ** (3.0 - q) / (c * k1t)) ** (1.0 / q)
    tuned = (4.0 * q * (2.0 - q) / c) ** q
    return (A * p * k1t * K1 / 4.0,), (p * q / c * young, cross / c * tuned, last)


def step2_parts(
    q1: float, l1: float, l2: float, *, alpha_max: float, form: Form
) -> tuple[Parts, Parts, Parts]:
    """Sum the positive terms of (15), (16), (17) by the weight that divides them.

    With sums (a, b, d) the conditions read a + b/k1 + d/k2 < l1, < l2/k1 and < l3/k2: the shape
    that the searches choose gains from. Arguments are not checked here.

    Parameters
    ----------
    q1, l1, l2 : float
        Exponent and gains.
    alpha_max : float
        Upper bound of α2.
    form : Form
        ``PRINTED`` or ``SHARP``.

    Returns
    -------
    tuple of tuple of float
        (a, b, d) for each of the three conditions.

    Examples
    --------
    >>> from parkproof.proof.conditions import step2_parts
    >>> from parkproof.proof.gains import Form
    >>> parts = step2_parts(9 / 11, 2.0, 4.2, alpha_max=1.5, form=Form.SHARP)
    >>> [round(part, 3) for part in parts[0]]
    [0.624, 4.222, 65.79]
    """
    r15, r16, r17 = _step2_rows(q1, l1, l2, alpha_max, form)
    return (
        (r15[0], r15[1], math.fsum(r15[2:])),
        (r16[0], math.fsum(r16[1:4]), math.fsum(r16[4:])),
        (0.0, r17[0], math.fsum(r17[1:])),
    )


def step3_parts(
    q2: float, k1_tilde: float, *, alpha_max: float, form: Form
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Sum the positive terms of (18), (19): those not divided by k̃2, and those divided by it.

    With sums (a, b) the conditions read a + b/k̃2 < 3k̃1/4 (untuned: < k̃1) and < k̃3/k̃2.
    Arguments are not checked here.

    Parameters
    ----------
    q2, k1_tilde : float
        Exponent and gain.
    alpha_max : float
        Upper bound of α1.
    form : Form
        ``PRINTED`` or ``UNTUNED``.

    Returns
    -------
    tuple of tuple of float
        (a, b) for each of the two conditions.

    Examples
    --------
    >>> from parkproof.proof.conditions import step3_parts
    >>> from parkproof.proof.gains import Form
    >>> first, second = step3_parts(7 / 9, 1.5, alpha_max=1.5, form=Form.PRINTED)
    >>> [round(part, 3) for part in first]
    [0.0, 1.105]
    """
    r18, r19 = _step3_rows(q2, k1_tilde, alpha_max, form)
    return (math.fsum(r18[:-1]), r18[-1]), (r19[0], r19[1] + r19[2])


def check_conditions(
    gains: Step2Gains | Step3Gains, *, alpha_max: float, form: str = Form.PRINTED
) -> tuple[Condition, ...]:
    """Evaluate (15)-(17) for gains of Step 2, or (18)-(19) for gains of Step 3.

    Parameters
    ----------
    gains : Step2Gains or Step3Gains
        The gains and weights.
    alpha_max : float
        Upper bound of α2 (Step 2) or of α1 (Step 3), positive.
    form : Form or str, optional
        ``printed`` (both steps), ``sharp`` (Step 2), ``untuned`` (Step 3).

    Returns
    -------
    tuple of Condition
        Three conditions for Step 2, two for Step 3.

    Raises
    ------
    InputError
        If alpha_max or the form is not allowed, or a term exceeds the range of floats.

    Examples
    --------
    The gains of the paper's simulation violate the paper's conditions:

    >>> from parkproof.proof.conditions import check_conditions
    >>> from parkproof.proof.gains import Step2Gains
    >>> gains = Step2Gains(q1=9 / 11, l1=2.0, l2=4.2, l3=21.0, k1=2.4, k2=17.5)
    >>> for condition in check_conditions(gains, alpha_max=1.5):
    ...     print(condition.name, round(condition.value, 2), condition.dominant.formula)
    (15) 4.14 (A q (3-2q) p^2 l1 L1 L2/c)/k2
    (16) 11.35 (W G q p^2 l2)/k2
    (17) 16.63 (W G p^2 l2)/k2
    """
    A = positive("alpha_max", alpha_max, example=1.5)
    chosen = form_of(form, type(gains))
    table: Table
    rows: tuple[Row, ...]
    negative: tuple[float, ...]
    try:
        if isinstance(gains, Step2Gains):
            table, by = _STEP2, {"": 1.0, "k1": gains.k1, "k2": gains.k2}
            rows = _step2_rows(gains.q1, gains.l1, gains.l2, A, chosen)
            negative = (gains.l1, gains.l2 / gains.k1, gains.l3 / gains.k2)
        else:
            table = _STEP3_UNTUNED if chosen is Form.UNTUNED else _STEP3
            by = {"": 1.0, "k2t": gains.k2_tilde}
            rows = _step3_rows(gains.q2, gains.k1_tilde, A, chosen)
            part = 1.0 if chosen is Form.UNTUNED else 0.75
            negative = (part * gains.k1_tilde, gains.k3_tilde / gains.k2_tilde)
        conditions = tuple(
            Condition(name, meaning, chosen, (
                Term(minus, -size),
                *(Term(f"({formula})/{weight}" if weight else formula, value / by[weight])
                  for value, (formula, weight) in zip(row, labels, strict=True)),
            ))
            for (name, meaning, minus, labels), size, row in zip(table, negative, rows, strict=True)
        )  # fmt: skip
        in_range = all(math.isfinite(condition.value) for condition in conditions)
    except (OverflowError, ValueError):  # of a power, or of a sum that holds inf - inf
        in_range = False
    if not in_range:
        raise InputError(
            f"{gains}: a term of the conditions exceeds the largest float, 1.8e308; "
            "write gains between 1e-9 and 1e9"
        )
    return conditions


def form_of(form: str, kind: type[Step2Gains] | type[Step3Gains]) -> Form:
    """Return the form that a word names, if the conditions of that step have it.

    Parameters
    ----------
    form : Form or str
        The word.
    kind : type
        `Step2Gains` or `Step3Gains`.

    Returns
    -------
    Form
        The form.

    Raises
    ------
    InputError
        If the step has no such form.

    Examples
    --------
    >>> from parkproof.proof.conditions import form_of
    >>> from parkproof.proof.gains import Step2Gains
    >>> form_of("sharp", Step2Gains)
    <Form.SHARP: 'sharp'>
    """
    step, other = ("2", Form.SHARP) if kind is Step2Gains else ("3", Form.UNTUNED)
    for known in (Form.PRINTED, other):
        if form == known:
            return known
    raise InputError(
        f'form = {form!r}: Step {step} has the forms "printed" and "{other}"; '
        'write for example form = "printed"'
    )
