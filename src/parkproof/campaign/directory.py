"""The directory of a campaign: rows that are whole or not there, whatever happens meanwhile.

``trials/`` holds nothing but Parquet files, each named after its first and last trial. A file is
written elsewhere in the directory, brought to the disk, and then takes its name, so that a process
that is killed at any moment leaves only whole files.
"""

import contextlib
import errno
import hashlib
import json
import os
import secrets
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from parkproof import __version__
from parkproof.campaign.table import TRIALS, Range, check_whole, file_of, written_ranges
from parkproof.errors import InputError

RECORD, PARTS, LOCK = "campaign.json", ".parts", ".lock"
"""What else lies in the directory: the campaign, what is being written, who writes."""


class CampaignDirectory:
    """A directory that this process may write to; see `open_directory`.

    Parameters
    ----------
    path : Path
        The directory.
    plain : dict
        The campaign as plain tables.

    Attributes
    ----------
    written : list of (int, int)
        Ranges of trials whose rows are there, in order.

    Examples
    --------
    See `open_directory`.
    """

    def __init__(self, path: Path, plain: dict[str, Any]) -> None:
        self.path = path
        self._plain = plain
        self.written = written_ranges(path)
        for trials in self.written:
            check_whole(file_of(path, trials), trials[1] - trials[0])

    def missing(self) -> list[Range]:
        """Give the ranges of trials that are asked for and not there."""
        gaps, begin = [], 0
        for first, after in self.written:
            if first > begin:
                gaps.append((begin, first))
            begin = after
        if begin < self._plain["trials"]:
            gaps.append((begin, self._plain["trials"]))
        return gaps

    def add(self, trials: Range, content: bytes) -> None:
        """Write the rows of a range of trials, all or nothing."""
        self._put(file_of(self.path, trials), content)
        self.written = sorted([*self.written, trials])

    def note(self, *, finished: bool) -> None:
        """Write what was asked, and whether it is done."""
        plain = self._plain
        record = {
            "version": __version__,
            "law": plain["law"],
            "trials": plain["trials"],
            "seed": plain["seed"],
            "draws": plain["draws"],
            "precision": plain["precision"],
            "finished": finished,
            "digest": digest_of(plain),
            "campaign": plain,
        }
        self._put(self.path / RECORD, json.dumps(record, indent=2).encode() + b"\n")

    def _put(self, target: Path, content: bytes) -> None:
        """Write a file elsewhere, bring it to the disk, and let it take its name."""
        work = self.path / PARTS / secrets.token_hex(8)
        try:
            with work.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            work.replace(target)
            _bring_to_disk(target.parent)
        except OSError as error:
            self._tell(error)
        finally:
            with contextlib.suppress(OSError):  # it has taken its name
                work.unlink()

    def _tell(self, error: OSError) -> None:
        done = sum(end - begin for begin, end in self.written)
        raise InputError(
            f"cannot write to {self.path}: {error.strerror or error}; the rows of {done:,} trials "
            "are whole and stay there: make room, and the same command goes on"
        ) from error


@contextmanager
def open_directory(path: Path, plain: dict[str, Any]) -> Iterator[CampaignDirectory]:
    """Open the directory of a campaign for writing, new or as an earlier call left it.

    Parameters
    ----------
    path : Path
        The directory; made if it is not there.
    plain : dict
        The campaign, from `parkproof.campaign.definition.plain_of`.

    Yields
    ------
    CampaignDirectory
        No other process may write to it meanwhile.

    Raises
    ------
    InputError
        If it holds something else or another campaign, another process writes to it, or it cannot
        be written to.

    Examples
    --------
    >>> plain = {"law": "corrected", "trials": 8, "seed": 0, "draws": "sobol",
    ...          "precision": "double"}
    >>> with open_directory(directory / "out", plain) as opened:
    ...     opened.add((0, 4), b"")
    ...     opened.missing()
    [(4, 8)]
    """
    try:
        _check_ours(path)
        path.mkdir(parents=True, exist_ok=True)
        lock = (path / LOCK).open("ab")
    except OSError as error:
        raise _unwritable(path, error) from error
    with lock:
        _lock(lock.fileno(), path)
        record = read_record(path) if (path / RECORD).exists() else None
        if record is not None:
            _check_same(path, record, plain)
        try:
            yield _as_left(path, plain, record)
        finally:
            with contextlib.suppress(OSError):  # there are only whole files now
                (path / PARTS).rmdir()


