"""Single files that a command writes: whole or not there at all."""

from pathlib import Path

from parkproof.cli.errors import why_not
from parkproof.errors import InputError
from parkproof.output import replace_file, sibling


def check_target(path: Path, *, overwrite: bool) -> None:
    """Check, before long work, that a file may be written where it is to go.

    Parameters
    ----------
    path : Path
        The file.
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    InputError
        If it is a directory, or exists and may not be replaced, or its folder is missing or cannot
        be written to.

    Examples
    --------
    >>> check_target(Path("gains.toml"), overwrite=False)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: gains.toml already exists; ...
    """
    if path.is_dir():
        raise InputError(f"{path} is a directory; name a file in it, {path / 'certificate.json'}")
    if path.is_file() and not overwrite:
        raise InputError(
            f"{path} already exists; write --overwrite to replace it, or choose another file"
        )
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}; make it, or choose another")
    if path.exists() and not path.is_file():  # a device or a pipe
        return
    trial = sibling(path.resolve(), "new")
    try:
        trial.touch(exist_ok=False)
        trial.unlink()
    except OSError as error:
        raise InputError(why_not(OSError(error.errno, error.strerror, str(path)))) from error


def write_file(path: Path, content: str | bytes, *, overwrite: bool) -> None:
    """Write a file that appears only when it is complete.

    Parameters
    ----------
    path : Path
        The file. Devices and pipes, such as /dev/stdout, are written to as they are.
    content : str or bytes
        What to write; text as UTF-8.
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    InputError
        If the file exists and may not be replaced, or cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_file(Path(folder) / "gains.toml", "[gains]", overwrite=False)
    ...     (Path(folder) / "gains.toml").read_text()
    '[gains]'
    """
    try:
        if path.is_dir():
            raise InputError(f"{path} is a directory; name a file in it, {path / 'scenario.toml'}")
        if path.exists() and not path.is_file():
            path.write_bytes(content.encode() if isinstance(content, str) else content)
            return
        if path.exists() and not overwrite:
            raise InputError(
                f"{path} already exists; write --overwrite to replace it, or choose another file"
            )
        replace_file(path.resolve(), content)
    except (OSError, RuntimeError) as error:  # RuntimeError: links that go round in a circle
        cause = error.strerror if isinstance(error, OSError) else str(error)
        number = error.errno if isinstance(error, OSError) else None
        raise InputError(why_not(OSError(number, cause, str(path)))) from error
