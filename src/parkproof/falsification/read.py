"""What a search is for: a scenario, or a certificate with all that it speaks of."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.falsification.claims import claims_of
from parkproof.falsification.space import SearchSpace, space_of_certificate, space_of_scenario
from parkproof.report.measured import Proven, proven_numbers
from parkproof.scenario import RunSettings, Scenario
from parkproof.scenario_file import read_scenario
from parkproof.scenario_file.overrides import apply_overrides
from parkproof.scenario_file.read import converted

_REMEDY = "name a certificate.json that parkproof certify or parkproof design wrote"

AFTER = 1.0
"""How long runs go on after the proven time, in s."""


@dataclass(frozen=True, kw_only=True)
class Target:
    """What is to be broken.

    Attributes
    ----------
    space : SearchSpace
        What may be chosen.
    claims : tuple of Proven
        What should hold for every choice.
    proved : bool
        Whether they are claims of a proof, which speaks of continuous time.
    """

    space: SearchSpace
    claims: tuple[Proven, ...]
    proved: bool


def target_of(path: Path, *, overrides: Sequence[str] = (), box: Sequence[float] = ()) -> Target:
    """Read a scenario or a certificate.

    Parameters
    ----------
    path : Path
        A certificate if its name ends in .json, else a scenario.
    overrides : sequence of str
        Such as ``run.duration=20``; of a certificate's runs only keys of ``run``.
    box : sequence of float
        Of a scenario: by how much each number of the start may differ.

    Returns
    -------
    Target
        The search that it asks for.

    Raises
    ------
    InputError
        If the file is neither, or an override or the box does not fit it.

    Examples
    --------
    >>> target_of(directory / "none.json")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...none.json: cannot be read (No such file or directory); ...
    """
    if path.suffix.lower() != ".json":
        scenario = read_scenario(path, overrides=overrides)
        space = space_of_scenario(scenario, box=box)
        return Target(space=space, claims=tuple(claims_of(scenario)), proved=False)
    if box:
        raise InputError("--box goes with a scenario: a certificate names its own starts")
    certificate = _certificate(path)
    run = _run_settings(certificate, overrides)
    try:
        space = space_of_certificate(certificate, run)
    except InputError as error:
        raise InputError(f"{path}: {error}; {_REMEDY}") from error
    return Target(space=space, claims=tuple(proven_numbers(certificate["claim"])), proved=True)


def _certificate(path: Path) -> dict[str, Any]:
    """A certificate of the right shape; whether it is proved is what `verify` says."""
    require("flint", extra="proof", purpose="parkproof falsify with a certificate")
    from parkproof.proof.checker.certificate import NotACertificateError, read
    from parkproof.proof.checker.shape import misfit_of_certificate

    try:
        certificate = read(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); {_REMEDY}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text; {_REMEDY}") from error
    except NotACertificateError as error:
        raise InputError(f"{path}: {error}; {_REMEDY}") from error
    if misfit := misfit_of_certificate(certificate):
        raise InputError(f"{path}: {misfit}; {_REMEDY}")
    return certificate


def _run_settings(certificate: dict[str, Any], overrides: Sequence[str]) -> RunSettings:
    """How runs of a certificate are carried out, as the command line changes it."""
    time = certificate["claim"]["total_time"]
    if not 0.0 < time < math.inf:
        raise InputError(f"the certificate's total_time = {time:g}: must be a positive number")
    usual = RunSettings(
        duration=math.ceil(time + AFTER),
        control_period=2e-3,
        plant_step=2e-3,
        discretisation="implicit",
    )
    for text in overrides:
        if not text.strip().startswith("run."):
            raise InputError(
                f"--set {text}: of a certificate's runs only keys of run can be set, such as "
                "run.control_period=0.001; everything else is what it speaks of"
            )
    data: dict[str, Any] = {"run": msgspec.to_builtins(usual)}
    apply_overrides(data, overrides, Scenario)
    run = converted(data["run"], RunSettings, "[run] of --set")
    if run.duration < time:
        raise InputError(
            f"run.duration = {run.duration:g}: shorter than the proven time, {time:g}; leave it out"
        )
    return run
