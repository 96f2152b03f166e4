"""The frame of a campaign's page, and what its sections have in common."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from string import Template

from parkproof.report.html import STYLE_SHEET

_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>
$style
.alarm { border: 3px solid #a84300; background: #fdf1e7; padding: 0 1rem 0.5rem;
  margin: 1rem 0; }
.alarm h2 { color: #a84300; margin-top: 0.8rem; }
.notice { border-left: 4px solid #e69f00; padding: 0.2rem 0.8rem; background: #fdf8ec; }
.source { font-size: 0.85rem; color: #57606a; }
.rate { font-size: 1.5rem; font-weight: 600; }
.wide { overflow-x: auto; }
.grid { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 380px), 1fr));
  gap: 0.8rem; }
.single { max-width: 760px; }
code { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: 0.88em;
  overflow-wrap: anywhere; }
@media (max-width: 600px) { body { padding: 0.8rem; } th, td { padding: 0.35rem 0.4rem; }
  td:first-child { min-width: 8em; } }
</style>
</head>
<body>
<h1>$title</h1>
<p class="lead">$lead</p>
$sections
<footer>Residual: the largest of |x0|, |x1|, |x2| in the last 2 s of a trial. Lengths are in image
units, inputs in those of the chained form. A trial ends early where it diverges or a limit is
reached. Everything on this page is of simulated runs, but for what is called proved. Parkproof
$version.</footer>
</body>
</html>
""")


@dataclass(frozen=True)
class Heading:
    """What was run, for the top of the page and the line under each section.

    Attributes
    ----------
    title : str
        Of the page.
    description : str
        What the trials are, in plain text.
    directory : str
        As the commands that replay a trial name it.
    command : str
        What made the trials.
    trials, asked : int
        Carried out, and asked for.
    independent : bool
        Whether the trials were drawn independently of each other.
    version : str
        Of the package.
    """

    title: str
    description: str
    directory: str
    command: str
    trials: int
    asked: int
    independent: bool
    version: str


def page_of(heading: Heading, sections: Sequence[str]) -> str:
    """Put the page together.

    Parameters
    ----------
    heading : Heading
        What was run.
    sections : sequence of str
        HTML.

    Returns
    -------
    str
        The HTML file.
    """
    return _PAGE.substitute(
        title=escape(heading.title),
        style=STYLE_SHEET,
        lead=f"{escape(heading.description)} Made by {code_of(heading.command)}.",
        sections="\n".join(part for part in sections if part),
        version=escape(heading.version),
    )


def code_of(command: str) -> str:
    """Mark a command.

    Parameters
    ----------
    command : str
        A line for a shell.

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> code_of("parkproof verify <file>")
    '<code>parkproof verify &lt;file&gt;</code>'
    """
    return f"<code>{escape(command)}</code>"


def replay_of(heading: Heading, trial: int) -> str:
    """Give the command that carries a trial out again.

    Parameters
    ----------
    heading : Heading
        What was run.
    trial : int
        Number of the trial.

    Returns
    -------
    str
        HTML.
    """
    return code_of(f"parkproof replay {shlex.quote(heading.directory)} {trial}")


def source_of(heading: Heading, trials: int, what: str = "trials") -> str:
    """Say below a section from how many trials its numbers are, and what made them.

    Parameters
    ----------
    heading : Heading
        What was run.
    trials : int
        How many.
    what : str
        What they are called.

    Returns
    -------
    str
        HTML.
    """
    return f'<p class="source">From {trials:,} {escape(what)}; {code_of(heading.command)}</p>'


def table_of(head: Sequence[str], rows: Sequence[Sequence[str]], *, numbers_from: int = 1) -> str:
    """Make a table that may be scrolled sideways on a small screen.

    Parameters
    ----------
    head : sequence of str
        Names of the columns, as text.
    rows : sequence of sequences of str
        Cells, as HTML.
    numbers_from : int
        The first column of numbers.

    Returns
    -------
    str
        HTML.
    """
    body = "".join(
        "<tr>"
        + "".join(
            f'<td class="number">{cell}</td>' if i >= numbers_from else f"<td>{cell}</td>"
            for i, cell in enumerate(row)
        )
        + "</tr>"
        for row in rows
    )
    names = "".join(f"<th>{escape(name)}</th>" for name in head)
    return f'<div class="wide"><table><tr>{names}</tr>{body}</table></div>'
