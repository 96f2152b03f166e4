"""``parkproof certify``: a certificate of whole runs."""

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
    overwrite: bool = False,
    quiet: bool = False,
) -> int:
    """Prove that runs with given gains park, and write the proof as a certificate.

    Proves in ball arithmetic that from every start of a box, for every camera, motor gain and
    disturbance within the bounds, the robot is parked within a time, and what it does not exceed
    on the way. Speaks of continuous time. Exit status 1 if no such claim could be proved.

    Parameters
    ----------
    gains : Path
        A file with [bounds] and [gains], and [starts], [switching] and law if not the defaults; or
        a scenario, whose start is then the only one.
    out : Path
        The certificate; default certificate.json.
    settings : list of str, optional
        Override a key of the file, as in gains.l[2]=30; may be repeated.
    overwrite : bool
        Replace the certificate if there is one.
    quiet : bool
        Show no progress.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        If the file is no such file, its law is the published one, or a library is missing.

    Examples
    --------
    >>> certify(Path("gains.toml"), settings=["law='published'"], quiet=True)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...law = "published"...
    """
    from parkproof.cli.console import progress, stdout_console
    from parkproof.cli.files import check_target, write_file
    from parkproof.errors import InputError
    from parkproof.extras import require
    from parkproof.spec import read_spec

    require("flint", "scipy", extra="proof", purpose="parkproof certify")
    from parkproof.proof.checker.statement import measured_sentence, statement_of
    from parkproof.proof.whole_run import certify as prove
    from parkproof.proof.whole_run import with_measured
    from parkproof.report.measured import measured_of

    spec = read_spec(gains, overrides=settings or ())
    if spec.gains is None:
        raise InputError(
            f"{gains}: has no [gains] to certify; write them, or find some with: parkproof design "
            f"{gains}"
        )
    if spec.law == "published":
        raise InputError(
            f'{gains}: law = "published": its Step 3 leaves the goal again, so there is nothing to '
            'certify; write law = "corrected"'
        )
    check_target(out, overwrite=overwrite)
    law = spec.law or "corrected"
    with progress(quiet=quiet) as report:
        found = prove(
            law=law,
            bounds=spec.bounds,
            gains=spec.gains,
            switching=spec.switching,
            starts=spec.starts.ranges,
            progress=lambda text: report(text, 0.0),
        )
        certificate = found.certificate
        if certificate is not None:
            report("measuring runs", 0.0)
            aim = spec.design
            certificate = with_measured(
                certificate,
                measured_of(
                    certificate,
                    control_period=aim.control_period,
                    noise=aim.noise,
                    latency=aim.latency,
                ),
            )
    console = stdout_console()
    if certificate is None:
        console.print(f"Not proved: {found.reason}.", soft_wrap=True)
        return 1
    write_file(out, json.dumps(certificate, indent=1) + "\n", overwrite=overwrite)
    for line in statement_of(certificate):
        console.print(line, soft_wrap=True)
    console.print()
    console.print(measured_sentence(certificate), soft_wrap=True)
    if law == "corrected" and spec.gains.return_steering:
        console.print(
            "Note: the theorem is about the law without steering in Step 3; write "
            "return_steering = false in [gains] of a scenario that is to rely on it.",
            soft_wrap=True,
        )
    if spec.switching is None:
        switching = {name: certificate["law"][name] for name in SWITCHING}
        console.print(f"Note: found for [switching]: {switching}.", soft_wrap=True)
    console.print(f"Proved. Wrote {out}; re-prove it with: parkproof verify {out}", soft_wrap=True)
    return 0


SWITCHING = ("tolerance", "hysteresis", "turn_tolerance", "chart_limit")
"""What is chosen where a file has no [switching]."""
