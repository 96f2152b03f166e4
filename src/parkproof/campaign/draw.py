"""What is drawn for a trial: a function of the seed, the trial's number and the file, no more."""

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from parkproof.campaign.definition import Campaign, Draws, Quantity
from parkproof.campaign.distributions import Choice, Constant, Continuous, Uniform

COUNTER = 4
"""Numbers that a step of the counter of Philox gives."""

WHOLE = {"seed"}
"""Last parts of keys that take whole numbers."""


def unit_numbers(
    dimensions: int, begin: int, end: int, *, seed: int, draws: Draws
) -> NDArray[np.float64]:
    """Numbers in [0, 1) of a range of trials.

    Parameters
    ----------
    dimensions : int
        Numbers a trial.
    begin, end : int
        The trials begin … end − 1.
    seed : int
        Seed of the campaign.
    draws : "sobol" or "independent"
        Points of a scrambled Sobol sequence, or of the counter-based generator Philox.

    Returns
    -------
    (dimensions, end - begin) array
        A column a trial; the same whatever the range in which it is asked for.

    Examples
    --------
    >>> some = unit_numbers(3, 5, 9, seed=1, draws="independent")
    >>> bool((unit_numbers(3, 8, 9, seed=1, draws="independent")[:, 0] == some[:, 3]).all())
    True
    """
    if dimensions == 0:
        return np.empty((0, end - begin))
    if draws == "independent":
        steps = -(-dimensions // COUNTER)
        generator = np.random.Generator(np.random.Philox(key=seed, counter=begin * steps))
        numbers = generator.random((end - begin, steps * COUNTER))[:, :dimensions]
    else:
        from scipy.stats import qmc

        sequence = qmc.Sobol(dimensions, seed=np.random.default_rng(seed))
        if begin:
            sequence.fast_forward(begin)
            numbers = sequence.random(end - begin)
        else:  # a beginning whose length is no power of 2 draws a warning
            numbers = sequence.random_base2((end - 1).bit_length())[:end]
    return np.ascontiguousarray(numbers.T)


def drawn_values(campaign: Campaign, begin: int, end: int) -> dict[str, NDArray[Any]]:
    """Values of all quantities of a range of trials.

    Parameters
    ----------
    campaign : Campaign
        The campaign.
    begin, end : int
        The trials begin … end − 1.

    Returns
    -------
    dict of str to array
        By key: floats; for a choice, the places in its values.

    Examples
    --------
    >>> from parkproof.campaign.definition import campaign_from_dict
    >>> campaign = campaign_from_dict(
    ...     {"law": "corrected", "start": {"pose": [-1, 0, 0]}, "trials": 10, "seed": 1,
    ...      "distributions": {"start.pose[0]": {"kind": "uniform", "low": -2, "high": -1}}},
    ...     where="example")
    >>> x = drawn_values(campaign, 0, 10)["start.pose[0]"]
    >>> bool(((x >= -2.0) & (x <= -1.0)).all())
    True
    """
    count = sum(quantity.drawn for quantity in campaign.quantities)
    return values_at(
        campaign, unit_numbers(count, begin, end, seed=campaign.seed, draws=campaign.draws)
    )


def values_at(campaign: Campaign, numbers: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
    """Values of all quantities at points of the unit cube.

    Parameters
    ----------
    campaign : Campaign
        The campaign.
    numbers : (dimensions, n) array
        In [0, 1): a row for each quantity that is drawn, in the order of the campaign.

    Returns
    -------
    dict of str to array
        As `drawn_values`.

    Examples
    --------
    >>> from parkproof.campaign.definition import campaign_from_dict
    >>> campaign = campaign_from_dict(
    ...     {"law": "corrected", "start": {"pose": [-1, 0, 0]}, "trials": 10, "seed": 1,
    ...      "distributions": {"start.pose[0]": {"kind": "uniform", "low": -2, "high": -1}}},
    ...     where="example")
    >>> values_at(campaign, np.array([[0.0, 0.5]]))
    {'start.pose[0]': array([-2. , -1.5])}
    """
    drawn = [quantity for quantity in campaign.quantities if quantity.drawn]
    return {q.key: _values(q, row) for q, row in zip(drawn, numbers, strict=True)}


def _values(quantity: Quantity, numbers: NDArray[np.float64]) -> NDArray[Any]:
    """Values of one quantity."""
    distribution = quantity.distribution
    if isinstance(distribution, Choice):
        return distribution.indices(numbers)
    if quantity.place[-1] in WHOLE and isinstance(distribution, Uniform):
        return distribution.whole_values(numbers)
    return cast(Continuous, distribution).values(numbers)  # nothing is drawn for a constant


def settings_of(campaign: Campaign, trial: int) -> dict[str, Any]:
    """Values of all quantities of one trial, constants too.

    Parameters
    ----------
    campaign : Campaign
        The campaign.
    trial : int
        Number of the trial.

    Returns
    -------
    dict of str to object
        By key: what a scenario file would hold there.

    Examples
    --------
    >>> from parkproof.campaign.definition import campaign_from_dict
    >>> campaign = campaign_from_dict(
    ...     {"law": "corrected", "start": {"pose": [-1, 0, 0]}, "trials": 10,
    ...      "distributions": {"run.latency": {"kind": "choice", "values": [0.03]}}},
    ...     where="example")
    >>> settings_of(campaign, 7)
    {'run.latency': 0.03}
    """
    drawn = drawn_values(campaign, trial, trial + 1)
    found: dict[str, Any] = {}
    for quantity in campaign.quantities:
        distribution = quantity.distribution
        if isinstance(distribution, Constant):
            found[quantity.key] = distribution.value
        elif isinstance(distribution, Choice):
            found[quantity.key] = distribution.values[int(drawn[quantity.key][0])]
        else:
            value = float(drawn[quantity.key][0])
            found[quantity.key] = int(value) if quantity.place[-1] in WHOLE else value
    return found
