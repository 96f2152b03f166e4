"""From nominal inputs to the inputs held over one control period, explicit or implicit.

The explicit form is the paper's: Theorem 1 evaluated at the sample, in four quarters, which lanes
go through in loops of their own. The implicit form evaluates the nominal law at the positions
predicted one period ahead and takes the sign at the period's end.
"""

from parkproof.laws.chains import ChannelLaw, ended_error
from parkproof.laws.parameters import LawParameters
from parkproof.laws.robustify import implicit_end, pull, robust
from parkproof.scalar import clip, scalar, spow_ended, spows_begun


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
def with_direct(tau2: float, direct: float, p: LawParameters) -> float:
    """Input τ2 of a channel's law with an input added as it is.

    Parameters
    ----------
    tau2, direct : float
        Both inputs, the first clipped at ``tau_max2`` already; at most one of them is not 0.
    p : LawParameters
        Gains and bounds.

    Returns
    -------
    float
        τ2, clipped at ``tau_max2``.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> with_direct(0.0, -3.0, default_parameters())
    -3.0
    """
    # written so that nothing is left of it in a law that adds none
    return clip(tau2 + direct, p.tau_max2) if direct != 0.0 else tau2


@scalar
def begun_errors(one: ChannelLaw, two: ChannelLaw, u0: float, u1: float) -> tuple[float, float]:
    """First quarter of `explicit_inputs`: powers of both channels' last states, begun.

    Parameters
    ----------
    one, two : tuples of 4 floats
        Laws of both channels.
    u0, u1 : float
        Measured last states of both channels.

    Returns
    -------
    tuple of 2 floats
        First halves of both powers, from `parkproof.scalar.spows_begun`.

    Examples
    --------
    >>> begun_errors((1.0, 1.0, -1.0, 1 / 3), (1.0, 2.0, 0.0, 0.5), 9.0, -1.0)
    (9.0, 1.0)
    """
    _, power1, _, _ = one
    _, power2, _, _ = two
    return spows_begun(u0, power1, u1, power2)


@scalar
def ended_errors(
    one: ChannelLaw, two: ChannelLaw, begun1: float, begun2: float, u0: float, u1: float
) -> tuple[float, float]:
    """Second quarter of `explicit_inputs`: errors of both channels.

    Parameters
    ----------
    one, two : tuples of 4 floats
        Laws of both channels.
    begun1, begun2 : float
        What `begun_errors` gave.
    u0, u1 : float
        Measured last states of both channels.

    Returns
    -------
    tuple of 2 floats
        ⌈u⌋^power + offset of each, `parkproof.laws.chains.chain_error`.

    Examples
    --------
    >>> ended_errors((1.0, 1.0, -1.0, 1 / 3), (1.0, 1.0, 0.0, 0.5), 9.0, 1.0, 9.0, -1.0)
    (8.0, -1.0)
    """
    _, power1, offset1, _ = one
    _, power2, offset2, _ = two
    error1 = ended_error(begun1, u0, power1, offset1)
    return error1, ended_error(begun2, u1, power2, offset2)


@scalar
def begun_answers(
    one: ChannelLaw, two: ChannelLaw, error1: float, error2: float
) -> tuple[float, float]:
    """Third quarter of `explicit_inputs`: powers of both channels' errors, begun.

    Parameters
    ----------
    one, two : tuples of 4 floats
        Laws of both channels.
    error1, error2 : float
        Their errors.

    Returns
    -------
    tuple of 2 floats
        First halves of both powers, from `parkproof.scalar.spows_begun`.

    Examples
    --------
    >>> begun_answers((1.0, 1.0, -1.0, 1.0), (1.0, 1.0, 0.0, 0.5), 8.0, -1.0)
    (8.0, 1.0)
    """
    _, _, _, outer1 = one
    _, _, _, outer2 = two
    return spows_begun(error1, outer1, error2, outer2)


