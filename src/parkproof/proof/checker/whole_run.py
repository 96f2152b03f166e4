"""Bounds of the switched run: turn, run-up, approach, return, hold, in continuous time.

Each phase starts from a box that holds all states in which the one before it can end. It ends, at
the latest, when its Lyapunov function has fallen to a level inside its tolerance.

1. Run-up: e = u0 − s·c falls in size at least as d|e|/dt = −λ1|e|^q0, monotonically, so u0 stays
   between its start and s·c; (x2, u1) are held; x1 drifts by at most α2^max·sup|u0|·sup|x2|·T1.
2. Approach: b1 = α2|u0| stays in a range, V of (s·x1, x2, u1) falls, x0 moves in direction s.
3. Return and 4. hold: V of (x0, u0) falls, V of (x2, u1) falls, to 0. x1 drifts by at most
   α2^max·sup|u0|·∫|x2| dt, which must leave it inside the hysteresis, or the law would go back.
   Begun with u0 ≥ 0, x0 stays above the lesser of its start and 0, with u0 ≤ 0 below the greater,
   where `parkproof.proof.checker.overshoot` proves it.

The turn before them is in `parkproof.proof.checker.starts`.
"""

from typing import Any

from flint import arb

from parkproof.proof.checker.balls import Range, down, exact, largest, least, point_power, size, up
from parkproof.proof.checker.links import Interval, PowerIntegrator
from parkproof.proof.checker.overshoot import reached
from parkproof.proof.checker.parts import (
    Box,
    GapError,
    Law,
    Links,
    Peaks,
    Uncertainty,
    around,
    largest_size,
    plus,
)
from parkproof.proof.checker.starts import boxes, directions


def cruise_range(law: Law, box: Box, way: int) -> Interval:
    """Range of s·u0 in the approach.

    Parameters
    ----------
    law : Law
        Its run-up speed and tolerance.
    box : Box
        Where Step 1 begins; u0 comes from there monotonically.
    way : int
        s.

    Returns
    -------
    tuple of 2 arb
        The range.
    """
    along = (box.u0[1] if way > 0 else -box.u0[0]).upper()
    high = law.cruise if along <= law.cruise else law.cruise + law.tolerance1
    return (law.cruise - law.tolerance1).lower(), high.upper()


def gain_range(law: Law, known: Uncertainty, starting: list[Box]) -> Range:
    """Range of b1 = α2|u0| in the approach, from all boxes and in all directions.

    Parameters
    ----------
    law, known
        The run.
    starting : list of Box
        Where Step 1 may begin.

    Returns
    -------
    pair of floats
        Rounded outwards.

    Raises
    ------
    GapError
        If the tolerance of Step 1 is not below the run-up speed.
    """
    ranges = [cruise_range(law, box, way) for box in starting for way, _ in directions(law, box)]
    slowest = least(*(low for low, _ in ranges))
    if not slowest > 0:
        raise GapError("the tolerance of Step 1 must be below runup_speed")
    low, high = (exact(end) for end in known.alpha[1])
    return down(low * slowest), up(high * largest(*(top for _, top in ranges)))


def run_up(
    box: Box,
    way: int,
    x0: Interval,
    law: Law,
    known: Uncertainty,
    hold: PowerIntegrator,
    peaks: Peaks,
) -> Box:
    """Step 1: the box in which it ends.

    Parameters
    ----------
    box : Box
        Where it begins, for all x0.
    way : int
        Direction of travel.
    x0 : tuple of 2 arb
        Range of x0 from which that direction is taken.
    law, known, hold
        The run.
    peaks : Peaks
        Takes in what is met.

    Returns
    -------
    Box
        Its u0 is that of the approach.
    """
    gamma, phi = known.gamma, known.phi
    a1, a2, b2 = exact(known.alpha[0][1]), exact(known.alpha[1][1]), exact(known.b2[1])
    target = law.cruise if way > 0 else -law.cruise
    error = largest(size(box.u0[0] - target), size(box.u0[1] - target))
    power_of_error = 1 - law.q0
    fall = point_power(error, power_of_error) - point_power(law.tolerance1, power_of_error)
    time = largest(arb(0), fall / (law.lambda1 * power_of_error))
    slow, fast = least(box.u0[0], target), largest(box.u0[1], target)
    u0 = largest(size(slow), size(fast))
    x0 = plus(x0, -a1 * largest(arb(0), -slow) * time, a1 * largest(arb(0), fast) * time)

    level = hold.level([box.x2, box.u1])
    x2, u1 = hold.states(level)
    tau2 = hold.tau(level, gamma[1], phi[1])
    # in a short time neither gets as far as V allows
    push = exact(gamma[1][1]) * tau2 + exact(phi[1])
    u1 = least(u1, largest_size(box.u1) + push * time)
    x2 = least(x2, largest_size(box.x2) + b2 * u1 * time)
    x1 = (box.x1 + a2 * u0 * x2 * time).upper()
    tau1 = (law.lambda1 * point_power(error, law.q0) + exact(phi[0])) / exact(gamma[0][0])
    peaks.meet(x0, x1, x2, u0, u1, tau1, tau2)
    low, high = cruise_range(law, box, way)
    cruising = (low, high) if way > 0 else (-high, -low)
    return Box(x0, x1, around(x2), cruising, around(u1), (box.after + time).upper())


