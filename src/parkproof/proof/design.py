"""Designs gains: searches candidates for the least price, then certifies the one it chose."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.proof.candidates import Candidate
from parkproof.proof.engines import HomogeneousEngine, directions_of
from parkproof.proof.find_links import approach_link, two_chain_link
from parkproof.proof.knob_search import KnobSearch
from parkproof.proof.limits import check_feasible, nearest, over_limits
from parkproof.proof.scaling import ThreeChainForm, TwoChainForm
from parkproof.proof.shapes import Scored, ShapeSearch, normal_ranges
from parkproof.proof.whole_run import Certified, certify
from parkproof.spec import Spec

TWO_CHAIN = ("7/9", (1.5, 6.5))
"""q2 and k̃1, k̃3 of the normalised form of holding and return: the paper's."""

ATTEMPTS, APART = 3, 0.005
"""How many candidates are certified at most, and by how much their times differ, as logarithms."""

PROOFS = 3
"""How many forms of the paper's Step 2 are proved at most, beside those that cannot be."""

COARSE = 4
"""Points at which directions of travel are compared, at most."""

AT_ONCE = 6
"""Candidates of the paper's engine that a descent looks at, for each step of the other's."""

RELAXED = 6.0
"""By how much the limit of the input is exceeded in search of one that would do."""

Progress = Callable[[str, float], None]


@dataclass
class Design:
    """What a design found.

    Attributes
    ----------
    spec : Spec
        For what.
    chosen : Candidate or None
        The best candidate; None if none was found at all.
    certificate : dict or None
        Its certificate; None if a limit cannot be kept.
    reason : str
        Why there is no certificate.
    looked_at : list of Candidate
        All candidates, with bounds that follow from proved links.
    interrupted : bool
        Whether the search was cut short.

    Examples
    --------
    >>> from parkproof.bounds import Bounds
    >>> Design(Spec(bounds=Bounds())).certificate is None
    True
    """

    spec: Spec
    chosen: Candidate | None = None
    certificate: dict[str, Any] | None = None
    reason: str = ""
    looked_at: list[Candidate] = field(default_factory=list)
    interrupted: bool = False


def two_chain_forms(
    spec: Spec, progress: Callable[[str], None] = lambda _: None
) -> tuple[TwoChainForm, TwoChainForm]:
    """Normalised forms of holding and of the return, proved.

    Parameters
    ----------
    spec : Spec
        What is uncertain.
    progress : callable
        Told what is being done.

    Returns
    -------
    tuple
        Holding, return.

    Raises
    ------
    InputError
        If a range is too wide for any Lyapunov function tried.

    Examples
    --------
    >>> from parkproof.bounds import Bounds
    >>> hold, back = two_chain_forms(Spec(bounds=Bounds(alpha=(0.5, 1.5))))
    >>> hold.link["rate"] > back.link["rate"] > 0.5
    True
    """
    q, k = TWO_CHAIN
    forms = []
    for name, gains in (("b2", spec.bounds.b2), ("alpha[0]", spec.bounds.alpha_of(0))):
        progress(f"Lyapunov function of two integrators for {name} in {list(gains)}")
        link = two_chain_link(q, k, gains)
        if link is None:
            raise InputError(
                f"bounds.{name} = {list(gains)}: no Lyapunov function was found for so wide a "
                "range; narrow it"
            )
        forms.append(TwoChainForm(q, k, link))
    return forms[0], forms[1]


