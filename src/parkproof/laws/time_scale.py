"""Gains of a loop that is a given number of times as fast (κ): exact, as the loops are homogeneous.

With time scaled by κ and the run-up speed c, states of the same path x1(x0) have x2 scaled by κ/c,
u1 by κ²/c and its rate by κ³/c.
"""

from parkproof.validate import Ratio


def scaled_approach(
    l: tuple[float, float, float],  # noqa: E741  (the paper's name)
    q1: float | str,
    *,
    speed: float,
    cruise: float,
) -> tuple[float, float, float]:
    """Gains l of Step 2 for a loop ``speed`` times as fast, at another run-up speed.

    Parameters
    ----------
    l : three floats
        Gains for speed 1 and run-up speed 1.
    q1 : float or str
        Exponent of Step 2.
    speed : float
        κ, how many times as fast.
    cruise : float
        Run-up speed c = |u0|.

    Returns
    -------
    three floats
        Gains l.

    Examples
    --------
    >>> scaled_approach((2.0, 4.2, 21.0), "9/11", speed=1.0, cruise=1.0)
    (2.0, 4.2, 21.0)
    >>> scaled_approach((2.0, 4.2, 21.0), "9/11", speed=1.0, cruise=0.5)[0]
    4.0
    """
    q = float(Ratio(q1, "q1"))
    e, r = 2.0 * q - 1.0, 3.0 * q - 2.0
    slope, spin, push = speed / cruise, speed**2 / cruise, speed**3 / cruise
    two, three = slope ** (1.0 / q), spin ** (1.0 / e)
    return l[0] * slope, l[1] * spin / two**e, l[2] * push / three**r


def scaled_pair(k: tuple[float, float], q2: float | str, *, speed: float) -> tuple[float, float]:
    """Gains of a chain of two (holding, turn, return) for a loop ``speed`` times as fast.

    Parameters
    ----------
    k : two floats
        Gains k̃1, k̃3 for speed 1.
    q2 : float or str
        Exponent.
    speed : float
        κ.

    Returns
    -------
    two floats
        Gains.

    Examples
    --------
    >>> scaled_pair((1.5, 6.5), "7/9", speed=1.0)
    (1.5, 6.5)
    """
    q = float(Ratio(q2, "q2"))
    return speed * k[0], speed ** (1.0 / q) * k[1]
