"""The one place where what goes wrong becomes a line on standard error and an exit status."""

import contextlib
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType
from typing import TYPE_CHECKING

from parkproof.errors import InputError, StoppedError

if TYPE_CHECKING:
    from cyclopts import CycloptsError

BAD_INPUT = 2

ONE_STOP = 2.0
"""Signals within this many seconds are one: terminals and supervisors often send it twice."""

SOON = 0.05
"""Seconds after which a stop that Python swallowed is tried again."""


def guarded(command: Callable[[], int]) -> int:
    """Call a command; what a user can cause becomes one line on standard error and a status.

    Parameters
    ----------
    command : callable
        Returns an exit status.

    Returns
    -------
    int
        Its status; 2 after bad input or an error of the operating system; 128 plus the number of
        the signal that stopped it.

    Examples
    --------
    >>> guarded(lambda: 0)
    0
    """
    status = 0
    with _stops() as arrived:
        try:
            _ensure_streams()
            status = command()
            sys.stdout.flush()
        except (Exception, KeyboardInterrupt) as error:
            if arrived:  # whatever a library has made of the exception that the signal raised
                status = _stopped(arrived[0], error)
            elif isinstance(error, KeyboardInterrupt):
                status = _stopped(signal.SIGINT, error)
            elif not isinstance(error, BrokenPipeError):
                status = _bad_input(error)
            else:  # whoever read the output, such as head, has had enough of it
                discard_output()
        except SystemExit as error:
            if not isinstance(error.code, int) or error.code <= 128:
                raise
            status = _stopped(error.code - 128, error)  # what stops a robot takes more signals
    return status


def _stopped(number: int, error: BaseException) -> int:
    """Say that a signal stopped the program; the status is what shells make of it."""
    who = "Ctrl-C" if number == signal.SIGINT else signal.Signals(number).name
    told = str(error) if isinstance(error, StoppedError) else ""
    left = told or "no half-written result is left; run the command again"
    _tell(f"stopped by {who}; {left}", error)
    return 128 + number


def _bad_input(error: BaseException) -> int:
    """Say what a user can mend; anything else is an error in this program and goes on as it is."""
    if isinstance(error, InputError):
        _tell(str(error), error)
    elif isinstance(error, MemoryError):
        _tell("out of memory; write a longer control_period or a shorter duration in [run]")
    elif isinstance(error, OSError):
        _tell(why_not(error))
        try:
            sys.stdout.flush()
        except OSError:  # it was the output, and would fail once more when Python ends
            discard_output()
    else:
        raise error
    return BAD_INPUT


def why_not(error: OSError) -> str:
    """Say in one line what the operating system refused, and what to do.

    Parameters
    ----------
    error : OSError
        The refusal.

    Returns
    -------
    str
        One line.

    Examples
    --------
    >>> import errno
    >>> why_not(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "gains.toml"))
    'cannot use gains.toml: No space left on device; free some space, or write to another disk'
    >>> why_not(PermissionError(errno.EACCES, os.strerror(errno.EACCES)))
    'cannot write the output: Permission denied; choose another place to write to'
    """
    what = f"use {error.filename}" if error.filename else "write the output"
    full = isinstance(error.errno, int) and os.strerror(error.errno).startswith("No space")
    remedy = (
        "free some space, or write to another disk" if full else "choose another place to write to"
    )
    return f"cannot {what}: {error.strerror or error}; {remedy}"


def discard_output() -> None:
    """Throw away what is still to be written to standard output, where nothing can be written."""
    with contextlib.suppress(OSError, ValueError):  # a standard output that is no file
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def usage_error(error: "CycloptsError") -> InputError:
    """Say in one line why a command line cannot be understood, and where to read on.

    Parameters
    ----------
    error : CycloptsError
        What the parser says.

    Returns
    -------
    InputError
        The same for `guarded`.

    Examples
    --------
    >>> from cyclopts import UnusedCliTokensError
    >>> print(usage_error(UnusedCliTokensError(unused_tokens=["more"], command_chain=["park"])))
    unexpected argument "more". See: parkproof park --help
    """
    from cyclopts import UnusedCliTokensError

    if isinstance(error, UnusedCliTokensError) and error.unused_tokens:
        cause = f'unexpected argument "{error.unused_tokens[0]}".'
    else:
        cause = str(error)
    return InputError(
        f"{cause} See: {' '.join(('parkproof', *(error.command_chain or ())))} --help"
    )


def _tell(message: str, error: BaseException | None = None) -> None:
    """Write one line to standard error, whatever the message and the error's notes hold."""
    message = "; ".join((message, *getattr(error, "__notes__", ())))
    line = "".join(c if c.isprintable() else repr(c)[1:-1] for c in " ".join(message.split()))
    with contextlib.suppress(OSError):  # nowhere to write it; the status still says it
        print(f"parkproof: {line}", file=sys.stderr, flush=True)


def _ensure_streams() -> None:
    """Make sure that there are streams, and that they can write every character somehow."""
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
    reconfigure = getattr(sys.stdout, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors="backslashreplace")


@contextlib.contextmanager
def _stops() -> Iterator[list[int]]:
    """Let Ctrl-C and requests to terminate raise an exception, so that everything is cleaned up.

    Yields the signals that have arrived.
    """
    arrived: list[int] = []
    last = -math.inf

    def stop(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
        nonlocal last
        now = time.monotonic()
        if now - last > ONE_STOP:
            last = now
            arrived.append(number)
            raise KeyboardInterrupt

    def swallowed(what: "sys.UnraisableHookArgs") -> None:
        """Stop a moment later where Python lets no exception through, as in a finaliser."""
        nonlocal last
        error = what.exc_value
        if isinstance(error, KeyboardInterrupt) or (
            error is not None and isinstance(error.__context__, KeyboardInterrupt)
        ):
            last = -math.inf
            threading.Timer(SOON, signal.raise_signal, (arrived[-1],)).start()
        else:
            hook(what)

    hook, sys.unraisablehook = sys.unraisablehook, swallowed
    before = {}
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)  # there is no SIGHUP on Windows
        # A signal that whoever started us has set to be ignored, as nohup does, stays ignored.
        if number is not None and signal.getsignal(number) not in {signal.SIG_IGN, None}:
            with contextlib.suppress(ValueError):  # not the main thread: signals do not come here
                before[number] = signal.signal(number, stop)
    try:
        yield arrived
    finally:
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)
