"""From nominal inputs to the inputs held over one control period, explicit or implicit.

The explicit form is the paper's: Theorem 1 evaluated at the sample. The implicit form evaluates the
nominal law at the positions predicted one period ahead and takes the sign at the period's end.
"""

from parkproof.laws.parameters import LawParameters
from parkproof.laws.robustify import robust, robust_implicit
from parkproof.scalar import scalar


@scalar
def predicted(
    x0: float, x1: float, x2: float, u0: float, u1: float, p: LawParameters
) -> tuple[float, float, float]:
    """Positions one period ahead (implicit form), or now (explicit form).

    Parameters
    ----------
    x0, x1, x2, u0, u1 : float
        Measured state.
    p : LawParameters
        Gains and bounds; α is taken in the middle of its bounds.

    Returns
    -------
    tuple of 3 floats
        x0, x1, x2.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> predicted(1.0, 2.0, 3.0, 4.0, 5.0, default_parameters())
    (1.0, 2.0, 3.0)
    """
    h = p.lookahead
    x2_ahead = x2 + h * u1
    return x0 + h * p.alpha1 * u0, x1 + h * p.alpha2 * u0 * x2_ahead, x2_ahead


@scalar
def inputs(
    nominal1: float,
    surface1: float,
    nominal2: float,
    surface2: float,
    u0: float,
    u1: float,
    p: LawParameters,
) -> tuple[float, float]:
    """Inputs τ1, τ2 for one period from the nominal inputs and their surfaces.

    Parameters
    ----------
    nominal1, surface1, nominal2, surface2 : float
        τ̃ and u* of both channels.
    u0, u1 : float
        Measured last states of both channels.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    tuple of 2 floats
        τ1, τ2.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> inputs(-2.0, 1.0, 3.0, 0.0, 9.0, -1.0, default_parameters())
    (-4.5, 5.5)
    """
    tau1 = (
        robust_implicit(nominal1, surface1, u0, p.phi1, p.gamma_min1, p.gamma_max1, p.period)
        if p.implicit > 0.0
        else robust(nominal1, p.phi1, p.gamma_min1)
    )
    tau2 = (
        robust_implicit(nominal2, surface2, u1, p.phi2, p.gamma_min2, p.gamma_max2, p.period)
        if p.implicit > 0.0
        else robust(nominal2, p.phi2, p.gamma_min2)
    )
    return tau1, tau2
