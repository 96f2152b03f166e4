"""What a certificate says of the law that it speaks of.

Reports compare scenarios with certificates without proving anything, so this needs no ball
arithmetic.
"""

from typing import Any

from parkproof.laws.gains import Gains, Switching


def law_section(name: str, gains: Gains, switching: Switching) -> dict[str, Any]:
    """All numbers of the law that a certificate speaks of.

    Parameters
    ----------
    name : "corrected" or "homogeneous"
        The law.
    gains : Gains
        Its gains.
    switching : Switching
        When it switches.

    Returns
    -------
    dict
        The certificate's section "law".

    Examples
    --------
    >>> law_section("corrected", Gains(), Switching())["l"]
    [2.0, 4.2, 21.0]
    """
    q0, q1, q2 = gains.exponents
    section: dict[str, Any] = {
        "name": name,
        "q0": str(q0),
        "q1": str(q1),
        "q2": str(q2),
        "lambda1": gains.lambda1,
        "k": list(gains.k),
        "hold": list(gains.hold or gains.k),
        "runup_speed": gains.runup_speed,
        "direction": gains.direction,
        "return_steering": False,
        "tolerance": list(switching.tolerance),
        "hysteresis": switching.hysteresis,
        "turn_tolerance": switching.turn_tolerance,
        "chart_limit": switching.chart_limit,
    }
    if name == "homogeneous":
        section |= {
            "ellipsoid": list(gains.ellipsoid or ()),
            "feedback": list(gains.feedback or ()),
        }
    else:
        section["l"] = list(gains.l)
    return section