def _approach(
    box: Box, way: int, law: Law, known: Uncertainty, links: Links, peaks: Peaks
) -> tuple[Interval, arb]:
    """Step 2: the range of x0 in which it ends, and the time until then."""
    level = links.approach.level([around(box.x1), box.x2, box.u1])
    time = links.approach.seconds(level, links.approach.inner_level(law.tolerance2))
    fastest = largest_size(box.u0)
    far = exact(known.alpha[0][1]) * fastest * time
    x0 = plus(box.x0, arb(0), far) if way > 0 else plus(box.x0, -far, arb(0))
    x1, x2, u1 = links.approach.states(level)
    correction = law.lambda1 * point_power(law.tolerance1, law.q0)
    tau1 = (correction + exact(known.phi[0])) / exact(known.gamma[0][0])
    tau2 = links.approach.tau(level, known.gamma[1], known.phi[1])
    peaks.meet(x0, x1, x2, fastest, u1, tau1, tau2)
    return x0, box.after + time


def _return(
    x0: Interval,
    u0: Interval,
    x2: arb,
    u1: arb,
    law: Law,
    known: Uncertainty,
    links: Links,
    peaks: Peaks,
) -> arb:
    """Steps 3 and 4: the time until (x0, x2, u0, u1) is 0."""
    gamma, phi = known.gamma, known.phi
    along, across = links.back.level([x0, u0]), links.hold.level([around(x2), around(u1)])
    far, fast = links.back.states(along)
    steep, spin = links.hold.states(across)
    drift = exact(known.alpha[1][1]) * fast * links.hold.travel(across)
    x1 = (law.tolerance2 + drift).upper()
    if not x1 <= law.hysteresis * law.tolerance2:
        ratio = up(x1 / law.tolerance2)
        raise GapError(
            f"in the return x1 may drift to {ratio:.3g} times its tolerance, and the law go back: "
            f"hysteresis must be at least {ratio:.3g}"
        )
    highest = exact(known.alpha[0][1])
    ends = reached(links.back.chain, highest, far, x0, u0, rest=law.tolerance2)
    tau1 = links.back.tau(along, gamma[0], phi[0])
    tau2 = links.hold.tau(across, gamma[1], phi[1])
    peaks.meet(ends, x1, steep, fast, spin, tau1, tau2)
    peaks.x1_at_rest = largest(peaks.x1_at_rest, x1)
    return largest(links.back.seconds(along, arb(0)), links.hold.seconds(across, arb(0)))


def run_bounds(
    starts: dict[str, Any], law: Law, known: Uncertainty, links: Links
) -> tuple[Peaks, Range]:
    """Bounds of all that a run can meet, if the links are proved for the range of b1 returned.

    Parameters
    ----------
    starts : dict
        Ranges of the start.
    law, known, links
        The run.

    Returns
    -------
    tuple
        The bounds, and the range of b1 = α2|u0| for which the approach must be proved.

    Raises
    ------
    GapError
        If a link of the reasoning does not hold.
    """
    peaks = Peaks()
    starting = list(boxes(starts, law, known, links.hold, peaks))
    for box in starting:
        for way, x0 in directions(law, box):
            cruising = run_up(box, way, x0, law, known, links.hold, peaks)
            end, time = _approach(cruising, way, law, known, links, peaks)
            small = law.tolerance2
            time += _return(end, cruising.u0, small, small, law, known, links, peaks)
            peaks.time = largest(peaks.time, time)
        straight = largest(law.tolerance2, law.turn_tolerance)
        # with nothing to correct across, the law begins in Step 3
        x2, u1 = (least(straight, largest_size(pair)) for pair in (box.x2, box.u1))
        time = _return(box.x0, box.u0, x2, u1, law, known, links, peaks)
        peaks.time = largest(peaks.time, box.after + time)
    if not peaks.states[2] <= law.turn_again:
        raise GapError("the heading may leave the chart, where the law would turn again")
    return peaks, gain_range(law, known, starting)
