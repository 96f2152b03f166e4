"""Directories of results: whole or not there at all, and nothing but a result is ever replaced.

And single files, whole or not there at all.
"""

import contextlib
import errno
import os
import secrets
import shutil
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from parkproof import __version__
from parkproof.errors import InputError

MANIFEST = ".parkproof"
"""Hidden file in every result directory: the names of the files that Parkproof wrote there."""

_REMEDIES = {
    errno.ENOSPC: "free some space, or choose a directory on another disk",
    errno.EDQUOT: "free some space, or choose a directory outside the quota",
    errno.EACCES: "choose a directory that you may write to",
    errno.EPERM: "choose a directory that you may write to",
    errno.EROFS: "choose a directory that you may write to",
    errno.ENAMETOOLONG: "choose a shorter name",
}


@contextmanager
def output_directory(
    path: Path | str, *, overwrite: bool = False, kept: Collection[str] = ()
) -> Iterator[Path]:
    """Make a directory of results that appears only when it is complete.

    Everything is written into a hidden directory beside ``path``, which takes its name when the
    block ends well. After any exception, Ctrl-C or a full disk nothing of it remains, and a result
    that was there before is as it was.

    Parameters
    ----------
    path : Path or str
        Where the results shall lie. Missing parents are made.
    overwrite : bool
        Whether an earlier result there may be replaced. Anything else never is: a directory with a
        file that Parkproof did not write, the current directory, a file.
    kept : collection of str
        Looked at after an exception: these files of the block are sound although the rest is not,
        and cannot be made again. They are left in a new directory beside ``path`` whose name ends
        in ``-broken-off``, which a note of the exception names.

    Yields
    ------
    Path
        The directory to write into.

    Raises
    ------
    InputError
        Before the block, if ``path`` exists and may not be replaced, or cannot be written to;
        after it, if a file could not be written (any `OSError` in the block).

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as parent:
    ...     with output_directory(Path(parent) / "out") as directory:
    ...         _ = (directory / "note.txt").write_text("done")
    ...     (Path(parent) / "out" / "note.txt").read_text()
    'done'
    """
    try:
        target = Path(path).resolve()
        _check_replaceable(target, shown=path, overwrite=overwrite)
        made = _make_parents(target)
    except (OSError, RuntimeError) as error:  # RuntimeError: links that go round in a circle
        raise _as_input_error(path, error) from error
    work = sibling(target, "new")
    try:
        work.mkdir()
        yield work
        _write_manifest(work)
        _check_replaceable(target, shown=path, overwrite=overwrite)
        _move_into_place(work, target)
    except BaseException as error:
        raised = _shown(error, path, work)
        if rest := _saved(work, target, kept):
            raised.add_note(f"what is sound of it is in {rest}: {', '.join(kept)}")
        if raised is error:
            raise
        raise raised from error
    finally:
        shutil.rmtree(work, ignore_errors=True)
        for parent in made:
            with contextlib.suppress(OSError):  # no longer empty: the result is in it
                parent.rmdir()


def write_whole(path: Path | str, content: str | bytes) -> None:
    """Write a file that appears only when it is complete; one that was there is replaced.

    Parameters
    ----------
    path : Path or str
        The file; its folder exists.
    content : str or bytes
        What to write; text as UTF-8.

    Raises
    ------
    InputError
        If it cannot be written; a file that was there before is then as it was.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_whole(Path(folder) / "goal.json", "{}")
    ...     (Path(folder) / "goal.json").read_text()
    '{}'
    """
    try:
        replace_file(Path(path).resolve(), content)
    except (OSError, RuntimeError) as error:
        raise _as_input_error(path, error) from error


