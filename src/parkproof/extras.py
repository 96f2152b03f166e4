"""Optional libraries: imported only when used, and named with their extra when they are missing."""

from importlib.util import find_spec

from parkproof.errors import InputError


def require(*modules: str, extra: str, purpose: str) -> None:
    """Check that optional libraries are installed.

    Parameters
    ----------
    *modules : str
        Names by which they are imported.
    extra : str
        The extra of parkproof that brings them.
    purpose : str
        What needs them.

    Raises
    ------
    InputError
        If one is missing.

    Examples
    --------
    >>> require("json", extra="proof", purpose="certify")
    >>> require("no_such_module", extra="proof", purpose="certify")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: certify needs no_such_module, which is not installed; ...
    """
    missing = [module for module in modules if find_spec(module) is None]
    if missing:
        raise InputError(
            f"{purpose} needs {' and '.join(missing)}, which is not installed; "
            f"run: pip install 'parkproof[{extra}]'"
        )
