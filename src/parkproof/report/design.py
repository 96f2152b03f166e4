"""The files of a design: gains, certificate, summary, a scenario, and pictures."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from parkproof.model.signals import Adversary
from parkproof.model.truth import Truth
from parkproof.proof.design import Design
from parkproof.proof.whole_run import with_measured
from parkproof.report.measured import bounds_of, gains_of, measured_of, start_at, switching_of
from parkproof.report.settling_map import draw_settling_map, settling_map
from parkproof.report.tradeoff import draw_tradeoff
from parkproof.scenario import RunSettings, Scenario
from parkproof.scenario_file import to_toml
from parkproof.scenario_file.write import toml_of
from parkproof.spec import Spec


def write_design(
    found: Design,
    directory: Path,
    *,
    pictures: bool = True,
    progress: Callable[[str, float], None] = lambda *_: None,
) -> None:
    """Write all files of a design that has a certificate.

    Parameters
    ----------
    found : Design
        The design; its certificate gets its section "measured".
    directory : Path
        Where to.
    pictures : bool
        Whether to draw.
    progress : callable
        Told what is being done.
    """
    if found.certificate is None:
        return
    period = found.spec.design.control_period
    progress("measuring runs", 0.0)
    aim = found.spec.design
    measured = measured_of(
        found.certificate, control_period=period, noise=aim.noise, latency=aim.latency
    )
    found.certificate = with_measured(found.certificate, measured)
    (directory / "certificate.json").write_text(
        json.dumps(found.certificate, indent=1) + "\n", encoding="utf-8"
    )
    (directory / "gains.toml").write_text(gains_toml(found), encoding="utf-8")
    (directory / "scenario.toml").write_text(to_toml(example_of(found)), encoding="utf-8")
    summary = json.dumps(summary_of_design(found), indent=2)
    (directory / "summary.json").write_text(summary + "\n", encoding="utf-8")
    if not pictures:
        return
    progress("drawing the trade-offs", 0.3)
    for ending in ("png", "svg"):
        draw_tradeoff(found, directory / f"tradeoff.{ending}")
    progress("the map of settling times", 0.4)
    times = settling_map(found.certificate, control_period=period)
    for ending in ("png", "svg"):
        draw_settling_map(times, directory / f"settling_map.{ending}")


def gains_toml(found: Design) -> str:
    """What was designed, as a file for `parkproof certify`; its [gains] go into any scenario.

    Parameters
    ----------
    found : Design
        The design.

    Returns
    -------
    str
        TOML.
    """
    if found.certificate is None:
        return ""
    spec = found.spec
    whole = Spec(
        title=spec.title,
        law=found.certificate["law"]["name"],
        bounds=spec.bounds,
        starts=spec.starts,
        limits=spec.limits,
        gains=gains_of(found.certificate),
        switching=switching_of(found.certificate),
    )
    return toml_of(whole, leave_out=("design",))


def example_of(found: Design) -> Scenario:
    """A scenario with the gains found, from a corner of the box, against the adversary.

    Parameters
    ----------
    found : Design
        The design, with a certificate.

    Returns
    -------
    Scenario
        For `parkproof park`.
    """
    certificate: dict[str, Any] = found.certificate or {}
    box = certificate["assumptions"]["starts"]
    start = start_at({name: pair[1] for name, pair in box.items()})
    bounds = bounds_of(certificate)
    worst = (Adversary(), Adversary())
    return Scenario(
        title=found.spec.title or "Designed gains",
        law=certificate["law"]["name"],
        bounds=bounds,
        gains=gains_of(certificate),
        switching=switching_of(certificate),
        truth=Truth(alpha=worst, gamma=worst, disturbance=worst, b2=Adversary()),
        start=start,
        limits=found.spec.limits,
        run=RunSettings(
            duration=float(f"{certificate['claim']['total_time'] + 3.0:.3g}"),
            control_period=found.spec.design.control_period,
            discretisation="implicit",
        ),
    )


def summary_of_design(found: Design) -> dict[str, Any]:
    """The design in numbers, for programs.

    Parameters
    ----------
    found : Design
        The design.

    Returns
    -------
    dict
        Claim, limits and what they need, and how the search went.
    """
    certificate: dict[str, Any] = found.certificate or {}
    chosen = found.chosen
    return {
        "law": certificate["law"]["name"],
        "claim": certificate["claim"],
        "sampled": certificate["sampled"],
        "measured": certificate["measured"],
        "limits": {
            name: {"allowed": allowed, "needed": needed}
            for name, (needed, allowed) in (chosen.excesses(found.spec) if chosen else {}).items()
        },
        "candidates": len(found.looked_at),
        "interrupted": found.interrupted,
        "versions": certificate["versions"],
    }


def facts_of(found: Design) -> list[tuple[str, str]]:
    """The design in a table for a reader.

    Parameters
    ----------
    found : Design
        The design.

    Returns
    -------
    list of pairs
        Label and text.
    """
    certificate: dict[str, Any] = found.certificate or {}
    claim, measured = certificate["claim"], certificate["measured"]
    low, high = claim["x0_range"]
    parked = f"{measured['parked']} of {measured['runs']} runs parked"
    return [
        ("Law", certificate["law"]["name"]),
        (
            "Parked within",
            f"{claim['total_time']:.4g} s, proved; x1 within {claim['x1_at_rest']:.3g}",
        ),
        ("Inputs", "|τ1| ≤ {:.4g}, |τ2| ≤ {:.4g}, proved".format(*claim["max_tau"])),
        ("Speeds", f"|v| ≤ {claim['max_speed']:.4g}, |ω| ≤ {claim['max_turn_rate']:.4g}, proved"),
        (
            "View",
            f"x0 from {low:.4g} to {high:.4g}, |x1| ≤ {claim['max_abs_state'][1]:.4g}, proved",
        ),
        (
            "Measured",
            f"{parked}; the slowest in {measured['slowest']} s, residual {measured['residual']}",
        ),
        ("Candidates", f"{len(found.looked_at):,} looked at"),
    ]
