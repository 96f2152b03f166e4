"""The corrected switching controller: the paper's steps, with the defects D1-D8 mended.

Step 0 turns first when the heading lies outside the chart. Step 1 holds (x2, u1) instead of leaving
them alone (D8). Step 2 works in either direction of travel, with x̃1 = sign(u0)·x1. Step 3 goes on
correcting x1 with the sign that u0 really has (D3), while |u0| lies in a window in which that is
expected to converge, and holds the heading outside it; or it only holds the heading. Step 4 goes on
holding. If x1 leaves its tolerance, the law goes back to the run-up, in the better direction.
"""

from parkproof.laws.chains import ChannelLaw, one_chain, three_chain, two_chain
from parkproof.laws.parameters import LawParameters
from parkproof.scalar import scalar, sign, spow


@scalar
def travel_before_return(x0: float, x1: float, u0: float, way: float, p: LawParameters) -> float:
    """Estimate of |x0| at the end of Step 2 for a direction of travel, with the nominal plant.

    Step 1 takes e = u0 − s·c to zero in |e|^(1−q0)/(λ1(1−q0)); Step 2 takes about the time of
    ẋ1 = −α c l1⌈x1⌋^q1.

    Parameters
    ----------
    x0, x1, u0 : float
        State at the start of Step 1.
    way : float
        s, 1 forward or −1 backward.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    float
        The estimated |x0|, which Step 3 will have to undo.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> p = default_parameters()
    >>> travel_before_return(3.0, 0.5, 0.0, -1.0, p) < travel_before_return(3.0, 0.5, 0.0, 1.0, p)
    True
    """
    cruise = way * p.runup_speed
    e = u0 - cruise
    runup_time = spow(abs(e), 1.0 - p.q0) / (p.lambda1 * (1.0 - p.q0))
    runup = cruise * runup_time + spow(e, 2.0 - p.q0) / (p.lambda1 * (2.0 - p.q0))
    approach_time = spow(abs(x1), 1.0 - p.q1) / (p.alpha2 * p.runup_speed * p.l1 * (1.0 - p.q1))
    return abs(x0 + p.alpha1 * (runup + cruise * approach_time))


@scalar
def better_direction(x0: float, x1: float, x2: float, u0: float, p: LawParameters) -> float:
    """Direction of travel that leaves less to undo; with equal merit, the one along which x1 falls.

    A given direction is kept, "toward" being that of the goal: −sign(x0), forward on its line.

    Parameters
    ----------
    x0, x1, x2, u0 : float
        State at the start of Step 1.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    float
        1 forward, −1 backward.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> better_direction(3.0, 0.5, 0.0, 0.0, default_parameters())
    -1.0
    """
    forward = travel_before_return(x0, x1, u0, 1.0, p)
    backward = travel_before_return(x0, x1, u0, -1.0, p)
    equal = 1.0 if x1 * x2 <= 0.0 else -1.0
    free = 1.0 if forward < backward else (-1.0 if backward < forward else equal)
    toward = -1.0 if x0 > 0.0 else 1.0
    given = toward if p.direction == 2.0 else p.direction
    return given if p.direction != 0.0 else free


@scalar
def corrected_begin(x1: float, x2: float, u1: float, p: LawParameters) -> float:
    """Step with which the corrected law begins, at the start and after a turn.

    A turn if the heading lies outside the chart; the return if there is nothing to correct across;
    else the run-up.

    Parameters
    ----------
    x1, x2, u1 : float
        State at the start; x2 is infinite beyond ±90°.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    float
        0 (turn), 1 (run-up) or 3 (return).

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> p = default_parameters()
    >>> [corrected_begin(x1, x2, 0.0, p) for x1, x2 in ((0.3, 0.0), (0.3, 99.0), (0.0, 0.0))]
    [1.0, 0.0, 3.0]
    """
    heading = max(abs(x2), abs(u1) - p.band2)
    straight = abs(x1) <= p.tolerance2 and heading <= max(p.tolerance2, p.turn_tolerance)
    return 0.0 if abs(x2) > p.x2_enter else (3.0 if straight and p.to_step3 <= 0.0 else 1.0)


@scalar
def corrected_switch(
    step: float,
    way: float,
    t: float,
    x0: float,
    x1: float,
    x2: float,
    u0: float,
    u1: float,
    p: LawParameters,
) -> float:
    """Step in force from this sample on.

    Parameters
    ----------
    step, way : float
        Step until now (1 run-up, 2 approach, 3 return, 4 hold) and direction of travel.
    t : float
        Time in s.
    x0, x1, x2, u0, u1 : float
        Measured state.
    p : LawParameters
        Gains and bounds. In the implicit form a disturbance may hold u within ``band`` of its
        surface without chatter, so the tolerances on u count from there.

    Returns
    -------
    float
        Step; 0 where the heading leaves the chart, and 1 where x1 left its tolerance.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> p = default_parameters()
    >>> corrected_switch(4.0, 1.0, 9.0, 0.0, 0.5, 0.0, 0.0, 0.0, p)
    1.0
    """
    error1 = abs(u0 - way * p.runup_speed) - p.band1
    error2 = max(abs(x1), abs(x2), abs(u1) - p.band2)
    error3 = max(abs(x0), abs(u0) - p.band1)
    done1 = error1 <= p.tolerance1 and t >= p.to_step2
    done2 = error2 <= p.tolerance2 and t >= p.to_step3
    onward = (
        2.0
        if step == 1.0 and done1
        else (
            3.0
            if step == 2.0 and done2
            else (4.0 if step == 3.0 and error3 <= p.tolerance3 else step)
        )
    )
    lost = step >= 3.0 and abs(x1) > p.x1_leave
    return 0.0 if abs(x2) > p.x2_leave else (1.0 if lost else onward)


@scalar
def corrected_channels(
    step: float,
    way: float,
    x0: float,
    x1: float,
    x2: float,
    u0: float,
    p: LawParameters,
) -> tuple[ChannelLaw, ChannelLaw]:
    """Laws of both channels in Steps 1 to 4.

    Parameters
    ----------
    step, way : float
        Step in force and direction of travel.
    x0, x1, x2, u0 : float
        State.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    two tuples of 4 floats
        The laws of τ̃1 and τ̃2.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> from parkproof.laws.chains import nominal_input
    >>> one, _ = corrected_channels(1.0, -1.0, 0.0, 0.3, 0.0, 7.0, default_parameters())
    >>> round(nominal_input(7.0, *one), 12)
    -2.0
    """
    cruising = step <= 2.0
    cruise = one_chain(way * p.runup_speed, p.lambda1, p.q0)
    back = two_chain(x0, p.K1, p.k3, p.inv_q2, p.r2)
    steering = step == 2.0 or (step == 3.0 and abs(u0) >= p.steer_low and abs(u0) <= p.steer_high)
    sided1 = (way if cruising else sign(u0)) * x1
    approach = three_chain(sided1, x2, p.L1, p.L2, p.l3, p.inv_q1, p.inv_e1, p.r1)
    straight = two_chain(x2, p.H1, p.hold3, p.inv_q2, p.r2)
    return cruise if cruising else back, approach if steering else straight
