"""What a certificate claims, in sentences that follow from its numbers alone."""

from typing import Any


def _ranges(given: dict[str, Any]) -> str:
    return ", ".join(f"{name} in {pair}" for name, pair in given.items())


def statement_of(certificate: dict[str, Any]) -> list[str]:
    """Say what a certificate claims, from its numbers alone.

    Parameters
    ----------
    certificate : dict
        From `read`.

    Returns
    -------
    list of str
        Sentences.

    Examples
    --------
    >>> statement_of({})
    Traceback (most recent call last):
    ...
    KeyError: 'claim'
    """
    claim, given, law = certificate["claim"], certificate["assumptions"], certificate["law"]
    (a1, a2), (g1, g2), (f1, f2) = given["alpha"], given["gamma"], given["disturbance"]
    low, high = claim["x0_range"]
    _, x1, x2, u0, u1 = claim["max_abs_state"]
    tau1, tau2 = claim["max_tau"]
    return [
        "THEOREM. Let x0' = a1 u0, x1' = a2 u0 x2, x2' = b2 u1, u0' = g1 tau1 + f1 and "
        "u1' = g2 tau2 + f2,",
        f"where a1 in {a1}, a2 in {a2}, b2 in {given['b2']}, g1 in {g1}, g2 in {g2}, "
        f"|f1| <= {f1} and |f2| <= {f2}, all of which may vary in time.",
        f"Under the {law['name']} law with the gains of this file, from every start with "
        f"{_ranges(given['starts'])}:",
        f"1. Within {claim['total_time']} s the robot is parked: x0, x2, u0 and u1 are 0 and stay "
        f"0, and x1 stays where it is, with |x1| <= {claim['x1_at_rest']}.",
        f"2. Always |tau1| <= {tau1} and |tau2| <= {tau2}.",
        f"3. Always {low} <= x0 <= {high} and |x1| <= {x1}: it stays in any view that holds this.",
        f"4. Always |u0| <= {u0}, and, after a turn if it needs one, |x2| <= {x2} and "
        f"|u1| <= {u1}.",
        f"5. Always |v| <= {claim['max_speed']} and |omega| <= {claim['max_turn_rate']}, and the "
        f"heading is within {claim['max_heading']} rad of the goal's.",
        "Here x0, x1 are the position, x2 is the tangent of the heading, u0 = v cos(theta) and "
        "u1 = omega / cos(theta)^2; in a turn v' = g1 tau1 + f1, omega' = g2 tau2 + f2, "
        "theta' = b2 omega, and a heading of half a turn is taken with one sign.",
        "The law uses the lower bounds of g1, g2 and the bounds of f1, f2 given here; its steps "
        "end when settled, its inputs are not clipped, and it does not steer in Step 3.",
        "This speaks of continuous time. What sampling, noise and latency add is not proved.",
    ]


def measured_sentence(certificate: dict[str, Any]) -> str:
    """Say what was measured beside the proof.

    Parameters
    ----------
    certificate : dict
        From `read`.

    Returns
    -------
    str
        A sentence; empty if nothing was measured.

    Examples
    --------
    >>> measured_sentence({"measured": {"runs": 256, "parked": 256}})
    'Measured, not proved: runs 256, parked 256.'
    """
    measured = certificate["measured"]
    if not isinstance(measured, dict) or not measured:
        return ""
    facts = ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in measured.items())
    return f"Measured, not proved: {facts}."