def _as_left(path: Path, plain: dict[str, Any], record: dict[str, Any] | None) -> CampaignDirectory:
    """The directory, new or as an earlier call left it, without what a kill left half written."""
    try:
        (path / PARTS).mkdir(exist_ok=True)
        for part in (path / PARTS).iterdir():
            part.unlink()
        (path / TRIALS).mkdir(exist_ok=True)
    except OSError as error:
        raise _unwritable(path, error) from error
    opened = CampaignDirectory(path, plain)
    if record is None and opened.written:
        raise InputError(
            f"{path} holds rows of trials, but no {RECORD} that says of which campaign; choose "
            "another directory"
        )
    last = opened.written[-1][1] if opened.written else 0
    if last > plain["trials"]:
        raise InputError(
            f"{path} holds trials up to {last - 1:,}, and {plain['trials']:,} are asked for: "
            f"no trial is ever removed; ask for {last:,} or more, or choose another directory"
        )
    if record is None or record["trials"] != plain["trials"]:
        opened.note(finished=False)
    return opened


def digest_of(plain: dict[str, Any]) -> str:
    """Digest of a campaign but for its number of trials, which may grow.

    Parameters
    ----------
    plain : dict
        The campaign as plain tables.

    Returns
    -------
    str
        Hexadecimal.

    Examples
    --------
    >>> digest_of({"trials": 1, "seed": 0}) == digest_of({"seed": 0, "trials": 2})
    True
    """
    kept = {key: value for key, value in plain.items() if key != "trials"}
    return hashlib.sha256(json.dumps(kept, sort_keys=True).encode()).hexdigest()


def read_record(path: Path) -> dict[str, Any]:
    """Read what a directory's campaign is.

    Parameters
    ----------
    path : Path
        The directory.

    Returns
    -------
    dict
        See `CampaignDirectory.note`.

    Raises
    ------
    InputError
        If it is no directory of a campaign.

    Examples
    --------
    >>> read_record(directory)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...: is no directory of a campaign (it has no campaign.json); ...
    """
    try:
        record = json.loads((path / RECORD).read_text(encoding="utf-8"))
        if isinstance(record["campaign"], dict) and isinstance(record["trials"], int):
            # before there was a choice, all was double
            return {**record, "campaign": {"precision": "double", **record["campaign"]}}
    except (FileNotFoundError, NotADirectoryError) as error:
        raise InputError(
            f"{path}: is no directory of a campaign (it has no {RECORD}); give the --out of "
            "parkproof campaign"
        ) from error
    except OSError as error:
        raise InputError(
            f"{path / RECORD}: cannot be read ({error.strerror}); check its permissions"
        ) from error
    except (ValueError, KeyError, TypeError):
        pass
    raise InputError(f"{path / RECORD}: is damaged; choose another directory")


def _check_ours(path: Path) -> None:
    """Raise if a directory holds something that is no campaign."""
    if not path.exists() or (path / RECORD).exists():
        return
    if not path.is_dir():
        raise InputError(f"{path} is a file: results go into a directory; choose another name")
    ours = {PARTS, LOCK, TRIALS}
    foreign = next((p.name for p in sorted(path.iterdir()) if p.name not in ours), None)
    if foreign is not None:
        raise InputError(
            f"{path} holds {foreign} and no campaign; choose a new directory, or an empty one"
        )


def _check_same(path: Path, record: dict[str, Any], plain: dict[str, Any]) -> None:
    """Raise if a directory holds another campaign, and say in what it differs."""
    difference = _difference(record["campaign"], plain)
    if difference is not None:
        raise InputError(
            f"{path} holds another campaign: {difference}; choose another directory, or go on with "
            "that campaign"
        )
    if record.get("version") != __version__:
        raise InputError(
            f"{path} was begun with Parkproof {record.get('version')}, and this is {__version__}, "
            "whose rows may differ; go on with that version, or choose another directory"
        )


def _difference(there: Any, asked: Any, key: str = "") -> str | None:
    """The first key in which two campaigns differ, with both values."""
    if isinstance(there, dict) and isinstance(asked, dict):
        for name in sorted({*there, *asked}):
            inner = f"{key}.{name}".removeprefix(".")
            found = _difference(there.get(name), asked.get(name), inner)
            if found is not None and inner != "trials":
                return found
        return None
    if there == asked:
        return None
    texts = ("nothing" if value is None else json.dumps(value) for value in (there, asked))
    was, now = (text if len(text) <= 60 else f"{text[:60]}..." for text in texts)
    return f"{key} is {was} there and {now} here"


def _unwritable(path: Path, error: OSError) -> InputError:
    reason = error.strerror or error
    return InputError(f"cannot write to {path}: {reason}; choose another directory")


def _lock(descriptor: int, path: Path) -> None:
    """Keep other processes out until the file is closed, also by being killed."""
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno not in {errno.EACCES, errno.EAGAIN, errno.EDEADLK}:
            raise _unwritable(path, error) from error
        raise InputError(
            f"{path}: another process is carrying this campaign out; wait for it, stop it, or "
            "choose another directory"
        ) from error


def _bring_to_disk(folder: Path) -> None:
    """Bring the names in a folder to the disk, where the system can."""
    if sys.platform == "win32":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