def design(
    spec: Spec,
    *,
    sweep: int = 16,
    steps: int = 40,
    progress: Progress = lambda *_: None,
) -> Design:
    """Find gains for a specification, with a certificate.

    Parameters
    ----------
    spec : Spec
        What is wanted.
    sweep, steps : int
        How many points each engine looks at: first spread, then descending from the best. So
        many forms of the paper's Step 2 are tried, too.
    progress : callable
        Told what is being done, and which share of it is done.

    Returns
    -------
    Design
        The certificate, or why there is none. Interrupted (KeyboardInterrupt), it certifies the
        best found so far.

    Raises
    ------
    InputError
        If no gains can do what is wanted.

    Examples
    --------
    >>> from parkproof.bounds import Bounds, Limits
    >>> from parkproof.spec import Aim, Starts
    >>> near = Starts(x0=(-0.2, 0.2), x1=(-0.1, 0.1), x2=(0, 0))
    >>> spec = Spec(bounds=Bounds(alpha=(0.9, 1.1)), starts=near,
    ...             limits=Limits(tau=(40, 40)), design=Aim(engine="homogeneous"))
    >>> found = design(spec, sweep=2, steps=2)
    >>> found.certificate["claim"]["max_tau"][1] < 40
    True
    """
    from flint import ctx

    from parkproof.proof.checker.certificate import PRECISION

    ctx.prec = PRECISION
    check_feasible(spec)
    found = Design(spec)
    engine = None
    try:
        hold, back = two_chain_forms(spec, lambda text: progress(text, 0.0))
        if spec.design.engine != "paper":
            engine = _homogeneous(found, hold, back, sweep, steps, progress)
        if spec.design.engine != "homogeneous":
            _paper(found, hold, back, sweep, steps, progress)
        beyond = found.chosen is None or over_limits(found.chosen, spec)
        if engine is not None and beyond and not found.interrupted:
            # beyond the limits, to say what would do
            search = KnobSearch(engine, spec, found.looked_at, RELAXED)
            _search(found, search, sweep, steps // 2, progress)
    except KeyboardInterrupt:
        found.interrupted = True
    if found.chosen is None:
        found.reason = (
            "the search was stopped before it found any gains"
            if found.interrupted
            else "no gains were found for which whole runs are proved to park"
        )
        return found
    if over_limits(found.chosen, spec):
        found.reason = nearest(spec, found.looked_at, found.chosen)
        return found
    progress("certifying the best candidate", 0.0)
    return _certified(found, lambda text: progress(f"certifying: {text}", 0.0))


def _search(found: Design, search: KnobSearch, sweep: int, steps: int, progress: Progress) -> None:
    """Search the candidates of one engine; what was found stays when the search is interrupted."""
    done = [0]

    def told() -> None:
        done[0] += 1
        progress(f"{search.engine.name} engine", min(1.0, done[0] / (sweep + steps)))

    try:
        search.sweep(sweep, told)
        search.descend(steps, told)
    finally:
        _take(found, search)


def _take(found: Design, search: KnobSearch) -> None:
    """Choose the best of a search if it is better than what was chosen."""
    if search.best is not None and search.price < _price(found):
        found.chosen = search.best


def _price(found: Design) -> float:
    return math.inf if found.chosen is None else found.chosen.price(found.spec)


def _best_way(found: Design, searches: Sequence[KnobSearch], points: int) -> KnobSearch:
    """The search in the best direction of travel, by a coarse sweep of each."""
    if len(searches) > 1:
        for search in searches:
            try:
                search.sweep(points)
            finally:
                _take(found, search)
    return min(searches, key=lambda search: search.price)


def _homogeneous(
    found: Design,
    hold: TwoChainForm,
    back: TwoChainForm,
    sweep: int,
    steps: int,
    progress: Progress,
) -> HomogeneousEngine:
    """Search the candidates of the homogeneous law in the best direction; give that engine."""
    spec = found.spec
    ways = [HomogeneousEngine(spec, hold, back, way) for way in directions_of(spec)]
    if len(ways) > 1:
        progress("homogeneous engine: directions of travel", 0.0)
    searches = [KnobSearch(engine, spec, found.looked_at) for engine in ways]
    best = _best_way(found, searches, min(COARSE, sweep))
    _search(found, best, sweep, steps, progress)
    return ways[searches.index(best)]


def _paper(
    found: Design,
    hold: TwoChainForm,
    back: TwoChainForm,
    sweep: int,
    steps: int,
    progress: Progress,
) -> None:
    """Sample forms of the paper's Step 2, prove the few best, and search their candidates.

    A form is proved only if, as sampled, it is better than what was found until then: proofs make
    bounds a little worse, not better.
    """
    spec, shapes = found.spec, ShapeSearch(found.spec, hold, back)
    shapes.run(
        sweep,
        steps,
        enough=_price(found),
        progress=lambda share: progress("shapes of the paper's Step 2, sampled", share),
    )
    found.interrupted = shapes.interrupted
    proofs = 0
    for scored in shapes.ranked():
        if scored.price >= _price(found) or proofs == PROOFS:
            return
        form = _proved(scored, spec, progress)
        if form is None:
            continue
        proofs += 1
        searches = [
            KnobSearch(shapes.engine(form, way), spec, found.looked_at)
            for way in directions_of(spec)
        ]
        for search in searches:
            search.look(scored.knobs)
            _take(found, search)
        if found.interrupted:
            return
        best = _best_way(found, searches, min(COARSE, sweep))
        best.descend_at_once(AT_ONCE * steps, scored.knobs)
        _take(found, best)
        _search(found, best, sweep, 0, progress)
        best.descend_at_once(AT_ONCE * steps)
        _take(found, best)


def _proved(scored: Scored, spec: Spec, progress: Progress) -> ThreeChainForm | None:
    """A form with a link that is proved instead of sampled; None if it cannot be."""
    form = scored.form
    gains = ", ".join(f"{gain:g}" for gain in form.l)
    progress(f"Lyapunov function of the paper's Step 2, q1 = {form.q}, l = ({gains})", 0.0)
    link = approach_link(Gains(q1=form.q, l=form.l), normal_ranges(spec))
    return None if link is None else replace(form, link=link)


def _certified(found: Design, progress: Callable[[str], None]) -> Design:
    """The design with the certificate of its best candidate that keeps the limits by its claim.

    Weights are sought anew for the rounded gains, so a claim may miss a limit that the candidate
    just kept; then the next best that differs is tried.
    """
    spec = found.spec
    kept = [c for c in found.looked_at if not over_limits(c, spec)]
    result, tried = Certified(None, "no candidate keeps the limits"), list[float]()
    for candidate in sorted(kept, key=lambda c: c.price(spec)):
        if any(abs(math.log(candidate.time / other)) < APART for other in tried):
            continue
        result = certify(
            law="homogeneous" if candidate.law == "homogeneous" else "corrected",
            bounds=spec.bounds,
            gains=candidate.gains,
            switching=candidate.switching,
            starts=spec.starts.ranges,
            progress=progress,
        )
        tried.append(candidate.time)
        if result.certificate is not None:
            claimed = candidate.with_claim(result.certificate["claim"])
            if not over_limits(claimed, spec):
                return replace(found, chosen=claimed, certificate=result.certificate)
        if len(tried) == ATTEMPTS:
            break
    return replace(found, reason=result.reason or "the certified bounds miss a limit by a little")