def replace_file(target: Path, content: str | bytes) -> None:
    """Write a file beside its place, and move it there when it is on the disk.

    Parameters
    ----------
    target : Path
        The file, with links resolved.
    content : str or bytes
        What to write; text as UTF-8.

    Raises
    ------
    OSError
        If it cannot be written; nothing is left of it.

    Examples
    --------
    >>> replace_file(directory / "note.txt", "done")
    >>> [path.name for path in directory.iterdir()]
    ['note.txt']
    """
    work = sibling(target, "new")
    try:
        with work.open("xb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        work.replace(target)
    finally:
        with contextlib.suppress(OSError):  # it has taken its name, or was never made
            work.unlink()


def sibling(target: Path, purpose: str) -> Path:
    """Give a new hidden name beside a target, so that renaming stays on one file system.

    Parameters
    ----------
    target : Path
        The file or directory.
    purpose : str
        A word in the name.

    Returns
    -------
    Path
        Nothing is there.

    Examples
    --------
    >>> sibling(Path("run"), "new").name.startswith(".run.new-")
    True
    """
    return target.with_name(f".{target.name[:100]}.{purpose}-{secrets.token_hex(4)}")


def _make_parents(target: Path) -> list[Path]:
    """Make the missing parents; those made, innermost first."""
    missing = [parent for parent in target.parents if not parent.exists()]
    target.parent.mkdir(parents=True, exist_ok=True)
    return missing


def _check_replaceable(target: Path, *, shown: Path | str, overwrite: bool) -> None:
    """Raise unless the target is free, or an earlier result that may be overwritten."""
    if not target.exists():
        return
    if not target.is_dir():
        raise InputError(f"{shown} is a file: results go into a directory; choose another name")
    here = Path.cwd()
    if target == here or target in here.parents:
        raise InputError(
            f"{shown} is the current directory or holds it, and is never replaced; choose a new "
            "directory, for example --out results"
        )
    if not overwrite:
        raise InputError(
            f"{shown} already exists; write --overwrite to replace an earlier result, or choose "
            "another directory"
        )
    listed = _manifest(target)
    foreign = next((name for name in _files(target) if name not in listed), None)
    if foreign is not None:
        raise InputError(
            f"{shown} holds {foreign}, which Parkproof did not write there, and is never replaced; "
            "choose another directory, or move that file away"
        )


def _shown(error: BaseException, path: Path | str, work: Path) -> BaseException:
    """The error as a user can understand it, who does not know the hidden directory."""
    if isinstance(error, OSError):
        return _as_input_error(path, error)
    if isinstance(error, InputError) and str(work) in str(error):
        return InputError(str(error).replace(str(work), str(path)))
    return error


def _saved(work: Path, target: Path, kept: Collection[str]) -> Path | None:
    """Move files out of what is thrown away; the directory they are in now, if there are any."""
    rest = target.with_name(f"{target.name[:100]}-broken-off")
    number = 1
    while rest.exists():
        number += 1
        rest = rest.with_name(f"{target.name[:100]}-broken-off-{number}")
    try:
        there = [work / name for name in kept if (work / name).is_file()]
        if not there:
            return None
        rest.mkdir()
        for file in there:
            file.rename(rest / file.name)
    except OSError:  # such as a disk that is gone: then there is nothing to save
        return None
    return rest


def _files(directory: Path) -> Iterator[str]:
    """All that is in a directory and those below, by relative name; links count, and end there."""
    pending = [directory]
    while pending:
        for entry in sorted(pending.pop().iterdir()):
            if entry.is_dir() and not entry.is_symlink():
                pending.append(entry)
            else:
                yield entry.relative_to(directory).as_posix()


def _manifest(directory: Path) -> set[str]:
    """The files that Parkproof wrote into a directory, by relative name."""
    try:
        lines = (directory / MANIFEST).read_text(encoding="utf-8").splitlines()
    except (FileNotFoundError, UnicodeDecodeError):
        return set()
    return {MANIFEST, *lines[1:]}


def _write_manifest(directory: Path) -> None:
    names = list(_files(directory))
    head = f"Written by Parkproof {__version__}; --overwrite needs this list:"
    (directory / MANIFEST).write_text("\n".join([head, *names, ""]), encoding="utf-8")


def _move_into_place(work: Path, target: Path) -> None:
    """Rename; an earlier result steps aside first, and comes back if anything goes wrong."""
    if not target.exists():
        work.rename(target)
        return
    aside = sibling(target, "old")
    try:
        target.rename(aside)
        work.rename(target)
    except BaseException:
        if aside.exists() and not target.exists():
            aside.rename(target)
        raise
    finally:
        if target.exists():
            shutil.rmtree(aside, ignore_errors=True)


def _as_input_error(path: Path | str, error: Exception) -> InputError:
    """What went wrong and what to do, in one line."""
    number = error.errno if isinstance(error, OSError) else None
    cause = (error.strerror if isinstance(error, OSError) else None) or str(error)
    if isinstance(error, NotADirectoryError | FileExistsError):
        remedy = "a file is in the way; choose another directory"
    else:
        remedy = _REMEDIES.get(number or 0, "choose another directory")
    return InputError(f"cannot write {path}: {' '.join(cause.split())}; {remedy}")
