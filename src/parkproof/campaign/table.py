"""The table of a campaign: Parquet files, each named after its first and last trial."""

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from parkproof.errors import InputError

if TYPE_CHECKING:
    import pyarrow as pa

TRIALS = "trials"
"""The folder of the files, which holds nothing else."""

_NAME = re.compile(r"(\d{12,16})-(\d{12,16})\.parquet")

Range = tuple[int, int]
"""The trials from the first number to before the second."""


def file_of(path: Path, trials: Range) -> Path:
    """Give the file of a range of trials.

    Parameters
    ----------
    path : Path
        The directory of a campaign.
    trials : (int, int)
        The range.

    Returns
    -------
    Path
        In its folder of trials.

    Examples
    --------
    >>> file_of(Path("out"), (0, 64)).name
    '000000000000-000000000063.parquet'
    """
    begin, end = trials
    return path / TRIALS / f"{begin:012d}-{end - 1:012d}.parquet"


def written_ranges(path: Path) -> list[Range]:
    """Find out which trials have rows.

    Parameters
    ----------
    path : Path
        The directory of a campaign.

    Returns
    -------
    list of (int, int)
        In order.

    Raises
    ------
    InputError
        If there are other files, or ranges that overlap.

    Examples
    --------
    >>> (directory / "trials").mkdir()
    >>> _ = (directory / "trials" / "000000000000-000000000063.parquet").write_bytes(b"")
    >>> written_ranges(directory)
    [(0, 64)]
    """
    ranges = []
    for file in sorted((path / TRIALS).iterdir()):
        match = _NAME.fullmatch(file.name)
        if match is None:
            raise InputError(
                f"{file}: is no file of this campaign; move it out of {path / TRIALS}, which holds "
                "rows of trials only"
            )
        ranges.append((int(match[1]), int(match[2]) + 1))
    ranges.sort()
    for (_, end), (begin, _) in itertools.pairwise(ranges):
        if begin < end:
            raise InputError(
                f"{path / TRIALS}: trial {begin:,} is there twice; remove one of its files"
            )
    return ranges


def row_of(path: Path, trial: int) -> dict[str, Any]:
    """Read the row of one trial.

    Parameters
    ----------
    path : Path
        The directory of a campaign.
    trial : int
        Number of the trial.

    Returns
    -------
    dict of str to object
        Its columns.

    Raises
    ------
    InputError
        If it is not there, or its file is damaged.

    Examples
    --------
    >>> (directory / "trials").mkdir()
    >>> row_of(directory, 7)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...: has no trial 7 (it has none yet); ...
    """
    ranges = written_ranges(path)
    for begin, end in ranges:
        if begin <= trial < end:
            file = file_of(path, (begin, end))
            row: dict[str, Any] = (
                read_rows(file, end - begin).slice(trial - begin, 1).to_pylist()[0]
            )
            return row
    there = f"trials {ranges[0][0]:,} to {ranges[-1][1] - 1:,}" if ranges else "none yet"
    raise InputError(
        f"{path}: has no trial {trial} (it has {there}); give another number, or go on with the "
        "campaign"
    )


def read_rows(file: Path, count: int, *, columns: Sequence[str] | None = None) -> "pa.Table":
    """Read a file of rows.

    Parameters
    ----------
    file : Path
        In ``trials/``.
    count : int
        How many rows its name promises.
    columns : sequence of str, optional
        Which columns; default all.

    Returns
    -------
    pyarrow.Table
        The rows.

    Raises
    ------
    InputError
        If it is damaged.

    Examples
    --------
    >>> _ = (directory / "a.parquet").write_bytes(b"half")
    >>> read_rows(directory / "a.parquet", 4)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...a.parquet: is damaged; remove it, and the same campaign ...
    """
    import pyarrow as pa
    from pyarrow import parquet

    try:
        table = parquet.read_table(str(file), columns=columns, partitioning=None)
    except (OSError, pa.ArrowException) as error:
        raise _damaged(file) from error
    if table.num_rows != count:
        raise _damaged(file)
    return table


def check_whole(file: Path, count: int) -> None:
    """Check that a file of rows ends as it should, without reading the rows.

    Parameters
    ----------
    file : Path
        In ``trials/``.
    count : int
        How many rows its name promises.

    Raises
    ------
    InputError
        If it is damaged.

    Examples
    --------
    >>> _ = (directory / "a.parquet").write_bytes(b"half")
    >>> check_whole(directory / "a.parquet", 4)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...a.parquet: is damaged; remove it, and the same campaign ...
    """
    import pyarrow as pa
    from pyarrow import parquet

    try:
        whole = parquet.read_metadata(str(file)).num_rows == count
    except (OSError, pa.ArrowException) as error:
        raise _damaged(file) from error
    if not whole:
        raise _damaged(file)


def _damaged(file: Path) -> InputError:
    return InputError(f"{file}: is damaged; remove it, and the same campaign writes it anew")


def outcomes_of(path: Path) -> dict[str, int]:
    """Count how the trials of a campaign ended.

    Parameters
    ----------
    path : Path
        The directory of a campaign.

    Returns
    -------
    dict of str to int
        By outcome; only those that occur.

    Raises
    ------
    InputError
        If a file is damaged.

    Examples
    --------
    >>> (directory / "trials").mkdir()
    >>> outcomes_of(directory)
    {}
    """
    counts: Counter[str] = Counter()
    for trials in written_ranges(path):
        table = read_rows(file_of(path, trials), trials[1] - trials[0], columns=["outcome"])
        for pair in table["outcome"].value_counts().to_pylist():
            counts[pair["values"]] += pair["counts"]
    return dict(counts)
