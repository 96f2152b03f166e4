"""Where a run begins: boxes in the chart, after a turn where one is needed, and ways of travel.

In the turn (Step 0) |v| falls at least as d|v|/dt = −λ1|v|^q0, and V of the holding law falls in
(θ, ω). Where the heading is wrapped, at ±π, V does not rise: with |a| and |y| as they are, I(a, y)
is larger where a and y differ in sign, and there the heading moves outwards.
"""

from collections.abc import Iterator
from typing import Any

from flint import arb

from parkproof.proof.checker.balls import exact, largest, point_power
from parkproof.proof.checker.links import Interval, PowerIntegrator
from parkproof.proof.checker.parts import (
    Box,
    GapError,
    Law,
    Peaks,
    Uncertainty,
    around,
    ends_of,
    largest_size,
    plus,
    product,
)

ROUNDING = exact("1/1000000000000")
"""By how much, relatively, a comparison in floats may be off."""


def boxes(
    starts: dict[str, Any], law: Law, known: Uncertainty, hold: PowerIntegrator, peaks: Peaks
) -> Iterator[Box]:
    """Boxes in the chart from which Steps 1 to 4 begin, after a turn where one is needed.

    Parameters
    ----------
    starts : dict
        The certificate's "starts": ranges of x0, x1, x2, u0, u1, or of x, y, theta, v, omega.
    law, known, hold
        The run.
    peaks : Peaks
        Takes in the turn.

    Yields
    ------
    Box
        At most two.

    Raises
    ------
    GapError
        If a state lies beyond the chart's limit, where only a pose says which way it faces.
    """
    if "x0" in starts:
        box = {name: ends_of(starts[name]) for name in ("x0", "x1", "x2", "u0", "u1")}
        if not largest_size(box["x2"]) <= (law.chart_limit * (1 - ROUNDING)).tan():
            raise GapError("starts beyond the chart's limit must be given as poses")
        x1 = largest_size(box["x1"])
        yield Box(box["x0"], x1, box["x2"], box["u0"], box["u1"], arb(0))
        return
    x, y, theta, v, omega = (ends_of(starts[name]) for name in ("x", "y", "theta", "v", "omega"))
    # the law compares in floats: at the limit itself, take both ways
    limit, below = law.chart_limit * (1 + ROUNDING), law.chart_limit * (1 - ROUNDING)
    if not largest_size(theta) <= exact("3.1416"):
        raise GapError("headings must lie within one turn, from -3.1416 to 3.1416")
    inner = (theta[0] if theta[0] > -limit else -limit, theta[1] if theta[1] < limit else limit)
    if not inner[0] > inner[1]:
        steepest = largest_size(inner)
        cosine = (steepest.cos().lower(), arb(1))
        square = (arb(1), (1 / cosine[0] ** 2).upper())
        x2 = (inner[0].tan().lower(), inner[1].tan().upper())
        yield Box(x, largest_size(y), x2, product(v, cosine), product(omega, square), arb(0))
    if not largest_size(theta) < below:
        yield _turn(x, y, theta, v, omega, law, known, hold, peaks)


def _turn(
    x: Interval,
    y: Interval,
    theta: Interval,
    v: Interval,
    omega: Interval,
    law: Law,
    known: Uncertainty,
    hold: PowerIntegrator,
    peaks: Peaks,
) -> Box:
    """Step 0: the box after the turn, and what is met on the way."""
    fastest, end = largest_size(v), law.turn_tolerance
    coasting = point_power(fastest, 2 - law.q0) / (law.lambda1 * (2 - law.q0))
    stopping = point_power(fastest, 1 - law.q0) / (law.lambda1 * (1 - law.q0))
    if not end <= law.chart_limit * (1 - ROUNDING):
        raise GapError("turn_tolerance must be below chart_limit, or the turn ends elsewhere")
    # a heading beside ±π may be taken with either sign
    facing = theta if largest_size(theta) < exact("3.1415") else around(largest_size(theta))
    level = hold.level([facing, omega])
    turning = hold.seconds(level, hold.inner_level(end))
    along = exact(known.alpha[0][1]) * coasting
    x0, x1 = plus(x, -along, along), largest_size(y) + exact(known.alpha[1][1]) * coasting
    braking = (law.lambda1 * point_power(fastest, law.q0) + exact(known.phi[0])) / exact(
        known.gamma[0][0]
    )
    rate = hold.states(level)[1]
    tau2 = hold.tau(level, known.gamma[1], known.phi[1])
    peaks.meet(x0, x1, arb(0), fastest, arb(0), braking, tau2)
    peaks.turn_rate = largest(peaks.turn_rate, rate)
    peaks.heading = arb.pi().upper()
    steep = end.tan()
    spin = end * (1 + steep * steep)
    return Box(x0, x1.upper(), around(steep), around(end), around(spin), largest(stopping, turning))


def directions(law: Law, box: Box) -> Iterator[tuple[int, Interval]]:
    """Directions of travel that the law may choose, with the x0 from which it may.

    Parameters
    ----------
    law : Law
        Its direction.
    box : Box
        Where Step 1 begins.

    Yields
    ------
    tuple
        1 or −1, and a range of x0.
    """
    low, high = box.x0
    toward, free = law.direction == "toward", law.direction == "auto"
    zero = arb(0)
    if law.direction == "forward" or free:
        yield 1, box.x0
    elif toward and low <= 0:
        yield 1, (low, high if high < 0 else zero)
    if law.direction == "backward" or free:
        yield -1, box.x0
    elif toward and high > 0:
        yield -1, (low if low > 0 else zero, high)
