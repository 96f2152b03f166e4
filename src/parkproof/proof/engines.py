"""The engines of a design: from a few numbers they make gains, with bounds of the runs.

The bounds are computed from links that were proved in normalised form or found by the matrix
inequality; the candidate that is chosen is certified again as a whole.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

from msgspec.structs import replace

from parkproof.errors import InputError
from parkproof.laws.gains import Gains, Switching
from parkproof.proof.candidates import MARGIN, Candidate, Knobs
from parkproof.proof.checker.balls import up
from parkproof.proof.checker.ellipsoid import Ellipsoid
from parkproof.proof.checker.links import Homogeneous, Link, PowerIntegrator
from parkproof.proof.checker.parts import Box, GapError, Law, Links, Peaks, Uncertainty
from parkproof.proof.checker.starts import boxes, directions
from parkproof.proof.checker.whole_run import gain_range, run_bounds, run_up
from parkproof.proof.law_section import law_section
from parkproof.proof.lmi import HomogeneousGains, homogeneous_gains
from parkproof.proof.scaling import ThreeChainForm, TwoChainForm
from parkproof.spec import Spec

RUN_UP_TIME = 0.15
"""Time in s that the run-up takes at most, where the input allows."""

SHARE = 0.9
"""The approach begins at this share of the run-up speed."""

ALL_HEADINGS = 30.0
"""Heading in degrees beyond which a robot turns first, where starts are poses."""

Direction = Literal["toward", "forward", "backward"]
"""Directions of travel that are tried."""


def directions_of(spec: Spec) -> tuple[Direction, ...]:
    """Directions of travel that are worth trying.

    "auto" is not: its bounds hold for both ways from every start, those of "toward" for one way
    from each, and those of "forward" for one from all; so it never has the better bounds. Where
    starts and view are symmetric about 0, forward and backward have mirrored bounds, and "toward"
    goes each way from a part of the starts; so it has bounds at least as good.

    Parameters
    ----------
    spec : Spec
        Starts and view.

    Returns
    -------
    tuple of str
        The first is "toward".

    Examples
    --------
    >>> from parkproof.bounds import Limits
    >>> from parkproof.bounds import Bounds
    >>> directions_of(Spec(bounds=Bounds()))
    ('toward',)
    >>> ahead = Limits(view=(-1.5, 5.0, -3.0, 3.0))
    >>> directions_of(Spec(bounds=Bounds(), limits=ahead))
    ('toward', 'forward', 'backward')
    """
    ranges, view = spec.starts.ranges, spec.limits.view
    along = [pair for name, pair in ranges.items() if name in ("x0", "u0", "x", "v")]
    if view is not None:
        along.append(view[:2])
    if all(low == -high for low, high in along):
        return ("toward",)
    return ("toward", "forward", "backward")


class Engine(Protocol):
    """Makes candidates."""

    @property
    def name(self) -> str:
        """Which one it is, for a reader."""

    def candidate(self, knobs: Knobs) -> Candidate | None:
        """The candidate with these numbers, or None if it has no proof."""


@dataclass(frozen=True)
class _Common:
    """What both engines share: holding, return, run-up, direction and the specification."""

    spec: Spec
    hold: TwoChainForm
    back: TwoChainForm
    direction: Direction

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
            direction=self.direction,
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
    spec, hold, back, direction
        The specification, normalised forms of holding and return, and the direction of travel.
    approach : ThreeChainForm
        Normalised form of Step 2.

    Examples
    --------
    >>> list(PaperEngine.__dataclass_fields__)
    ['spec', 'hold', 'back', 'direction', 'approach']
    """

    approach: ThreeChainForm

    @property
    def name(self) -> str:
        """Which one it is, for a reader."""
        return "paper"

    def candidate(self, knobs: Knobs) -> Candidate | None:
        """The candidate with these numbers, or None if it has no proof."""
        gains, switching, hold, back = self.gains(knobs)
        l, link = self.approach.scaled(knobs.approach, gains.runup_speed)  # noqa: E741
        try:
            whole = replace(gains, l=l, q1=self.approach.q)
        except InputError:  # gains beyond those that a law takes
            return None
        return self.finished("corrected", whole, switching, Links(link, hold, back))


@dataclass(frozen=True)
class HomogeneousEngine(_Common):
    """The homogeneous law, whose Step 2 comes from a matrix inequality.

    Examples
    --------
    >>> list(HomogeneousEngine.__dataclass_fields__)
    ['spec', 'hold', 'back', 'direction', '_solved']
    """

    _solved: dict[tuple[float, ...], HomogeneousGains | None] = field(
        default_factory=dict, repr=False
    )

    @property
    def name(self) -> str:
        """Which one it is, for a reader."""
        return "homogeneous"

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
