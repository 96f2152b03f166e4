"""The page of a campaign: its sections as HTML, from what was found."""

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from string import Template

from parkproof.report.deciders import Decider
from parkproof.report.distributions import LEVELS, METRICS, SETTLING, Metric, Spread
from parkproof.report.html import STYLE_SHEET, number_text, picture
from parkproof.report.success import Success
from parkproof.report.violations import AgainstProof
from parkproof.report.worst_trials import WorstTrial
from parkproof.simulation.outcome import Outcome

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
        lead=f"{escape(heading.description)} Made by {_code(heading.command)}.",
        sections="\n".join(part for part in sections if part),
        version=escape(heading.version),
    )


def _code(command: str) -> str:
    return f"<code>{escape(command)}</code>"


def _replay(heading: Heading, trial: int) -> str:
    return _code(f"parkproof replay {shlex.quote(heading.directory)} {trial}")


def _source(heading: Heading, trials: int, what: str = "trials") -> str:
    """Under a section: from how many trials its numbers are, and what made them."""
    return f'<p class="source">From {trials:,} {escape(what)}; {_code(heading.command)}</p>'


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], *, numbers_from: int = 1) -> str:
    """A table of HTML cells that may be scrolled sideways on a small screen."""
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


def unfinished(heading: Heading) -> str:
    """Say so if trials are missing.

    Parameters
    ----------
    heading : Heading
        What was run.

    Returns
    -------
    str
        HTML; empty if none is.
    """
    if heading.trials >= heading.asked:
        return ""
    return (
        f'<p class="notice">{heading.trials:,} of {heading.asked:,} trials were carried out when '
        f"this page was made; {_code(heading.command)} goes on with the others.</p>"
    )


def alarm(heading: Heading, found: AgainstProof, *, note: str) -> str:
    """Name the trials that contradict the certificate.

    Parameters
    ----------
    heading : Heading
        What was run.
    found : AgainstProof
        The comparison.
    note : str
        What sampling may have to do with it, in plain text.

    Returns
    -------
    str
        HTML; empty if there are none.
    """
    if not found.violating:
        return ""
    count, among = found.violating, int(found.covered.sum())
    rows = []
    for one in found.named:
        broken = [
            "did not park"
            if math.isinf(each.worst)
            else f"{escape(each.name)}: {number_text(each.worst)}, "
            f"proved {number_text(each.proven)}"
            for each in one.broken
        ]
        rows.append([str(one.trial), "<br>".join(broken), _replay(heading, one.trial)])
    more = count - len(rows)
    return (
        '<div class="alarm" role="alert">'
        f"<h2>Alarm: {count:,} {'trial contradicts' if count == 1 else 'trials contradict'} the "
        f"certificate</h2><p>Of {among:,} trials that it speaks of.</p>"
        + _table(("Trial", "Beyond what is proved", "Replay it"), rows, numbers_from=9)
        + (f"<p>And {more:,} more.</p>" if more else "")
        + f"<p>{escape(note)}</p></div>"
    )


def percentages(found: Success) -> tuple[str, str, str]:
    """Share and both ends of its interval in per cent, with the digits that the interval warrants.

    Parameters
    ----------
    found : Success
        The interval.

    Returns
    -------
    three strings
        The ends are rounded outwards.

    Examples
    --------
    >>> percentages(Success(parked=999, trials=1000, low=0.99444, high=0.99997, confidence=0.95))
    ('99.90', '99.44', '100')
    """
    width = 100.0 * (found.high - found.low)
    digits = min(max(1, 1 - math.floor(math.log10(width))), 8) if width > 0.0 else 8
    unit = 10.0**digits
    share = 100.0 * found.parked / found.trials if found.trials else math.nan
    low = math.floor(100.0 * found.low * unit) / unit
    high = math.ceil(100.0 * found.high * unit) / unit
    one, two, three = (
        f"{value:g}" if value in {0.0, 100.0} else f"{value:.{digits}f}"
        for value in (share, low, high)
    )
    return one, two, three


