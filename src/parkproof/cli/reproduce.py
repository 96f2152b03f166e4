"""``parkproof reproduce``: Section 4 of the paper, made anew."""

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from rich.console import Console

_STYLES = {"holds": "green", "fails": "red", "cannot be decided": "yellow"}


def reproduce(
    *,
    out: Path = Path("reproduction"),
    law: Literal["published", "corrected", "both"] = "both",
    overwrite: bool = False,
    quiet: bool = False,
) -> int:
    """Make Section 4 of the paper anew: its figures, and what its claims come to.

    Writes Figures 3 to 8, the trajectories and summaries of every law into a directory, and a page,
    index.html, with the figures side by side and the table of claims.

    Parameters
    ----------
    out : Path
        Directory for the results; default reproduction.
    law : "published", "corrected" or "both"
        The law as printed, the law that works, or (default) both.
    overwrite : bool
        Replace an earlier result in that directory.
    quiet : bool
        Show neither progress nor the table.

    Returns
    -------
    int
        Exit status.

    Examples
    --------
    >>> reproduce(out=Path(), law="both", overwrite=True)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...
    """
    from parkproof.cli.console import progress, stdout_console
    from parkproof.output import output_directory
    from parkproof.report.reproduce import reproduce as make_anew

    laws = ("published", "corrected") if law == "both" else (law,)
    with output_directory(out, overwrite=overwrite) as work, progress(quiet=quiet) as report:
        result = make_anew(work, laws=laws, progress=report)
    if not quiet:
        console = stdout_console()
        _print_claims(console, result["claims"])
        console.print(f"The page: {out / 'index.html'}", soft_wrap=True, style="bold")
    return 0


def _print_claims(console: "Console", claims: list[dict[str, str]]) -> None:
    """Print each claim with where the paper makes it, what was measured, and the verdict."""
    from rich.table import Column, Table
    from rich.text import Text

    table = Table.grid(Column(width=9), Column(overflow="fold"), padding=(0, 2, 0, 0))
    for claim in claims:
        text = Text(claim["claim"], style="bold")
        text.append(f" [{claim['where']}]", style="not bold dim")
        text.append(f"\n{claim['measured']}", style="not bold")
        table.add_row(Text(claim["verdict"], style=_STYLES.get(claim["verdict"], "")), text)
        table.add_row()
    console.print(table)
    counts = Counter(claim["verdict"] for claim in claims)
    listed = ", ".join(f"{verdict}: {count}" for verdict, count in counts.most_common())
    console.print(f"Of {len(claims)} rows: {listed}.")
