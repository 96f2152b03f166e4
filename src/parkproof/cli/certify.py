"""``parkproof certify``: a certificate of Step 2."""

import json
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def certify(
    gains: Path,
    /,
    *,
    out: Path = Path("certificate.json"),
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None,
    start: tuple[float, float, float] = (1.0, 0.0, 0.0),
    gain_range: tuple[float, float] | None = None,
    varying: bool = False,
    overwrite: bool = False,
    quiet: bool = False,
) -> int:
    """Prove that Step 2 settles in a given time, and write the proof as a certificate.

    Proves, in ball arithmetic, that Step 2 with the gains of a file brings (x1, x2, u1) to zero
    within a time, for every camera, motor gain and disturbance within the bounds. Covers Step 2
    alone, in continuous time. Exit status 1 if no such claim could be proved.

    Parameters
    ----------
    gains : Path
        A scenario file, or a file with [bounds] and [gains].
    out : Path
        The certificate; default certificate.json.
    settings : list of str, optional
        Override a key of the file, as in gains.l[2]=30; may be repeated.
    start : three floats
        Step 2 may start with |x1|, |x2|, |u1| up to these; default 1 0 0.
    gain_range : two floats, optional
        Range of b1 = alpha2 |u0|; default that of alpha2 times runup_speed.
    varying : bool
        Let b1 vary in time, as under a tilted camera or while u0 changes; else it is constant.
    overwrite : bool
        Replace the certificate if there is one.
    quiet : bool
        Show no progress.

    Returns
    -------
    int
        Exit status.

    Examples
    --------
    >>> certify(Path("gains.toml"), quiet=True)
    Consider x1' = b1 x2...
    0
    """
    from parkproof.cli.console import progress, stdout_console
    from parkproof.cli.files import write_file
    from parkproof.extras import require
    from parkproof.scenario_file import read_gains_file
    from parkproof.validate import not_negative

    require("flint", "scipy", extra="proof", purpose="parkproof certify")
    from parkproof.proof.certify import certify_step2
    from parkproof.proof.verify import statement_of

    given = read_gains_file(gains, overrides=settings or ())
    speed = given.gains.runup_speed
    low, high = given.bounds.alpha_of(1)
    sizes = [not_negative("start", size) for size in start]
    with progress(quiet=quiet) as report:
        found = certify_step2(
            given.gains,
            b1=gain_range or (speed * low, speed * high),
            varies=varying,
            start=[(0.0 - size, size) for size in sizes],
            progress=lambda text: report(text, 0.0),
        )
    console = stdout_console()
    if found is None:
        console.print(
            "Not proved: no weights were found with which V decreases for all of these gains. A "
            "narrower range of b1, larger l2 and l3, or a q1 nearer to 1 would help.",
        )
        return 1
    write_file(out, json.dumps(found.certificate, indent=1) + "\n", overwrite=overwrite)
    for line in statement_of(found.certificate):
        console.print(line, soft_wrap=True)
    console.print()
    console.print(
        f"Proved in {found.boxes:,} boxes. Wrote {out}; re-prove it with: parkproof verify {out}",
        soft_wrap=True,
    )
    return 0
