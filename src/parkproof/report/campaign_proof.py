"""Parts of a campaign's page that compare its trials with a certificate."""

import math
from collections.abc import Sequence
from html import escape

from parkproof.report.campaign_page import Heading, code_of, replay_of, source_of, table_of
from parkproof.report.html import number_text
from parkproof.report.violations import AgainstProof


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
        rows.append([str(one.trial), "<br>".join(broken), replay_of(heading, one.trial)])
    more = count - len(rows)
    return (
        '<div class="alarm" role="alert">'
        f"<h2>Alarm: {count:,} {'trial contradicts' if count == 1 else 'trials contradict'} the "
        f"certificate</h2><p>Of {among:,} trials that it speaks of.</p>"
        + table_of(("Trial", "Beyond what is proved", "Replay it"), rows, numbers_from=9)
        + (f"<p>And {more:,} more.</p>" if more else "")
        + f"<p>{escape(note)}</p></div>"
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
        f"<p>{code_of(name)}, proved again for this page:</p>",
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
        parts.append(table_of(head, rows))
    return "".join(parts) + source_of(heading, count, "trials that the certificate speaks of")
