"""The table of a campaign's trials, read one column at a time.

A column of a million trials is 8 MB; the table as a whole would be some hundred times that.
"""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.campaign.table import file_of, read_rows, written_ranges
from parkproof.errors import InputError
from parkproof.simulation.outcome import Outcome

Floats = NDArray[np.float64]

OUTCOMES = tuple(Outcome)
"""What the codes of `TrialTable.outcomes` stand for."""

PARKED = OUTCOMES.index(Outcome.PARKED)


class TrialTable:
    """The table of a campaign, whose rows are in the order of the trials' numbers.

    Parameters
    ----------
    directory : Path
        The directory of the campaign.

    Raises
    ------
    InputError
        If its folder of trials holds something else, or a file is damaged when it is read.

    Examples
    --------
    >>> (directory / "trials").mkdir()
    >>> len(TrialTable(directory))
    0
    """

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._ranges = written_ranges(directory)

    def __len__(self) -> int:
        return sum(end - begin for begin, end in self._ranges)

    @property
    def trials(self) -> NDArray[np.int64]:
        """Numbers of the trials."""
        parts = [np.arange(begin, end, dtype=np.int64) for begin, end in self._ranges]
        return np.concatenate([np.empty(0, dtype=np.int64), *parts])

    def _pieces(self, name: str) -> Iterator[tuple[slice, Any]]:
        """A column's pieces with the rows they fill."""
        row = 0
        for begin, end in self._ranges:
            count = end - begin
            part = read_rows(file_of(self._directory, (begin, end)), count, columns=[name])
            yield slice(row, row + count), part[name].combine_chunks()
            row += count

    def column(self, name: str) -> Floats:
        """One column of numbers.

        Parameters
        ----------
        name : str
            Its name.

        Returns
        -------
        array
            A number a trial; NaN where there is none.
        """
        values = np.empty(len(self))
        for rows, piece in self._pieces(name):
            values[rows] = piece.to_numpy(zero_copy_only=False)
        return values

    @property
    def outcomes(self) -> NDArray[np.int8]:
        """How the trials ended, as places in OUTCOMES."""
        codes = np.empty(len(self), dtype=np.int8)
        place = {outcome.value: i for i, outcome in enumerate(OUTCOMES)}
        for rows, piece in self._pieces("outcome"):
            words = piece.dictionary_encode()
            known = words.dictionary.to_pylist()
            if strange := next((word for word in known if word not in place), None):
                raise InputError(
                    f"{self._directory}: outcome {strange!r} is none of {', '.join(place)}; the "
                    "table was changed, or another version wrote it: run the campaign again"
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
