"""Searches for gains that satisfy (15)-(17) or (18)-(19): Remark 3, Remark 4, and one that works.

Remark 3 puts one number l for l1 and l2 into (15)-(17) and repeats until l is large enough. Write
f(l) = max(l̄1, l̄2(l)), with the smallest k1, k2 that (44)-(49) allow. Every term grows with l, so
f never decreases; hence l ≤ f(l) gives f(l) ≤ f(f(l)), and so on for ever:

    **Remark 3 stops at its first l, or never.**

(Stopping at l = f(l) would not help: Step b takes its l1 and l2 between l̄1, l̄2 and l.)

Where does l go? (44) alone gives l̄2 ≥ C l^(1+1/q1) with C > 0, faster than l. Let b15, b16 be the
k1-terms of (15), (16) at l1 = l2 = l, times k1, and p = 2^(1−q), c = 1+q, q = q1, A = alpha_max.
Step b needs l > l̄1 > p/c + k̄11, so (44) asks for k1 > b15/(l − p/c). With (45), for all slacks,

    l̄2(l) > k1 (p q/c + k̄12) > g(l) = (p q/c) b15/(l − p/c) + b16,

a bound that slacks can come as near to as one likes. If A ≥ 1 then g(l) > l for every l: b16
contains A (2−q) p² l^(1/q) + (2−q) p²/c, where the first is at least l for l ≥ 1 and at least
l^(3/2) for l < 1, the second more than 1/2, and l^(3/2) + 1/2 > l. So then no l works, for any q1
and any slacks. For smaller A the minimum of g(l)/l, convex in log l, is found numerically.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from parkproof.errors import InputError
from parkproof.laws.gains import exponent
from parkproof.proof.conditions import (
    Condition,
    Form,
    Step2Gains,
    Step3Gains,
    check_conditions,
    form_of,
    step2_parts,
    step3_parts,
)
from parkproof.validate import positive

Slacks = tuple[float, float, float, float, float, float]

_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_RANGE = (1e-6, 1e6)
_LARGEST_L = 1e12


class SearchOutcome(StrEnum):
    """How a search for gains ended.

    Attributes
    ----------
    FEASIBLE
        Gains were found, and the conditions were evaluated at them and hold.
    DOES_NOT_TERMINATE
        The algorithm as printed would run for ever; the reason says why.

    Examples
    --------
    >>> from parkproof.proof.search import SearchOutcome
    >>> SearchOutcome.DOES_NOT_TERMINATE.value
    'does not terminate'
    """

    FEASIBLE = "feasible"
    DOES_NOT_TERMINATE = "does not terminate"


@dataclass(frozen=True)
class Step2Found:
    """Gains of Step 2 that a search found.

    Parameters
    ----------
    gains : Step2Gains
        The gains and weights.
    conditions : tuple of Condition
        (15)-(17) evaluated at them; all hold.

    Examples
    --------
    >>> from parkproof.proof.search import sequential_search
    >>> sequential_search(9 / 11, alpha_max=1.5).conditions[2].name
    '(17)'
    """

    gains: Step2Gains
    conditions: tuple[Condition, ...]


@dataclass(frozen=True)
class Step3Found:
    """Gains of Step 3 that a search found.

    Parameters
    ----------
    gains : Step3Gains
        The gains and the weight.
    conditions : tuple of Condition
        (18)-(19) evaluated at them; both hold.

    Examples
    --------
    >>> from parkproof.proof.search import remark4_search
    >>> remark4_search(7 / 9, 1.5, alpha_max=1.5).conditions[1].name
    '(19)'
    """

    gains: Step3Gains
    conditions: tuple[Condition, ...]


@dataclass(frozen=True)
class Remark3Pass:
    """One pass through Step a of Remark 3.

    Parameters
    ----------
    l : float
        The number that stands for l1 and l2.
    k1, k2 : float
        The smallest weights that (44)-(46) and (47)-(49) allow.
    l1_bar, l2_bar : float
        The lower bounds l̄1 of l1 and l̄2 of l2.

    Examples
    --------
    >>> from parkproof.proof.search import Remark3Pass
    >>> Remark3Pass(l=4.5, k1=2.4, k2=17.5, l1_bar=1.8, l2_bar=4.1).bound
    4.1
    """

    l: float  # noqa: E741 - the paper's symbol
    k1: float
    k2: float
    l1_bar: float
    l2_bar: float

    @property
    def bound(self) -> float:
        """max(l̄1, l̄2), which l must exceed; otherwise the next l."""
        return max(self.l1_bar, self.l2_bar)


@dataclass(frozen=True)
class Remark3Result:
    """What Remark 3's algorithm does.

    Parameters
    ----------
    outcome : SearchOutcome
        How it ends.
    reason : str
        The same in one sentence, with numbers.
    passes : tuple of Remark3Pass
        The first passes through Step a.
    growth_exponent : float
        1 + 1/q1, the power of l with which l̄2 grows.
    smallest_ratio : float
        The smallest l̄2(l)/l over l > l̄1, for the given slacks: from 1 up, there is no l with
        l̄2(l) < l.
    workable_l : tuple of float or None
        The open interval of first l with which it would terminate; None if there are none.
    some_slacks_work : bool
        Whether some other slacks, with a fitting first l, would make it terminate.
    found : Step2Found or None
        Verified gains, if it terminates.

    Examples
    --------
    >>> from parkproof.proof.search import remark3_search
    >>> result = remark3_search(9 / 11, alpha_max=1.5)
    >>> result.workable_l is None, result.some_slacks_work
    (True, False)
    """

    outcome: SearchOutcome
    reason: str
    passes: tuple[Remark3Pass, ...]
    growth_exponent: float
    smallest_ratio: float
    workable_l: tuple[float, float] | None
    some_slacks_work: bool
    found: Step2Found | None


def _minimum_beyond(low: float, function: Callable[[float], float]) -> tuple[float, float]:
    """Argument and value of the minimum over x > low of a function convex in log x."""
    left, width = math.log(low), 1.0
    while function(math.exp(left + width)) < function(math.exp(left + 0.5 * width)):
        width *= 2.0
    right = left + width
    x, y = right - _GOLDEN * width, left + _GOLDEN * width
    at_x, at_y = function(math.exp(x)), function(math.exp(y))
    # A minimum is flat: 1e-7 in its place is 1e-14 in its value.
    while right - left > 1e-7:
        if at_x <= at_y:
            right, y, at_y = y, x, at_x
            x = right - _GOLDEN * (right - left)
            at_x = function(math.exp(x))
        else:
            left, x, at_x = x, y, at_y
            y = left + _GOLDEN * (right - left)
            at_y = function(math.exp(y))
    return (math.exp(x), at_x) if at_x <= at_y else (math.exp(y), at_y)


def _crossing(below: float, above: float, function: Callable[[float], float]) -> float:
    """Where a function passes 1, between a point of value below 1 and one of value from 1 up."""
    while abs(above - below) > 1e-12 * below:
        middle = 0.5 * (below + above)
        below, above = (middle, above) if function(middle) < 1.0 else (below, middle)
    return below


def _in_range(name: str, value: float, example: float) -> float:
    low, high = _RANGE
    if not low <= positive(name, value, example=example) <= high:
        raise InputError(
            f"{name} = {value}: must lie between {low:g} and {high:g} for a search in floating "
            f"point; write for example {name} = {example}"
        )
    return float(value)


def _six(slack: float | Slacks) -> Slacks:
    names = ("k11", "k12", "k13", "k21", "k22", "k23")
    given = slack if isinstance(slack, tuple) else (slack,) * 6
    if len(given) != len(names):
        raise InputError(
            f"slack = {slack}: must be one number or six, (k11, k12, k13, k21, k22, k23); "
            "write for example slack = 0.6"
        )
    k11, k12, k13, k21, k22, k23 = (
        _in_range(f"slack {name}", value, 0.6) for name, value in zip(names, given, strict=True)
    )
    return k11, k12, k13, k21, k22, k23


def remark3_search(
    q1: float,
    *,
    alpha_max: float,
    slack: float | Slacks = 0.6,
    initial_l: float = 4.5,
    max_passes: int = 8,
) -> Remark3Result:
    """Run the algorithm of Remark 3, (44)-(49), as printed, and notice when it cannot stop.

    Step a takes the smallest k1, k2, which make l̄2 smallest; Step b takes the middle of (l̄1, l)
    for l1 and of (l̄2, l) for l2, and an l3 one thousandth above its bound. By the argument in this
    module's text the first pass decides; later ones are recorded to show where l goes.

    Parameters
    ----------
    q1 : float
        Exponent, in (2/3, 1).
    alpha_max : float
        Upper bound of α2, positive.
    slack : float or tuple of six floats, optional
        k̄_ij, one number for all or (k̄11, k̄12, k̄13, k̄21, k̄22, k̄23), positive.
    initial_l : float, optional
        The first l, positive.
    max_passes : int, optional
        How many passes are recorded at most; recording also ends when l passes 1e12.

    Returns
    -------
    Remark3Result
        The outcome with its reason, the passes, and verified gains if it terminates.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> from parkproof.proof.search import remark3_search
    >>> result = remark3_search(13 / 15, alpha_max=1.5)
    >>> print(result.reason)
    max(l1_bar, l2_bar) = 107.7 >= l = 4.5, and it never decreases in l, so the next l is never
    large enough either; l2_bar >= 13.1 l for every l > l1_bar and grows like l^2.154, so l is
    unbounded; no slacks change that
    >>> [float(f"{one.l:.3g}") for one in result.passes]
    [4.5, 108.0, 69200.0, 75600000000.0]
    >>> remark3_search(13 / 15, alpha_max=0.01).outcome.value
    'feasible'
    """
    q = float(exponent("q1", q1, 2.0 / 3.0, "2/3"))
    A = _in_range("alpha_max", alpha_max, 1.5)
    first_l = _in_range("initial_l", initial_l, 4.5)
    slacks = _six(slack)
    passes = [_step_a(q, first_l, A, slacks)]
    first = passes[0]

    def ratio(l: float) -> float:  # noqa: E741 - the paper's symbol
        return _step_a(q, l, A, slacks).l2_bar / l

    at, smallest = _minimum_beyond(first.l1_bar, ratio)
    workable = None
    if smallest < 1.0:
        high = at
        while ratio(high) < 1.0:
            high *= 2.0
        low = first.l1_bar if ratio(first.l1_bar) < 1.0 else _crossing(at, first.l1_bar, ratio)
        workable = low, _crossing(at, high, ratio)
    found = _step_b(q, first, A, slacks)
    if found is not None:
        reason = f"max(l1_bar, l2_bar) = {first.bound:.4g} < l = {first_l:.4g} at the first l"
    else:
        while len(passes) < max_passes and first_l <= passes[-1].bound < _LARGEST_L:
            passes.append(_step_a(q, passes[-1].bound, A, slacks))
        reason = _why_never(first, q, smallest, workable, _some_slacks_work(q, A))
    return Remark3Result(
        outcome=SearchOutcome.DOES_NOT_TERMINATE if found is None else SearchOutcome.FEASIBLE,
        reason=reason,
        passes=tuple(passes),
        growth_exponent=1.0 + 1.0 / q,
        smallest_ratio=smallest,
        workable_l=workable,
        some_slacks_work=_some_slacks_work(q, A),
        found=found,
    )


def _step_a(q: float, l: float, A: float, slacks: Slacks) -> Remark3Pass:  # noqa: E741
    k11, k12, k13, k21, k22, k23 = slacks
    (a15, b15, d15), (a16, b16, d16), (_, b17, d17) = step2_parts(
        q, l, l, alpha_max=A, form=Form.PRINTED
    )
    k1 = max(b15 / k11, b16 / k12, b17 / k13)
    k2 = max(d15 / k21, d16 / k22, d17 / k23)
    return Remark3Pass(l, k1, k2, a15 + k11 + k21, k1 * (a16 + k12 + k22))


def _step_b(q: float, last: Remark3Pass, A: float, slacks: Slacks) -> Step2Found | None:
    """Gains by Step b; none unless l > l̄1 and l > l̄2, by enough for floats to show it."""
    if last.bound >= last.l:
        return None
    gains = Step2Gains(
        q1=q, l1=0.5 * (last.l1_bar + last.l), l2=0.5 * (last.l2_bar + last.l),
        l3=1.001 * last.k2 * (slacks[2] + slacks[5]), k1=last.k1, k2=last.k2,
    )  # fmt: skip
    conditions = check_conditions(gains, alpha_max=A, form=Form.PRINTED)
    return Step2Found(gains, conditions) if all(c.holds for c in conditions) else None


def _some_slacks_work(q: float, A: float) -> bool:
    """Whether g(l) < l for some l > p/c, in the words of this module's text."""
    edge = 2.0 ** (1.0 - q) / (1.0 + q)

    def ratio(l: float) -> float:  # noqa: E741 - the paper's symbol
        (_, b15, _), (a16, b16, _), _ = step2_parts(q, l, l, alpha_max=A, form=Form.PRINTED)
        return (a16 * b15 / (l - edge) + b16) / l if l > edge else math.inf

    return A < 1.0 and _minimum_beyond(edge, ratio)[1] < 1.0


