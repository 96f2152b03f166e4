"""One candidate of a design: gains from a few numbers, and the bounds of the run under them.

The bounds are computed from links that were proved in normalised form or found by the matrix
inequality; the candidate that is chosen is certified again as a whole.
"""

import dataclasses
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from msgspec.structs import replace

from parkproof.laws.gains import Gains, Switching
from parkproof.proof.checker.balls import up
from parkproof.proof.checker.ellipsoid import Ellipsoid
from parkproof.proof.checker.links import Homogeneous, Link, PowerIntegrator
from parkproof.proof.checker.parts import Box, GapError, Law, Links, Peaks, Uncertainty
from parkproof.proof.checker.starts import boxes, directions
from parkproof.proof.checker.whole_run import gain_range, run_bounds, run_up
from parkproof.proof.lmi import HomogeneousGains, homogeneous_gains
from parkproof.proof.scaling import ThreeChainForm, TwoChainForm
from parkproof.proof.whole_run import law_section
from parkproof.spec import Spec

RUN_UP_TIME = 0.15
"""Time in s that the run-up takes at most, where the input allows."""

SHARE = 0.9
"""The approach begins at this share of the run-up speed."""

ALL_HEADINGS = 30.0
"""Heading in degrees beyond which a robot turns first, where starts are poses."""

MARGIN = 0.98
"""Share of a limit that candidates may use; certifying costs a little."""


class Knobs(NamedTuple):
    """What a design varies.

    Attributes
    ----------
    cruise : float
        Run-up speed.
    approach : float
        Time scale of the paper's Step 2, or |τ2| of the homogeneous law.
    hold, back : float
        Time scales of holding and of the return.
    """

    cruise: float
    approach: float
    hold: float
    back: float


@dataclass(frozen=True)
class Candidate:
    """Gains, and the bounds of the run under them.

    Attributes
    ----------
    law : str
        "corrected" or "homogeneous".
    gains : Gains
        All gains.
    switching : Switching
        When the law switches.
    time, travel, heading : float
        Bounds of the total time, of |x0| and of |x2|.
    tau : pair of floats
        Bounds of |τ1|, |τ2|.
    speed, turn_rate, across : float
        Bounds of |v|, |ω| and |x1|.
    x0 : pair of floats
        Range of x0.
    x1_at_rest : float
        Bound of |x1| at the end.

    Examples
    --------
    >>> "travel" in Candidate.__dataclass_fields__
    True
    """

    law: str
    gains: Gains
    switching: Switching
    time: float
    travel: float
    heading: float
    tau: tuple[float, float]
    speed: float
    turn_rate: float
    across: float
    x0: tuple[float, float]
    x1_at_rest: float

    def with_claim(self, claim: dict[str, Any]) -> "Candidate":
        """The same gains with the bounds that a certificate claims.

        Parameters
        ----------
        claim : dict
            Its section "claim".

        Returns
        -------
        Candidate
            With these bounds.
        """
        low, high = claim["x0_range"]
        tau1, tau2 = claim["max_tau"]
        return dataclasses.replace(
            self,
            time=claim["total_time"],
            travel=claim["max_abs_state"][0],
            heading=claim["max_abs_state"][2],
            tau=(tau1, tau2),
            speed=claim["max_speed"],
            turn_rate=claim["max_turn_rate"],
            across=claim["max_abs_state"][1],
            x0=(low, high),
            x1_at_rest=claim["x1_at_rest"],
        )

    def excesses(self, spec: Spec) -> dict[str, tuple[float, float]]:
        """Each limit of the specification with what this candidate needs of it.

        Parameters
        ----------
        spec : Spec
            Its limits.

        Returns
        -------
        dict
            By the name of the limit: what is needed, and what is allowed.
        """
        limits, aim = spec.limits, spec.design
        pairs: dict[str, tuple[float, float]] = {
            "design.x1_at_rest": (self.x1_at_rest, aim.x1_at_rest)
        }
        if limits.tau is not None:
            for i in range(2):
                pairs[f"limits.tau[{i}]"] = (self.tau[i], limits.tau[i])
        if limits.speed is not None:
            pairs["limits.speed"] = (self.speed, limits.speed)
        if limits.turn_rate is not None:
            pairs["limits.turn_rate"] = (self.turn_rate, limits.turn_rate)
        if aim.time_limit is not None:
            pairs["design.time_limit"] = (self.time, aim.time_limit)
        if limits.view is not None:
            low, high, below, above = limits.view
            needed = (-self.x0[0], self.x0[1], self.across, self.across)
            allowed = (-low, high, -below, above)
            for i, pair in enumerate(zip(needed, allowed, strict=True)):
                pairs[f"limits.view[{i}]"] = pair
        return pairs

    def price(self, spec: Spec) -> float:
        """What a design makes least: the aim, and far more for every limit that is exceeded.

        Parameters
        ----------
        spec : Spec
            Aim and limits.

        Returns
        -------
        float
            The price.
        """
        sizes = [self.tau[i] / (spec.limits.tau or (1.0, 1.0))[i] for i in range(2)]
        aims = {"time": self.time, "input": max(sizes), "travel": self.travel}
        over = sum(
            max(0.0, math.log(max(needed, 1e-9) / (MARGIN * allowed)))
            for needed, allowed in self.excesses(spec).values()
        )
        return math.log(aims[spec.design.aim]) + 30.0 * over


