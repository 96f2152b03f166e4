"""Section 4 made anew: runs, figures, claims and the page, in one directory."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec

from parkproof import __version__
from parkproof.report.claims import claims_of
from parkproof.report.evidence import figure_runs, gather
from parkproof.report.figures import paper_figures
from parkproof.report.findings import draw_findings
from parkproof.report.page import write_page
from parkproof.report.path_picture import path_picture
from parkproof.report.style import time_of_interest
from parkproof.results import summary_of, write_summary, write_trajectory

LAWS = ("published", "corrected")
FAST = "corrected_fast"
"""The run whose figures end soon after it has parked; the others keep the paper's time axis."""


def reproduce(
    directory: Path,
    *,
    laws: tuple[str, ...] = LAWS,
    progress: Callable[[str, float], None] | None = None,
) -> dict[str, Any]:
    """Make section 4 of the paper anew.

    Parameters
    ----------
    directory : Path
        Where everything is written; it exists.
    laws : tuple of str
        "published", "corrected" or both. The table of claims compares both laws, so it is always
        made from both.
    progress : callable, optional
        Told what is being done, and the fraction done.

    Returns
    -------
    dict
        ``claims``: a list of dicts with claim, where, measured and verdict; ``runs``: a summary
        for each directory of figures.

    Examples
    --------
    >>> result = reproduce(directory, laws=("published",))
    >>> result["runs"]["published"]["outcome"]
    'finished away from the goal'
    """
    tell = progress or (lambda _text, _fraction: None)
    tell("runs of Figures 3 to 8", 0.0)
    both = figure_runs(LAWS)
    shown = {name: run for name, run in both.items() if name.split("_")[0] in laws}
    done = 0.1

    def tell_more(text: str) -> None:
        nonlocal done
        tell(text, done)
        done += 0.08

    evidence = gather(both, progress=tell_more)
    claims = claims_of(evidence)
    summaries = {}
    for name, run in shown.items():
        tell_more(f"figures of {name.replace('_', ', ')}")
        folder = directory / name
        folder.mkdir()
        paper_figures(run, folder, until=time_of_interest(run) if name == FAST else None)
        path_picture(run, folder / "path.png")
        write_trajectory(run, folder / "trajectory.parquet")
        write_summary(run, folder / "summary.json")
        summaries[name] = summary_of(run)
    tell("findings and page", 0.9)
    findings = directory / "findings"
    findings.mkdir()
    draw_findings(evidence, findings)
    write_page(directory / "index.html", runs=shown, claims=claims, evidence=evidence)
    rows = msgspec.to_builtins(claims)
    result = {"version": __version__, "claims": rows, "runs": summaries}
    (directory / "summary.json").write_bytes(msgspec.json.format(msgspec.json.encode(result)))
    tell("done", 1.0)
    return result