def _why_never(
    first: Remark3Pass,
    q: float,
    smallest: float,
    workable: tuple[float, float] | None,
    some_slacks: bool,
) -> str:
    why = (
        f"max(l1_bar, l2_bar) = {first.bound:.4g} >= l = {first.l:.4g}, and it never decreases in "
        "l, so the next l is never large enough either; "
    )
    power = 1.0 + 1.0 / q
    if workable is None:
        other = "other slacks, with a fitting l, do" if some_slacks else "no slacks change that"
        return why + (
            f"l2_bar >= {smallest:.3g} l for every l > l1_bar and grows like l^{power:.3f}, "
            f"so l is unbounded; {other}"
        )
    low, high = workable
    if first.l >= high:
        why += f"l2_bar > l for every larger l and grows like l^{power:.3f}, so l is unbounded; "
    else:
        why += f"l never exceeds {low:.6g}, itself not enough; "
    return why + f"a first l between {low:.6g} and {high:.6g} would do"


def sequential_search(
    q1: float, *, alpha_max: float, margin: float = 1e-2, form: str = Form.PRINTED
) -> Step2Found:
    """Choose l1, k1, l2, k2, l3 in that order from (15)-(17), with the smallest l3.

    Each has only a lower bound once those before it are chosen: l1 and then k1 from (15) without
    its k2-terms, l2 from (16) without them, k2 from (15) and (16), l3 from (17). So gains always
    exist. Sums of positive terms against one monomial each are a geometric program, convex in the
    logarithms; minimising over one variable keeps it convex, so three nested golden-section
    searches (over l1, k1, l2) reach the smallest l3 that the conditions allow.

    Parameters
    ----------
    q1 : float
        Exponent, in (2/3, 1).
    alpha_max : float
        Upper bound of α2, positive.
    margin : float, optional
        The relative margin that each condition keeps: by this much its positive terms could grow.
    form : Form or str, optional
        ``printed`` or ``sharp``.

    Returns
    -------
    Step2Found
        The gains, with the conditions evaluated at them.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> from parkproof.proof.search import sequential_search
    >>> found = sequential_search(13 / 15, alpha_max=1.5, form="sharp").gains
    >>> [float(f"{gain:.3g}") for gain in (found.l1, found.k1, found.l2, found.k2, found.l3)]
    [0.782, 3.22, 5.11, 456.0, 208.0]
    """
    q = float(exponent("q1", q1, 2.0 / 3.0, "2/3"))
    A = _in_range("alpha_max", alpha_max, 1.5)
    s = 1.0 + _in_range("margin", margin, 0.01)
    chosen = form_of(form, Step2Gains)
    best = (math.inf, 0.0, 0.0, 0.0, 0.0)

    def over_l1(l1: float) -> float:
        (a15, b15, _), (a16, b16, _), _ = step2_parts(q, l1, 1.0, alpha_max=A, form=chosen)
        room = l1 / s - a15

        def over_k1(k1: float) -> float:
            room15, taken16 = room - b15 / k1, a16 + b16 / k1

            def over_l2(l2: float) -> float:
                nonlocal best
                (_, _, d15), (_, _, d16), (_, b17, d17) = step2_parts(
                    q, l1, l2, alpha_max=A, form=chosen
                )
                room16 = l2 / (s * k1) - taken16
                if room15 <= 0.0 or room16 <= 0.0:  # at the lower bounds, by rounding
                    return math.inf
                k2 = max(d15 / room15, d16 / room16)
                l3 = s * (k2 * b17 / k1 + d17)
                best = min(best, (l3, l1, k1, l2, k2))
                return l3

            return _minimum_beyond(s * k1 * taken16, over_l2)[1]

        return math.inf if room <= 0.0 else _minimum_beyond(b15 / room, over_k1)[1]

    _minimum_beyond(s * 2.0 ** (1.0 - q) / (1.0 + q), over_l1)
    l3, l1, k1, l2, k2 = best
    gains = Step2Gains(q1=q, l1=l1, l2=l2, l3=l3, k1=k1, k2=k2)
    return Step2Found(gains, check_conditions(gains, alpha_max=A, form=chosen))