@scalar
def ended_answers(
    one: ChannelLaw,
    two: ChannelLaw,
    begun1: float,
    begun2: float,
    error1: float,
    error2: float,
    p: LawParameters,
) -> tuple[float, float]:
    """Last quarter of `explicit_inputs`: inputs that answer the errors of both channels.

    Parameters
    ----------
    one, two : tuples of 4 floats
        Laws of both channels.
    begun1, begun2 : float
        What `begun_answers` gave.
    error1, error2 : float
        Their errors.
    p : LawParameters
        Gains and bounds; inputs are clipped at ``tau_max``.

    Returns
    -------
    tuple of 2 floats
        τ1, τ2.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> one, two = (1.0, 1.0, -1.0, 1 / 3), (1.0, 1.0, 0.0, 0.5)
    >>> begun = begun_answers(one, two, 8.0, -1.0)
    >>> ended_answers(one, two, *begun, 8.0, -1.0, default_parameters())
    (-4.5, 3.5)
    """
    gain1, _, _, outer1 = one
    gain2, _, _, outer2 = two
    # Theorem 1's division by γ_m, which processors are slow at, is done once and for all
    tau1 = robust(-gain1 * spow_ended(begun1, error1, outer1), p.phi1, 1.0) * p.inv_gamma1
    tau2 = robust(-gain2 * spow_ended(begun2, error2, outer2), p.phi2, 1.0) * p.inv_gamma2
    return clip(tau1, p.tau_max1), clip(tau2, p.tau_max2)


@scalar
def explicit_inputs(
    one: ChannelLaw, two: ChannelLaw, u0: float, u1: float, p: LawParameters
) -> tuple[float, float]:
    """Inputs τ1, τ2 for one period in the explicit form: Theorem 1 at the sample.

    Parameters
    ----------
    one, two : tuples of 4 floats
        Laws of both channels.
    u0, u1 : float
        Measured last states of both channels.
    p : LawParameters
        Gains and bounds; inputs are clipped at ``tau_max``.

    Returns
    -------
    tuple of 2 floats
        τ1, τ2.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> one, two = (1.0, 1.0, -1.0, 1 / 3), (1.0, 1.0, 0.0, 0.5)
    >>> explicit_inputs(one, two, 9.0, -1.0, default_parameters())
    (-4.5, 3.5)
    """
    error1, error2 = ended_errors(one, two, *begun_errors(one, two, u0, u1), u0, u1)
    begun1, begun2 = begun_answers(one, two, error1, error2)
    return ended_answers(one, two, begun1, begun2, error1, error2, p)


@scalar
def implicit_answers(
    end1: float, size1: float, end2: float, size2: float, u0: float, u1: float, p: LawParameters
) -> tuple[float, float]:
    """Inputs that bring both channels to their ends, the second half of `implicit_inputs`.

    Parameters
    ----------
    end1, end2 : float
        Where u0 and u1 shall end, from `parkproof.laws.robustify.implicit_end`.
    size1, size2 : float
        Gains of their laws, or a positive multiple of them; no control where one is 0.
    u0, u1 : float
        Measured last states of both channels.
    p : LawParameters
        Gains and bounds; inputs are clipped at ``tau_max``.

    Returns
    -------
    tuple of 2 floats
        τ1, τ2.

    Examples
    --------
    >>> from parkproof.laws import default_parameters
    >>> tau1, tau2 = implicit_answers(
    ...     1.0, 2.0, 0.0, 0.0, 1.002, 0.5, default_parameters(implicit=True))
    >>> round(tau1, 9), tau2
    (-1.0, 0.0)
    """
    tau1 = pull(u0, end1, size1, p.gamma_max1, p.period)
    tau2 = pull(u1, end2, size2, p.gamma_max2, p.period)
    return clip(tau1, p.tau_max1), clip(tau2, p.tau_max2)


@scalar
def implicit_inputs(
    one: ChannelLaw, two: ChannelLaw, u0: float, u1: float, p: LawParameters
) -> tuple[float, float]:
    """Inputs τ1, τ2 for one period in the implicit form.

    Parameters
    ----------
    one, two : tuples of 4 floats
        Laws of both channels at the positions of `predicted`.
    u0, u1 : float
        Measured last states of both channels.
    p : LawParameters
        Gains and bounds; inputs are clipped at ``tau_max``.

    Returns
    -------
    tuple of 2 floats
        τ1, τ2.

    Examples
    --------
    Far from their surfaces both forms nearly agree; on them, the implicit one is at rest:

    >>> from parkproof.laws import default_parameters
    >>> one, two = (1.0, 1.0, -1.0, 1 / 3), (1.0, 1.0, 0.0, 0.5)
    >>> tau1, tau2 = implicit_inputs(one, two, 9.0, 0.0, default_parameters(implicit=True))
    >>> round(tau1, 2), abs(tau2)
    (-4.5, 0.0)
    """
    end1 = implicit_end(u0, *one, p.kappa1 * p.phi1, p.kappa1)
    end2 = implicit_end(u1, *two, p.kappa2 * p.phi2, p.kappa2)
    gain1, _, _, _ = one
    gain2, _, _, _ = two
    return implicit_answers(end1, gain1, end2, gain2, u0, u1, p)