class Engine(Protocol):
    """Makes candidates."""

    def candidate(self, knobs: Knobs) -> Candidate | None:
        """The candidate with these numbers, or None if it has no proof."""


@dataclass(frozen=True)
class _Common:
    """What both engines share: holding, return, run-up and the specification."""

    spec: Spec
    hold: TwoChainForm
    back: TwoChainForm

    def gains(self, knobs: Knobs) -> tuple[Gains, Switching, PowerIntegrator, PowerIntegrator]:
        """Gains without those of the approach, and the links of holding and return."""
        spec = self.spec
        hold_gains, hold = self.hold.scaled(knobs.hold)
        back_gains, back = self.back.scaled(knobs.back)
        ranges = spec.starts.ranges
        speed = max(abs(end) for end in ranges.get("u0", ranges.get("v", (0.0, 0.0))))
        error = knobs.cruise + speed
        quick = error ** (2.0 / 3.0) / (RUN_UP_TIME * 2.0 / 3.0)
        gamma, phi = spec.bounds.gamma_of(0)[0], spec.bounds.disturbance_of(0)
        if spec.limits.tau is not None:
            strongest = MARGIN * gamma * spec.limits.tau[0] - phi
            quick = min(quick, max(strongest, 1e-3) / error ** (1.0 / 3.0))
        gains = Gains(
            q0="1/3",
            q2=self.hold.q,
            lambda1=float(f"{quick:.5g}"),
            k=back_gains,
            hold=hold_gains,
            runup_speed=float(f"{knobs.cruise:.5g}"),
            direction="toward",
            return_steering=False,
        )
        tolerance = spec.design.tolerance
        # where the start may face anywhere, a robot that is aslant turns first
        limit = ALL_HEADINGS if "theta" in ranges else Switching().chart_limit
        switching = Switching(
            chart_limit=limit,
            tolerance=(float(f"{(1.0 - SHARE) * gains.runup_speed:.5g}"), tolerance, tolerance),
            hysteresis=float(f"{spec.design.x1_at_rest / tolerance:.6g}"),
            turn_tolerance=tolerance,
        )
        return gains, switching, hold, back

    def known(self) -> Uncertainty:
        """What is uncertain, as the checker takes it."""
        bounds = self.spec.bounds
        return Uncertainty.of(
            {
                "alpha": [bounds.alpha_of(i) for i in range(2)],
                "gamma": [bounds.gamma_of(i) for i in range(2)],
                "disturbance": [bounds.disturbance_of(i) for i in range(2)],
                "b2": bounds.b2,
            }
        )

    def finished(
        self, name: str, gains: Gains, switching: Switching, links: Links
    ) -> Candidate | None:
        """The candidate with its bounds."""
        # a drift beyond the hysteresis is a limit that is exceeded, not the end of the search
        loose = {**law_section(name, gains, switching), "hysteresis": 1e6}
        try:
            peaks, _ = run_bounds(self.spec.starts.ranges, Law.of(loose), self.known(), links)
        except (GapError, ValueError, OverflowError):
            return None
        _, across, heading, _, _ = (up(state) for state in peaks.states)
        low, high = -up(-peaks.x0[0]), up(peaks.x0[1])
        found = Candidate(
            law=name,
            gains=gains,
            switching=switching,
            time=up(peaks.time),
            travel=max(-low, high),
            heading=heading,
            tau=(up(peaks.tau[0]), up(peaks.tau[1])),
            speed=up(peaks.speed),
            turn_rate=up(peaks.turn_rate),
            across=across,
            x0=(low, high),
            x1_at_rest=up(peaks.x1_at_rest),
        )
        return found if math.isfinite(found.time) else None


