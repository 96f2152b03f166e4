"""``parkproof design``: gains with a certificate."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import Console

    from parkproof.cli.console import Report
    from parkproof.proof.design import Design
    from parkproof.spec import Spec


def design(
    spec: Path,
    /,
    *,
    out: Path | None = None,
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None,
    effort: float = 1.0,
    overwrite: bool = False,
    no_pictures: bool = False,
    quiet: bool = False,
) -> int:
    """Find gains for given limits, with a proof that runs under them park.

    Writes gains.toml, certificate.json, summary.json, a scenario that uses the gains, and
    pictures: the trade-offs, and the settling time over starts. Exit status 1, with the limit that
    binds and the nearest value that would do, if no gains were found. Ctrl-C ends the search and
    certifies the best found so far.

    Parameters
    ----------
    spec : Path
        The specification; "parkproof init --kind design" writes a commented one.
    out : Path, optional
        Directory for the results; default designs/NAME, after the file's name.
    settings : list of str, optional
        Override a key of the file, as in limits.tau=[20,20]; may be repeated.
    effort : float
        How many candidates are looked at, as a multiple of the usual number.
    overwrite : bool
        Replace earlier results there.
    no_pictures : bool
        Draw nothing.
    quiet : bool
        Show no progress.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        If the file is no specification, or a library is missing.

    Examples
    --------
    >>> design(Path("gains.toml"), settings=["limits.tau=[1, 1]", "bounds.disturbance=2.5"])
    Nothing is proved: limits.tau[0] = 1: ...
    1
    """
    from parkproof.cli.console import print_files, progress, stdout_console
    from parkproof.errors import InputError
    from parkproof.extras import require
    from parkproof.output import output_directory
    from parkproof.validate import positive

    require("flint", "scipy", "clarabel", extra="proof", purpose="parkproof design")
    scale = positive("effort", effort)
    if scale > LARGEST_EFFORT:
        raise InputError(f"effort = {scale:g}: must be at most {LARGEST_EFFORT:g}; write 10.0")
    directory = Path("designs") / spec.stem if out is None else out
    console = stdout_console()
    try:
        wanted = _wanted(spec, settings or ())
        with (
            output_directory(directory, overwrite=overwrite) as work,
            progress(quiet=quiet) as report,
        ):
            found = _search(wanted, scale, work, report, pictures=not no_pictures)
            names = sorted(path.name for path in work.iterdir())
    except _NotFoundError as error:
        begin = "Interrupted: n" if error.interrupted else "N"
        console.print(f"{begin}othing is proved: {error}.", soft_wrap=True)
        return 130 if error.interrupted else 1
    _print(found, console)
    print_files(console, directory, names)
    return 130 if found.interrupted else 0


LARGEST_EFFORT = 1e3
"""A design of the usual effort takes minutes."""


class _NotFoundError(Exception):
    """There are no gains, or none were found; what was begun of the results is taken away."""

    def __init__(self, reason: str, *, interrupted: bool = False) -> None:
        super().__init__(reason)
        self.interrupted = interrupted


def _wanted(spec: Path, settings: "Sequence[str]") -> "Spec":
    """The specification; one that no gains can meet is no bad input, but has no design."""
    from parkproof.errors import InputError
    from parkproof.proof.limits import check_feasible
    from parkproof.spec import read_spec

    try:
        wanted = read_spec(spec, overrides=settings)
    except InputError as error:
        # bounds that nothing can lie in, but not keys that are misspelt or of a wrong type
        said = str(error)
        if "[bounds]" in said and "unknown key" not in said and "expected" not in said:
            raise _NotFoundError(str(error)) from error
        raise
    try:
        check_feasible(wanted)
    except InputError as error:
        raise _NotFoundError(str(error)) from error
    return wanted


def _search(
    wanted: "Spec", scale: float, work: Path, report: "Report", *, pictures: bool
) -> "Design":
    """Find, write and draw."""
    from parkproof.errors import InputError
    from parkproof.proof.design import design as search
    from parkproof.report.design import write_design

    sweep, steps = (max(2, round(usual * scale)) for usual in (16, 40))
    try:
        found = search(wanted, sweep=sweep, steps=steps, progress=report)
    except InputError as error:  # no Lyapunov function for so wide a range
        raise _NotFoundError(str(error)) from error
    if found.certificate is None:
        raise _NotFoundError(found.reason, interrupted=found.interrupted)
    write_design(found, work, pictures=pictures, progress=report)
    return found


def _print(found: "Design", console: "Console") -> None:
    """What was found, for a reader."""
    from parkproof.cli.console import facts_table
    from parkproof.report.design import facts_of

    if found.interrupted:
        console.print("Interrupted: this is the best that was found until then.\n")
    console.print(facts_table(facts_of(found)))
