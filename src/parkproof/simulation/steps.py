"""Integration steps of (6) in the chart, and of the turn outside it, as scalar functions.

The classical Runge-Kutta method with the input held. The last states' rates γτ + φ do not depend on
the state, so the caller gives them at the step's start, middle and end, and likewise the gains α1,
α2 and b2, which may vary in time.
"""

from parkproof.model.chained import chained_rates
from parkproof.scalar import cosine, scalar, sine

FiveFloats = tuple[float, float, float, float, float]

Scales = tuple[float, float, float]
"""α1, α2 and b2."""


@scalar
def time_in_period(t: float, h: float, i: float, steps: float) -> float:
    """Time after i of the integration steps of a control period.

    A step's end is the next one's start to the last bit, also across periods if h is the next
    sample's time less t.

    Parameters
    ----------
    t, h : float
        Start and length of the period in s.
    i, steps : float
        Whole numbers, i from 0 to steps.

    Returns
    -------
    float
        Time in s.

    Examples
    --------
    >>> [time_in_period(1.0, 0.5, i, 2) for i in range(3)]
    [1.0, 1.25, 1.5]
    """
    return t + h if i == steps else t + i * (h / steps)


@scalar
def chained_step(
    x0: float,
    x1: float,
    x2: float,
    u0: float,
    u1: float,
    start: Scales,
    middle: Scales,
    end: Scales,
    start1: float,
    middle1: float,
    end1: float,
    start2: float,
    middle2: float,
    end2: float,
    h: float,
) -> FiveFloats:
    """One Runge-Kutta step of the extended chained form (6), with b2.

    Parameters
    ----------
    x0, x1, x2, u0, u1 : float
        State.
    start, middle, end : three floats each
        α1, α2 and b2 at the step's start, middle and end.
    start1, middle1, end1, start2, middle2, end2 : float
        u̇0 and u̇1 at the step's start, middle and end.
    h : float
        Step in s.

    Returns
    -------
    tuple of 5 floats
        State at the step's end.

    Examples
    --------
    >>> chained_step(0.0, 0.0, 0.5, 1.0, 0.0, *[(1.0, 1.0, 1.0)] * 3, *[0.0] * 6, 0.1)
    (0.1, 0.05, 0.5, 1.0, 0.0)
    """
    half = 0.5 * h
    a0, a1, a2 = start
    m0, m1, m2 = middle
    e0, e1, e2 = end
    p0, p1, p2 = chained_rates(x2, u0, u1, a0, a1, a2)
    u0_q, u1_q = u0 + half * start1, u1 + half * start2
    q0, q1, q2 = chained_rates(x2 + half * p2, u0_q, u1_q, m0, m1, m2)
    u0_r, u1_r = u0 + half * middle1, u1 + half * middle2
    r0, r1, r2 = chained_rates(x2 + half * q2, u0_r, u1_r, m0, m1, m2)
    u0_s, u1_s = u0 + h * middle1, u1 + h * middle2
    s0, s1, s2 = chained_rates(x2 + h * r2, u0_s, u1_s, e0, e1, e2)
    w = h / 6.0
    return (
        x0 + w * (p0 + 2.0 * (q0 + r0) + s0),
        x1 + w * (p1 + 2.0 * (q1 + r1) + s1),
        x2 + w * (p2 + 2.0 * (q2 + r2) + s2),
        u0 + w * (start1 + 4.0 * middle1 + end1),
        u1 + w * (start2 + 4.0 * middle2 + end2),
    )


