"""Searches for gains that satisfy the conditions: one that works for (15)-(17), and Remark 4.

The search of Remark 3 as printed is in `parkproof.proof.remark3`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from parkproof.errors import InputError
from parkproof.laws.gains import exponent
from parkproof.proof.conditions import (
    Condition,
    check_conditions,
    form_of,
    step2_parts,
    step3_parts,
)
from parkproof.proof.gains import Form, Step2Gains, Step3Gains
from parkproof.validate import positive

_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_RANGE = (1e-6, 1e6)


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


def minimum_beyond(low: float, function: Callable[[float], float]) -> tuple[float, float]:
    """Argument and value of the minimum over x > low of a function convex in log x.

    Parameters
    ----------
    low : float
        Open lower end, positive.
    function : callable
        The function.

    Returns
    -------
    tuple of 2 floats
        Argument and value.

    Examples
    --------
    >>> x, y = minimum_beyond(0.1, lambda x: x + 1.0 / x)
    >>> round(x, 6), round(y, 6)
    (1.0, 2.0)
    """
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


def crossing(below: float, above: float, function: Callable[[float], float]) -> float:
    """Where a function passes 1, between a point of value below 1 and one of value from 1 up.

    Parameters
    ----------
    below, above : float
        Such points, positive.
    function : callable
        The function.

    Returns
    -------
    float
        The place.

    Examples
    --------
    >>> round(crossing(1.0, 9.0, lambda x: x / 4.0), 9)
    4.0
    """
    while abs(above - below) > 1e-12 * below:
        middle = 0.5 * (below + above)
        below, above = (middle, above) if function(middle) < 1.0 else (below, middle)
    return below


def in_range(name: str, value: float, example: float) -> float:
    """Check that an input of a search lies in [1e-6, 1e6].

    Parameters
    ----------
    name : str
        What the number is called.
    value : float
        The number.
    example : float
        A value that would do, for the message.

    Returns
    -------
    float
        The same number.

    Raises
    ------
    InputError
        If it does not.

    Examples
    --------
    >>> in_range("margin", 0.01, 0.01)
    0.01
    """
    low, high = _RANGE
    if not low <= positive(name, value, example=example) <= high:
        raise InputError(
            f"{name} = {value}: must lie between {low:g} and {high:g} for a search in floating "
            f"point; write for example {name} = {example}"
        )
    return float(value)


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
    A = in_range("alpha_max", alpha_max, 1.5)
    s = 1.0 + in_range("margin", margin, 0.01)
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

            return minimum_beyond(s * k1 * taken16, over_l2)[1]

        return math.inf if room <= 0.0 else minimum_beyond(b15 / room, over_k1)[1]

    minimum_beyond(s * 2.0 ** (1.0 - q) / (1.0 + q), over_l1)
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
    k1t = in_range("k1_tilde", k1_tilde, 1.5)
    A = in_range("alpha_max", alpha_max, 1.5)
    s = 1.0 + in_range("margin", margin, 0.01)
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
