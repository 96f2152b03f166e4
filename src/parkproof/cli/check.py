"""``parkproof check``: the paper's conditions on the gains."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

if TYPE_CHECKING:
    from parkproof.proof.conditions import Condition
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
    form, (18)(19) as printed and as (18')(19'). Each form is sufficient by itself. The exit status
    is 0 whether they hold or not.

    Parameters
    ----------
    gains : Path
        A scenario file, or a file with [bounds], [gains] and [weights].
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

    Examples
    --------
    >>> check(Path("gains.toml"), check_holds=True)
    Section 4...
    1
    """
    from parkproof.cli.conditions_table import all_hold, as_data
    from parkproof.scenario_file import read_gains_file

    given = read_gains_file(gains, overrides=settings or ())
    step2, step3 = _evaluate(given)
    proved = [any(map(all_hold, forms.values())) for forms in (step2, step3)]
    if as_json:
        from parkproof.cli.console import write

        data: dict[str, Any] = {
            "file": str(gains),
            "title": given.title,
            "law": given.law,
            "weights": {"k": given.weights.k, "k_step3": given.weights.k_step3},
            "step2": {name: as_data(conditions) for name, conditions in step2.items()},
            "step3": {name: as_data(conditions) for name, conditions in step3.items()},
            "holds": {"step2": proved[0], "step3": proved[1]},
            "verdict": [_verdict("2", step2), _verdict("3", step3)],
        }
        write(json.dumps(data, indent=2, ensure_ascii=False) + "\n")
    else:
        _print(given, step2, step3)
    return 1 if check_holds and not all(proved) else 0


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


def _print(given: "GainsFile", step2: "Forms", step3: "Forms") -> None:
    from parkproof.cli.conditions_table import ABBREVIATIONS, print_dominant, values_table
    from parkproof.cli.console import facts_table, stdout_console

    console = stdout_console()
    gains, weights = given.gains, given.weights
    if given.title:
        console.print(given.title, style="bold")
    l1, l2, l3 = gains.l
    k1, k2 = weights.k
    for step, law, proof, forms in (
        (
            "Step 2",
            f"q1 = {gains.q1}, l = ({l1:.5g}, {l2:.5g}, {l3:.5g}), "
            f"alpha2 <= {given.bounds.alpha_of(1)[1]:g}",
            f"weights of the proof: k1 = {k1:.5g}, k2 = {k2:.5g}",
            step2,
        ),
        (
            "Step 3",
            f"q2 = {gains.q2}, k~1 = {gains.k[0]:.5g}, k~3 = {gains.k[1]:.5g}, "
            f"alpha1 <= {given.bounds.alpha_of(0)[1]:g}",
            f"weight of the proof: k~2 = {weights.k_step3:.5g}",
            step3,
        ),
    ):
        console.print()
        console.print(facts_table([(step, law), ("", proof)]))
        console.print(values_table(forms))
        print_dominant(console, forms)
    console.print()
    console.print(_verdict("2", step2), style="bold")
    console.print(_verdict("3", step3), style="bold")
    console.print()
    for sentence in (_PROOF_ONLY, _SUFFICIENT, _SCAN, ABBREVIATIONS):
        console.print(sentence)
