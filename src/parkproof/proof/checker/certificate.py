"""Certificates: reading one, proving what it claims, and saying it in sentences.

`prove` takes nothing from the file on trust but what the theorem assumes: every rate and size is
proved anew, every bound of the run is computed anew from them, and each number claimed must not be
below its bound.
"""

import hashlib
import json
import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from flint import ctx

from parkproof.proof.checker.balls import Range, exact
from parkproof.proof.checker.chains import TwoChain
from parkproof.proof.checker.ellipsoid import Ellipsoid
from parkproof.proof.checker.links import Homogeneous, Link, PowerIntegrator
from parkproof.proof.checker.parts import GapError, Law, Links, Peaks, Uncertainty
from parkproof.proof.checker.shape import misfit_of_certificate
from parkproof.proof.checker.squares import ThreeChainWithSquares
from parkproof.proof.checker.whole_run import run_bounds

SCHEMA = "parkproof-certificate-1"
PRECISION = 64
"""Bits of the ball arithmetic."""

LARGEST_CHART = 89
"""Largest chart_limit in degrees: the tangent must stay a number of moderate size."""


class NotACertificateError(ValueError):
    """A file that cannot be read as a certificate, or whose digest is wrong."""


def digest_of(certificate: dict[str, Any]) -> str:
    """SHA-256 of all of a certificate but its digest.

    Parameters
    ----------
    certificate : dict
        The certificate, with or without its digest.

    Returns
    -------
    str
        Hexadecimal digest of its canonical JSON.

    Examples
    --------
    >>> digest_of({"a": 1, "digest": "x"}) == digest_of({"a": 1})
    True
    """
    rest = {key: value for key, value in certificate.items() if key != "digest"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len({key for key, _ in pairs}) != len(pairs):
        raise ValueError("a key is given twice")
    return dict(pairs)


def read(text: str) -> dict[str, Any]:
    """Read a certificate and check its schema and digest.

    Parameters
    ----------
    text : str
        JSON.

    Returns
    -------
    dict
        The certificate.

    Raises
    ------
    NotACertificateError
        If it cannot be read, is of another schema, or its digest is wrong.

    Examples
    --------
    >>> read("{}")
    Traceback (most recent call last):
    ...
    parkproof.proof.checker.certificate.NotACertificateError: not a parkproof-certificate-1 ...
    """
    try:
        certificate = json.loads(text, object_pairs_hook=_without_repetition)
        digest = digest_of(certificate) if isinstance(certificate, dict) else ""
    except RecursionError as error:
        raise NotACertificateError("not JSON: lists are nested too deeply") from error
    except ValueError as error:
        raise NotACertificateError(f"not JSON: {error}") from error
    if not isinstance(certificate, dict) or certificate.get("schema") != SCHEMA:
        raise NotACertificateError(f"not a {SCHEMA} (its key schema says otherwise)")
    if certificate.get("digest") != digest:
        raise NotACertificateError("the digest is wrong: the file was changed or cut short")
    return certificate


def two_chain_of(law: dict[str, Any], lyapunov: dict[str, Any], name: str) -> PowerIntegrator:
    """The proof of a chain of two that a certificate proposes.

    Parameters
    ----------
    law, lyapunov : dict
        Sections of a certificate.
    name : "hold" or "return"
        Which chain.

    Returns
    -------
    PowerIntegrator
        Not yet proved.

    Examples
    --------
    >>> two_chain_of({}, {}, "hold")
    Traceback (most recent call last):
    ...
    KeyError: 'hold'
    """
    found, gains = lyapunov[name], law["k" if name == "return" else "hold"]
    chain = TwoChain(law["q2"], gains, found["k2"])
    return PowerIntegrator(chain, found["rate"], tuple(found["sizes"]))


def links_of(law: dict[str, Any], lyapunov: dict[str, Any]) -> Links:
    """The proofs of the three chains that a certificate proposes.

    Parameters
    ----------
    law, lyapunov : dict
        Sections of a certificate.

    Returns
    -------
    Links
        Not yet proved.

    Examples
    --------
    >>> links_of({}, {})
    Traceback (most recent call last):
    ...
    KeyError: 'approach'
    """
    found = lyapunov["approach"]
    approach: Link
    if law["name"] == "homogeneous":
        ellipsoid = Ellipsoid(law["ellipsoid"], law["feedback"])
        approach = Homogeneous(ellipsoid, found["rate"], (found["rho"][0], found["rho"][1]))
    else:
        chain = ThreeChainWithSquares(law["q1"], law["l"], found["k"], 1.0, found["s"])
        approach = PowerIntegrator(chain, found["rate"], tuple(found["sizes"]))
    hold, back = (two_chain_of(law, lyapunov, name) for name in ("hold", "return"))
    return Links(approach, hold, back)


def _numbers(value: Any) -> list[float]:
    """All numbers in a section, wherever they stand."""
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return []
    if isinstance(value, int | float):
        return [value]
    inner = value.values() if isinstance(value, dict) else value
    return [number for part in inner for number in _numbers(part)]


def _crossed(pairs: list[Any]) -> bool:
    return any(len(pair) != 2 or not pair[0] <= pair[1] for pair in pairs)


def _flaws(certificate: dict[str, Any]) -> Iterator[str]:
    """Why a certificate's numbers make no sense."""
    law, lyapunov = certificate["law"], certificate["lyapunov"]
    claim, given = certificate["claim"], certificate["assumptions"]
    if not all(map(math.isfinite, _numbers([law, lyapunov, claim, given]))):
        yield "a number is not finite"
    if _crossed([*given["alpha"], *given["gamma"], given["b2"], *given["starts"].values()]):
        yield "a range of the assumptions is crossed"
    gains = ["k", "hold", "tolerance", "lambda1", "runup_speed", "turn_tolerance", "chart_limit"]
    gains += ["l"] if law["name"] == "corrected" else []
    # ρ is 0 without disturbance, and squares may be left out of V
    links = [{**link, "rho": [], "s": []} for link in lyapunov.values()]
    free = _numbers([[link.get("rho", []), link.get("s", [])] for link in lyapunov.values()])
    positive = _numbers([links, given["alpha"], given["gamma"], given["b2"]])
    positive += _numbers([law[name] for name in gains])
    if not all(number > 0 for number in positive) or min([*given["disturbance"], *free]) < 0:
        yield "a gain, weight or bound is not positive"
    if not law["chart_limit"] <= LARGEST_CHART or not law["turn_tolerance"] < 1:
        yield f"chart_limit must be at most {LARGEST_CHART} degrees, and turn_tolerance below 1"
    if not law["hysteresis"] > 1:
        yield "hysteresis must exceed 1"
    lowest = {"q0": Fraction(0), "q1": Fraction(2, 3), "q2": Fraction(1, 2)}
    if any(not low < Fraction(law[name]) < 1 for name, low in lowest.items()):
        yield "an exponent lies outside its interval"
    if certificate["sampled"]:
        yield "links were only sampled: " + ", ".join(map(str, certificate["sampled"]))


def _false_claim(claim: dict[str, Any], peaks: Peaks) -> str:
    """Which claim is below its bound, or nothing."""
    low, high = claim["x0_range"]
    bounds = {
        "total_time": [(claim["total_time"], peaks.time)],
        "max_tau": list(zip(claim["max_tau"], peaks.tau, strict=True)),
        "max_abs_state": list(zip(claim["max_abs_state"], peaks.states, strict=True)),
        "max_speed": [(claim["max_speed"], peaks.speed)],
        "max_turn_rate": [(claim["max_turn_rate"], peaks.turn_rate)],
        "max_heading": [(claim["max_heading"], peaks.heading)],
        "x0_range": [(-low, -peaks.x0[0]), (high, peaks.x0[1])],
        "x1_at_rest": [(claim["x1_at_rest"], peaks.x1_at_rest)],
    }
    for name, pairs in bounds.items():
        for claimed, bound in pairs:
            if not exact(claimed) >= bound:
                return f"{name}: {claimed!r} is claimed, {bound.str(8, radius=False)} follows"
    return ""


def _unproved_link(links: Links, known: Uncertainty, b1: Range) -> str:
    """Which link is not proved, or nothing."""
    two, one = (known.gamma[1], known.phi[1]), (known.gamma[0], known.phi[0])
    if not links.hold.proved([known.b2], *two):
        return "the Lyapunov function of holding (x2, u1) is not proved to fall as claimed"
    if not links.back.proved([known.alpha[0]], *one):
        return "the Lyapunov function of the return is not proved to fall as claimed"
    if not links.approach.proved([b1, known.b2], *two):
        return "the Lyapunov function of the approach is not proved to fall as claimed"
    return ""


def why_not(certificate: dict[str, Any]) -> str:
    """Re-prove all that a certificate claims.

    Parameters
    ----------
    certificate : dict
        From `read`.

    Returns
    -------
    str
        Nothing if every claim was proved, else the first reason why not.

    Raises
    ------
    NotACertificateError
        If a part is missing or of the wrong kind.

    Examples
    --------
    >>> why_not({"schema": SCHEMA})
    Traceback (most recent call last):
    ...
    parkproof.proof.checker.certificate.NotACertificateError: its keys is not what it must be ...
    """
    ctx.prec = PRECISION
    if place := misfit_of_certificate(certificate):
        raise NotACertificateError(f"{place} is not what it must be (see the schema)")
    try:
        for flaw in _flaws(certificate):
            return flaw
        law, known = Law.of(certificate["law"]), Uncertainty.of(certificate["assumptions"])
        links = links_of(certificate["law"], certificate["lyapunov"])
        starts = certificate["assumptions"]["starts"]
        peaks, b1 = run_bounds(starts, law, known, links)
        return _false_claim(certificate["claim"], peaks) or _unproved_link(links, known, b1)
    except GapError as error:
        return str(error)
    except (ValueError, ArithmeticError) as error:  # a ball that is no number proves nothing
        return f"arithmetic failed: {error}"