@dataclass(frozen=True)
class PaperEngine(_Common):
    """The corrected law with the paper's Step 2.

    Attributes
    ----------
    spec, hold, back
        The specification, and normalised forms of holding and return.
    approach : ThreeChainForm
        Normalised form of Step 2.

    Examples
    --------
    >>> list(PaperEngine.__dataclass_fields__)
    ['spec', 'hold', 'back', 'approach']
    """

    approach: ThreeChainForm

    def candidate(self, knobs: Knobs) -> Candidate | None:
        """The candidate with these numbers, or None if it has no proof."""
        gains, switching, hold, back = self.gains(knobs)
        l, link = self.approach.scaled(knobs.approach, gains.runup_speed)  # noqa: E741
        whole = replace(gains, l=l, q1=self.approach.q)
        return self.finished("corrected", whole, switching, Links(link, hold, back))


@dataclass(frozen=True)
class HomogeneousEngine(_Common):
    """The homogeneous law, whose Step 2 comes from a matrix inequality.

    Examples
    --------
    >>> list(HomogeneousEngine.__dataclass_fields__)
    ['spec', 'hold', 'back', '_solved']
    """

    _solved: dict[tuple[float, ...], HomogeneousGains | None] = field(
        default_factory=dict, repr=False
    )

    def candidate(self, knobs: Knobs) -> Candidate | None:
        """The candidate with these numbers, or None if it has no proof."""
        gains, switching, hold, back = self.gains(knobs)
        key = knobs[:3]  # the speed of the return comes later, and is varied most
        if key not in self._solved:
            self._solved[key] = self._solve(knobs.approach, gains, switching, hold)
        found = self._solved[key]
        if found is None:
            return None
        ellipsoid = Ellipsoid(found.ellipsoid, found.feedback)
        link: Link = Homogeneous(ellipsoid, found.rate, found.rho)
        whole = replace(gains, ellipsoid=found.ellipsoid, feedback=found.feedback)
        return self.finished("homogeneous", whole, switching, Links(link, hold, back))

    def _solve(
        self, tau_max: float, gains: Gains, switching: Switching, hold: PowerIntegrator
    ) -> HomogeneousGains | None:
        """The fastest approach from all states in which the run-up can end."""
        bounds = self.spec.bounds
        law, known = Law.of(law_section("corrected", gains, switching)), self.known()
        gamma, phi = bounds.gamma_of(1), bounds.disturbance_of(1)
        if phi >= gamma[0] * tau_max:
            return None
        try:
            starting = list(boxes(self.spec.starts.ranges, law, known, hold, Peaks()))
            b1 = gain_range(law, known, starting)
            ends = [
                run_up(box, way, x0, law, known, hold, Peaks())
                for box in starting
                for way, x0 in directions(law, box)
            ]
        except (GapError, ValueError, OverflowError):
            return None
        return homogeneous_gains(
            b1=b1,
            b2=bounds.b2,
            gamma=gamma,
            disturbance=phi,
            tau_max=tau_max,
            starts=_corners(ends),
        )


def _corners(ends: Sequence[Box]) -> list[tuple[float, float, float]]:
    """Half of the corners of the boxes in which a run-up ends; the others follow by symmetry."""
    sizes = {(up(box.x1), up(box.x2[1]), up(box.u1[1])) for box in ends}
    return [
        (x1, s * x2, t * u1) for x1, x2, u1 in sizes for s, t in itertools.product((1, -1), (1, -1))
    ]
