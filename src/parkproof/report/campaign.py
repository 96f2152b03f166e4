"""The report of a campaign: one self-contained HTML page from its directory."""

import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof import __version__
from parkproof.campaign.definition import Campaign, campaign_from_dict
from parkproof.campaign.directory import RECORD, read_record
from parkproof.campaign.prepare import Prepared, prepare
from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.output import write_whole
from parkproof.report.campaign_causes import Rerun, sensitivity_section, worst_section
from parkproof.report.campaign_coverage import coverage_of
from parkproof.report.campaign_page import Heading, page_of
from parkproof.report.campaign_proof import alarm, proof_section
from parkproof.report.campaign_sections import (
    metrics_section,
    outcomes_section,
    settling_section,
    unfinished,
)
from parkproof.report.campaign_study import drawn_keys, study_of
from parkproof.report.deciders import Decider, deciders_of
from parkproof.report.distributions import METRICS, SETTLING, histogram, spread_of
from parkproof.report.measured import proven_numbers, sampling_bands
from parkproof.report.proved_certificate import proved_certificate
from parkproof.report.success import success_of
from parkproof.report.trial_table import PARKED, TrialTable, counted
from parkproof.report.violations import AgainstProof, against_proof
from parkproof.report.worst_trials import path_panel, worst_of
from parkproof.simulation.run import simulate

NAME = "report.html"

STUDY = 16_384
"""Further trials, at most, that say which uncertainty matters most."""

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class _Proof:
    """A certificate beside the trials."""

    certificate: dict[str, Any]
    name: str
    found: AgainstProof

    @property
    def numbers(self) -> dict[str, float]:
        """Proved numbers by name; none where the certificate speaks of no trial."""
        proven = proven_numbers(self.certificate["claim"])
        return {one.name: one.bound for one in proven} if self.found.covered.any() else {}


def write_report(
    directory: Path,
    *,
    certificate: Path | None = None,
    command: str | None = None,
    study: int = STUDY,
    threads: int = 1,
    progress: Progress | None = None,
) -> Path:
    """Write the report of a campaign as ``report.html`` in its directory.

    The page needs nothing else: pictures are inside. One column of the table is in memory at a
    time. Which uncertainty matters most is asked of further trials, see
    `parkproof.report.sensitivity`; the worst trials are carried out again, one by one.

    Parameters
    ----------
    directory : Path
        Of the campaign, finished or not.
    certificate : Path, optional
        A certificate that the trials are compared with. It is proved again first.
    command : str, optional
        What the page says made the trials; default ``parkproof campaign`` with the directory.
    study : int
        At most about so many further trials for the study of what matters; 0 leaves it out.
    threads : int
        For these.
    progress : callable, optional
        Told what is being done, and the fraction done.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    InputError
        If the directory holds no campaign, the certificate is none or not proved, or the page
        cannot be written; an earlier page is then as it was.

    Examples
    --------
    >>> from parkproof.campaign.run import run_campaign
    >>> campaign = campaign_from_dict(
    ...     {"law": "corrected", "start": {"pose": [-1, 0, 0]}, "trials": 10,
    ...      "run": {"duration": 12.0, "control_period": 0.01},
    ...      "distributions": {"start.pose[0]": {"kind": "uniform", "low": -2, "high": -1}}},
    ...     where="example")
    >>> run_campaign(campaign, directory / "out")
    >>> page = write_report(directory / "out")
    >>> "10 of 10 trials parked" in page.read_text(encoding="utf-8")
    True
    """
    require("scipy", extra="campaign", purpose="the report of a campaign")
    tell = progress or (lambda _text, _fraction: None)
    tell("reading the table", 0.0)
    prepared = _prepared(directory)
    if certificate is not None:
        check_comparable(prepared.campaign, certificate)
    table = TrialTable(directory)
    heading = _heading(directory, prepared, len(table), command)
    proof = None
    if certificate is not None:
        tell("comparing with the certificate", 0.05)
        proof = _beside_proof(certificate, prepared, table)
    tell("distributions", 0.15)
    sections = [unfinished(heading), *_sections(heading, table, proof)]
    if proof is not None:
        note = _sampling_note(proof.certificate, prepared)
        sections.insert(0, alarm(heading, proof.found, note=note))
    if len(table):
        tell("which uncertainty matters most", 0.3)
        if study:
            sections.append(_study_section(heading, prepared, study, threads))
        sections.append(_worst_section(heading, prepared, table, tell))
    target = directory / NAME
    write_whole(target, page_of(heading, sections))
    tell("done", 1.0)
    return target


