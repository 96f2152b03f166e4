"""Work that the loop must not wait for: done in order by one thread beside it."""

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import Any, Self

from parkproof.errors import InputError


class Worker:
    """Does jobs one after the other in a thread of its own, until one of them fails.

    Parameters
    ----------
    name : str
        What it does, for the sentence when it fails.
    capacity : int
        Largest number of bulky jobs that wait.
    realtime : bool
        What happens to a bulky job when so many wait: with True it is refused, so that the loop
        goes on; with False, for a loop on simulated time, the loop waits.

    Examples
    --------
    >>> done = []
    >>> worker = Worker("counting", capacity=2, realtime=False)
    >>> all(worker.do(lambda i=i: done.append(i), bulky=True) for i in range(5))
    True
    >>> worker.close()
    >>> done, worker.fault
    ([0, 1, 2, 3, 4], None)
    """

    def __init__(self, name: str, *, capacity: int, realtime: bool) -> None:
        self._name = name
        self._realtime = realtime
        self._free = threading.Semaphore(capacity)
        self._executor = ThreadPoolExecutor(max_workers=1, thread_name_prefix=f"parkproof {name}")
        self._failure: BaseException | None = None
        self._closed = False

    @property
    def fault(self) -> str | None:
        """Why it does no more, in a sentence; None while all is well."""
        if self._failure is None:
            return None
        why = self._failure
        cause = (why.strerror if isinstance(why, OSError) else None) or str(why)
        return f"{self._name} stopped: {' '.join(cause.split())}"

    def do(self, job: Callable[[], None], *, bulky: bool = False) -> bool:
        """Have a job done; False if it is refused, or an earlier one failed."""
        if self._failure is not None or self._closed:
            return False
        if bulky and not self._free.acquire(blocking=not self._realtime):
            return False
        future = self._executor.submit(self._run, job)
        future.add_done_callback(self._release if bulky else self._keep_failure)
        return True

    def _run(self, job: Callable[[], None]) -> None:
        if self._failure is None:
            job()

    def _release(self, future: "Future[Any]") -> None:
        self._keep_failure(future)
        self._free.release()

    def _keep_failure(self, future: "Future[Any]") -> None:
        if self._failure is None:
            self._failure = future.exception()

    def close(self) -> None:
        """Finish all jobs. What failed for a reason other than the outside's is raised here."""
        self._closed = True
        self._executor.shutdown(wait=True)
        if self._failure is not None and not isinstance(self._failure, OSError | InputError):
            raise self._failure


class WrittenBeside:
    """A file that a worker writes, whole at the end of a ``with`` block.

    Parameters
    ----------
    worker : Worker
        What writes it.
    """

    def __init__(self, worker: Worker) -> None:
        self._worker = worker
        self._closed = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Write what still waits, and close the file. May be called twice."""
        if self._closed:
            return
        self._closed = True
        self._flush()
        self._worker.do(self._finish)
        try:
            self._worker.close()
        finally:
            self._let_go()

    def _flush(self) -> None:
        """Have written what was not handed over yet."""

    def _finish(self) -> None:
        """Write the end, in the thread beside."""
        raise NotImplementedError

    def _let_go(self) -> None:
        """Let go of the file, whether it is whole or not."""
        raise NotImplementedError