def outcomes_section(heading: Heading, found: Success, counts: Mapping[Outcome, int]) -> str:
    """How many trials parked, and how the others ended.

    Parameters
    ----------
    heading : Heading
        What was run.
    found : Success
        Share and interval.
    counts : mapping of Outcome to int
        The most frequent first.

    Returns
    -------
    str
        HTML.
    """
    if not found.trials:
        return "<h2>How many parked</h2><p>No trial was carried out yet.</p>"
    share, low, high = percentages(found)
    even = (
        ""
        if heading.independent
        else " The trials are points of a scrambled Sobol' sequence, which fill the space more "
        "evenly than independent draws; for those the interval is exact."
    )
    rows = [
        [escape(outcome.value), f"{count:,}", number_text(100.0 * count / found.trials)]
        for outcome, count in counts.items()
    ]
    return (
        "<h2>How many parked</h2>"
        f'<p class="rate">{found.parked:,} of {found.trials:,} trials parked: {share} %</p>'
        f"<p>{100.0 * found.confidence:g} % confidence interval of the probability to park: "
        f"{low} % to {high} % (Clopper-Pearson, exact).{even}</p>"
        + _table(("Outcome", "Trials", "Per cent"), rows)
        + _source(heading, found.trials)
    )


def spreads_table(
    spreads: Mapping[Metric, Spread], proven: Mapping[str, float], trials: int
) -> str:
    """Quantiles of metrics, beside what is proved.

    Parameters
    ----------
    spreads : mapping of Metric to Spread
        A row each.
    proven : mapping of str to float
        Proved numbers by name; may be empty.
    trials : int
        Of all.

    Returns
    -------
    str
        HTML.
    """
    names = {0.0: "Least", 0.5: "Median", 1.0: "Largest"}
    head = ["", "Trials", *(names.get(level, f"{100.0 * level:g} %") for level in LEVELS)]
    rows = []
    for metric, spread in spreads.items():
        values = spread.quantiles or (None,) * len(LEVELS)
        row = [escape(metric.label), f"{spread.count:,}", *map(number_text, values)]
        rows.append([*row, number_text(proven.get(metric.proven))] if proven else row)
    missing = max((spread.missing for spread in spreads.values()), default=0)
    remark = f"<p>A trial that has no value is left out: up to {missing:,} of {trials:,}.</p>"
    table = _table([*head, "Proved at most"] if proven else head, rows)
    return table + (remark if missing else "")


def settling_section(
    heading: Heading, drawing: bytes, spread: Spread, proven: Mapping[str, float]
) -> str:
    """How long the trials took.

    Parameters
    ----------
    heading : Heading
        What was run.
    drawing : bytes
        The histogram, SVG.
    spread : Spread
        Of the trials that parked.
    proven : mapping of str to float
        Proved numbers by name; may be empty.

    Returns
    -------
    str
        HTML.
    """
    if not spread.count:
        return "<h2>Time until parked</h2><p>No trial parked.</p>" + _source(
            heading, heading.trials
        )
    caption = f"Time until parked of the {spread.count:,} trials that parked"
    return (
        "<h2>Time until parked</h2>"
        + f'<div class="single">{picture(drawing, caption, kind="svg")}</div>'
        + spreads_table({SETTLING: spread}, proven, heading.trials)
        + _source(heading, heading.trials)
    )


def proof_section(
    heading: Heading, found: AgainstProof, *, name: str, statement: Sequence[str]
) -> str:
    """What a certificate proves, beside the worst of the trials that it speaks of.

    Parameters
    ----------
    heading : Heading
        What was run.
    found : AgainstProof
        The comparison.
    name : str
        Of the certificate's file.
    statement : sequence of str
        What it proves, in plain text.

    Returns
    -------
    str
        HTML.
    """
    count = int(found.covered.sum())
    lines = "<br>".join(map(escape, statement))
    parts = [
        "<h2>Beside the proof</h2>",
        f"<p>{_code(name)}, proved again for this page:</p>",
        f"<details><summary>The theorem</summary><p>{lines}</p></details>",
        f"<p>It speaks of {count:,} of {heading.trials:,} trials."
        + (" Not counted are:</p>" if found.outside else "</p>"),
    ]
    if found.outside:
        reasons = (f"<li>{escape(why)}: {n:,}</li>" for why, n in found.outside.items())
        parts.append(f"<ul>{''.join(reasons)}</ul>")
    if found.compared:
        rows = [
            [
                escape(one.name),
                number_text(one.proven),
                "not parked" if one.worst == math.inf else number_text(one.worst),
                "–" if math.isinf(one.worst) else number_text(one.ratio),
            ]
            for one in found.compared
        ]
        head = ("Number", "Proved", "Worst trial", "Worst / proved")
        parts.append(_table(head, rows))
    return "".join(parts) + _source(heading, count, "trials that the certificate speaks of")


