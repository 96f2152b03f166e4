"""Conditions (15)-(19) as tables for people and as data for programs."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table

if TYPE_CHECKING:
    from rich.console import Console

    from parkproof.proof.conditions import Condition

ABBREVIATIONS = (
    "In the terms, q is q1 in Step 2 and q2 in Step 3; A = alpha_max, p = 2^(1-q), c = 1+q, "
    "m = l1^(1/q-1), L1 = l1^(1/q), L2 = l2^(1/(2q-1)), G = (3-2q) L2/(q c), K1 = k1t^(1/q), "
    "W = 2^q as printed and 1 in the sharp form; k1t, k2t, k3t are k~1, k~2, k~3."
)


def all_hold(conditions: Sequence["Condition"]) -> bool:
    """Say whether every condition holds.

    Parameters
    ----------
    conditions : sequence of Condition
        Of one form.

    Returns
    -------
    bool
        Whether each value is negative.

    Examples
    --------
    >>> all_hold([])
    True
    """
    return all(condition.holds for condition in conditions)


def values_table(forms: dict[str, tuple["Condition", ...]]) -> Table:
    """Lay out values and margins, the forms side by side.

    Parameters
    ----------
    forms : dict of str to conditions
        What each form is called, and its conditions.

    Returns
    -------
    rich.table.Table
        A row a condition.

    Examples
    --------
    >>> values_table({}).row_count
    0
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in forms:
        table.add_column(name, no_wrap=True)
        table.add_column("value", justify="right", no_wrap=True)
        table.add_column("margin", justify="right", no_wrap=True)
        table.add_column("< 0?", no_wrap=True)
    for conditions in zip(*forms.values(), strict=True):
        cells: list[str] = []
        for condition in conditions:
            cells += [
                condition.name,
                f"{condition.value:.4g}",
                f"{100.0 * condition.relative_margin:+.3g} %",
                "holds" if condition.holds else "fails",
            ]
        table.add_row(*cells)
    return table


def print_dominant(console: "Console", forms: dict[str, tuple["Condition", ...]]) -> None:
    """Print the largest positive term of each condition.

    Parameters
    ----------
    console : Console
        Where to print.
    forms : dict of str to conditions
        As for `values_table`.

    Examples
    --------
    >>> from rich.console import Console
    >>> print_dominant(Console(), {})
    """
    if not forms:
        return
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    table.add_column(justify="right", no_wrap=True)
    for form, conditions in forms.items():
        for condition in conditions:
            term = condition.dominant
            table.add_row(f"{condition.name} {form}", term.formula, f"{term.value:.4g}")
    console.print("Largest positive terms:")
    console.print(table)


def as_data(conditions: Sequence["Condition"]) -> list[dict[str, Any]]:
    """Give conditions as plain data.

    Parameters
    ----------
    conditions : sequence of Condition
        Any.

    Returns
    -------
    list of dict
        Name, meaning, formula, value, margins, whether it holds, and the terms.

    Examples
    --------
    >>> as_data([])
    []
    """
    return [
        {
            "name": condition.name,
            "meaning": condition.meaning,
            "formula": condition.formula,
            "value": condition.value,
            "margin": condition.margin,
            "relative_margin": condition.relative_margin,
            "holds": condition.holds,
            "dominant": condition.dominant.formula,
            "terms": {term.formula: term.value for term in condition.terms},
        }
        for condition in conditions
    ]
