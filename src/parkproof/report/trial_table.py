"""The table of a campaign's trials, read one column at a time.

A column of a million trials is 8 MB; the table as a whole would be some hundred times that.
"""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.dataset as ds
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.simulation.outcome import Outcome

Floats = NDArray[np.float64]

OUTCOMES = tuple(Outcome)
"""What the codes of `TrialTable.outcomes` stand for."""

PARKED = OUTCOMES.index(Outcome.PARKED)

KEYS = ("trial", "outcome", "total", "residual")
"""Columns without which nothing can be said."""

DRAWN = "drawn."
"""Columns of what was drawn begin so."""


class TrialTable:
    """The Parquet files of a campaign, one row a trial, in whatever order they were written.

    Parameters
    ----------
    folder : Path
        The folder of the files; one without any is a table without trials.

    Raises
    ------
    InputError
        If the folder is not there, holds something else than Parquet, or lacks a column.

    Examples
    --------
    >>> (directory / "trials").mkdir()
    >>> len(TrialTable(directory / "trials"))
    0
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        if not folder.is_dir():
            raise InputError(
                f"{folder}: there is no such folder; name the directory that parkproof campaign "
                "wrote"
            )
        try:
            self._dataset = ds.dataset(folder, format="parquet")
            self._count = self._dataset.count_rows() if self._dataset.files else 0
        except (pa.ArrowException, OSError) as error:
            raise self._unreadable(error) from error
        missing = [name for name in KEYS if self._count and name not in self.names]
        if missing:
            raise InputError(
                f"{folder}: no column {' and no column '.join(missing)}; name the directory that "
                "parkproof campaign wrote"
            )

    def _unreadable(self, error: Exception) -> InputError:
        cause = str(error).partition("\n")[0]
        return InputError(
            f"{self._folder}: cannot be read as a table of trials ({cause}); nothing but the "
            "Parquet files of parkproof campaign may lie there: run the campaign again"
        )

    def __len__(self) -> int:
        return self._count

    @property
    def names(self) -> list[str]:
        """Names of the columns."""
        return list(self._dataset.schema.names)

    @property
    def drawn(self) -> list[str]:
        """Keys of the scenario that were drawn, one column each."""
        return [name.removeprefix(DRAWN) for name in self.names if name.startswith(DRAWN)]

    def _pieces(self, name: str) -> Iterator[tuple[slice, Any]]:
        """A column's pieces with the rows they fill; always in the same order."""
        begin = 0
        if not self._count:
            return
        try:
            for batch in self._dataset.to_batches(columns=[name]):
                yield slice(begin, begin + len(batch)), batch.column(0)
                begin += len(batch)
        except (pa.ArrowException, OSError) as error:
            raise self._unreadable(error) from error

    def column(self, name: str) -> Floats:
        """One column of numbers.

        Parameters
        ----------
        name : str
            Its name.

        Returns
        -------
        array
            A number a trial; NaN where there is none, and all NaN where there is no such column.
        """
        values = np.full(self._count, np.nan)
        if name in self.names:
            for rows, piece in self._pieces(name):
                values[rows] = piece.cast(pa.float64()).to_numpy(zero_copy_only=False)
        return values

    @property
    def trials(self) -> NDArray[np.int64]:
        """Numbers of the trials."""
        numbers = np.empty(self._count, dtype=np.int64)
        for rows, piece in self._pieces("trial"):
            numbers[rows] = piece.to_numpy(zero_copy_only=False)
        return numbers

    @property
    def outcomes(self) -> NDArray[np.int8]:
        """How the trials ended, as places in OUTCOMES."""
        codes = np.empty(self._count, dtype=np.int8)
        place = {outcome.value: i for i, outcome in enumerate(OUTCOMES)}
        for rows, piece in self._pieces("outcome"):
            words = piece if pa.types.is_dictionary(piece.type) else piece.dictionary_encode()
            known = words.dictionary.to_pylist()
            if strange := next((word for word in known if word not in place), None):
                raise InputError(
                    f"{self._folder}: outcome {strange!r} is none of {', '.join(place)}; the table "
                    "was written by another version or changed: run the campaign again"
                )
            numbers = np.array([place[word] for word in known], dtype=np.int8)
            codes[rows] = numbers[words.indices.to_numpy(zero_copy_only=False)]
        return codes


def counted(codes: NDArray[np.int8]) -> dict[Outcome, int]:
    """How many trials ended in each way, the most frequent first.

    Parameters
    ----------
    codes : array
        From `TrialTable.outcomes`.

    Returns
    -------
    dict of Outcome to int
        Only ways that occurred.

    Examples
    --------
    >>> counted(np.array([0, 2, 2], dtype=np.int8))
    {<Outcome.STILL_MOVING: 'still moving'>: 2, <Outcome.PARKED: 'parked'>: 1}
    """
    counts = Counter({outcome: int((codes == i).sum()) for i, outcome in enumerate(OUTCOMES)})
    return {outcome: count for outcome, count in counts.most_common() if count}
