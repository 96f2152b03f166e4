"""What a person reads: tables and sentences on standard output, progress on standard error."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TextIO, cast

from rich.console import Console
from rich.table import Column, Table

from parkproof.cli.errors import discard_output

Report = Callable[[str, float], None]
"""Called with what is being done and the fraction of it that is done."""


class _PatientConsole(Console):
    """A console that outlives its reader."""

    def on_broken_pipe(self) -> None:
        """Go on silently: what the command does, and its status, do not depend on the reader."""
        discard_output()


def stdout_console() -> Console:
    """Make a console for standard output: no markup, no numbers coloured by chance.

    Returns
    -------
    rich.console.Console
        80 columns wide where the output is no terminal.

    Examples
    --------
    >>> stdout_console().print("1 [robot]")
    1 [robot]
    """
    return _PatientConsole(markup=False, highlight=False, emoji=False)


def write(text: str) -> None:
    r"""Write text for programs to standard output, exactly as it is.

    Parameters
    ----------
    text : str
        The text.

    Examples
    --------
    >>> write("{}\n")
    {}
    """
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except BrokenPipeError:
        discard_output()


def facts_table(facts: list[tuple[str, str]]) -> Table:
    """Lay out names and what they are, long texts wrapped.

    Parameters
    ----------
    facts : list of (str, str)
        The rows.

    Returns
    -------
    rich.table.Table
        Without lines.

    Examples
    --------
    >>> stdout_console().print(facts_table([("Outcome", "parked")]))
      Outcome   parked
    """
    table = Table.grid(
        Column(style="bold", no_wrap=True), Column(overflow="fold"), padding=(0, 3, 0, 0)
    )
    table.pad_edge = True
    for name, value in facts:
        table.add_row(f"  {name}", value)
    return table


def print_files(console: Console, directory: Path, names: list[str]) -> None:
    """Say where results lie.

    Parameters
    ----------
    console : Console
        Where to print.
    directory : Path
        The directory; printed on one line, to be copied.
    names : list of str
        The files in it.

    Examples
    --------
    >>> print_files(stdout_console(), Path("runs/paper"), ["summary.json", "path.png"])
    Results in runs/paper
      summary.json, path.png
    """
    console.print(f"Results in {directory}", soft_wrap=True, style="bold")
    console.print(_indented(", ".join(names)))


def _indented(text: str) -> Any:
    from rich.padding import Padding

    return Padding(text, (0, 0, 0, 2))


class _Tolerant:
    """A stream that may go away, as a terminal that is closed, without a word.

    Parameters
    ----------
    stream : TextIO
        What is written to.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write, if that is possible."""
        with suppress(OSError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Have written, if that is possible."""
        with suppress(OSError):
            self._stream.flush()


def _stderr_console() -> Console:
    """A console for bars: what is done matters more than they do."""
    stream = cast("TextIO", _Tolerant(sys.stderr))
    return Console(file=stream, markup=False, highlight=False)


Count = Callable[[int, int], None]
"""Called with how many are done, and of how many."""


@contextmanager
def counted(unit: str, *, quiet: bool = False) -> Iterator[Count]:
    """Show a bar with rate and time left on standard error, if that is a terminal.

    Parameters
    ----------
    unit : str
        What is counted.
    quiet : bool
        Show none.

    Yields
    ------
    callable
        Takes how many are done, and of how many; what is done at the first call was done before.

    Examples
    --------
    >>> with counted("trials", quiet=True) as count:
    ...     count(3, 10)
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = _stderr_console()
    with Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=None),
        TextColumn("{task.fields[rate]}", markup=False),
        TimeRemainingColumn(),
        TextColumn("left", markup=False),
        console=console,
        transient=True,
        disable=quiet or not console.is_terminal,
        expand=True,
    ) as bar:
        task = bar.add_task("starting", total=None, start=False, rate="")

        def count(done: int, of: int) -> None:
            said = f"{done:,} of {of:,} {unit}"
            if not bar.tasks[task].started:
                bar.update(task, description=said, total=of, completed=done)
                bar.start_task(task)
                return
            bar.update(task, description=said, completed=done)
            speed = bar.tasks[task].speed
            bar.update(task, rate=f"{speed:,.0f} {unit}/s" if speed else "")

        yield count


@contextmanager
def progress(*, quiet: bool = False) -> Iterator[Report]:
    """Show a bar on standard error while something is done, if that is a terminal.

    Parameters
    ----------
    quiet : bool
        Show none.

    Yields
    ------
    callable
        Takes what is being done and the fraction done, 0 to 1.

    Examples
    --------
    >>> with progress(quiet=True) as report:
    ...     report("simulating", 0.5)
    """
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = _stderr_console()
    shown = not quiet and console.is_terminal
    with Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=None),
        TimeElapsedColumn(),
        console=console,
        transient=True,
        disable=not shown,
        expand=True,
    ) as bar:
        task = bar.add_task("", total=1.0)

        def report(doing: str, fraction: float) -> None:
            bar.update(task, description=doing, completed=fraction)

        yield report
