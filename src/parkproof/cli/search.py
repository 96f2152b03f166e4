"""``parkproof search``: gains that satisfy the paper's conditions."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

if TYPE_CHECKING:
    from parkproof.proof.remark3 import Remark3Result
    from parkproof.proof.search import Step2Found, Step3Found
    from parkproof.validate import Ratio


def search(
    *,
    q1: str = "9/11",
    q2: str = "7/9",
    alpha_max: float = 1.5,
    slack: float = 0.6,
    initial_l: float = 4.5,
    k1_tilde: float = 1.5,
    margin: float = 0.01,
    form: Literal["printed", "sharp"] = "printed",
    out: Path | None = None,
    overwrite: bool = False,
    as_json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """Search for gains: Remark 3 as printed, a search that works, and Remark 4.

    Parameters
    ----------
    q1 : str
        Exponent of Step 2, in (2/3, 1); default 9/11.
    q2 : str
        Exponent of Step 3, in (1/2, 1); default 7/9.
    alpha_max : float
        Upper bound of the image scales; default 1.5.
    slack : float
        All six slacks of Remark 3; default 0.6.
    initial_l : float
        The l that Remark 3 begins with; default 4.5.
    k1_tilde : float
        The gain k~1 that Remark 4 begins with; default 1.5.
    margin : float
        What every condition keeps: by this fraction its positive terms could grow; default 0.01.
    form : "printed" or "sharp"
        Form of (15)-(17) for the search that works; default printed.
    out : Path, optional
        Write the gains to a file that "parkproof check" accepts.
    overwrite : bool
        Replace that file if there is one.
    as_json : bool
        Print everything as JSON instead of tables.

    Returns
    -------
    int
        Exit status.

    Examples
    --------
    >>> search(q1="13/15", form="sharp")
    Remark 3 as printed...does not terminate...
    0
    """
    from parkproof.laws.gains import exponent
    from parkproof.proof.remark3 import remark3_search
    from parkproof.proof.search import remark4_search, sequential_search

    step2 = exponent("q1", q1, 2.0 / 3.0, "2/3")
    step3 = exponent("q2", q2, 0.5, "1/2")
    remark3 = remark3_search(step2, alpha_max=alpha_max, slack=slack, initial_l=initial_l)
    found2 = sequential_search(step2, alpha_max=alpha_max, margin=margin, form=form)
    found3 = remark4_search(step3, k1_tilde, alpha_max=alpha_max, margin=margin)
    if out is not None:
        from parkproof.cli.files import write_file

        text = _gains_file(found2, found3, q1=step2, q2=step3, alpha_max=alpha_max)
        write_file(out, text, overwrite=overwrite)
    if as_json:
        from parkproof.cli.console import write

        data = _as_data(remark3, found2, found3)
        write(json.dumps(data, indent=2, ensure_ascii=False) + "\n")
    else:
        _print(remark3, found2, found3, alpha_max=alpha_max, slack=slack, q2=step3)
        if out is not None:
            from parkproof.cli.console import stdout_console

            console = stdout_console()
            console.print()
            console.print(f"Wrote {out}; check it with: parkproof check {out}", soft_wrap=True)
    return 0


def _gains_file(
    found2: "Step2Found", found3: "Step3Found", *, q1: "Ratio", q2: "Ratio", alpha_max: float
) -> str:
    """The gains as TOML, every number to its last digit."""
    two, three = found2.gains, found3.gains
    return f"""\
# Gains that satisfy (15)-(17) in the {found2.conditions[0].form} form, and (18)(19).
[bounds]
# The conditions use the upper bound alone; write your camera's lower bound here.
alpha = [{min(0.5, alpha_max)!r}, {alpha_max!r}]

[gains]
q1 = "{q1}"
q2 = "{q2}"
l = [{two.l1!r}, {two.l2!r}, {two.l3!r}]
k = [{three.k1_tilde!r}, {three.k3_tilde!r}]

# Weights of the proof; the law does not use them.
[weights]
k = [{two.k1!r}, {two.k2!r}]
k_step3 = {three.k2_tilde!r}
"""


def _as_data(
    remark3: "Remark3Result", found2: "Step2Found", found3: "Step3Found"
) -> dict[str, Any]:
    from parkproof.cli.conditions_table import as_data

    return {
        "remark3": {
            "outcome": remark3.outcome.value,
            "reason": remark3.reason,
            "passes": [asdict(one) for one in remark3.passes],
            "growth_exponent": remark3.growth_exponent,
            "workable_l": remark3.workable_l,
            "some_slacks_work": remark3.some_slacks_work,
            "gains": asdict(remark3.found.gains) if remark3.found is not None else None,
        },
        "sequential": {
            "form": found2.conditions[0].form.value,
            "gains": asdict(found2.gains),
            "conditions": as_data(found2.conditions),
        },
        "remark4": {
            "form": found3.conditions[0].form.value,
            "gains": asdict(found3.gains),
            "conditions": as_data(found3.conditions),
        },
    }


def _print(
    remark3: "Remark3Result",
    found2: "Step2Found",
    found3: "Step3Found",
    *,
    alpha_max: float,
    slack: float,
    q2: "Ratio",
) -> None:
    from rich import box
    from rich.table import Table

    from parkproof.cli.conditions_table import values_table
    from parkproof.cli.console import stdout_console

    console = stdout_console()
    heading = f"Remark 3 as printed (alpha_max = {alpha_max:g}, slacks {slack:g})"
    console.print(f"{heading}: {remark3.outcome.value}", style="bold")
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("pass", "l", "k1", "k2", "l1_bar", "l2_bar"):
        table.add_column(name, justify="right", no_wrap=True)
    for number, one in enumerate(remark3.passes, start=1):
        values = (one.l, one.k1, one.k2, one.l1_bar, one.l2_bar)
        table.add_row(str(number), *(f"{value:.4g}" for value in values))
    console.print(table)
    console.print(f"Why: {remark3.reason}.")
    console.print()

    two, form = found2.gains, found2.conditions[0].form
    console.print(f"Search one by one, l1, k1, l2, k2, l3, {form} form: feasible", style="bold")
    console.print(
        f"l = ({two.l1:.4g}, {two.l2:.4g}, {two.l3:.4g}), weights of the proof "
        f"k = ({two.k1:.4g}, {two.k2:.4g}); the smallest l3 that the conditions allow"
    )
    console.print(values_table({str(form): found2.conditions}))

    three = found3.gains
    console.print(f"Remark 4 (q2 = {q2}): feasible", style="bold")
    console.print(
        f"k~1 = {three.k1_tilde:.4g} (given), k~3 = {three.k3_tilde:.4g}, weight of the proof "
        f"k~2 = {three.k2_tilde:.4g}"
    )
    console.print(values_table({str(found3.conditions[0].form): found3.conditions}))
