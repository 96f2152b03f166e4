"""The laws by name. A new law is one module beside this one, and one line here."""

from collections.abc import Callable
from typing import NamedTuple

from parkproof.errors import InputError
from parkproof.laws.corrected import corrected_nominal, corrected_start, corrected_switch
from parkproof.laws.published import published_nominal, published_start, published_switch


class Law(NamedTuple):
    """The three scalar functions of a law, and whether it can turn outside the chart."""

    name: str
    start: Callable[..., tuple[float, float]]
    switch: Callable[..., tuple[float, float]]
    nominal: Callable[..., tuple[float, float, float, float]]
    turns: bool


LAWS = {
    "published": Law(
        "published", published_start, published_switch, published_nominal, turns=False
    ),
    "corrected": Law("corrected", corrected_start, corrected_switch, corrected_nominal, turns=True),
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
