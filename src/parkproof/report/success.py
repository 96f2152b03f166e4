"""The share of trials that parked, with an exact interval."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Success:
    """How many trials parked, and what that says of all trials that might have been drawn.

    Attributes
    ----------
    parked, trials : int
        Counts.
    low, high : float
        Ends of the Clopper-Pearson interval of the probability; 0 and 1 without trials.
    confidence : float
        The interval holds the probability at least as often as this.
    """

    parked: int
    trials: int
    low: float
    high: float
    confidence: float


def success_of(parked: int, trials: int, *, confidence: float = 0.95) -> Success:
    """Estimate the probability of parking.

    The interval of C. J. Clopper and E. S. Pearson (Biometrika 26, 1934), from SciPy. It is exact
    for trials drawn independently: it never holds the probability less often than it says.

    Parameters
    ----------
    parked, trials : int
        Counts.
    confidence : float
        Between 0 and 1.

    Returns
    -------
    Success
        Counts and interval.

    Examples
    --------
    >>> found = success_of(1000, 1000)
    >>> round(found.low, 5), found.high
    (0.99632, 1.0)
    """
    from scipy.stats import binomtest

    low, high = 0.0, 1.0
    if trials:
        interval = binomtest(parked, trials).proportion_ci(confidence, method="exact")
        low, high = float(interval.low), float(interval.high)
    return Success(parked=parked, trials=trials, low=low, high=high, confidence=confidence)
