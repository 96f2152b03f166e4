"""``parkproof replay``: carry out again a trial of a campaign, or a recorded run of the lab."""

from pathlib import Path


def replay(
    path: Path,
    trial: int | None = None,
    /,
    *,
    out: Path | None = None,
    overwrite: bool = False,
    no_pictures: bool = False,
    quiet: bool = False,
) -> int:
    """Carry out one trial of a campaign, or a recorded run of the laboratory, again.

    Of a campaign: the trial is run alone by the plain reference, drawn, and written as a scenario
    for "parkproof park". The exit status is 0 if it ends as in the campaign, and 1 if not.

    Of a recording: estimator, law and safety are run on the recorded pictures and times. The exit
    status is 0 if every command is the same as the one that was sent, and 1 if one differs or
    cannot be compared.

    Parameters
    ----------
    path : Path
        The directory of a campaign, or the run.mcap of a run of the laboratory, or its directory.
    trial : int, optional
        Number of the trial; for a campaign only.
    out : Path, optional
        Directory for the trial's results; default runs/, the campaign's name and the number.
    overwrite : bool
        Replace an earlier result there.
    no_pictures : bool
        Write only the trial's numbers and scenario.
    quiet : bool
        Print nothing.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        If there is no such campaign, trial or recording.
    """
    from parkproof.campaign.replay import is_campaign
    from parkproof.errors import InputError

    if is_campaign(path):
        if trial is None:
            raise InputError(
                f"{path} is a campaign: say which trial, for example parkproof replay {path} 0"
            )
        name = f"{path.resolve().name}-{trial}"
        directory = Path("runs") / name if out is None else out
        return _trial(path, trial, directory, overwrite, no_pictures, quiet)
    if trial is not None and (path.is_dir() or not path.exists()):
        raise InputError(
            f"{path}: is no directory of a campaign (it has no campaign.json); give the --out of "
            "parkproof campaign"
        )
    if trial is not None or out is not None or overwrite or no_pictures:
        raise InputError(
            f"{path} is no campaign: a trial, --out, --overwrite and --no-pictures go with the "
            "directory of one; leave them out to replay a recording"
        )
    return _recording(path, quiet)


def _trial(
    path: Path, number: int, directory: Path, overwrite: bool, no_pictures: bool, quiet: bool
) -> int:
    """Run a trial again, and write what is to be known of it."""
    from parkproof.campaign.replay import trial_of
    from parkproof.cli.console import print_files, progress, stdout_console
    from parkproof.cli.run_files import carry_out, draw
    from parkproof.cli.run_table import print_run
    from parkproof.output import output_directory

    found = trial_of(path, number)
    with output_directory(directory, overwrite=overwrite) as work, progress(quiet=quiet) as report:
        run = carry_out(found.scenario, work, report)
        if not no_pictures:
            draw(run, work, report)
        names = sorted(file.name for file in work.iterdir())
    if not quiet:
        console = stdout_console()
        print_run(console, run)
        console.print(found.compared(run), soft_wrap=True)
        console.print()
        print_files(console, directory, names)
    return 0 if found.same(run) else 1


def _recording(path: Path, quiet: bool) -> int:
    """Run a recording again, and compare the commands."""
    from parkproof.cli.console import progress, stdout_console
    from parkproof.lab.replay import replayed

    file = path / "run.mcap" if path.is_dir() else path
    with progress(quiet=quiet) as report:
        report("replaying", 0.0)
        found = replayed(file)
    if not quiet:
        stdout_console().print(found.sentence, soft_wrap=True)
    return 0 if found.same else 1
