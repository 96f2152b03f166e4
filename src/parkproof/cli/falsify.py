"""``parkproof falsify``: search for the run that breaks a claim."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def falsify(
    file: Path,
    /,
    *,
    out: Path = Path("falsified.toml"),
    runs: int | None = None,
    seconds: float | None = None,
    objective: list[str] | None = None,
    box: str = "",
    seed: int = 0,
    threads: int | None = None,
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None,
    overwrite: bool = False,
    quiet: bool = False,
    as_json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """Search for the run that breaks a claim, or comes nearest to a bound.

    Varied are start, truth and disturbance. The claim of a scenario is that it parks
    within its duration and keeps to its limits, whatever the truth within its bounds; those of a
    certificate are all numbers of its theorem. The worst is written as a
    scenario. The exit status is 1 if a claim is broken. Ctrl-C keeps the worst so far.

    Parameters
    ----------
    file : Path
        A scenario, or a certificate (.json).
    out : Path
        Where to write the worst run as a scenario; default falsified.toml.
    runs : int, optional
        About how many runs; default 8192, or as many as --seconds allows.
    seconds : float, optional
        About how long, in s; then the result depends on the machine.
    objective : list of str, optional
        Search for this number only; may be repeated. Default all that have a bound.
    box : str
        Of a scenario: by how much the numbers of its start may differ, as in 0.5,0.2,0.1; default
        not at all.
    seed : int
        The same seed gives the same search; default 0.
    threads : int, optional
        Default one a processor; the result does not depend on it.
    settings : list of str, optional
        Override a key of the scenario, or of [run] for a certificate, as in
        run.control_period=0.001; may be repeated.
    overwrite : bool
        Replace the file written if there is one.
    quiet : bool
        Show neither progress nor the table.
    as_json : bool
        Print what was found as JSON instead of the table.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        If the file is neither, an option does not fit it, or a library is missing.

    Examples
    --------
    >>> falsify(Path("scenario.toml"), runs=0)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: --runs 0: must be from 1 to ...
    """
    from parkproof.cli.campaign import processors
    from parkproof.cli.console import progress, stdout_console, write
    from parkproof.cli.falsify_table import nearest, print_falsification, print_replay, record_of
    from parkproof.cli.files import check_target, write_file
    from parkproof.extras import require

    require("scipy", extra="campaign", purpose="parkproof falsify")
    from parkproof.falsification.claims import chosen
    from parkproof.falsification.confirm import Exceeded, finer, replayed
    from parkproof.falsification.read import target_of
    from parkproof.falsification.search import falsify as search
    from parkproof.scenario_file import to_toml

    most, longest = _budget(runs, seconds)
    _check_numbers(seed, threads)
    target = target_of(file, overrides=settings or (), box=_widths(box))
    objectives = chosen(target.claims, objective or ())
    check_target(out, overwrite=overwrite)
    with progress(quiet=quiet) as report:
        found = search(
            target.space,
            target.claims,
            objectives=objectives,
            runs=most,
            seconds=longest,
            seed=seed,
            threads=threads or processors(),
            progress=report,
        )
        broken = [Exceeded(worst=one) for one in found.worst if one.broken]
        interrupted = found.interrupted
        if target.proved and not interrupted:
            report("sampling more finely", 1.0)
            try:
                sizes = finer([one.worst for one in broken])
                broken = [replace(one, finer=size) for one, size in zip(broken, sizes, strict=True)]
            except KeyboardInterrupt:
                interrupted = True
        alarms = [one.worst for one in broken if one.holds_up]
        searched = [one for one in found.worst if one.claim in objectives]
        worst = nearest(alarms or [one.worst for one in broken] or searched)
        write_file(out, to_toml(worst.scenario), overwrite=overwrite)
        replay = None
        if not interrupted:
            report("running the worst again", 1.0)
            try:
                replay = replayed(worst)
            except KeyboardInterrupt:
                interrupted = True
    if as_json:
        record = {
            "file": str(file),
            "seed": seed,
            "interrupted": interrupted,
            **record_of(found, target, broken, worst, replay, out),
        }
        write(json.dumps(record, indent=2, ensure_ascii=False) + "\n")
    elif not quiet:
        console = stdout_console()
        print_falsification(console, found, target, broken)
        print_replay(console, worst, replay, out)
    if interrupted:
        return 130
    return 1 if alarms else 0


MOST_RUNS, MOST_THREADS, USUAL_RUNS = 10**9, 1024, 8192


def _check_numbers(seed: int, threads: int | None) -> None:
    """Raise if a seed or a number of threads is none."""
    from parkproof.errors import InputError

    if seed < 0:
        raise InputError(f"--seed {seed}: must be a whole number >= 0; write 0")
    if threads is not None and not 1 <= threads <= MOST_THREADS:
        raise InputError(f"--threads {threads}: must be from 1 to {MOST_THREADS}; leave it out")


def _budget(runs: int | None, seconds: float | None) -> tuple[int, float]:
    """How many runs and how many seconds at most."""
    from parkproof.errors import InputError

    if runs is not None and not 1 <= runs <= MOST_RUNS:
        raise InputError(f"--runs {runs}: must be from 1 to {MOST_RUNS:,}; write for example 8192")
    if seconds is not None and not 0.0 < seconds < math.inf:
        raise InputError(f"--seconds {seconds:g}: must be a positive number; write for example 60")
    usual = USUAL_RUNS if seconds is None else MOST_RUNS
    return runs or usual, seconds or math.inf


def _widths(box: str) -> tuple[float, ...]:
    """By how much each number of the start may differ."""
    from parkproof.errors import InputError
    from parkproof.validate import not_negative

    if not box.strip():
        return ()
    parts = box.strip().removeprefix("[").removesuffix("]").split(",")
    if len(parts) > NUMBERS:
        raise InputError(f"--box {box}: has {len(parts)} numbers; a start has {NUMBERS}")
    try:
        return tuple(not_negative("--box", float(part)) for part in parts)
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"--box {box}: must be numbers, one for each of the start; write for example "
            "--box 0.5,0.2,0.1"
        ) from error


NUMBERS = 5
"""Numbers of a start: x0, x1, x2, u0, u1, or x, y, theta, v, omega."""
