"""Searches the numbers that a design varies, with one engine, for the least price."""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from parkproof.proof.candidates import Candidate, Knobs
from parkproof.proof.engines import Engine, HomogeneousEngine
from parkproof.spec import Spec

if TYPE_CHECKING:
    from numpy.typing import NDArray

LOWEST, HIGHEST = Knobs(0.05, 0.1, 0.2, 0.15), Knobs(3.0, 6.0, 6.0, 4.0)
"""Where the search looks; the homogeneous law's τ2 has its own range."""

NO_PROOF = 1e3
"""Price of numbers without a candidate; those outside their ranges cost more."""


def _simplex(start: Sequence[float], size: float) -> list[list[float]]:
    """A start for a descent that stays in the cube."""
    corners = [list(start)]
    for i, x in enumerate(start):
        corner = list(start)
        corner[i] = x - size if x > 0.5 else x + size
        corners.append(corner)
    return corners


class KnobSearch:
    """Candidates of one engine: a sweep, then a descent from the best.

    Parameters
    ----------
    engine : Engine
        Makes the candidates.
    spec : Spec
        What is wanted.
    looked_at : list of Candidate
        Takes in all candidates.
    relaxed : float
        By how much the homogeneous law's input may exceed its limit.

    Attributes
    ----------
    best : Candidate or None
        The one of least price.
    best_knobs : Knobs or None
        Its numbers.
    price : float
        Its price.

    Examples
    --------
    >>> from parkproof.bounds import Bounds
    >>> class Nothing:
    ...     name = "none"
    ...     def candidate(self, knobs):
    ...         return None
    >>> search = KnobSearch(Nothing(), Spec(bounds=Bounds()), [])
    >>> search.sweep(2)
    >>> search.best is None
    True
    """

    def __init__(
        self, engine: Engine, spec: Spec, looked_at: list[Candidate], relaxed: float = 1.0
    ) -> None:
        self.engine, self._spec, self._looked_at = engine, spec, looked_at
        self.best: Candidate | None = None
        self.best_knobs: Knobs | None = None
        self.price = math.inf
        self._ranges = self._ranges_of(relaxed)
        self._swept: list[tuple[float, tuple[float, ...]]] = []

    def _ranges_of(self, relaxed: float) -> list[tuple[float, float]]:
        """Logarithms of the least and largest numbers."""
        lows, highs = list(LOWEST), list(HIGHEST)
        if isinstance(self.engine, HomogeneousEngine):
            bounds, tau = self._spec.bounds, self._spec.limits.tau
            weakest = bounds.disturbance_of(1) / bounds.gamma_of(1)[0]
            limit = tau[1] if tau else 20.0 * (1.0 + weakest)
            lows[1], highs[1] = 1.05 * weakest + 1e-2 * limit, relaxed * limit
        return [(math.log(low), math.log(high)) for low, high in zip(lows, highs, strict=True)]

    def look(self, knobs: Knobs) -> float:
        """Price of the candidate with these numbers, which is remembered if it is the best.

        Parameters
        ----------
        knobs : Knobs
            The numbers.

        Returns
        -------
        float
            The price; infinite if there is no such candidate.
        """
        candidate = self.engine.candidate(knobs)
        if candidate is None:
            return math.inf
        self._looked_at.append(candidate)
        price = candidate.price(self._spec)
        if price < self.price:
            self.best, self.best_knobs, self.price = candidate, knobs, price
        return price

    def _at(self, unit: Sequence[float]) -> list[float]:
        """Logarithms of numbers at a point of the unit cube, or of its nearest one."""
        return [
            low + min(max(x, 0.0), 1.0) * (high - low)
            for x, (low, high) in zip(unit, self._ranges, strict=False)
        ]

    def _without_return(self, unit: Sequence[float]) -> float:
        """Price at a point of the cube of three numbers, with the best return for it."""
        cruise, approach, hold = (math.exp(log) for log in self._at(unit))
        outside = _outside(unit)
        low, high = self._ranges[3]
        found = math.inf
        for fine in (4, 2):  # a coarse sweep of the return's speed, then a finer one at its best
            step = (high - low) / (2 * fine)
            prices = []
            for i in range(2 * fine + 1):
                back = low + i * step
                price = self.look(Knobs(cruise, approach, hold, math.exp(back)))
                if math.isinf(price):
                    return NO_PROOF + outside
                prices.append((price, back))
            least, at = min(prices)
            found = min(found, least)
            low, high = at - step, at + step
        return found + outside

    def sweep(self, count: int, progress: Callable[[], None] = lambda: None) -> None:
        """Look at points spread over the cube; at those of an earlier sweep no more.

        Parameters
        ----------
        count : int
            How many.
        progress : callable
            Called after each.
        """
        from scipy.stats import qmc

        points = qmc.Sobol(3, seed=0).random_base2(math.ceil(math.log2(count)))
        for point in points[len(self._swept) : count]:
            self._swept.append((self._without_return(point), tuple(point)))
            progress()

    def descend(self, steps: int, progress: Callable[[], None] = lambda: None) -> None:
        """Descend from the best point of the sweep, with the best return for each.

        Parameters
        ----------
        steps : int
            At how many points it looks at most.
        progress : callable
            Called after each step.
        """
        if steps > 0:
            _descend(self._without_return, min(self._swept)[1], 0.15, steps, progress)

    def descend_at_once(self, count: int, start: Knobs | None = None, size: float = 0.08) -> None:
        """Descend in all four numbers, which is better where a candidate costs little.

        Parameters
        ----------
        count : int
            At how many candidates it looks at most.
        start : Knobs, optional
            From where; default the best.
        size : float
            First steps, as shares of the ranges.
        """

        def price(unit: Sequence[float]) -> float:
            found = self.look(Knobs(*(math.exp(log) for log in self._at(unit))))
            return min(found, NO_PROOF) + _outside(unit)

        knobs = start or self.best_knobs
        if knobs is None:
            return
        unit = [
            (math.log(x) - low) / (high - low)
            for x, (low, high) in zip(knobs, self._ranges, strict=True)
        ]
        _descend(price, unit, size, count, lambda: None)


def _outside(unit: Sequence[float]) -> float:
    return sum(max(0.0, -x, x - 1.0) for x in unit)


def _descend(
    price: Callable[[Any], float],
    start: Sequence[float],
    size: float,
    count: int,
    progress: Callable[[], None],
) -> None:
    """Nelder and Mead's descent; what it finds is remembered by what is looked at."""
    from scipy.optimize import minimize

    def told(_: "NDArray[Any]") -> None:
        progress()

    minimize(
        price,
        start,
        method="Nelder-Mead",
        callback=told,
        options={
            "maxfev": count,
            "xatol": 2e-3,
            "fatol": 1e-3,
            "initial_simplex": _simplex(start, size),
        },
    )
