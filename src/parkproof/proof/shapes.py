"""Searches normalised forms of the paper's Step 2 by sampling: q1 and two ratios of l1, l2, l3.

A form's price is that of its best candidate with a sampled link. Sampling costs about a second,
a proof half a minute; so many forms are sampled, and the few best ones are left to be proved.
Nothing that is sampled here enters a certificate.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from parkproof.laws.gains import Gains
from parkproof.proof.candidates import Knobs
from parkproof.proof.checker.balls import Range
from parkproof.proof.engines import SHARE, Direction, PaperEngine, directions_of
from parkproof.proof.find_links import sampled_approach_link
from parkproof.proof.knob_search import KnobSearch
from parkproof.proof.scaling import ThreeChainForm, TwoChainForm
from parkproof.spec import Spec

Shape = tuple[str, tuple[float, float, float]]
"""q1 as a ratio, and l in normalised form."""

KNOWN_SHAPES: tuple[Shape, ...] = (
    ("7/9", (1.0, 2.5, 8.0)),
    ("7/9", (1.5, 4.6, 29.0)),
    ("9/11", (2.0, 4.2, 21.0)),
)
"""Shapes to begin with: one of little input, one for an uncertain b2, and the paper's."""

TYPICAL_SHAPES: tuple[Shape, ...] = (
    ("7/9", (1.0, 2.3, 7.6)),
    ("5/7", (1.0, 2.5, 14.4)),
    ("9/11", (1.0, 2.2, 6.6)),
    ("9/13", (1.0, 2.3, 16.7)),
    ("11/13", (1.0, 2.3, 6.0)),
    ("13/15", (1.0, 2.3, 5.5)),
    ("19/21", (1.0, 2.3, 5.0)),
)
"""Every q1 that is tried, with gains near which others are tried."""

AROUND = ((1.4, 2.0), (0.9, 0.8), (1.2, 1.3))
"""Factors of l2 and l3 that are tried, too: the less is known, the larger they must be."""

PROMISING = 3
"""Forms around which others are tried."""

FIRST, EACH = 100, 40
"""Candidates looked at for the first form, and for each other, which begins from the best."""

HOPELESS = 0.3
"""By how much, as a logarithm, the best form may cost more than what there is already."""


@dataclass(frozen=True)
class Scored:
    """A form with a sampled link, and what a design would pay with it.

    Attributes
    ----------
    form : ThreeChainForm
        The form.
    knobs : Knobs
        Numbers of its best candidate.
    price : float
        The price of that.

    Examples
    --------
    >>> Scored(ThreeChainForm("9/11", (2.0, 4.2, 21.0), {}), Knobs(1, 1, 1, 1), 3.2).price
    3.2
    """

    form: ThreeChainForm
    knobs: Knobs
    price: float


def normal_ranges(spec: Spec) -> list[Range]:
    """Ranges of b1 and b2 in the approach, for run-up speed 1.

    Parameters
    ----------
    spec : Spec
        What is uncertain.

    Returns
    -------
    list of two pairs
        The ranges, b1's with room for rounding.

    Examples
    --------
    >>> from parkproof.bounds import Bounds
    >>> b1, b2 = normal_ranges(Spec(bounds=Bounds(alpha=(0.5, 1.5))))
    >>> round(b1[0], 6), round(b1[1], 6)
    (0.45, 1.5)
    """
    low, high = spec.bounds.alpha_of(1)
    return [(low * SHARE * (1.0 - 1e-9), high * (1.0 + 1e-9)), spec.bounds.b2]


