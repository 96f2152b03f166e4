"""One candidate of a design: gains from a few numbers, the bounds of the run, and its price."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from parkproof.laws.gains import Gains, Switching
from parkproof.spec import Spec

MARGIN = 0.98
"""Share of a limit that candidates may use; certifying costs a little."""

LEAST = 1e-9
"""Bounds and limits below it count as this one, to be compared as logarithms."""


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
            max(0.0, math.log(max(needed, LEAST) / (MARGIN * max(allowed, LEAST))))
            for needed, allowed in self.excesses(spec).values()
        )
        return math.log(aims[spec.design.aim]) + 30.0 * over
