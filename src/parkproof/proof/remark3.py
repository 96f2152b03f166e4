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
from dataclasses import dataclass
from enum import StrEnum

from parkproof.errors import InputError
from parkproof.laws.gains import exponent
from parkproof.proof.conditions import check_conditions, step2_parts
from parkproof.proof.gains import Form, Step2Gains
from parkproof.proof.search import Step2Found, crossing, in_range, minimum_beyond

Slacks = tuple[float, float, float, float, float, float]

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
    >>> from parkproof.proof.remark3 import SearchOutcome
    >>> SearchOutcome.DOES_NOT_TERMINATE.value
    'does not terminate'
    """

    FEASIBLE = "feasible"
    DOES_NOT_TERMINATE = "does not terminate"


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
    >>> from parkproof.proof.remark3 import Remark3Pass
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
    >>> from parkproof.proof.remark3 import remark3_search
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


def _six(slack: float | Slacks) -> Slacks:
    names = ("k11", "k12", "k13", "k21", "k22", "k23")
    given = slack if isinstance(slack, tuple) else (slack,) * 6
    if len(given) != len(names):
        raise InputError(
            f"slack = {slack}: must be one number or six, (k11, k12, k13, k21, k22, k23); "
            "write for example slack = 0.6"
        )
    k11, k12, k13, k21, k22, k23 = (
        in_range(f"slack {name}", value, 0.6) for name, value in zip(names, given, strict=True)
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
    >>> from parkproof.proof.remark3 import remark3_search
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
    A = in_range("alpha_max", alpha_max, 1.5)
    first_l = in_range("initial_l", initial_l, 4.5)
    slacks = _six(slack)
    passes = [_step_a(q, first_l, A, slacks)]
    first = passes[0]

    def ratio(l: float) -> float:  # noqa: E741 - the paper's symbol
        return _step_a(q, l, A, slacks).l2_bar / l

    at, smallest = minimum_beyond(first.l1_bar, ratio)
    workable = None
    if smallest < 1.0:
        high = at
        while ratio(high) < 1.0:
            high *= 2.0
        low = first.l1_bar if ratio(first.l1_bar) < 1.0 else crossing(at, first.l1_bar, ratio)
        workable = low, crossing(at, high, ratio)
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

    return A < 1.0 and minimum_beyond(edge, ratio)[1] < 1.0


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
