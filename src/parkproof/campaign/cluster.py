"""Chunks of a campaign on the workers of a `dask.distributed` scheduler.

A chunk is a pure function of the campaign and its range, so that it does not matter which worker
carries it out, or how often. Only this process writes.
"""

import logging
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from parkproof import __version__
from parkproof.campaign.rows import parquet_of
from parkproof.campaign.run import Results
from parkproof.campaign.table import Range
from parkproof.errors import InputError
from parkproof.extras import require

if TYPE_CHECKING:
    from distributed import Client, Future

CONNECTING = 10.0
"""Longest time to reach a scheduler, in s."""

PATIENCE = 60.0
"""Longest time without any worker, in s."""

LOOK = 1.0
"""How often to look for workers while nothing comes, in s."""

DEATHS = 3
"""How often a chunk is given to workers again after it was lost with several of them."""

EACH = 2
"""Chunks that are sent ahead for each thread of the workers."""


@contextmanager
def connected(address: str) -> "Iterator[Client]":
    """Connect to a scheduler.

    Parameters
    ----------
    address : str
        Such as ``tcp://10.0.0.1:8786``.

    Yields
    ------
    distributed.Client
        Closed at the end of the block.

    Raises
    ------
    InputError
        If distributed is not installed, or the scheduler is not there.

    Examples
    --------
    >>> with connected("10.0.0.1"):
    ...     pass
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: --scheduler 10.0.0.1: ...; write for example tcp://10.0.0.1:8786
    """
    if "://" not in address or not address.rpartition(":")[2].isdigit():
        raise InputError(
            f"--scheduler {address}: is no address of a scheduler; write for example "
            "tcp://10.0.0.1:8786"
        )
    require("distributed", extra="cluster", purpose="parkproof campaign --scheduler")
    from distributed import Client

    for name in ("distributed", "distributed.client"):  # one sentence says it, not their log
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        client = Client(address, timeout=CONNECTING, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"--scheduler {address}: there is no scheduler ({_said(error)}); start one with "
            "dask scheduler, or leave --scheduler out"
        ) from error
    try:
        yield client
    finally:
        client.close(timeout=CONNECTING)


def on_cluster(text: str, chunks: Sequence[Range], client: "Client", address: str) -> Results:
    """Carry out chunks on the workers of a scheduler.

    Parameters
    ----------
    text : str
        The campaign, as `parkproof.campaign.prepare.prepared_from` takes it.
    chunks : sequence of (int, int)
        Ranges of trials.
    client : distributed.Client
        From `connected`.
    address : str
        Of its scheduler, for messages.

    Yields
    ------
    ((int, int), bytes)
        A range and its rows as a Parquet file, as they come. Those of workers that die are given
        to others.

    Raises
    ------
    InputError
        If the scheduler is lost, there are no workers for long, or they cannot do the work.

    Examples
    --------
    See `parkproof.campaign.run.run_campaign`.
    """
    yield from _Work(client, address, text).results(chunks)


class _Work:
    """Chunks in the hands of workers, and those that wait."""

    def __init__(self, client: "Client", address: str, text: str) -> None:
        self._client = client
        self._address = address
        self._text = text
        self._running: dict[Any, Range] = {}
        self._done: SimpleQueue[Future[Any]] = SimpleQueue()
        self._deaths: dict[Range, int] = {}
        self._alone_since: float | None = None

    def results(self, chunks: Sequence[Range]) -> Results:
        """Give the results as they come."""
        waiting = list(reversed(chunks))
        try:
            while waiting or self._running:
                room = EACH * max(1, self._threads()) - len(self._running)
                for _ in range(min(room, len(waiting))):
                    self._submit(waiting.pop())
                for future in self._finished():
                    chunk, content = self._running.pop(future), self._taken(future)
                    if content is None:
                        self._again(chunk, future)
                        waiting.append(chunk)
                    else:
                        yield chunk, content
        finally:
            if self._client.status == "running":
                self._client.cancel(list(self._running))

    def _submit(self, chunk: Range) -> None:
        # two clients may carry out one campaign, or one client a chunk twice: no key is shared
        future = self._client.submit(
            parquet_of, self._text, *chunk, version=__version__, pure=False, retries=DEATHS
        )
        self._running[future] = chunk
        future.add_done_callback(self._done.put)

    def _finished(self) -> "Iterator[Future[Any]]":
        """Chunks that are done, well or not, after waiting a little for one."""
        with suppress(Empty):
            yield self._done.get(timeout=LOOK)
            while True:
                yield self._done.get_nowait()

    def _threads(self) -> int:
        """Threads of all workers; raises if the scheduler is lost, or has had none for long."""
        if self._client.status != "running":
            raise self._lost()
        try:
            workers = self._client.scheduler_info(n_workers=-1)["workers"]
        except (OSError, TimeoutError) as error:
            raise self._lost() from error
        if workers:
            self._alone_since = None
            return sum(int(worker["nthreads"]) for worker in workers.values())
        now = time.monotonic()
        if self._alone_since is None:
            self._alone_since = now
        if now - self._alone_since > PATIENCE:
            raise InputError(
                f"--scheduler {self._address}: has had no worker for {PATIENCE:.0f} s; start some "
                f"with dask worker {self._address}, and the same command goes on"
            )
        return 0

    def _taken(self, future: "Future[Any]") -> bytes | None:
        """The rows; None if they were lost with a worker."""
        from distributed import KilledWorker

        if future.status == "finished":
            try:
                return bytes(future.result(timeout=PATIENCE))
            except (OSError, TimeoutError, CancelledError, KilledWorker):
                return None  # its worker died with the rows
        if future.status in {"cancelled", "lost"}:
            if self._client.status != "running":
                raise self._lost()
            return None
        error = future.exception(timeout=CONNECTING)
        if isinstance(error, KilledWorker):
            return None
        if isinstance(error, InputError):
            raise error
        raise InputError(
            f"--scheduler {self._address}: a worker cannot carry out trials ({_said(error)}); "
            f"install parkproof[campaign] {__version__} for the workers, and the same command goes "
            "on"
        ) from error

    def _again(self, chunk: Range, future: "Future[Any]") -> None:
        """Count how often a chunk was lost; raise if it was too often."""
        self._deaths[chunk] = deaths = self._deaths.get(chunk, 0) + 1
        if deaths > DEATHS:
            raise InputError(
                f"--scheduler {self._address}: trials {chunk[0]:,} to {chunk[1] - 1:,} were lost "
                f"with their workers again and again ({future.status}); look whether they run out "
                "of memory, and the same command goes on"
            )

    def _lost(self) -> InputError:
        return InputError(
            f"--scheduler {self._address}: the scheduler was lost; what has come from it is "
            "written: start it again, and the same command goes on"
        )


def _said(error: object) -> str:
    """What an error says, in one line."""
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= 200 else f"{text[:200]}..."
