"""``parkproof verify``: re-proves a certificate."""

from pathlib import Path

_REMEDY = "name a certificate.json that parkproof certify or parkproof design wrote"


def verify(certificate: Path, /) -> int:
    """Re-prove a certificate and print its theorem.

    Exit status 0 proved, 1 not proved, 2 unreadable or its digest is wrong.

    Parameters
    ----------
    certificate : Path
        A file written by "parkproof certify".

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        If the library of the arithmetic is missing, or the file is no certificate.

    Examples
    --------
    >>> verify(Path("scenario.toml"))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: scenario.toml: not JSON: ...
    """
    from parkproof.cli.console import stdout_console
    from parkproof.errors import InputError
    from parkproof.extras import require

    require("flint", extra="proof", purpose="parkproof verify")
    from parkproof.proof.checker.certificate import NotACertificateError, read, why_not
    from parkproof.proof.checker.statement import measured_sentence, statement_of

    try:
        found = read(certificate.read_text(encoding="utf-8"))
        reason = why_not(found)
    except OSError as error:
        cause = f"cannot be read ({error.strerror})"
        raise InputError(f"{certificate}: {cause}; {_REMEDY}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{certificate}: not UTF-8 text; {_REMEDY}") from error
    except NotACertificateError as error:
        raise InputError(f"{certificate}: {error}; {_REMEDY}") from error
    console = stdout_console()
    if reason:
        console.print(f"NOT PROVED: {reason}.", soft_wrap=True)
        return 1
    for line in statement_of(found):
        console.print(line, soft_wrap=True)
    console.print()
    if measured := measured_sentence(found):
        console.print(measured, soft_wrap=True)
    console.print("Proved.")
    return 0