def remark4_search(
    q2: float,
    k1_tilde: float,
    *,
    alpha_max: float,
    margin: float = 1e-2,
    form: str = Form.PRINTED,
) -> Step3Found:
    """Choose k̃2 from (18) and then k̃3 from (19), for a given k̃1 (Remark 4).

    k̃3's bound grows with k̃2, so k̃2 is taken as small as (18) allows, then k̃3 as (19) allows.

    Parameters
    ----------
    q2 : float
        Exponent, in (1/2, 1).
    k1_tilde : float
        Gain k̃1, positive; in the untuned form above 2^(1−q2)/(1+q2).
    alpha_max : float
        Upper bound of α1, positive.
    margin : float, optional
        The relative margin that each condition keeps: by this much its positive terms could grow.
    form : Form or str, optional
        ``printed`` or ``untuned``.

    Returns
    -------
    Step3Found
        The gains, with the conditions evaluated at them.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> from parkproof.proof.search import remark4_search
    >>> found = remark4_search(7 / 9, 1.5, alpha_max=1.5).gains
    >>> round(found.k2_tilde, 3), round(found.k3_tilde, 2)
    (0.992, 10.84)
    """
    q = float(exponent("q2", q2, 0.5, "1/2"))
    k1t = _in_range("k1_tilde", k1_tilde, 1.5)
    A = _in_range("alpha_max", alpha_max, 1.5)
    s = 1.0 + _in_range("margin", margin, 0.01)
    chosen = form_of(form, Step3Gains)
    (a18, b18), (a19, b19) = step3_parts(q, k1t, alpha_max=A, form=chosen)
    room = (1.0 if chosen is Form.UNTUNED else 0.75) * k1t / s - a18
    if room <= 0.0:
        raise InputError(
            f"k1_tilde = {k1t}: (18') with this margin asks for more than {s * a18:.6g}; "
            f"write for example k1_tilde = {2.0 * s * a18:.3g}"
        )
    k2t = b18 / room
    gains = Step3Gains(q2=q, k1_tilde=k1t, k2_tilde=k2t, k3_tilde=s * (k2t * a19 + b19))
    return Step3Found(gains, check_conditions(gains, alpha_max=A, form=chosen))
