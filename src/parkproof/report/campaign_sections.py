"""Sections of a campaign's page on how its trials went: outcomes, times, other metrics."""

import math
from collections.abc import Mapping
from html import escape

from parkproof.report.campaign_page import Heading, code_of, source_of, table_of
from parkproof.report.distributions import LEVELS, METRICS, SETTLING, Metric, Spread
from parkproof.report.html import number_text, picture
from parkproof.report.success import Success
from parkproof.simulation.outcome import Outcome


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
        f"this page was made; {code_of(heading.command)} goes on with the others.</p>"
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
        + table_of(("Outcome", "Trials", "Per cent"), rows)
        + source_of(heading, found.trials)
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
    table = table_of([*head, "Proved at most"] if proven else head, rows)
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
        return "<h2>Time until parked</h2><p>No trial parked.</p>" + source_of(
            heading, heading.trials
        )
    caption = f"Time until parked of the {spread.count:,} trials that parked"
    return (
        "<h2>Time until parked</h2>"
        + f'<div class="single">{picture(drawing, caption, kind="svg")}</div>'
        + spreads_table({SETTLING: spread}, proven, heading.trials)
        + source_of(heading, heading.trials)
    )


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
        + source_of(heading, heading.trials)
    )
