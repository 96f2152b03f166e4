"""The laws by name. A new law is one module beside this one, and one line here."""

from collections.abc import Callable
from typing import NamedTuple

from parkproof.errors import InputError
from parkproof.laws.corrected import (
    better_direction,
    corrected_begin,
    corrected_nominal,
    corrected_switch,
)
from parkproof.laws.published import (
    published_begin,
    published_direction,
    published_nominal,
    published_switch,
)


class Law(NamedTuple):
    """The scalar functions of a law, and whether it can turn outside the chart.

    Attributes
    ----------
    name : str
        As in a scenario.
    begin : callable
        (x2, p) → the first step.
    direction : callable
        (x0, x1, x2, u0, p) → direction of travel, asked whenever Step 1 begins.
    switch : callable
        (step, direction, t, x0, x1, x2, u0, u1, p) → the step in force.
    nominal : callable
        (step, direction, x0, x1, x2, u0, u1, p) → τ̃1, u0*, τ̃2, u1*.
    turns : bool
        Whether it has a Step 0.
    """

    name: str
    begin: Callable[..., float]
    direction: Callable[..., float]
    switch: Callable[..., float]
    nominal: Callable[..., tuple[float, float, float, float]]
    turns: bool


LAWS = {
    "published": Law(
        "published",
        published_begin,
        published_direction,
        published_switch,
        published_nominal,
        turns=False,
    ),
    "corrected": Law(
        "corrected",
        corrected_begin,
        better_direction,
        corrected_switch,
        corrected_nominal,
        turns=True,
    ),
}


def law_named(name: str) -> Law:
    """Look up a law.

    Parameters
    ----------
    name : str
        "published" or "corrected".

    Returns
    -------
    Law
        Its scalar functions.

    Raises
    ------
    InputError
        If there is no such law.

    Examples
    --------
    >>> law_named("corrected").turns
    True
    """
    if name not in LAWS:
        raise InputError(f'law = "{name}": there is no such law; write one of {", ".join(LAWS)}')
    return LAWS[name]
