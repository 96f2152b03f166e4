"""``parkproof check``: the conditions on the gains."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

if TYPE_CHECKING:
    from rich.console import Console

    from parkproof.proof.conditions import Condition
    from parkproof.proof.homogeneous_conditions import HomogeneousConditions
    from parkproof.scenario_file import GainsFile

    Forms = dict[str, tuple[Condition, ...]]

_PROOF_ONLY = (
    "The weights k1, k2 and k~2 belong to the proof alone: the law does not use them, and others "
    "may prove the same gains."
)
_SCAN = (
    "(18)(19) are read from a scan that lost part of them; (18')(19'), untuned, are derived anew."
)
_SUFFICIENT = "The conditions are sufficient, not necessary: gains that fail them may still park."
_OTHER_LAW = (
    "(15)-(17) are about gains q1 and l, which the homogeneous law does not use; in their place "
    "stands the matrix inequality, proved in exact rationals. The weight k~2 belongs to the proof "
    "alone."
)
_ONLY_B2_1 = (
    "(15)-(17) are about b2 = 1, and say nothing of b2 in [{:g}, {:g}], which parkproof certify "
    "takes in"
)
_WORDS = {"printed": "as printed", "sharp": "in the sharp form", "untuned": "in the untuned form"}


def check(
    gains: Path,
    /,
    *,
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None,
    as_json: Annotated[bool, Parameter(name="--json")] = False,
    check_holds: Annotated[bool, Parameter(name="--check")] = False,
) -> int:
    """Evaluate the paper's conditions (15)-(19) on the gains in a file.

    Shows every condition with its value, which must be negative, its margin (by how much its
    positive terms could grow together) and its largest term: (15)-(17) as printed and in the sharp
    form, (18)(19) as printed and as (18')(19'). Each form is sufficient by itself. For the
    homogeneous law, which has no gains of (15)-(17), Step 2 is judged by its matrix inequality;
    that needs the extra "proof". The exit status is 0 whether they hold or not.

    Parameters
    ----------
    gains : Path
        A scenario file, a file with [bounds], [gains] and [weights], or gains of a design.
    settings : list of str, optional
        Override a key of the file, as in gains.l[2]=300; may be repeated.
    as_json : bool
        Print everything as JSON instead of tables.
    check_holds : bool
        Exit with status 1 unless the conditions of both steps hold in some form.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        If the file has no gains, or --check needs a library that is missing.

    Examples
    --------
    >>> check(Path("gains.toml"), check_holds=True)
    Section 4...
    1
    """
    from parkproof.cli.conditions_table import all_hold

    given = _read(gains, settings or ())
    step2, step3 = _evaluate(given)
    own, missing = None, ""
    if given.law == "homogeneous":
        step2 = {}
        own, missing = _judged(given, must=check_holds)
    elif given.bounds.b2 != (1.0, 1.0):
        missing = _ONLY_B2_1.format(*given.bounds.b2)
    proved = [
        bool(own and own.holds) or (not missing and any(map(all_hold, step2.values()))),
        any(map(all_hold, step3.values())),
    ]
    if as_json:
        from parkproof.cli.console import write

        data = _data(given, step2, step3, own, missing)
        data = {"file": str(gains), **data}
        data["holds"] = {"step2": None if missing else proved[0], "step3": proved[1]}
        write(json.dumps(data, indent=2, ensure_ascii=False) + "\n")
    else:
        _print(given, step2, step3, own, missing)
    return 1 if check_holds and not all(proved) else 0


def _read(path: Path, settings: Sequence[str]) -> "GainsFile":
    """Gains from a scenario, a file of gains, or a specification."""
    from msgspec.structs import replace

    from parkproof.errors import InputError
    from parkproof.scenario_file import GainsFile, read_gains_file
    from parkproof.scenario_file.toml import load_toml
    from parkproof.spec import read_spec

    data = load_toml(path)
    if "start" in data or not {"starts", "limits", "design"} & set(data):
        return read_gains_file(path, overrides=settings)
    spec = read_spec(path, overrides=settings)
    if spec.gains is None:
        raise InputError(
            f"{path}: has no [gains] to check; write them, or find some with: parkproof design "
            f"{path}"
        )
    given = GainsFile(bounds=spec.bounds, gains=spec.gains, law=spec.law, title=spec.title)
    if spec.switching is not None:
        given = replace(given, switching=spec.switching)
    return given


def _judged(given: "GainsFile", *, must: bool) -> tuple["HomogeneousConditions | None", str]:
    """Step 2 of the homogeneous law, or the sentence why it cannot be judged here."""
    from parkproof.errors import InputError
    from parkproof.extras import require
    from parkproof.proof.homogeneous_conditions import homogeneous_conditions

    try:
        require("flint", extra="proof", purpose="judging Step 2 of the homogeneous law")
    except InputError as error:
        if must:
            raise
        return None, str(error)
    tolerance = given.switching.tolerance[0]
    return homogeneous_conditions(given.gains, given.bounds, tolerance=tolerance), ""


def _data(
    given: "GainsFile",
    step2: "Forms",
    step3: "Forms",
    own: "HomogeneousConditions | None",
    missing: str,
) -> dict[str, Any]:
    """All but whether the steps hold."""
    from parkproof.cli.conditions_table import as_data
    from parkproof.cli.homogeneous_table import homogeneous_data

    first: dict[str, Any] = {name: as_data(conditions) for name, conditions in step2.items()}
    weights: dict[str, Any] = {"k": given.weights.k} if step2 else {}
    return {
        "title": given.title,
        "law": given.law,
        "weights": {**weights, "k_step3": given.weights.k_step3},
        "step2": homogeneous_data(own) if own else first,
        "step3": {name: as_data(conditions) for name, conditions in step3.items()},
        "holds": {},
        "verdict": [_verdict2(step2, own, missing), _verdict("3", step3)],
    }


def _evaluate(given: "GainsFile") -> tuple["Forms", "Forms"]:
    """The conditions of Step 2 and of Step 3, each in both forms."""
    from parkproof.proof.conditions import check_conditions
    from parkproof.proof.gains import Form, Step2Gains, Step3Gains

    l1, l2, l3 = given.gains.l
    k1, k2 = given.weights.k
    k1_tilde, k3_tilde = given.gains.k
    step2 = Step2Gains(q1=float(given.gains.q1), l1=l1, l2=l2, l3=l3, k1=k1, k2=k2)
    step3 = Step3Gains(
        q2=float(given.gains.q2),
        k1_tilde=k1_tilde,
        k2_tilde=given.weights.k_step3,
        k3_tilde=k3_tilde,
    )
    return (
        {
            form.value: check_conditions(step2, alpha_max=given.bounds.alpha_of(1)[1], form=form)
            for form in (Form.PRINTED, Form.SHARP)
        },
        {
            form.value: check_conditions(step3, alpha_max=given.bounds.alpha_of(0)[1], form=form)
            for form in (Form.PRINTED, Form.UNTUNED)
        },
    )


def _verdict(step: str, forms: "Forms") -> str:
    """One sentence on the conditions of a step."""
    from parkproof.cli.conditions_table import all_hold

    holding = [_WORDS[name] for name, conditions in forms.items() if all_hold(conditions)]
    if holding:
        return f"Step {step}: satisfied {' and '.join(holding)}."
    failing = "; ".join(
        f"{', '.join(c.name for c in conditions if not c.holds)} {_WORDS[name]}"
        for name, conditions in forms.items()
    )
    return f"Step {step}: not satisfied; these fail: {failing}."


def _verdict2(step2: "Forms", own: "HomogeneousConditions | None", missing: str) -> str:
    """One sentence on Step 2, whatever the law."""
    from parkproof.cli.homogeneous_table import homogeneous_verdict

    if missing:
        return f"Step 2: not judged: {missing}."
    return homogeneous_verdict(own) if own else _verdict("2", step2)


def _print(
    given: "GainsFile",
    step2: "Forms",
    step3: "Forms",
    own: "HomogeneousConditions | None",
    missing: str,
) -> None:
    from parkproof.cli.conditions_table import ABBREVIATIONS
    from parkproof.cli.console import stdout_console

    console = stdout_console()
    gains, weights = given.gains, given.weights
    if given.title:
        console.print(given.title, style="bold")
    if step2:
        l1, l2, l3 = gains.l
        k1, k2 = weights.k
        law = f"q1 = {gains.q1}, l = ({l1:.5g}, {l2:.5g}, {l3:.5g}), "
        law += f"alpha2 <= {given.bounds.alpha_of(1)[1]:g}"
        proof = f"weights of the proof: k1 = {k1:.5g}, k2 = {k2:.5g}"
        _print_step(console, "Step 2", law, proof, step2)
    elif own:
        _print_homogeneous(console, own)
    law = f"q2 = {gains.q2}, k~1 = {gains.k[0]:.5g}, k~3 = {gains.k[1]:.5g}, "
    law += f"alpha1 <= {given.bounds.alpha_of(0)[1]:g}"
    proof = f"weight of the proof: k~2 = {weights.k_step3:.5g}"
    _print_step(console, "Step 3", law, proof, step3)
    console.print()
    console.print(_verdict2(step2, own, missing), style="bold")
    console.print(_verdict("3", step3), style="bold")
    console.print()
    first = _PROOF_ONLY if step2 else _OTHER_LAW
    for sentence in (first, _SUFFICIENT, _SCAN, ABBREVIATIONS):
        console.print(sentence)


def _print_step(console: "Console", step: str, law: str, proof: str, forms: "Forms") -> None:
    """The paper's conditions on one step."""
    from parkproof.cli.conditions_table import print_dominant, values_table
    from parkproof.cli.console import facts_table

    console.print()
    console.print(facts_table([(step, law), ("", proof)]))
    console.print(values_table(forms))
    print_dominant(console, forms)


def _print_homogeneous(console: "Console", own: "HomogeneousConditions") -> None:
    """The homogeneous law's conditions on Step 2."""
    from parkproof.cli.console import facts_table
    from parkproof.cli.homogeneous_table import homogeneous_facts, homogeneous_table

    console.print()
    console.print(facts_table([("Step 2", homogeneous_facts(own))]))
    console.print(homogeneous_table(own))
