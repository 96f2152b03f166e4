"""``parkproof replay``: carry a recorded run of the laboratory out again."""

from pathlib import Path


def replay(recording: Path, /, *, quiet: bool = False) -> int:
    """Carry out a recorded run of the laboratory again, and compare the commands.

    Estimator, law and safety are run on the recorded pictures and times. The exit status is 0 if
    every command is the same as the one that was sent, and 1 if one differs or cannot be compared.

    Parameters
    ----------
    recording : Path
        The run.mcap of a run, or its directory.
    quiet : bool
        Print nothing.

    Returns
    -------
    int
        Exit status.
    """
    from parkproof.cli.console import progress, stdout_console
    from parkproof.lab.replay import replayed

    path = recording / "run.mcap" if recording.is_dir() else recording
    with progress(quiet=quiet) as report:
        report("replaying", 0.0)
        found = replayed(path)
    if not quiet:
        stdout_console().print(found.sentence, soft_wrap=True)
    return 0 if found.same else 1
