"""Which trials a certificate speaks of: its law, its bounds, its starts, exact measurements."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.proof.law_section import law_section
from parkproof.report.measured import bounds_of
from parkproof.scenario import Scenario
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.trials import Trials

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SLACK = 1e-12
"""By how much, relatively, a sum of amplitudes or a start may be off by rounding."""


def other_than_certified(certificate: dict[str, Any], scenario: Scenario) -> list[str]:
    """In what all trials of a scenario differ from what a certificate assumes.

    Parameters
    ----------
    certificate : dict
        The certificate.
    scenario : Scenario
        What the trials share; starts and truth are not looked at.

    Returns
    -------
    list of str
        Differences in words; empty if there is none.
    """
    law, given = certificate["law"], certificate["assumptions"]
    own = law_section(scenario.law, scenario.gains, scenario.switching)
    names = sorted(name for name in {*law, *own} if law.get(name) != own.get(name))
    reasons = [f"another law, other gains or other switching ({', '.join(names)})"] if names else []
    if scenario.gains.return_steering:
        reasons.append("gains.return_steering = true")
    if (scenario.switching.to_step2, scenario.switching.to_step3) != ("settled", "settled"):
        reasons.append("steps that end at a given time")
    known, proved = scenario.bounds, bounds_of(certificate)
    lowest = [[bounds.gamma_of(i)[0] for i in range(2)] for bounds in (known, proved)]
    if lowest[0] != lowest[1]:
        reasons.append(f"the controller was told other lowest γ than {json_text(lowest[1])}")
    if known.disturbance != proved.disturbance:
        allowed = json_text(given["disturbance"])
        reasons.append(f"the controller was told other bounds of φ than {allowed}")
    if scenario.robot.kind != "chained":
        reasons.append(f'robot.kind = "{scenario.robot.kind}"')
    if scenario.camera is not None:
        reasons.append("a camera of its own")
    if any(scenario.run.deviations):
        reasons.append("noise of the measurements")
    if scenario.run.delay_samples:
        reasons.append("latency of the measurements")
    if scenario.limits.saturate:
        reasons.append("inputs are clipped (limits.saturate)")
    return reasons


def json_text(value: Any) -> str:
    """Numbers and lists of a certificate as it writes them, with four digits.

    Parameters
    ----------
    value : number or list
        From JSON.

    Returns
    -------
    str
        Text.

    Examples
    --------
    >>> json_text([[0.5, 1.5], 2])
    '[[0.5, 1.5], 2]'
    """
    if isinstance(value, list | tuple):
        return "[" + ", ".join(json_text(part) for part in value) + "]"
    return f"{value:.4g}"


def outside_assumptions(certificate: dict[str, Any], trials: Trials) -> dict[str, Flags]:
    """Which trials start, or have a truth, outside what a certificate assumes.

    Parameters
    ----------
    certificate : dict
        The certificate.
    trials : Trials
        Starts and truths.

    Returns
    -------
    dict of str to array of bool
        A flag a trial for each assumption, in words.
    """
    given = certificate["assumptions"]
    low, high = _ends(trials.scale_mean, trials.scale_tones)
    least, most = _ends(trials.mean, trials.tones)
    push = np.maximum(np.maximum(-least[2:], most[2:]), trials.adversary)
    one, two = given["disturbance"]
    allowed = np.array([[one], [two]])
    return {
        "start outside the certified box": _starts_outside(given["starts"], trials),
        "α outside its bounds": _outside(low[:2], high[:2], given["alpha"]),
        "γ outside its bounds": _outside(least[:2], most[:2], given["gamma"]),
        "φ outside its bounds": np.any(push > allowed * (1.0 + SLACK), axis=0),
        "b2 outside its bounds": _outside(low[2:], high[2:], [given["b2"]]),
    }


def _ends(mean: Floats, tones: Floats) -> tuple[Floats, Floats]:
    """Least and largest value that signals can take."""
    reach = np.abs(tones[:, :, 0]).sum(axis=1)
    return mean - reach, mean + reach


def _outside(low: Floats, high: Floats, ranges: list[list[float]]) -> Flags:
    """Whether a signal leaves its range, whichever of them."""
    least, most = np.array(ranges).T[..., np.newaxis]
    slack = SLACK * np.maximum(np.abs(most), 1.0)
    out: Flags = np.any((low < least - slack) | (high > most + slack), axis=0)
    return out


def _starts_outside(box: dict[str, list[float]], trials: Trials) -> Flags:
    """Whether a start lies outside the box, in the coordinates of the box."""
    one, two, slope, four, five = trials.state
    charted = trials.in_chart > 0.0
    if "x0" in box:
        angle = np.where(charted, 0.0, slope)
        slope = np.where(charted, slope, np.tan(angle))
        four = np.where(charted, four, four * np.cos(angle))
        five = np.where(charted, five, five / np.cos(angle) ** 2)
        ahead = np.abs(angle) < 0.5 * math.pi
    else:
        steep = np.where(charted, slope, 0.0)
        slope = np.where(charted, np.arctan(steep), slope)
        four = np.where(charted, four * np.hypot(1.0, steep), four)
        five = np.where(charted, five / (1.0 + steep**2), five)
        ahead = np.ones_like(charted)
    outside = ~ahead
    for values, (low, high) in zip((one, two, slope, four, five), box.values(), strict=True):
        slack = SLACK * max(abs(low), abs(high), 1.0)
        outside |= ~((values >= low - slack) & (values <= high + slack))
    return outside


def tighter_limits(certificate: dict[str, Any], scenario: Scenario) -> set[Outcome]:
    """Limits of a scenario that a certified run may reach: to end there contradicts nothing.

    Parameters
    ----------
    certificate : dict
        The certificate.
    scenario : Scenario
        What the trials share.

    Returns
    -------
    set of Outcome
        How such trials end.
    """
    claim, limits = certificate["claim"], scenario.limits
    found = set()
    if limits.tau and any(a < b for a, b in zip(limits.tau, claim["max_tau"], strict=True)):
        found.add(Outcome.INPUT_LIMIT)
    if (limits.speed or math.inf) < claim["max_speed"] or (
        (limits.turn_rate or math.inf) < claim["max_turn_rate"]
    ):
        found.add(Outcome.SPEED_LIMIT)
    if view := limits.view:
        (low, high), aside = claim["x0_range"], claim["max_abs_state"][1]
        if view[0] > low or view[1] < high or view[2] > -aside or view[3] < aside:
            found.add(Outcome.OUT_OF_VIEW)
    return found