def metrics_section(
    heading: Heading,
    drawings: Mapping[Metric, bytes],
    spreads: Mapping[Metric, Spread],
    proven: Mapping[str, float],
) -> str:
    """Residuals, inputs and excursions.

    Parameters
    ----------
    heading : Heading
        What was run.
    drawings : mapping of Metric to bytes
        Histograms, SVG.
    spreads : mapping of Metric to Spread
        Of all metrics.
    proven : mapping of str to float
        Proved numbers by name; may be empty.

    Returns
    -------
    str
        HTML.
    """
    images = (
        picture(data, f"{metric.label}, {spreads[metric].count:,} trials", kind="svg")
        for metric, data in drawings.items()
    )
    return (
        "<h2>Residuals, inputs, excursions</h2>"
        f'<div class="grid">{"".join(images)}</div>'
        + spreads_table({metric: spreads[metric] for metric in METRICS}, proven, heading.trials)
        + _source(heading, heading.trials)
    )


def sensitivity_section(heading: Heading, found: Sequence[Decider], *, trials: int) -> str:
    """Which uncertainty matters most.

    Parameters
    ----------
    heading : Heading
        What was run.
    found : sequence of Decider
        An output each.
    trials : int
        Carried out for it.

    Returns
    -------
    str
        HTML.
    """
    said = [
        f"<h3>{escape(one.question)}</h3><p>{escape(one.answer)}</p>"
        for one in found
        if one.drawing is None
    ]
    drawn = [
        f"<div><h3>{escape(one.question)}</h3>{picture(one.drawing, one.answer, kind='svg')}</div>"
        for one in found
        if one.drawing is not None
    ]
    explained = (
        "<p>Sobol' indices: the share of an output's variance that a drawn quantity accounts for "
        "alone (first order), and together with all others (total). Lines: 95 % intervals, from "
        "400 resamples. A trial that does not park counts with the duration of the run, and a "
        "distance with its logarithm.</p>"
        if trials
        else ""
    )
    source = (
        _source(heading, trials, "further trials from the same distributions") if trials else ""
    )
    return (
        "<h2>Which uncertainty matters most</h2>"
        f'{explained}{"".join(said)}<div class="grid">{"".join(drawn)}</div>{source}'
    )


@dataclass(frozen=True)
class Rerun:
    """A trial that was carried out again to be drawn.

    Attributes
    ----------
    trial : WorstTrial
        As the table has it.
    drawing : bytes
        Its path, PNG.
    outcome : Outcome
        How the new run ended.
    """

    trial: WorstTrial
    drawing: bytes
    outcome: Outcome


def worst_section(heading: Heading, found: Sequence[Rerun]) -> str:
    """The worst trials with their paths.

    Parameters
    ----------
    heading : Heading
        What was run.
    found : sequence of Rerun
        The worst first.

    Returns
    -------
    str
        HTML.
    """
    if not found:
        return ""
    title = "The worst trial" if len(found) == 1 else f"The {len(found)} worst trials"
    images = []
    for one in found:
        trial = one.trial
        when = (
            f" after {number_text(trial.total)} s"
            if trial.outcome is Outcome.PARKED
            else f", run ended at {number_text(trial.ended)} s"
        )
        text = f"Trial {trial.trial}: {trial.outcome.value}{when}"
        if not math.isnan(trial.residual):
            text += f", residual {number_text(trial.residual)}"
        note = f"<br>{_replay(heading, trial.trial)}"
        if one.outcome is not trial.outcome:
            note += (
                f"<br>Carried out again in plain arithmetic, it ended: {escape(one.outcome.value)}."
            )
        images.append(picture(one.drawing, text, note=note))
    return (
        f"<h2>{title}</h2>"
        "<p>Those that did not park first, then the slowest, then those with the largest residual; "
        "the first of equals. Each was carried out again to be drawn.</p>"
        f'<div class="grid">{"".join(images)}</div>' + _source(heading, heading.trials)
    )