def check_comparable(campaign: Campaign, certificate: Path) -> None:
    """Check that trials are carried out precisely enough to be compared with a proof.

    Parameters
    ----------
    campaign : Campaign
        The trials'.
    certificate : Path
        The proof's.

    Raises
    ------
    InputError
        If they are in single precision.

    Examples
    --------
    >>> campaign = campaign_from_dict(
    ...     {"law": "corrected", "start": {"pose": [-1, 0, 0]}, "trials": 10,
    ...      "precision": "single"}, where="example")
    >>> check_comparable(campaign, directory / "certificate.json")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ... precision = "single": ...
    """
    if campaign.precision == "single":
        raise InputError(
            f'{certificate} cannot be compared with trials in precision = "single": what rounding '
            "adds to them would be taken for violations; leave the certificate out, or write "
            'precision = "double" and choose another directory'
        )


def _prepared(directory: Path) -> Prepared:
    """The campaign of a directory; what it draws was checked when it began."""
    where = str(directory / RECORD)
    campaign = campaign_from_dict(read_record(directory)["campaign"], where=where)
    return prepare(campaign, where=where, check=False)


def _heading(directory: Path, prepared: Prepared, trials: int, command: str | None) -> Heading:
    campaign, scenario = prepared.campaign, prepared.campaign.scenario
    run = scenario.run
    drawn = ", ".join(drawn_keys(prepared)) or "nothing but noise"
    how = "a scrambled Sobol' sequence" if campaign.draws == "sobol" else "independent draws"
    singles = " Carried out in single precision." if campaign.precision == "single" else ""
    default = f"parkproof campaign CAMPAIGN.toml --out {shlex.quote(str(directory))}"
    return Heading(
        title=scenario.title or f"A campaign of the {scenario.law} law",
        description=(
            f"{trials:,} trials of the {scenario.law} law in its {run.discretisation} form, "
            f"{run.duration:g} s each with a control period of {1e3 * run.control_period:g} ms, "
            f"as far as that is not drawn. Drawn by {how}, seed {campaign.seed}: {drawn}.{singles}"
        ),
        directory=str(directory),
        command=command or default,
        trials=trials,
        asked=campaign.trials,
        independent=campaign.draws == "independent",
        version=__version__,
    )


def _beside_proof(path: Path, prepared: Prepared, table: TrialTable) -> _Proof:
    certificate = proved_certificate(path)
    covered = coverage_of(certificate, prepared, table)
    found = against_proof(certificate, table, covered.outside, long_enough=covered.long_enough)
    return _Proof(certificate, str(path), found)


def _sampling_note(certificate: dict[str, Any], prepared: Prepared) -> str:
    """What sampling alone may do."""
    period = prepared.campaign.scenario.run.control_period
    one, two = sampling_bands(certificate, period)
    return (
        "The proof is of continuous time. A control period of "
        f"{1e3 * period:g} ms lets u0 stray by {one:.2g} and u1 by {two:.2g}, and each step end up "
        "to a period late; what goes beyond that, sampling does not explain."
    )


def _sections(heading: Heading, table: TrialTable, proof: _Proof | None) -> list[str]:
    """Outcomes, times, comparison with the proof, and the other metrics."""
    codes = table.outcomes
    parts = [
        outcomes_section(
            heading, success_of(int((codes == PARKED).sum()), len(table)), counted(codes)
        )
    ]
    if not len(table):
        return parts
    proven = proof.numbers if proof else {}
    apart = ~proof.found.covered if proof and proven else None
    total = table.column(SETTLING.column)
    drawing = histogram(SETTLING, total, apart=apart, bound=proven.get(SETTLING.proven), wide=True)
    parts.append(settling_section(heading, drawing, spread_of(total), proven))
    if proof is not None:
        from parkproof.proof.checker.statement import statement_of

        statement = statement_of(proof.certificate)
        parts.append(proof_section(heading, proof.found, name=proof.name, statement=statement))
    spreads, drawings = {}, {}
    for metric in METRICS:
        values: NDArray[np.float64] = table.column(metric.column)
        spreads[metric] = spread_of(values)
        if metric.drawn:
            bound = proven.get(metric.proven)
            drawings[metric] = histogram(metric, values, apart=apart, bound=bound)
    parts.append(metrics_section(heading, drawings, spreads, proven))
    return parts


def _study_section(heading: Heading, prepared: Prepared, trials: int, threads: int) -> str:
    """What matters most, or why there is no question."""
    keys = drawn_keys(prepared)
    if len(keys) < 2:
        only = f"Only {keys[0]} is drawn." if keys else "Nothing but noise is drawn."
        return sensitivity_section(heading, [Decider("One quantity", only)], trials=0)
    found = study_of(prepared, trials=trials, threads=threads)
    return sensitivity_section(heading, deciders_of(found), trials=found.trials)


def _worst_section(heading: Heading, prepared: Prepared, table: TrialTable, tell: Progress) -> str:
    """The worst trials, carried out again and drawn."""
    worst, found = worst_of(table), []
    for i, trial in enumerate(worst):
        tell(f"drawing trial {trial.trial}", 0.5 + 0.5 * i / len(worst))
        run = simulate(prepared.scenario_of(trial.trial))
        found.append(Rerun(trial, path_panel(run), run.outcome))
    return worst_section(heading, found)