class ShapeSearch:
    """Forms for a specification: a sweep over q1 and l, then descents in l from the best.

    Parameters
    ----------
    spec : Spec
        What is wanted.
    hold, back : TwoChainForm
        Normalised forms of holding and of the return.

    Attributes
    ----------
    interrupted : bool
        Whether the search was cut short.

    Examples
    --------
    >>> "ranked" in dir(ShapeSearch)
    True
    """

    def __init__(self, spec: Spec, hold: TwoChainForm, back: TwoChainForm) -> None:
        self._spec, self._hold, self._back = spec, hold, back
        self._ranges = normal_ranges(spec)
        self._direction: Direction | None = None
        self._best: Scored | None = None
        self._scored: dict[Shape, Scored] = {}
        self.interrupted = False

    def engine(self, form: ThreeChainForm, direction: Direction) -> PaperEngine:
        """An engine with a form.

        Parameters
        ----------
        form : ThreeChainForm
            The form, with a link that is sampled or proved.
        direction : Direction
            Of travel.

        Returns
        -------
        PaperEngine
            The engine.
        """
        return PaperEngine(self._spec, self._hold, self._back, direction, form)

    def price(self, shape: Shape) -> float:
        """What a design would pay with a shape.

        Parameters
        ----------
        shape : Shape
            q1 and l.

        Returns
        -------
        float
            The price; infinite if V falls for no weights tried, or no run is bounded.
        """
        q, l = shape  # noqa: E741
        shape = (q, (_short(l[0]), _short(l[1]), _short(l[2])))
        if shape in self._scored:
            return self._scored[shape].price
        link = sampled_approach_link(Gains(q1=q, l=shape[1]), self._ranges)
        if link is None:
            return math.inf
        form = ThreeChainForm(q, shape[1], link)
        search = self._first(form) if self._direction is None else self._next(form)
        if search.best_knobs is None:
            return math.inf
        scored = Scored(form, search.best_knobs, search.price)
        self._scored[shape] = scored
        if self._best is None or scored.price < self._best.price:
            self._best = scored
        return scored.price

    def _first(self, form: ThreeChainForm) -> KnobSearch:
        """Search with the first form, in all directions of travel; the best stays."""
        ways = directions_of(self._spec)
        searches = [KnobSearch(self.engine(form, way), self._spec, []) for way in ways]
        for search in searches:
            search.sweep(8)
            search.descend_at_once(FIRST)
        best = min(searches, key=lambda search: search.price)
        if best.best is not None:
            self._direction = ways[searches.index(best)]
        return best

    def _next(self, form: ThreeChainForm) -> KnobSearch:
        """Search with another form from the best numbers."""
        search = KnobSearch(self.engine(form, self._direction or "toward"), self._spec, [])
        if self._best is not None:
            search.look(self._best.knobs)
            search.descend_at_once(EACH, self._best.knobs)
        return search

    def run(
        self,
        sweep: int,
        steps: int,
        *,
        enough: float = math.inf,
        progress: Callable[[float], None] = lambda _: None,
    ) -> None:
        """Search; KeyboardInterrupt ends it, and what was found stays.

        Parameters
        ----------
        sweep, steps : int
            How many forms are tried beside the known ones, and at most in the descents.
        enough : float
            Price of what there is already; where a sweep stays far above it, no descent begins.
        progress : callable
            Told which share is done.
        """
        done, whole = [0], len(KNOWN_SHAPES) + sweep + steps

        def price(shape: Shape) -> float:
            found = self.price(shape)
            done[0] += 1
            progress(min(1.0, done[0] / whole))
            return found

        try:
            for shape in [*KNOWN_SHAPES, *TYPICAL_SHAPES[:sweep]]:
                price(shape)
            promising = [scored.form for scored in self.ranked()[:PROMISING]] or [
                ThreeChainForm(q, gains, {}) for q, gains in TYPICAL_SHAPES
            ]
            around = [
                (form.q, (form.l[0], form.l[1] * more, form.l[2] * most))
                for more, most in AROUND
                for form in promising
            ]
            for shape in around[: max(0, sweep - len(TYPICAL_SHAPES))]:
                price(shape)
            if self._best is None or self._best.price > enough + HOPELESS:
                return
            order = [scored.form.q for scored in self.ranked()]
            for q, count in zip(order, (steps // 2, steps // 4), strict=False):
                self._descend(q, count, price)
        except KeyboardInterrupt:
            self.interrupted = True

    def _descend(self, q: str, count: int, price: Callable[[Shape], float]) -> None:
        """Descend in l2 and l3, in units of l1, from the best form of an exponent."""
        from scipy.optimize import minimize

        start = next(scored for scored in self.ranked() if scored.form.q == q)
        first, *others = start.form.l
        x = [math.log(other) for other in others]

        def at(logs: Sequence[float]) -> float:
            second, third = (math.exp(min(max(log, -9.0), 15.0)) for log in logs)
            return min(price((q, (first, second, third))), 1e3)

        simplex = [x, [x[0] + 0.12, x[1] + 0.12], [x[0], x[1] - 0.2]]
        if count > len(simplex):  # fewer say nothing beyond the start
            minimize(
                at,
                x,
                method="Nelder-Mead",
                options={"maxfev": count, "initial_simplex": simplex, "xatol": 0.02, "fatol": 3e-3},
            )

    def ranked(self) -> list[Scored]:
        """The best form of each exponent, by price, and the known ones after them.

        Returns
        -------
        list of Scored
            None twice.
        """
        by_price = sorted(self._scored.values(), key=lambda scored: scored.price)
        best: dict[str, Scored] = {}
        for scored in by_price:
            best.setdefault(scored.form.q, scored)
        known = [self._scored[shape] for shape in KNOWN_SHAPES if shape in self._scored]
        return [*best.values(), *(scored for scored in known if scored not in best.values())]


def _short(value: float) -> float:
    return float(f"{value:.4g}")
