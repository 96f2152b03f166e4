"""``parkproof campaign``: many trials, drawn from distributions."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def campaign(
    file: Path,
    /,
    *,
    out: Path | None = None,
    trials: int | None = None,
    threads: int | None = None,
    scheduler: str | None = None,
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None,
    certificate: Path | None = None,
    no_report: bool = False,
    quiet: bool = False,
) -> int:
    """Carry out many trials, drawn from distributions, and keep a row of each.

    Writes the row of every trial to trials/*.parquet of the directory as it goes, and in the end
    report.html. Stopped or killed at any moment, the same command goes on where it was. The rows
    do not depend on the number of threads or workers, or on interruptions.

    Parameters
    ----------
    file : Path
        The campaign file; "parkproof init --kind campaign" writes one.
    out : Path, optional
        Directory for the results; default campaigns/ and the file's name.
    trials : int, optional
        Other number of trials than the file's; later also a larger one.
    threads : int, optional
        How many trials are worked on side by side; default one a processor.
    scheduler : str, optional
        Address of a scheduler of dask.distributed, such as tcp://10.0.0.1:8786, whose workers do
        the work instead.
    settings : list of str, optional
        Override a key of the file, as in run.duration=10 or seed=7; may be repeated.
    certificate : Path, optional
        A certificate with which the report compares the trials.
    no_report : bool
        Write no report.
    quiet : bool
        Show neither progress nor the table.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        If the file is no campaign, or the directory or the scheduler cannot be used.
    StoppedError
        If it was stopped; what has been written stays.

    Examples
    --------
    >>> campaign(Path("campaign.toml"), trials=0)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: campaign.toml with --set trials=0: trials = 0: a campaign needs ...
    """
    from parkproof.campaign.definition import read_campaign
    from parkproof.campaign.run import run_campaign
    from parkproof.cli.console import counted, progress
    from parkproof.errors import InputError, StoppedError
    from parkproof.extras import require
    from parkproof.scenario_file.read import named_with

    given = [*(settings or ()), *([f"trials={trials}"] if trials is not None else [])]
    asked = read_campaign(file, overrides=given)
    _check_threads(threads, scheduler)
    if certificate is not None and not certificate.is_file():
        raise InputError(
            f"{certificate}: no such file; name a certificate.json that parkproof certify or "
            "parkproof design wrote"
        )
    if certificate is not None:
        from parkproof.report.campaign import check_comparable

        check_comparable(asked, certificate)
    require("scipy", extra="campaign", purpose="parkproof campaign")
    directory = Path("campaigns") / file.stem if out is None else out
    reached = "no trial has been done yet"
    with counted("trials", quiet=quiet) as count:

        def tell(done: int, of: int) -> None:
            nonlocal reached
            reached = f"the rows of {done:,} of {of:,} trials are in {directory}"
            count(done, of)

        try:
            run_campaign(
                asked,
                directory,
                where=named_with(file, given),
                threads=threads or processors(),
                scheduler=scheduler,
                progress=tell,
            )
        except KeyboardInterrupt as error:
            raise StoppedError(f"{reached}; the same command goes on from there") from error
    if not no_report:
        from parkproof.report.campaign import write_report

        with progress(quiet=quiet) as report:
            write_report(
                directory,
                certificate=certificate,
                threads=threads or processors(),
                progress=report,
            )
    if not quiet:
        _print(directory, asked.trials)
    return 0


def _check_threads(threads: int | None, scheduler: str | None) -> None:
    """Check the number of threads before anything is done."""
    from parkproof.errors import InputError

    if threads is None:
        return
    if scheduler is not None:
        raise InputError(
            f"--threads {threads} with --scheduler: the workers of the scheduler have threads of "
            "their own; leave --threads out"
        )
    if not 1 <= threads <= MOST_THREADS:
        raise InputError(
            f"--threads {threads}: must be from 1 to {MOST_THREADS}; leave it out for one a "
            "processor"
        )


MOST_THREADS = 1024


def processors() -> int:
    """Processors that this process may use.

    Returns
    -------
    int
        At least 1.

    Examples
    --------
    >>> processors() >= 1
    True
    """
    import os

    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _print(directory: Path, trials: int) -> None:
    """How the trials ended, for a reader."""
    from parkproof.campaign.table import outcomes_of
    from parkproof.cli.console import facts_table, print_files, stdout_console

    counts = outcomes_of(directory)
    total = sum(counts.values())
    facts = [("Trials", f"{total:,} of {trials:,}")]
    facts += [
        (outcome.capitalize(), f"{count:,} ({100.0 * count / total:.6g} %)")
        for outcome, count in sorted(counts.items(), key=lambda pair: (-pair[1], pair[0]))
    ]
    console = stdout_console()
    console.print(facts_table(facts))
    console.print()
    names = ["campaign.json", "report.html", "trials/*.parquet"]
    print_files(console, directory, [name for name in names if any(directory.glob(name))])
