"""``parkproof init``: a file to start from."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def init(
    *,
    kind: str = "paper",
    out: Path | None = None,
    overwrite: bool = False,
    list_kinds: Annotated[bool, Parameter(name="--list")] = False,
) -> int:
    """Write a commented scenario, campaign or other file that runs as it is.

    Parameters
    ----------
    kind : str
        Kind of file, default paper; --list names them all.
    out : Path, optional
        File to write; default standard output.
    overwrite : bool
        Replace the file if there is one.
    list_kinds : bool
        List the kinds instead.

    Returns
    -------
    int
        Exit status.

    Examples
    --------
    >>> init(kind="adversary")  # doctest: +ELLIPSIS
    # ...
    0
    """
    from parkproof.cli.console import facts_table, stdout_console, write
    from parkproof.scenario_file import SPECIFICATIONS, TEMPLATES, template

    if list_kinds:
        stdout_console().print(facts_table(list((TEMPLATES | SPECIFICATIONS).items())))
        return 0
    text = template(kind)
    if out is None:
        write(text)
        return 0
    from parkproof.cli.files import write_file

    write_file(out, text, overwrite=overwrite)
    commands = {
        "design": "design",
        "campaign": "campaign",
        "world": "lab --world",
        "robot": "camera --latency --robot",
    }
    command = commands.get(kind, "park")
    stdout_console().print(f"Wrote {out}; run it with: parkproof {command} {out}", soft_wrap=True)
    return 0
