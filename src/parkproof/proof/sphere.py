"""A dense search of the homogeneous sphere for the state where V decreases least."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from parkproof.errors import InputError
from parkproof.proof.lyapunov import ChainLyapunov
from parkproof.validate import increasing, positive


@dataclass(frozen=True)
class WorstRatio:
    """Where V decreases least among the sampled states.

    Parameters
    ----------
    ratio : float
        The largest V̇/V^((1+q)/2); if negative, its opposite is the sampled c.
    state : tuple of floats
        The state where it was found.
    alpha : float
        The α for which it was found.

    Examples
    --------
    >>> WorstRatio(ratio=-1.2, state=(1.0, 0.0, 0.0), alpha=0.5).ratio
    -1.2
    """

    ratio: float
    state: tuple[float, ...]
    alpha: float


def worst_ratio(
    lyapunov: ChainLyapunov, *, alpha: Sequence[float], points: int = 41, zooms: int = 10
) -> WorstRatio:
    """Search the homogeneous sphere for the largest V̇/V^((1+q)/2). Sampled, not proved.

    A grid covers the faces of the cube max_i |ξ_i|/(L_1…L_i) = 1, half of them by the loop's odd
    symmetry; around the worst state of each face, finer grids follow. A positive ratio
    is a counterexample, and exact up to rounding. A negative one is evidence only: the true maximum
    is no smaller. For a ratio −c < 0 the end points of α stand for all α between them, because
    V̇ + cV^((1+q)/2) is convex in α.

    Parameters
    ----------
    lyapunov : ChainLyapunov
        V.
    alpha : two floats
        Bounds of α.
    points : int
        Grid points along each edge of a face, at least 3.
    zooms : int
        Finer grids on each face.

    Returns
    -------
    WorstRatio
        The largest ratio found, and where.

    Raises
    ------
    InputError
        If the bounds are crossed or not positive, or there are too few points.

    Examples
    --------
    The published gains fail with the paper's weights, and pass with others:

    >>> from parkproof.laws.gains import Gains
    >>> from parkproof.proof.lyapunov import step2_lyapunov
    >>> gains = Gains(q1="9/11", l=(2.0, 4.2, 21.0))
    >>> for k in ((2.4, 17.5), (4.28, 311.0)):
    ...     print(round(worst_ratio(step2_lyapunov(gains, k=k), alpha=(0.5, 1.5)).ratio, 1))
    14.4
    -1.2
    """
    import numpy as np

    low, high = increasing("alpha", alpha)
    ends = np.array([[positive("alpha's lower bound", low)], [high]])
    if points < 3:
        raise InputError(f"points = {points}: a face needs at least 3 an edge; write points = 41")
    r = len(lyapunov.gains)
    worst = WorstRatio(-math.inf, (), high)
    grid, radius = np.linspace(-1.0, 1.0, points), 2.0 / (points - 1)
    fine = np.linspace(-1.0, 1.0, 13)
    for face in range(r):
        axes, reach = [grid] * (r - 1), radius
        for _ in range(zooms + 1):
            free = np.array(list(itertools.product(*axes))).T
            cube = np.insert(free, face, 1.0, axis=0)
            state = lyapunov.state_at(*cube)
            ratios = lyapunov.decay_ratio(*state, alpha=ends)
            end, at = np.unravel_index(int(ratios.argmax()), ratios.shape)
            if ratios[end, at] > worst.ratio:
                found = tuple(float(entry[at]) for entry in state)
                worst = WorstRatio(float(ratios[end, at]), found, (low, high)[int(end)])
            axes = [np.clip(center + reach * fine, -1.0, 1.0) for center in free[:, at]]
            reach /= 4.0
    return worst
