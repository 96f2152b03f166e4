"""The laws by name. A new law is one module beside this one, and one line here."""

from collections.abc import Callable
from typing import NamedTuple

from parkproof.errors import InputError
from parkproof.laws.chains import ChannelLaw
from parkproof.laws.corrected import (
    better_direction,
    corrected_begin,
    corrected_channels,
    corrected_switch,
)
from parkproof.laws.homogeneous import homogeneous_channels, homogeneous_direct
from parkproof.laws.published import (
    no_direct,
    published_begin,
    published_channels,
    published_direction,
    published_switch,
)


class Law(NamedTuple):
    """The scalar functions of a law, and whether it can turn outside the chart.

    Attributes
    ----------
    name : str
        As in a scenario.
    begin : callable
        (x1, x2, u1, p) → the first step, at the start and after a turn.
    direction : callable
        (x0, x1, x2, u0, p) → direction of travel, asked whenever Step 1 begins.
    switch : callable
        (step, direction, t, x0, x1, x2, u0, u1, p) → the step in force.
    channels : callable
        (step, direction, x0, x1, x2, u0, p) → the laws of both channels.
    direct : callable
        (step, direction, x1, x2, u1, p) → what is added to τ2 as it is.
    turns : bool
        Whether it has a Step 0.
    """

    name: str
    begin: Callable[..., float]
    direction: Callable[..., float]
    switch: Callable[..., float]
    channels: Callable[..., tuple[ChannelLaw, ChannelLaw]]
    direct: Callable[..., float]
    turns: bool


LAWS = {
    "published": Law(
        "published",
        published_begin,
        published_direction,
        published_switch,
        published_channels,
        no_direct,
        turns=False,
    ),
    "corrected": Law(
        "corrected",
        corrected_begin,
        better_direction,
        corrected_switch,
        corrected_channels,
        no_direct,
        turns=True,
    ),
    "homogeneous": Law(
        "homogeneous",
        corrected_begin,
        better_direction,
        corrected_switch,
        homogeneous_channels,
        homogeneous_direct,
        turns=True,
    ),
}


def law_named(name: str) -> Law:
    """Look up a law.

    Parameters
    ----------
    name : str
        "published", "corrected" or "homogeneous".

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
