"""A range of trials carried out, as rows of the table: a pure function of the campaign."""

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from parkproof import __version__
from parkproof.campaign.definition import Quantity
from parkproof.campaign.draw import drawn_values
from parkproof.campaign.ensembles import ensembles
from parkproof.campaign.prepare import Prepared, prepared_from, values_of
from parkproof.errors import InputError
from parkproof.simulation.ensemble import simulate_trials

if TYPE_CHECKING:
    import pyarrow as pa

PIECE = 512
"""Trials between two looks at whether to stop."""


class GivenUpError(Exception):
    """A range of trials was given up because its campaign was stopped."""


def rows_of(
    prepared: Prepared, begin: int, end: int, *, stopped: Callable[[], bool] = lambda: False
) -> "pa.Table":
    """Carry out a range of trials.

    Parameters
    ----------
    prepared : Prepared
        The campaign.
    begin, end : int
        The trials begin … end − 1.
    stopped : callable
        Asked now and then whether to give up.

    Returns
    -------
    pyarrow.Table
        A row a trial in order: ``trial``, ``outcome``, the metrics of `simulate_ensemble`, and
        ``drawn.KEY`` for each quantity that is drawn.

    Raises
    ------
    GivenUpError
        If it was told to stop.

    Examples
    --------
    See `parkproof.campaign.run.run_campaign`.
    """
    import pyarrow as pa

    precision = prepared.campaign.precision
    drawn, numbers = drawn_values(prepared.campaign, begin, end), np.arange(begin, end)
    columns: dict[str, NDArray[Any]] = {}
    for members, scenario, trials in ensembles(prepared, drawn, numbers, size=PIECE):
        if stopped():
            raise GivenUpError
        for name, found in simulate_trials(scenario, trials, precision=precision).items():
            kind = object if name == "outcome" else float
            columns.setdefault(name, np.empty(end - begin, dtype=kind))[members] = found
    outcome = pa.array([one.value for one in columns.pop("outcome")], pa.string())
    table = {"trial": pa.array(numbers, pa.int64()), "outcome": outcome}
    table |= {name: pa.array(column, pa.float64()) for name, column in columns.items()}
    for quantity in prepared.campaign.quantities:
        if quantity.key in drawn:
            table[f"drawn.{quantity.key}"] = _column(quantity, drawn[quantity.key])
    return pa.table(table)


def _column(quantity: Quantity, drawn: NDArray[Any]) -> "pa.Array":
    """Values of a quantity: numbers, or text where its values are no numbers."""
    import pyarrow as pa

    values = values_of(quantity)
    if not values:
        return pa.array(drawn, pa.float64())
    if quantity.numeric:
        return pa.array(np.array(values, dtype=float)[drawn], pa.float64())
    texts = [value if isinstance(value, str) else json.dumps(value) for value in values]
    return pa.array([texts[i] for i in drawn.tolist()], pa.string())


def parquet_of(
    text: str, begin: int, end: int, *, version: str, stopped: Callable[[], bool] = lambda: False
) -> bytes:
    """Carry out a range of trials anywhere: what a thread or a worker of a cluster does.

    Parameters
    ----------
    text : str
        The campaign, as `parkproof.campaign.prepare.prepared_from` takes it.
    begin, end : int
        The trials begin … end − 1.
    version : str
        Version of Parkproof that asks.
    stopped : callable
        Asked now and then whether to give up.

    Returns
    -------
    bytes
        A Parquet file of `rows_of` these trials.

    Raises
    ------
    InputError
        If this is another version of Parkproof.
    GivenUpError
        If it was told to stop.

    Examples
    --------
    >>> parquet_of("", 0, 1, version="0")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: a worker has Parkproof ..., and the campaign needs 0; ...
    """
    import pyarrow as pa
    from pyarrow import parquet

    if version != __version__:
        raise InputError(
            f"a worker has Parkproof {__version__}, and the campaign needs {version}; install the "
            "same version for the workers"
        )
    table = rows_of(prepared_from(text), begin, end, stopped=stopped)
    with pa.BufferOutputStream() as stream:
        parquet.write_table(
            table,
            stream,
            compression="zstd",
            use_dictionary=[n for n in table.column_names if table[n].type == pa.string()],
            use_byte_stream_split=[n for n in table.column_names if table[n].type == pa.float64()],
        )
        return bytes(stream.getvalue())
