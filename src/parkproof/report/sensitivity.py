"""Which uncertainty matters most: Sobol' indices of what was drawn.

The indices are those of I. M. Sobol' (Math. Comput. Simul. 55, 2001), estimated as A. Saltelli et
al. advise (Comput. Phys. Commun. 181, 2010) by `scipy.stats.sobol_indices`. The estimator needs
trials of its own, in pairs that differ in one quantity only, which the table of a campaign does
not hold; in lanes they take seconds. Measures for given data were not taken: they give first-order
indices only, which miss a quantity that matters together with others, as an input gain does with a
disturbance; and the library that has most of them, SALib, brings pandas with it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CONFIDENCE = 0.95

RESAMPLES = 400
"""Of the bootstrap that gives the intervals."""

LEAST_POINTS = 64


@dataclass(frozen=True)
class Sensitivity:
    """Sobol' indices of some outputs by some inputs.

    Attributes
    ----------
    inputs : tuple of str
        What was drawn.
    first, total : array (outputs, inputs)
        Share of an output's variance that goes when this input alone is known, and that stays when
        all others are known. Estimates: they may come out a little below 0 or above 1.
    first_range, total_range : array (2, outputs, inputs)
        Ends of 95 % intervals (percentile bootstrap).
    values : array (outputs, points)
        Independent samples of the outputs, for their counts and means.
    trials : int
        Carried out.
    """

    inputs: tuple[str, ...]
    first: Array
    total: Array
    first_range: Array
    total_range: Array
    values: Array
    trials: int


def points_for(inputs: int, trials: int) -> int:
    """How many points a study of so many trials may have.

    Parameters
    ----------
    inputs : int
        Drawn quantities d.
    trials : int
        At most about so many; a point needs d + 2.

    Returns
    -------
    int
        A power of two, as the Sobol' sequence asks, and at least 64.

    Examples
    --------
    >>> points_for(12, 20_000), points_for(12, 10)
    (1024, 64)
    """
    most = max(trials // (inputs + 2), LEAST_POINTS)
    return 1 << (most.bit_length() - 1)


def sensitivity_of(
    outputs: Callable[[Array], Array], inputs: tuple[str, ...], *, points: int, seed: int
) -> Sensitivity:
    """Estimate Sobol' indices.

    Parameters
    ----------
    outputs : callable
        Takes points of the unit cube (points, inputs), each coordinate the quantile of one input,
        and gives finite numbers (outputs, points), two outputs or more.
    inputs : tuple of str
        Their names; two or more.
    points : int
        A power of two. Trials: points·(inputs + 2).
    seed : int
        Of the points and of the bootstrap.

    Returns
    -------
    Sensitivity
        Indices and intervals; 0 for an output that does not vary.

    Examples
    --------
    >>> linear = lambda x: np.array([3.0 * x[:, 0] + x[:, 1], x[:, 0] * 0.0])
    >>> found = sensitivity_of(linear, ("a", "b"), points=1024, seed=0)
    >>> found.first.round(1).tolist(), found.trials
    ([[0.9, 0.1], [0.0, 0.0]], 4096)
    """
    from scipy.stats import bootstrap, qmc, sobol_indices

    d = len(inputs)
    rng = np.random.default_rng(seed)
    both = qmc.Sobol(2 * d, scramble=True, rng=rng).random(points)
    one, two = both[:, :d], both[:, d:]
    mixed = np.repeat(one[np.newaxis], d, axis=0)
    for i in range(d):
        mixed[i, :, i] = two[:, i]
    f_one, f_two = outputs(one), outputs(two)
    f_mixed = np.array([outputs(block) for block in mixed])

    def indices(rows: NDArray[np.intp]) -> Array:
        """First-order and total indices from some of the points."""
        some: dict[str, Any] = {
            "f_A": f_one[:, rows],
            "f_B": f_two[:, rows],
            "f_AB": f_mixed[..., rows],
        }
        found = sobol_indices(func=some, n=points)
        return np.array([found.first_order, found.total_order])

    rows = np.arange(points)
    first, total = indices(rows)
    spread = bootstrap(
        (rows,), indices, method="percentile", n_resamples=RESAMPLES, rng=rng,
        confidence_level=CONFIDENCE, vectorized=False,
    ).confidence_interval  # fmt: skip
    (first_low, total_low), (first_high, total_high) = spread.low, spread.high
    return Sensitivity(
        inputs=inputs,
        first=first,
        total=total,
        first_range=np.array([first_low, first_high]),
        total_range=np.array([total_low, total_high]),
        values=np.hstack([f_one, f_two]),
        trials=points * (d + 2),
    )
