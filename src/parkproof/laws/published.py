"""The paper's switching controller, Steps 1 to 3 exactly as printed, then "stop".

Section 3 of the paper. It is kept as published, defects included: in Step 3 τ̃2 is the law of Step 2
unchanged, though u0 has changed sign (defect D3), and after Step 3 both inputs are zero.
"""

from parkproof.laws.chains import ChannelLaw, one_chain, three_chain, two_chain
from parkproof.laws.parameters import LawParameters
from parkproof.scalar import scalar


@scalar
def published_begin(x1: float, x2: float, u1: float, p: LawParameters) -> float:
    """Step with which the published law begins: Step 1.

    Parameters
    ----------
    x1, x2, u1 : float
        State at the start.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    float
        1.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> published_begin(0.0, 0.0, 0.0, default_parameters())
    1.0
    """
    return 1.0


@scalar
def published_direction(x0: float, x1: float, x2: float, u0: float, p: LawParameters) -> float:
    """Direction of travel of Steps 1 and 2: always forward.

    Parameters
    ----------
    x0, x1, x2, u0 : float
        State at the start of Step 1.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    float
        1.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> published_direction(3.0, 0.5, 0.0, 0.0, default_parameters())
    1.0
    """
    return 1.0


@scalar
def published_switch(
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
    """Step in force from this sample on: each ends when settled, or at its given time.

    Parameters
    ----------
    step, way : float
        Step until now (1, 2, 3, or 4 for stopped) and direction of travel.
    t : float
        Time in s.
    x0, x1, x2, u0, u1 : float
        Measured state.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    float
        Step.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> published_switch(1.0, 1.0, 0.5, 0.0, 0.3, 0.0, 1.0, 0.0, default_parameters())
    2.0
    """
    done1 = (t >= p.to_step2) if p.to_step2 >= 0.0 else (abs(u0 - 1.0) - p.band1 <= p.tolerance1)
    error2 = max(abs(x1), abs(x2), abs(u1) - p.band2)
    done2 = (t >= p.to_step3) if p.to_step3 >= 0.0 else (error2 <= p.tolerance2)
    done3 = max(abs(x0), abs(u0) - p.band1) <= p.tolerance3
    return (
        2.0
        if step == 1.0 and done1
        else (3.0 if step == 2.0 and done2 else (4.0 if step == 3.0 and done3 else step))
    )


@scalar
def published_channels(
    step: float,
    way: float,
    x0: float,
    x1: float,
    x2: float,
    u0: float,
    p: LawParameters,
) -> tuple[ChannelLaw, ChannelLaw]:
    """Laws of both channels as published.

    Parameters
    ----------
    step, way : float
        Step in force and direction of travel (always forward).
    x0, x1, x2, u0 : float
        State.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    two tuples of 4 floats
        The laws of τ̃1 and τ̃2; gain 0 where a channel is not controlled.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> from parkproof.laws.chains import nominal_input
    >>> one, two = published_channels(1.0, 1.0, 0.0, 0.3, 0.0, 9.0, default_parameters())
    >>> nominal_input(9.0, *one), nominal_input(0.5, *two) == 0.0
    (-2.0, True)
    """
    runup = one_chain(1.0, p.lambda1, p.q0)
    back = two_chain(x0, p.K1, p.k3, p.inv_q2, p.r2)
    approach = three_chain(x1, x2, p.L1, p.L2, p.l3, p.inv_q1, p.inv_e1, p.r1)
    stopped = (0.0, 1.0, 0.0, 1.0)
    first = runup if step <= 2.0 else (back if step == 3.0 else stopped)
    second = approach if step == 2.0 or step == 3.0 else stopped  # noqa: PLR1714  (for lanes)
    return first, second


@scalar
def no_direct(step: float, way: float, x1: float, x2: float, u1: float, p: LawParameters) -> float:
    """Input τ2 beside those of the channels' laws: none.

    Parameters
    ----------
    step, way : float
        Step in force and direction of travel.
    x1, x2, u1 : float
        State.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    float
        0.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> no_direct(2.0, 1.0, 0.1, 0.2, 0.3, default_parameters())
    0.0
    """
    return 0.0
