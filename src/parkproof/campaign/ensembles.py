"""Trials split into ensembles: what lanes can carry out side by side."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.campaign.lanes import trials_from
from parkproof.campaign.prepare import Prepared, values_of
from parkproof.scenario import Scenario
from parkproof.simulation.trials import Trials


def ensembles(
    prepared: Prepared, drawn: Mapping[str, NDArray[Any]], numbers: NDArray[np.int64], *, size: int
) -> Iterator[tuple[NDArray[np.intp], Scenario, Trials]]:
    """Split trials into ensembles that share all but what may differ side by side.

    Parameters
    ----------
    prepared : Prepared
        The campaign.
    drawn : mapping of str to array
        Values of its quantities, from `parkproof.campaign.draw.drawn_values` or `values_at`.
    numbers : array of int
        Numbers of the trials, on which the noise of their measurements depends.
    size : int
        Trials of an ensemble at most.

    Yields
    ------
    (array, Scenario, Trials)
        Places of the trials among those given, what they share, and in what they differ.

    Examples
    --------
    >>> from parkproof.campaign.draw import drawn_values
    >>> from parkproof.campaign.prepare import prepared_from
    >>> prepared = prepared_from('''{"law": "corrected", "start": {"pose": [-1, 0, 0]},
    ...     "trials": 10, "run": {"duration": 1.0, "control_period": 0.01}, "distributions":
    ...     {"start.pose[0]": {"kind": "uniform", "low": -2, "high": -1}}}''')
    >>> drawn = drawn_values(prepared.campaign, 0, 4)
    >>> [len(trials) for _, _, trials in ensembles(prepared, drawn, np.arange(4), size=3)]
    [3, 1]
    """
    values = prepared.numbers_of(drawn)
    sizes = [len(values_of(quantity)) for quantity in prepared.splitting]
    chosen = tuple(drawn[quantity.key] for quantity in prepared.splitting)
    group = np.ravel_multi_index(chosen, sizes) if sizes else np.zeros(len(numbers), dtype=int)
    for index in np.unique(group).tolist():
        members = np.flatnonzero(group == index)
        scenario = prepared.group(index)
        for first in range(0, len(members), size):
            piece = members[first : first + size]
            side_by_side = {place: found[piece] for place, found in values.items()}
            yield piece, scenario, trials_from(scenario, side_by_side, numbers[piece].tolist())
