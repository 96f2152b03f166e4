"""A certificate for a report: read from its file, and proved again before anything rests on it."""

from pathlib import Path
from typing import Any

from parkproof.errors import InputError
from parkproof.extras import require

_REMEDY = "name a certificate.json that parkproof certify or parkproof design wrote"


def proved_certificate(path: Path) -> dict[str, Any]:
    """Read a certificate and prove it.

    Parameters
    ----------
    path : Path
        Its file.

    Returns
    -------
    dict
        The certificate.

    Raises
    ------
    InputError
        If the library of the arithmetic is missing, the file is no certificate, or what it claims
        is not proved.

    Examples
    --------
    >>> proved_certificate(directory / "none.json")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...none.json: cannot be read (No such file or directory); ...
    """
    require("flint", extra="proof", purpose="a certificate")
    from parkproof.proof.checker.certificate import NotACertificateError, read, why_not

    try:
        found = read(path.read_text(encoding="utf-8"))
        reason = why_not(found)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); {_REMEDY}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text; {_REMEDY}") from error
    except NotACertificateError as error:
        raise InputError(f"{path}: {error}; {_REMEDY}") from error
    if reason:
        raise InputError(f"{path}: is not proved ({reason}); see: parkproof verify {path}")
    return found
