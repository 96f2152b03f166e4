"""TOML files read with messages for a user."""

import re
import tomllib
from pathlib import Path
from typing import Any

from parkproof.errors import InputError
from parkproof.scenario_file.words import plain

MAX_BYTES = 1_000_000
"""A longer file is no scenario."""

_TOML_PLACE = re.compile(r"(?s)(.*) \(at (?:line (\d+), column (\d+)|end of document)\)")
_TOML_RULES = {
    "Invalid value": 'invalid value; write numbers plainly and text in "double quotes"',
    "Cannot overwrite a value": "a key is given twice; keep one of them",
    "Illegal character '\\n'": "a quoted text does not end on its line; add the closing quote",
    "Unclosed array": "a list is not closed; add the closing ]",
    "Unterminated string": "a quoted text is not closed; add the closing quote",
}


def load_toml(path: Path, *, kind: str = "") -> dict[str, Any]:
    r"""Read a TOML file that is not empty.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        Kind of file to start from, for messages, as in `parkproof init --kind`; default a scenario.

    Returns
    -------
    dict
        What it holds.

    Raises
    ------
    InputError
        If it cannot be read, is not UTF-8 or not TOML, or holds nothing.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "gains.toml"
    ...     _ = path.write_text("[gains]\nlambda1 = 2.0")
    ...     load_toml(path)
    {'gains': {'lambda1': 2.0}}
    """
    begin = f"parkproof init --kind {kind}" if kind else "parkproof init"
    text = _text(path, begin)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: {_toml_error(str(error), text)}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(
            f"{path}: a number is too long or lists are nested too deeply; write plain numbers"
        ) from error
    if not data:
        what = "specification" if kind else "scenario"
        raise InputError(f"{path}: the file is empty; for a {what} to start from, run: {begin}")
    return data


def _text(path: Path, begin: str) -> str:
    """Read a UTF-8 file; a byte-order mark, as some editors write it, is passed over."""
    try:
        with path.open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
    except FileNotFoundError as error:
        raise InputError(
            f"{path}: no such file; check the name, or write one with: {begin} --out {path}"
        ) from error
    except IsADirectoryError as error:
        raise InputError(f"{path}: is a directory; name a scenario file (.toml) in it") from error
    except OSError as error:
        raise InputError(
            f"{path}: cannot be read ({error.strerror}); check its permissions or name another file"
        ) from error
    if len(raw) > MAX_BYTES:
        raise InputError(f"{path}: longer than {MAX_BYTES:,} bytes, so it is no scenario file")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{path}: line {line}: not UTF-8 text (byte 0x{raw[error.start]:02x}); "
            "save the file as UTF-8"
        ) from error


def _toml_error(message: str, text: str) -> str:
    """Say where TOML is broken, why, and what stands there."""
    match = _TOML_PLACE.fullmatch(message)
    rule, line, column = match.groups() if match is not None else (message, None, None)
    if re.fullmatch(r"Cannot declare .* twice", rule):
        rule = "this table is given twice; join the two"
    if line is None and rule == "Invalid value":
        rule = "the last value is missing or not complete"
    rule = _TOML_RULES.get(rule, rule[:1].lower() + rule[1:])
    if line is None:
        return f"end of the file: not valid TOML: {rule}"
    source = text.splitlines()[int(line) - 1].strip() if text.splitlines()[int(line) - 1 :] else ""
    return f"line {line}, column {column}: not valid TOML: {rule} (in: {plain(source)})"