@scalar
def turning_step(
    x: float,
    y: float,
    theta: float,
    v: float,
    omega: float,
    start: Scales,
    middle: Scales,
    end: Scales,
    start1: float,
    middle1: float,
    end1: float,
    start2: float,
    middle2: float,
    end2: float,
    h: float,
) -> FiveFloats:
    """One Runge-Kutta step outside the chart, where the inputs act on v and ω, and θ̇ = b2·ω.

    Parameters
    ----------
    x, y, theta, v, omega : float
        State.
    start, middle, end : three floats each
        α1, α2 and b2 at the step's start, middle and end.
    start1, middle1, end1, start2, middle2, end2 : float
        v̇ and ω̇ at the step's start, middle and end.
    h : float
        Step in s.

    Returns
    -------
    tuple of 5 floats
        State at the step's end.

    Examples
    --------
    >>> x, y, *_ = turning_step(0.0, 0.0, 0.0, 1.0, 0.0, *[(1.0, 1.0, 1.0)] * 3, *[0.0] * 6, 0.1)
    >>> round(x, 12), round(y, 12)
    (0.1, 0.0)
    """
    half = 0.5 * h
    a0, a1, a2 = start
    m0, m1, m2 = middle
    e0, e1, e2 = end
    v_q, omega_q = v + half * start1, omega + half * start2
    v_r, omega_r = v + half * middle1, omega + half * middle2
    v_s, omega_s = v + h * middle1, omega + h * middle2
    theta_q = theta + half * (a2 * omega)
    theta_r = theta + half * (m2 * omega_q)
    theta_s = theta + h * (m2 * omega_r)
    w = h / 6.0
    along = (
        a0 * v * cosine(theta)
        + 2.0 * (m0 * v_q * cosine(theta_q) + m0 * v_r * cosine(theta_r))
        + e0 * v_s * cosine(theta_s)
    )
    across = (
        a1 * v * sine(theta)
        + 2.0 * (m1 * v_q * sine(theta_q) + m1 * v_r * sine(theta_r))
        + e1 * v_s * sine(theta_s)
    )
    return (
        x + w * along,
        y + w * across,
        theta + w * (a2 * omega + 2.0 * (m2 * omega_q + m2 * omega_r) + e2 * omega_s),
        v + w * (start1 + 4.0 * middle1 + end1),
        omega + w * (start2 + 4.0 * middle2 + end2),
    )


@scalar
def chained_euler_step(
    x0: float,
    x1: float,
    x2: float,
    u0: float,
    u1: float,
    scales: Scales,
    rate1: float,
    rate2: float,
    h: float,
) -> FiveFloats:
    """One explicit Euler step of (6).

    Simulations elsewhere mostly take such steps; this one is for comparisons with them.

    Parameters
    ----------
    x0, x1, x2, u0, u1 : float
        State.
    scales : three floats
        α1, α2 and b2 at the step's start.
    rate1, rate2 : float
        u̇0 and u̇1 at the step's start.
    h : float
        Step in s.

    Returns
    -------
    tuple of 5 floats
        State at the step's end.

    Examples
    --------
    >>> chained_euler_step(0.0, 0.0, 0.5, 1.0, 0.0, (1.0, 1.0, 1.0), 2.0, 2.0, 0.1)
    (0.1, 0.05, 0.5, 1.2, 0.2)
    """
    a0, a1, a2 = scales
    p0, p1, p2 = chained_rates(x2, u0, u1, a0, a1, a2)
    return x0 + h * p0, x1 + h * p1, x2 + h * p2, u0 + h * rate1, u1 + h * rate2


@scalar
def turning_euler_step(
    x: float,
    y: float,
    theta: float,
    v: float,
    omega: float,
    scales: Scales,
    rate1: float,
    rate2: float,
    h: float,
) -> FiveFloats:
    """One explicit Euler step outside the chart.

    Parameters
    ----------
    x, y, theta, v, omega : float
        State.
    scales : three floats
        α1, α2 and b2 at the step's start.
    rate1, rate2 : float
        v̇ and ω̇ at the step's start.
    h : float
        Step in s.

    Returns
    -------
    tuple of 5 floats
        State at the step's end.

    Examples
    --------
    >>> turning_euler_step(0.0, 0.0, 0.0, 1.0, 0.5, (1.0, 1.0, 1.0), 2.0, 2.0, 0.1)
    (0.1, 0.0, 0.05, 1.2, 0.7)
    """
    a0, a1, a2 = scales
    along, across = a0 * v * cosine(theta), a1 * v * sine(theta)
    return (
        x + h * along,
        y + h * across,
        theta + h * (a2 * omega),
        v + h * rate1,
        omega + h * rate2,
    )
