"""The parts of a whole run's proof: the law, what is uncertain, boxes of states, largest values."""

from dataclasses import dataclass, field
from typing import Any

from flint import arb

from parkproof.proof.checker.balls import Range, exact, largest, least, size
from parkproof.proof.checker.links import Interval, Link, PowerIntegrator


class GapError(Exception):
    """A link of the chain of reasoning that does not hold, with the reason."""


@dataclass(frozen=True)
class Law:
    """What the whole run needs of the law, exactly.

    Attributes
    ----------
    q0, lambda1, cruise : arb
        Exponent and gain of Step 1, and |u0| at its end.
    direction : str
        "forward", "backward", "toward" or "auto".
    tolerance1, tolerance2 : arb
        At which Steps 1 and 2 end.
    hysteresis, turn_tolerance, chart_limit : arb
        As in [switching]; the limit in rad.
    """

    q0: arb
    lambda1: arb
    cruise: arb
    direction: str
    tolerance1: arb
    tolerance2: arb
    hysteresis: arb
    turn_tolerance: arb
    chart_limit: arb

    @staticmethod
    def of(given: dict[str, Any]) -> "Law":
        """Read a certificate's section "law"."""
        one, two, _ = (exact(tolerance) for tolerance in given["tolerance"])
        return Law(
            q0=exact(given["q0"]),
            lambda1=exact(given["lambda1"]),
            cruise=exact(given["runup_speed"]),
            direction=given["direction"],
            tolerance1=one,
            tolerance2=two,
            hysteresis=exact(given["hysteresis"]),
            turn_tolerance=exact(given["turn_tolerance"]),
            chart_limit=exact(given["chart_limit"]) * arb.pi() / 180,
        )

    @property
    def turn_again(self) -> arb:
        """|x2| beyond which the law turns again."""
        angle = self.chart_limit + exact("19/20") * (arb.pi() / 2 - self.chart_limit)
        return (angle * (1 - exact("1/1000000000000"))).tan()  # the law compares in floats


@dataclass(frozen=True)
class Uncertainty:
    """What is uncertain: the section "assumptions" of a certificate.

    Attributes
    ----------
    alpha, gamma : two ranges each
        Bounds of α_i and γ_i.
    phi : tuple of two floats
        Bounds of |φ_i|.
    b2 : pair of floats
        Range of the gain in ẋ2 = b2·u1.
    """

    alpha: tuple[Range, Range]
    gamma: tuple[Range, Range]
    phi: tuple[float, float]
    b2: Range

    @staticmethod
    def of(given: dict[str, Any]) -> "Uncertainty":
        """Read a certificate's section "assumptions"."""
        (a1, a2), (g1, g2), (f1, f2) = given["alpha"], given["gamma"], given["disturbance"]
        low, high = given["b2"]
        return Uncertainty(
            ((a1[0], a1[1]), (a2[0], a2[1])),
            ((g1[0], g1[1]), (g2[0], g2[1])),
            (f1, f2),
            (low, high),
        )


@dataclass(frozen=True)
class Links:
    """The proofs of the three chains: (x1, x2, u1), (x2, u1) or (θ, ω), and (x0, u0)."""

    approach: Link
    hold: PowerIntegrator
    back: PowerIntegrator


@dataclass
class Peaks:
    """Largest values met so far; all are upper bounds.

    Attributes
    ----------
    tau : list of 2 arb
        |τ1|, |τ2|.
    states : list of 5 arb
        |x0|, |x1|, |x2|, |u0|, |u1|.
    speed, turn_rate, heading : arb
        |v|, |ω|, |θ|.
    x0 : list of 2 arb
        Least and largest x0.
    time, x1_at_rest : arb
        Total time, and |x1| at the end.
    """

    tau: list[arb] = field(default_factory=lambda: [arb(0), arb(0)])
    states: list[arb] = field(default_factory=lambda: [arb(0)] * 5)
    speed: arb = field(default_factory=arb)
    turn_rate: arb = field(default_factory=arb)
    heading: arb = field(default_factory=arb)
    x0: list[arb] = field(default_factory=lambda: [arb(0), arb(0)])
    time: arb = field(default_factory=arb)
    x1_at_rest: arb = field(default_factory=arb)

    def meet(self, x0: Interval, x1: arb, x2: arb, u0: arb, u1: arb, tau1: arb, tau2: arb) -> None:
        """Take in a phase inside the chart."""
        self.x0 = [least(self.x0[0], x0[0]), largest(self.x0[1], x0[1])]
        sizes = [largest(-self.x0[0], self.x0[1]), x1, x2, u0, u1]
        self.states = [largest(a, b) for a, b in zip(self.states, sizes, strict=True)]
        self.tau = [largest(self.tau[0], tau1), largest(self.tau[1], tau2)]
        self.speed = largest(self.speed, u0 * (1 + x2 * x2).sqrt())
        self.turn_rate = largest(self.turn_rate, u1)
        self.heading = largest(self.heading, x2.atan())


@dataclass(frozen=True)
class Box:
    """A box of states inside the chart at the start of Step 1 or 3, after some time."""

    x0: Interval
    x1: arb
    x2: Interval
    u0: Interval
    u1: Interval
    after: arb


def plus(one: Interval, low: arb, high: arb) -> Interval:
    """Widen an interval: its low end by one number, its high end by another.

    Parameters
    ----------
    one : tuple of 2 arb
        The interval.
    low, high : arb
        What is added to its ends.

    Returns
    -------
    tuple of 2 arb
        The wider one.

    Examples
    --------
    >>> [float(end) for end in plus((arb(0), arb(1)), arb(-1), arb(2))]
    [-1.0, 3.0]
    """
    return (one[0] + low).lower(), (one[1] + high).upper()


def ends_of(pair: Any) -> Interval:
    """The exact ends of a pair of floats.

    Parameters
    ----------
    pair : pair of floats
        Ends.

    Returns
    -------
    tuple of 2 arb
        The interval.

    Examples
    --------
    >>> [float(end) for end in ends_of([0.5, 1.5])]
    [0.5, 1.5]
    """
    return exact(pair[0]), exact(pair[1])


def around(bound: arb) -> Interval:
    """The interval from −bound to bound.

    Parameters
    ----------
    bound : arb
        Not negative.

    Returns
    -------
    tuple of 2 arb
        The interval.

    Examples
    --------
    >>> [float(end) for end in around(arb(2))]
    [-2.0, 2.0]
    """
    return -bound.upper(), bound.upper()


def largest_size(pair: Interval) -> arb:
    """The largest |x| in an interval.

    Parameters
    ----------
    pair : tuple of 2 arb
        The interval.

    Returns
    -------
    arb
        An upper bound of it.

    Examples
    --------
    >>> float(largest_size((arb(-3), arb(2))))
    3.0
    """
    return largest(size(pair[0]), size(pair[1]))


def product(one: Interval, two: Interval) -> Interval:
    """An interval that holds the products of two.

    Parameters
    ----------
    one, two : tuples of 2 arb
        Intervals.

    Returns
    -------
    tuple of 2 arb
        The interval.

    Examples
    --------
    >>> [float(end) for end in product((arb(-1), arb(2)), (arb(0), arb(3)))]
    [-3.0, 6.0]
    """
    corners = [a * b for a in one for b in two]
    return least(*corners), largest(*corners)
