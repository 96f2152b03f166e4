"""Makes certificates of whole runs: what is sought is sampled, what is written is proved."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from parkproof import __version__
from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.laws.gains import Gains, Switching
from parkproof.proof.checker.balls import up
from parkproof.proof.checker.certificate import (
    PRECISION,
    SCHEMA,
    digest_of,
    links_of,
    two_chain_of,
)
from parkproof.proof.checker.parts import GapError, Law, Peaks, Uncertainty
from parkproof.proof.checker.starts import boxes
from parkproof.proof.checker.whole_run import gain_range, run_bounds
from parkproof.proof.find_links import approach_link, two_chain_link
from parkproof.proof.homogeneous_rate import proven_rate
from parkproof.proof.law_section import law_section


@dataclass(frozen=True)
class Certified:
    """A certificate, or why there is none.

    Attributes
    ----------
    certificate : dict or None
        As it is written to a file; `parkproof.proof.checker` re-proves it.
    reason : str
        Why nothing was proved; empty if something was.

    Examples
    --------
    >>> Certified(None, "no weights were found").certificate is None
    True
    """

    certificate: dict[str, Any] | None
    reason: str = ""


def _rounded_up(value: Any) -> float:
    """The number with seven digits next above a bound."""
    top = up(value)
    if top == 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(abs(top))) - 6)
    rounded = float(f"{math.ceil(top / unit) * unit:.7g}")
    return rounded if rounded >= top else float(f"{(math.ceil(top / unit) + 1) * unit:.7g}")


def claim_of(peaks: Peaks) -> dict[str, Any]:
    """The claim of a certificate: bounds, rounded up to seven digits.

    Parameters
    ----------
    peaks : Peaks
        Bounds of the run.

    Returns
    -------
    dict
        Its section "claim".

    Examples
    --------
    >>> claim_of(Peaks())["total_time"]
    0.0
    """
    low, high = peaks.x0
    return {
        "total_time": _rounded_up(peaks.time),
        "max_tau": [_rounded_up(tau) for tau in peaks.tau],
        "max_abs_state": [_rounded_up(state) for state in peaks.states],
        "max_speed": _rounded_up(peaks.speed),
        "max_turn_rate": _rounded_up(peaks.turn_rate),
        "max_heading": _rounded_up(peaks.heading),
        "x0_range": [0.0 - _rounded_up(-low), _rounded_up(high)],
        "x1_at_rest": _rounded_up(peaks.x1_at_rest),
    }


def certify(
    *,
    law: Literal["corrected", "homogeneous"],
    bounds: Bounds,
    gains: Gains,
    switching: Switching | None = None,
    starts: Mapping[str, tuple[float, float]],
    progress: Callable[[str], None] = lambda _: None,
) -> Certified:
    """Prove that whole runs park, from every start of a box, whatever is uncertain within bounds.

    Parameters
    ----------
    law : "corrected" or "homogeneous"
        The law, without steering in Step 3.
    bounds : Bounds
        Of α, γ, φ and b2; all may vary in time.
    gains : Gains
        Its gains, with exponents that are ratios.
    switching : Switching, optional
        When it switches, always "settled". Default: tolerances of 0.01, and the least hysteresis
        with which the proof goes through.
    starts : mapping
        Ranges of x0, x1, x2, u0 and u1, or of x, y, theta, v and omega.
    progress : callable
        Told what is being done.

    Returns
    -------
    Certified
        The certificate, or why there is none.

    Raises
    ------
    InputError
        If an argument breaks a rule.

    Examples
    --------
    >>> known = Bounds(alpha=(0.9, 1.1))
    >>> starts = dict.fromkeys(("x0", "x1", "x2", "u0", "u1"), (0.0, 0.1))
    >>> gains = Gains(q1="13/15", direction="toward")
    >>> found = certify(law="corrected", bounds=known, gains=gains, starts=starts)
    >>> found.certificate["claim"]["total_time"] < 30.0
    True
    """
    from flint import ctx

    ctx.prec = PRECISION
    for name, exponent in zip(("q0", "q1", "q2"), gains.exponents, strict=True):
        if exponent.fraction is None:
            raise InputError(
                f'{name} = {exponent}: a certificate needs a ratio of integers; write "9/11"'
            )
    gains.check_law(law)
    free = switching is None
    chosen = switching or Switching(
        tolerance=(0.1 * gains.runup_speed, 0.01, 0.01), hysteresis=1e9, turn_tolerance=0.01
    )
    section, b2 = law_section(law, gains, chosen), bounds.b2
    assumptions = {
        "alpha": [list(bounds.alpha_of(i)) for i in range(2)],
        "gamma": [list(bounds.gamma_of(i)) for i in range(2)],
        "disturbance": [bounds.disturbance_of(i) for i in range(2)],
        "b2": list(b2),
        "starts": {name: list(pair) for name, pair in starts.items()},
    }
    q2 = str(gains.exponents[2])
    progress("holding: Lyapunov function of (x2, u1)")
    hold = two_chain_link(q2, gains.hold or gains.k, b2)
    progress("return: Lyapunov function of (x0, u0)")
    back = two_chain_link(q2, gains.k, bounds.alpha_of(0))
    if hold is None or back is None:
        which = "hold" if hold is None else "k"
        return Certified(None, f"no Lyapunov function was found for {which}: raise {which}[1]")
    lyapunov = {"hold": hold, "return": back}
    try:
        ranges = _gain_ranges(section, assumptions, lyapunov)
        progress(f"approach: Lyapunov function for b1 in [{ranges[0][0]:.3g}, {ranges[0][1]:.3g}]")
        approach = _approach(law, gains, ranges, bounds)
        if approach is None:
            return Certified(
                None,
                f"no Lyapunov function was found for the approach with b1 in {list(ranges[0])} and "
                f"b2 in {list(b2)}: narrow them, raise l2 and l3, or take a q1 nearer to 1",
            )
        lyapunov["approach"] = approach
        progress("the whole run")
        peaks = _peaks(section, assumptions, lyapunov)
        if free:
            drift = up(peaks.x1_at_rest / section["tolerance"][1])
            section["hysteresis"] = max(2.0, math.ceil(100.0 * drift) / 100.0)
            peaks = _peaks(section, assumptions, lyapunov)
    except (GapError, ValueError, ArithmeticError) as error:
        return Certified(None, str(error))
    return Certified(_signed(claim_of(peaks), assumptions, section, lyapunov))


def with_measured(certificate: dict[str, Any], measured: Mapping[str, Any]) -> dict[str, Any]:
    """A certificate with what was measured beside it, under a new digest.

    Parameters
    ----------
    certificate : dict
        The certificate.
    measured : mapping
        What was measured, and how; no part of the proof.

    Returns
    -------
    dict
        The certificate.

    Examples
    --------
    >>> with_measured({"claim": 1}, {"runs": 3})["measured"]
    {'runs': 3}
    """
    body = {key: value for key, value in certificate.items() if key != "digest"}
    body["measured"] = dict(measured)
    return {**body, "digest": digest_of(body)}


def _peaks(section: dict[str, Any], assumptions: dict[str, Any], lyapunov: dict[str, Any]) -> Peaks:
    links = links_of(section, lyapunov)
    starts, known = assumptions["starts"], Uncertainty.of(assumptions)
    return run_bounds(starts, Law.of(section), known, links)[0]


def _gain_ranges(
    section: dict[str, Any], assumptions: dict[str, Any], lyapunov: dict[str, Any]
) -> list[tuple[float, float]]:
    """Ranges of b1 and b2 in the approach."""
    law, known = Law.of(section), Uncertainty.of(assumptions)
    hold = two_chain_of(section, lyapunov, "hold")
    starting = list(boxes(assumptions["starts"], law, known, hold, Peaks()))
    return [gain_range(law, known, starting), known.b2]


def _approach(
    law: str, gains: Gains, ranges: list[tuple[float, float]], bounds: Bounds
) -> dict[str, Any] | None:
    """The link of Step 2, proved."""
    if law == "homogeneous" and gains.ellipsoid is not None and gains.feedback is not None:
        gamma, phi = bounds.gamma_of(1), bounds.disturbance_of(1)
        found = proven_rate(
            gains.ellipsoid,
            gains.feedback,
            b1=ranges[0],
            b2=ranges[1],
            gamma=gamma,
            disturbance=phi,
        )
        return None if found is None else {"rate": found[0], "rho": list(found[1])}
    return approach_link(gains, ranges)


def _signed(
    claim: dict[str, Any],
    assumptions: dict[str, Any],
    section: dict[str, Any],
    lyapunov: dict[str, Any],
) -> dict[str, Any]:
    """The certificate with its digest."""
    from importlib.metadata import version

    body = {
        "schema": SCHEMA,
        "claim": claim,
        "assumptions": assumptions,
        "law": section,
        "lyapunov": lyapunov,
        "sampled": [],
        "measured": {},
        "method": "bisection of homogeneous surfaces in ball arithmetic (Arb), and exact rationals",
        "versions": {"parkproof": __version__, "python-flint": version("python-flint")},
    }
    body = json.loads(json.dumps(body))
    return {**body, "digest": digest_of(body)}
