"""All the numbers that a law needs, in one flat tuple of floats.

A flat tuple goes unchanged into compiled lanes. Every field is derived from what the controller
may know: bounds, gains, switching conditions, and its own period and discretisation.
"""

import math
from typing import Literal, NamedTuple

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.laws.ellipsoid import lowest_level, widest
from parkproof.laws.gains import Gains, Switching
from parkproof.validate import positive

Discretisation = Literal["explicit", "implicit"]

DIRECTIONS = {"auto": 0.0, "toward": 2.0, "forward": 1.0, "backward": -1.0}


class LawParameters(NamedTuple):
    """Numbers used by the scalar laws; made by `law_parameters`.

    The paper's symbols keep their names; L1 = l1^(1/q1), L2 = l2^(1/(2q1−1)),
    K1 = k̃1^(1/q2), H1 = hold1^(1/q2). From P11 on, they are those of homogeneous control and 0
    without it.
    """

    lambda1: float
    q0: float
    l1: float
    l3: float
    L1: float
    L2: float
    q1: float
    inv_q1: float
    inv_e1: float
    r1: float
    k3: float
    K1: float
    hold3: float
    H1: float
    inv_q2: float
    r2: float
    runup_speed: float
    direction: float
    steer_low: float
    steer_high: float
    to_step2: float
    to_step3: float
    tolerance1: float
    tolerance2: float
    tolerance3: float
    x1_leave: float
    turn_tolerance: float
    x2_enter: float
    x2_leave: float
    phi1: float
    phi2: float
    gamma_min1: float
    gamma_min2: float
    inv_gamma1: float
    inv_gamma2: float
    gamma_max1: float
    gamma_max2: float
    kappa1: float
    kappa2: float
    alpha1: float
    alpha2: float
    period: float
    lookahead: float
    band1: float
    band2: float
    tau_max1: float
    tau_max2: float
    P11: float
    P12: float
    P13: float
    P22: float
    P23: float
    P33: float
    feedback1: float
    feedback2: float
    feedback3: float
    level_min: float
    widest: float


def law_parameters(
    *,
    bounds: Bounds,
    gains: Gains,
    switching: Switching,
    control_period: float,
    discretisation: Discretisation = "explicit",
    saturation: tuple[float, float] | None = None,
) -> LawParameters:
    """Flatten what a controller knows into the numbers that the scalar laws take.

    Parameters
    ----------
    bounds : Bounds
        Known bounds of the plant.
    gains : Gains
        Gains of the law.
    switching : Switching
        When steps end.
    control_period : float
        Period h in s.
    discretisation : "explicit" or "implicit"
        The form of the law in sampled time (`parkproof.laws.inputs`).
    saturation : two floats, optional
        Clip |τ1|, |τ2| at these; outside every guarantee.

    Returns
    -------
    LawParameters
        ``kappa_i`` is h·γ_i^M/γ_i^m, ``inv_gamma_i`` is 1/γ_i^m;
        ``lookahead`` is h in the implicit form and 0 in the explicit one; ``band_i`` is
        h·γ_i^M·φ_i^M/γ_i^m in the implicit form (how far a disturbance holds u off its surface) and
        0 in the explicit one; ``alpha_i`` is the middle of the bounds; ``steer_low`` is infinite
        where Step 3 never steers.

    Raises
    ------
    InputError
        If the period is not positive, or a power of a gain exceeds the largest float.

    Examples
    --------
    >>> p = law_parameters(bounds=Bounds(alpha=(0.5, 1.5)), gains=Gains(), switching=Switching(),
    ...                    control_period=0.01)
    >>> p.alpha2, p.lookahead
    (1.0, 0.0)
    """
    h = positive("control_period", control_period, example=0.001)
    q0, q1, q2 = (float(q) for q in gains.exponents)
    e1 = 2.0 * q1 - 1.0
    l1, l2, l3 = gains.l
    k1, k3 = gains.k
    hold1, hold3 = gains.hold or gains.k
    low, high = gains.steering_speeds or (0.1 * gains.runup_speed, gains.runup_speed)
    if not gains.return_steering:
        low = math.inf
    to_step2, to_step3 = switching.times
    tolerance1, tolerance2, tolerance3 = switching.tolerance
    x2_enter, x2_leave = switching.chart_tangents
    (low1, high1), (low2, high2) = bounds.alpha_of(0), bounds.alpha_of(1)
    (gm1, gM1), (gm2, gM2) = bounds.gamma_of(0), bounds.gamma_of(1)
    phi1, phi2 = bounds.disturbance_of(0), bounds.disturbance_of(1)
    implicit = discretisation == "implicit"
    limit1, limit2 = saturation or (math.inf, math.inf)
    try:
        L1, L2 = l1 ** (1.0 / q1), l2 ** (1.0 / e1)
        K1, H1 = k1 ** (1.0 / q2), hold1 ** (1.0 / q2)
    except OverflowError as error:
        raise InputError(
            f"gains l = {list(gains.l)}, k = {list(gains.k)}: a power of them exceeds the largest "
            "float; write gains between 1e-9 and 1e9"
        ) from error
    return LawParameters(
        lambda1=gains.lambda1,
        q0=q0,
        l1=l1,
        l3=l3,
        L1=L1,
        L2=L2,
        q1=q1,
        inv_q1=1.0 / q1,
        inv_e1=1.0 / e1,
        r1=3.0 * q1 - 2.0,
        k3=k3,
        K1=K1,
        hold3=hold3,
        H1=H1,
        inv_q2=1.0 / q2,
        r2=2.0 * q2 - 1.0,
        runup_speed=gains.runup_speed,
        direction=DIRECTIONS[gains.direction],
        steer_low=low,
        steer_high=high,
        to_step2=to_step2,
        to_step3=to_step3,
        tolerance1=tolerance1,
        tolerance2=tolerance2,
        tolerance3=tolerance3,
        x1_leave=switching.hysteresis * tolerance2,
        turn_tolerance=switching.turn_tolerance,
        x2_enter=x2_enter,
        x2_leave=x2_leave,
        phi1=phi1,
        phi2=phi2,
        gamma_min1=gm1,
        gamma_min2=gm2,
        inv_gamma1=1.0 / gm1,
        inv_gamma2=1.0 / gm2,
        gamma_max1=gM1,
        gamma_max2=gM2,
        kappa1=h * gM1 / gm1,
        kappa2=h * gM2 / gm2,
        alpha1=0.5 * (low1 + high1),
        alpha2=0.5 * (low2 + high2),
        period=h,
        lookahead=h if implicit else 0.0,
        band1=h * gM1 * phi1 / gm1 if implicit else 0.0,
        band2=h * gM2 * phi2 / gm2 if implicit else 0.0,
        tau_max1=limit1,
        tau_max2=limit2,
        **_homogeneous(gains, gM2, h, h if implicit else 0.0),
    )


def _homogeneous(
    gains: Gains, gamma_max: float, period: float, lookahead: float
) -> dict[str, float]:
    """Numbers of homogeneous control."""
    P, k = gains.ellipsoid or (0.0,) * 6, gains.feedback or (0.0,) * 3
    given = gains.ellipsoid is not None
    names = ("P11", "P12", "P13", "P22", "P23", "P33", "feedback1", "feedback2", "feedback3")
    return {
        **dict(zip(names, (*P, *k), strict=True)),
        "level_min": lowest_level(k, gamma_max, period, lookahead) if given else 0.0,
        "widest": widest(P) if given else 0.0,
    }
