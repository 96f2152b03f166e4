"""Designs gains: searches candidates for the least price, then certifies the one it chose."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.proof.candidates import (
    SHARE,
    Candidate,
    Engine,
    HomogeneousEngine,
    Knobs,
    PaperEngine,
)
from parkproof.proof.find_links import approach_link, two_chain_link
from parkproof.proof.limits import check_feasible, nearest, over_limits
from parkproof.proof.scaling import ThreeChainForm, TwoChainForm
from parkproof.proof.whole_run import Certified, certify
from parkproof.spec import Spec

TWO_CHAIN = ("7/9", (1.5, 6.5))
"""q2 and k̃1, k̃3 of the normalised form of holding and return: the paper's."""

FORMS = (
    ("7/9", (1.0, 2.5, 8.0)),
    ("7/9", (1.5, 4.6, 29.0)),
    ("9/11", (2.0, 4.2, 21.0)),
)
"""q1 and l of the normalised forms of Step 2 that are tried: one of little input, one for an
uncertain b2, and the paper's."""

ATTEMPTS, APART = 3, 0.005
"""How many candidates are certified at most, and by how much their times differ, as logarithms."""

RELAXED = 6.0
"""By how much the limit of the input is exceeded in search of one that would do."""

LOWEST, HIGHEST = Knobs(0.05, 0.1, 0.2, 0.15), Knobs(3.0, 6.0, 6.0, 4.0)
"""Where the search looks; the homogeneous law's τ2 has its own range."""


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


def engines(spec: Spec, progress: Callable[[str], None]) -> Iterator[Engine]:
    """The engines that a specification asks for, with their proved links.

    Parameters
    ----------
    spec : Spec
        What is wanted.
    progress : callable
        Told what is being done.

    Yields
    ------
    Engine
        One for the homogeneous law, and one for each normalised form of the paper's.

    Raises
    ------
    InputError
        If a range is too wide for any Lyapunov function tried.
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
    hold, back = forms
    if spec.design.engine != "paper":
        yield HomogeneousEngine(spec, hold, back)
    if spec.design.engine == "homogeneous":
        return
    low, high = spec.bounds.alpha_of(1)
    ranges = [(low * SHARE * (1.0 - 1e-9), high * (1.0 + 1e-9)), spec.bounds.b2]
    for q1, gains_l in FORMS:
        progress(f"Lyapunov function of the paper's Step 2, q1 = {q1}")
        link = approach_link(Gains(q1=q1, l=gains_l), ranges)
        if link is not None:
            yield PaperEngine(spec, hold, back, ThreeChainForm(q1, gains_l, link))


def _range_of(engine: Engine, spec: Spec, relaxed: float) -> list[tuple[float, float]]:
    """Logarithms of the least and largest cruise, approach and hold."""
    lows, highs = list(LOWEST[:3]), list(HIGHEST[:3])
    if isinstance(engine, HomogeneousEngine):
        weakest = spec.bounds.disturbance_of(1) / spec.bounds.gamma_of(1)[0]
        limit = spec.limits.tau[1] if spec.limits.tau else 20.0 * (1.0 + weakest)
        lows[1], highs[1] = 1.05 * weakest + 1e-2 * limit, relaxed * limit
    return [(math.log(low), math.log(high)) for low, high in zip(lows, highs, strict=True)]


class _Search:
    """Candidates of one engine: a sweep, then a descent from the best."""

    def __init__(
        self, engine: Engine, spec: Spec, looked_at: list[Candidate], relaxed: float = 1.0
    ) -> None:
        self._engine, self._spec, self._looked_at = engine, spec, looked_at
        self.best: Candidate | None = None
        self._ranges = _range_of(engine, spec, relaxed)

    def price(self, unit: Sequence[float]) -> float:
        """Price at a point of the unit cube, with the best return for it."""
        logs = [
            low + min(max(x, 0.0), 1.0) * (high - low)
            for x, (low, high) in zip(unit, self._ranges, strict=True)
        ]
        outside = sum(max(0.0, -x, x - 1.0) for x in unit)
        cruise, approach, hold = (math.exp(log) for log in logs)
        low, high = math.log(LOWEST.back), math.log(HIGHEST.back)
        found = math.inf
        for fine in (
            4,
            2,
        ):  # a coarse sweep of the return's speed, then a finer one around its best
            step = (high - low) / (2 * fine)
            prices = []
            for i in range(2 * fine + 1):
                back = low + i * step
                candidate = self._engine.candidate(Knobs(cruise, approach, hold, math.exp(back)))
                if candidate is None:
                    return 1e3 + outside
                self._looked_at.append(candidate)
                price = candidate.price(self._spec)
                prices.append((price, back))
                if self.best is None or price < self.best.price(self._spec):
                    self.best = candidate
            least, at = min(prices)
            found = min(found, least)
            low, high = at - step, at + step
        return found + outside

    def run(self, sweep: int, steps: int, progress: Callable[[float], None]) -> None:
        """Sweep the cube, then descend."""
        from scipy.optimize import minimize
        from scipy.stats import qmc

        # of any number of points the first; scipy warns of all but powers of two
        points = qmc.Sobol(3, seed=0).random_base2((sweep - 1).bit_length())[:sweep]
        prices = []
        for i, point in enumerate(points):
            prices.append((self.price(point), tuple(point)))
            progress((i + 1) / (sweep + steps))
        start = min(prices)[1]
        count = [0]

        def told(_: object) -> None:
            count[0] += 1
            progress(min(1.0, (sweep + count[0]) / (sweep + steps)))

        minimize(
            self.price,
            start,
            method="Nelder-Mead",
            callback=told,
            options={
                "maxfev": steps,
                "xatol": 2e-3,
                "fatol": 2e-3,
                "initial_simplex": _simplex(start),
            },
        )


def _simplex(start: Sequence[float]) -> list[list[float]]:
    """A start for the descent that stays in the cube."""
    corners = [list(start)]
    for i, x in enumerate(start):
        corner = list(start)
        corner[i] = x - 0.15 if x > 0.5 else x + 0.15
        corners.append(corner)
    return corners


def design(
    spec: Spec,
    *,
    sweep: int = 16,
    steps: int = 40,
    progress: Callable[[str, float], None] = lambda *_: None,
) -> Design:
    """Find gains for a specification, with a certificate.

    Parameters
    ----------
    spec : Spec
        What is wanted.
    sweep, steps : int
        How many points each engine looks at: first spread, then descending from the best.
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
    used = []
    try:
        for engine in engines(spec, lambda text: progress(text, 0.0)):
            used.append(engine)
            _look(found, engine, sweep, steps, progress)
        if found.chosen is None or over_limits(found.chosen, spec):
            for engine in used:  # beyond the limits, to say what would do
                _look(found, engine, sweep, steps // 2, progress, relaxed=RELAXED)
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


def _look(
    found: Design,
    engine: Engine,
    sweep: int,
    steps: int,
    progress: Callable[[str, float], None],
    *,
    relaxed: float = 1.0,
) -> None:
    """Search the candidates of one engine; what was found stays when the search is interrupted."""
    name = "homogeneous" if isinstance(engine, HomogeneousEngine) else "paper"
    search = _Search(engine, found.spec, found.looked_at, relaxed)
    try:
        search.run(sweep, steps, partial(progress, f"{name} engine"))
    finally:
        better, best = search.best, found.chosen
        if better is not None and (
            best is None or better.price(found.spec) < best.price(found.spec)
        ):
            found.chosen = better


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
