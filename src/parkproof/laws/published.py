"""The paper's switching controller, Steps 1 to 3 exactly as printed, then "stop".

Section 3 of the paper. It is kept as published, defects included: in Step 3 τ̃2 is the law of Step 2
unchanged, though u0 has changed sign (defect D3), and after Step 3 both inputs are zero.
"""

from parkproof.laws.chains import (
    one_chain,
    three_chain,
    three_chain_surface,
    two_chain,
    two_chain_surface,
)
from parkproof.laws.parameters import LawParameters
from parkproof.scalar import scalar


@scalar
def published_begin(x2: float, p: LawParameters) -> float:
    """Step with which the published law begins: Step 1.

    Parameters
    ----------
    x2 : float
        tan θ at the start.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    float
        1.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> published_begin(0.0, default_parameters())
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
def published_nominal(
    step: float,
    way: float,
    x0: float,
    x1: float,
    x2: float,
    u0: float,
    u1: float,
    p: LawParameters,
) -> tuple[float, float, float, float]:
    """Nominal inputs τ̃1, τ̃2 of the published law, and the surfaces of both channels.

    Parameters
    ----------
    step, way : float
        Step in force and direction of travel (always forward).
    x0, x1, x2, u0, u1 : float
        State.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    tuple of 4 floats
        τ̃1, u0*, τ̃2, u1*; where a channel is not controlled, τ̃ = 0 and u* = u.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> published_nominal(1.0, 1.0, 0.0, 0.3, 0.0, 9.0, 0.5, default_parameters())
    (-2.0, 1.0, 0.0, 0.5)
    """
    runup1 = one_chain(u0 - 1.0, p.lambda1, p.q0)
    return1 = two_chain(x0, u0, p.K1, p.k3, p.inv_q2, p.r2)
    approach2 = three_chain(x1, x2, u1, p.L1, p.L2, p.l3, p.inv_q1, p.inv_e1, p.r1)
    approach2_surface = three_chain_surface(x1, x2, p.L1, p.l2, p.inv_q1, p.e1)
    nominal1 = runup1 if step <= 2.0 else (return1 if step == 3.0 else 0.0)
    surface1 = 1.0 if step <= 2.0 else (two_chain_surface(x0, p.k1, p.q2) if step == 3.0 else u0)
    approaching = step == 2.0 or step == 3.0  # noqa: PLR1714  (a tuple would not compile to lanes)
    nominal2 = approach2 if approaching else 0.0
    surface2 = approach2_surface if approaching else u1
    return nominal1, surface1, nominal2, surface2
