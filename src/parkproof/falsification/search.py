"""The search: differential evolution on compiled lanes, a whole population at a time."""

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.falsification.claims import TIME, scores_of, sizes_of
from parkproof.falsification.space import SearchSpace
from parkproof.report.measured import Proven
from parkproof.scenario import Scenario
from parkproof.simulation.ensemble import simulate_trials
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.trials import trials_of

Floats = NDArray[np.float64]
Report = Callable[[str, float], None]

POPULATION = 64
"""Runs at a time: a block of lanes. More at a time would mean fewer generations."""

DIGITS = 9
"""Points are rounded to so many digits, so that one met again is known again."""

FIRST = 0.125
"""Share of the runs that is drawn at random, before anything is improved."""

LATEST = 1.25
"""Signals switch until so many times as late as the run given was settled."""

BEST = 0.5
"""Share of a first population that is the best known for its claim; the others are for variety."""


@dataclass(frozen=True, kw_only=True)
class Worst:
    """The worst run found for a claim.

    Attributes
    ----------
    claim : Proven
        The claim.
    size : float
        What the run came to; infinite for the time of a run that did not park.
    outcome : Outcome
        How the run ended.
    scenario : Scenario
        The run.
    """

    claim: Proven
    size: float
    outcome: Outcome
    scenario: Scenario

    @property
    def share(self) -> float:
        """Size over bound; NaN where there is no bound to compare with."""
        bound = self.claim.bound
        return self.size / bound if 0.0 < bound < math.inf else math.nan

    @property
    def broken(self) -> bool:
        """Whether the run exceeds the bound."""
        return self.size > self.claim.bound


@dataclass(frozen=True, kw_only=True)
class Falsification:
    """What a search found.

    Attributes
    ----------
    worst : tuple of Worst
        One for each claim, searched for or not.
    runs : int
        Runs that were carried out.
    interrupted : bool
        Whether Ctrl-C ended the search.
    """

    worst: tuple[Worst, ...]
    runs: int
    interrupted: bool


class _SpentError(Exception):
    """The runs or the time of this part of the search are spent, or its claim is broken."""


class _Archive:
    """All runs of a search. Whatever a run was for, it counts for every claim."""

    def __init__(self, space: SearchSpace, claims: Sequence[Proven], threads: int) -> None:
        self.space, self.claims, self.threads = space, claims, threads
        self.points: list[Floats] = []
        self.scores: list[Floats] = []
        self.runs = 0
        self.worst: list[tuple[float, float, Outcome, Scenario]] = []
        self._known: dict[bytes, Floats] = {}

    def carry_out(self, scenarios: Sequence[Scenario]) -> tuple[Floats, dict[str, Any]]:
        """Run, and keep the worst of each claim; gives the scores, a column a run."""
        rows = simulate_trials(scenarios[0], trials_of(scenarios), threads=self.threads)
        self.runs += len(scenarios)
        sizes = sizes_of(self.claims, rows)
        scores = scores_of(self.claims, sizes, rows)
        for i, j in enumerate(np.argmax(scores, axis=1)):
            one = (float(scores[i, j]), float(sizes[i, j]), rows["outcome"][j], scenarios[j])
            if i == len(self.worst):
                self.worst.append(one)
            elif one[0] > self.worst[i][0]:
                self.worst[i] = one
        return scores, rows

    def broken(self, place: int) -> bool:
        """Whether a run that breaks a claim is known."""
        return self.worst[place][1] > self.claims[place].bound

    def scores_at(self, points: Floats) -> Floats:
        """Scores of points, a row a point; those met before are not run again."""
        rounded = np.round(points, DIGITS)
        keys = [point.tobytes() for point in rounded]
        met = dict(zip(keys, rounded, strict=True))
        fresh = {key: point for key, point in met.items() if key not in self._known}
        if fresh:
            scores, _ = self.carry_out([self.space.scenario_at(p) for p in fresh.values()])
            for (key, point), column in zip(fresh.items(), scores.T, strict=True):
                self._known[key] = column
                self.points.append(point)
                self.scores.append(column)
        return np.array([self._known[key] for key in keys])


