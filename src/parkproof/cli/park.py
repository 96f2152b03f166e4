"""``parkproof park``: carry out one run."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def park(
    scenario: Path,
    /,
    *,
    out: Path | None = None,
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None,
    as_json: Annotated[bool, Parameter(name="--json")] = False,
    check: bool = False,
    overwrite: bool = False,
    no_pictures: bool = False,
    quiet: bool = False,
) -> int:
    """Carry out the run that a scenario file describes.

    Writes summary.json, trajectory.parquet, the resolved scenario.toml, Figures 3 to 8 as in the
    paper, pictures of the path and of the whole run, and an animation. The exit status is 0 when
    the run was carried out, however it ended.

    Parameters
    ----------
    scenario : Path
        The scenario file; "parkproof init" writes one.
    out : Path, optional
        Directory for the results; default runs/ and the scenario file's name.
    settings : list of str, optional
        Override a key of the file, as in run.duration=10 or gains.l[2]=25; may be repeated.
    as_json : bool
        Print the summary as JSON instead of a table.
    check : bool
        Exit with status 1 unless the robot parked.
    overwrite : bool
        Replace an earlier result in that directory.
    no_pictures : bool
        Write only the numbers: summary.json, trajectory.parquet and scenario.toml.
    quiet : bool
        Show neither progress nor the table.

    Returns
    -------
    int
        Exit status.

    Examples
    --------
    >>> park(Path("scenario.toml"), settings=["run.duration=10"], check=True, no_pictures=True)
    Section 4...parked...
    0
    """
    from parkproof.cli.console import print_files, progress, stdout_console, write
    from parkproof.cli.run_files import carry_out, draw
    from parkproof.output import output_directory
    from parkproof.scenario_file import read_scenario

    given = read_scenario(scenario, overrides=settings or ())
    directory = Path("runs") / scenario.stem if out is None else out
    with output_directory(directory, overwrite=overwrite) as work, progress(quiet=quiet) as report:
        run = carry_out(given, work, report)
        if not no_pictures:
            draw(run, work, report)
        names = sorted(path.name for path in work.iterdir())
        text = (work / "summary.json").read_text(encoding="utf-8")
    if as_json:
        write(text)
    elif not quiet:
        from parkproof.cli.run_table import print_run

        console = stdout_console()
        print_run(console, run)
        print_files(console, directory, names)
    return 1 if check and run.outcome.value != "parked" else 0