def falsify(
    space: SearchSpace,
    claims: Sequence[Proven],
    *,
    objectives: Sequence[Proven],
    runs: int = 8192,
    seconds: float = math.inf,
    seed: int = 0,
    threads: int = 1,
    progress: Report = lambda doing, fraction: None,  # noqa: ARG005
) -> Falsification:
    """Search for runs that break claims, or come nearest to their bounds.

    Parameters
    ----------
    space : SearchSpace
        Starts and truths.
    claims : sequence of Proven
        What is looked at in every run.
    objectives : sequence of Proven
        The claims that are searched for, one after the other; each ends when it is broken, and what
        is left goes to the others.
    runs : int
        At most so many runs, up to a population more.
    seconds : float
        At most so long, about; then the result depends on the machine.
    seed : int
        The same seed gives the same search.
    threads : int
        Nothing depends on it but the time.
    progress : callable
        Called with what is being done and the fraction done.

    Returns
    -------
    Falsification
        The worst run of every claim. Ctrl-C gives what was found until then.

    Examples
    --------
    >>> from parkproof.falsification.claims import claims_of
    >>> from parkproof.falsification.space import space_of_scenario
    >>> from parkproof.scenario import RunSettings, Start
    >>> from parkproof.bounds import Bounds
    >>> scenario = Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)),
    ...                     bounds=Bounds(alpha=(0.8, 1.2)),
    ...                     run=RunSettings(duration=12.0, control_period=0.02))
    >>> claims = claims_of(scenario)
    >>> found = falsify(space_of_scenario(scenario), claims, objectives=claims[:1], runs=256)
    >>> found.runs >= 256, found.worst[0].broken
    (True, False)
    """
    begin = time.monotonic()
    rng = np.random.default_rng(seed)
    archive = _Archive(space, claims, threads)
    progress("the run as given", 0.0)
    _, rows = archive.carry_out([space.base])
    total = float(rows["total"][0])
    if math.isfinite(total):
        archive.space = replace(space, horizon=min(space.horizon, LATEST * total))
    places = [claims.index(claim) for claim in objectives]

    def spent() -> float:
        return max(archive.runs / runs, (time.monotonic() - begin) / seconds)

    interrupted = False
    try:
        while archive.runs == 1 or (spent() < FIRST and not all(map(archive.broken, places))):
            progress(f"{archive.runs} runs at random", spent())
            archive.scores_at(rng.random((POPULATION, space.dimension)))
        for order, place in enumerate(places):
            left = 1.0 - spent()
            until = spent() + left / (len(places) - order)
            _improve(archive, place, rng, spent, until, progress)
    except KeyboardInterrupt:
        interrupted = True
    worst = tuple(
        Worst(claim=claim, size=size, outcome=outcome, scenario=scenario)
        for claim, (_, size, outcome, scenario) in zip(claims, archive.worst, strict=True)
    )
    return Falsification(worst=worst, runs=archive.runs, interrupted=interrupted)


def _improve(
    archive: _Archive,
    place: int,
    rng: np.random.Generator,
    spent: Callable[[], float],
    until: float,
    progress: Report,
) -> None:
    """Differential evolution for one claim, from the best that is known for it."""
    from scipy.optimize import differential_evolution

    claim = archive.claims[place]

    def scores(columns: Floats) -> Floats:
        if spent() >= until or archive.broken(place):
            raise _SpentError
        progress(_said(claim, archive.worst[place][1]), spent())
        return -archive.scores_at(np.clip(columns.T, 0.0, 1.0))[:, place]

    known = np.array(archive.points)
    order = np.argsort([-column[place] for column in archive.scores], kind="stable")
    best = order[: int(BEST * POPULATION)]
    others = rng.permutation(order[len(best) :])[: POPULATION - len(best)]
    first = known[np.concatenate([best, others])]
    with suppress(_SpentError):
        differential_evolution(
            scores,
            [(0.0, 1.0)] * archive.space.dimension,
            init=first,
            maxiter=10**9,
            tol=0.0,
            seed=rng,
            polish=False,
            vectorized=True,
            updating="deferred",
        )


def _said(claim: Proven, size: float) -> str:
    """How far a search has come, for its progress."""
    if claim.name == TIME and not math.isfinite(size):
        return "a run that does not park"
    if not 0.0 < claim.bound < math.inf:
        return f"{claim.name}: {size:.4g} so far"
    return f"{claim.name}: {size / claim.bound:.3f} of its bound so far"
