"""The page of the reproduction: one self-contained HTML file."""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template

from parkproof import __version__
from parkproof.report.claims import Claim, Verdict
from parkproof.report.evidence import Evidence
from parkproof.report.findings import FINDINGS
from parkproof.report.html import STYLE_SHEET, number_text, picture
from parkproof.simulation.run import Run

NAMES = {
    "published": "As published",
    "corrected": "Corrected law, Step 3 at 25 s",
    "corrected_fast": "Corrected law, as fast as it goes",
}
CAPTIONS = {
    3: "the states (x0, u0) over time",
    4: "the states (x1, x2, u1) over time",
    5: "the control inputs (τ1, τ2) over time",
    6: "the state x_m over time",
    7: "the state y_m over time",
    8: "the state θ over time",
}
VERDICT_CLASS = {Verdict.HOLDS: "holds", Verdict.FAILS: "fails", Verdict.OPEN: "open"}

_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Section 4, made anew</title>
<style>
$style
.verdict { font-weight: 600; white-space: nowrap; }
.holds { color: #00664c; } .fails { color: #a84300; } .open { color: #57606a; }
.row { display: grid; grid-template-columns: repeat(auto-fit, minmax(360px, 1fr)); gap: 0.8rem; }
.pairs { display: grid; grid-template-columns: repeat(auto-fit, minmax(480px, 1fr));
  gap: 0.8rem; }
</style>
</head>
<body>
<h1>Section 4, made anew</h1>
<p class="lead">H. Chen, S. Ding, X. Chen, L. Wang, C. Zhu, W. Chen, <em>Global Finite-time
Stabilization for Nonholonomic Mobile Robots Based on Visual Servoing</em>, Int. J. Adv. Robot.
Syst. 2014, 11:180, doi 10.5772/59307. Every figure and every number below was computed by this
run of Parkproof $version.</p>
$runs
$claims
$figures
$findings
<footer>The true α, γ(t) and φ(t) were not published; the ones used here lie inside the published
bounds: α = (1, 1), γ<sub>i</sub> = 1.5 + 0.5 sin(t + p<sub>i</sub>), φ<sub>i</sub> = 2.5
sin(t + p<sub>i</sub>), with p = (0, π/2). The exponents q0, q1, q2 = 1/3, 9/11, 7/9 are a reading
of a damaged scan. Measured values are of simulated runs; what is sampled or only expected is called
so.</footer>
</body>
</html>
""")


def _runs(runs: Mapping[str, Run]) -> str:
    """The table of the runs that the figures show."""
    rows = []
    for name, run in runs.items():
        steps, metrics = run.settling_time.steps, run.metrics
        after = (metrics.max_abs_after_step2 or {}).get("x1")
        cells = [
            number_text(steps["1"]),
            number_text(steps["2"]),
            number_text(steps["3"]),
            number_text(metrics.residual),
            number_text(after),
            ", ".join(number_text(x) for x in metrics.peak_tau),
            ", ".join(number_text(x) for x in metrics.total_variation_tau),
        ]
        numbers = "".join(f'<td class="number">{cell}</td>' for cell in cells)
        rows.append(f"<tr><td>{NAMES[name]}</td><td>{run.outcome.value}</td>{numbers}</tr>")
    return (
        "<h2>The runs</h2><table><tr><th>Run</th><th>Outcome</th><th>Step 1 ends (s)</th>"
        "<th>Step 2 ends (s)</th><th>Step 3 ends (s)</th><th>Residual</th>"
        "<th>Largest |x1| after Step 2</th><th>Peak |τ1|, |τ2|</th>"
        "<th>Variation of τ1, τ2 per s</th></tr>" + "".join(rows) + "</table>"
        "<p>Residual: the largest of |x0|, |x1|, |x2| over the last 2 s. The inputs vary so much "
        "because both laws are in their explicit form here, as in the paper; the last section "
        "shows the implicit form.</p>"
    )


def _claims(claims: Sequence[Claim]) -> str:
    rows = "".join(
        f"<tr><td>{escape(c.claim)}</td><td>{escape(c.where)}</td><td>{escape(c.measured)}</td>"
        f'<td class="verdict {VERDICT_CLASS[c.verdict]}">{c.verdict.value}</td></tr>'
        for c in claims
    )
    return (
        "<h2>The paper's claims, beside what happens when they are run</h2>"
        "<table><tr><th>Claim</th><th>Where</th><th>What we measured</th><th>Verdict</th></tr>"
        f"{rows}</table>"
    )


def _figures(runs: Mapping[str, Run], directory: Path) -> str:
    parts = ["<h2>Figures 3 to 8</h2>"]
    for number, caption in CAPTIONS.items():
        images = [
            picture(
                (directory / name / f"figure{number}.png").read_bytes(),
                f"Figure {number}. {NAMES[name]}",
            )
            for name in runs
        ]
        heading = f"<h3>Figure {number}: {escape(caption)}</h3>"
        parts.append(f'{heading}<div class="row">{"".join(images)}</div>')
    return "".join(parts)


def _findings(evidence: Evidence, directory: Path) -> str:
    """Pictures of the findings, and the convergence study in a sentence."""
    images = []
    for name, (heading, _) in FINDINGS.items():
        image = picture((directory / "findings" / f"{name}.png").read_bytes(), heading)
        images.append(image)
    errors = "; ".join(
        f"{1e3 * step:g} ms: {error:.0e}" for step, error in evidence.plant_errors.items()
    )
    return (
        f'<h2>What was found</h2><div class="pairs">{"".join(images)}</div>'
        "<p>The plant is integrated by the classical Runge-Kutta method, in steps of at most 1 ms "
        "(0.2 ms where a signal jumps). Largest difference of any state in the first 3 s from a "
        f"run with steps of 0.25 ms: {errors}.</p>"
    )


def write_page(
    path: Path,
    *,
    runs: Mapping[str, Run],
    claims: Sequence[Claim],
    evidence: Evidence | None,
) -> None:
    """Write the page; the figures that it embeds lie in directories beside it.

    Parameters
    ----------
    path : Path
        The HTML file.
    runs : mapping of str to Run
        The runs that Figures 3 to 8 show, by the name of their directory.
    claims : sequence of Claim
        The table of claims; may be empty.
    evidence : Evidence or None
        What the findings were drawn from; None leaves them out.

    Examples
    --------
    >>> from parkproof.report.figures import paper_figures
    >>> from parkproof.report.findings import draw_findings
    >>> for name in runs:
    ...     (directory / name).mkdir()
    ...     _ = paper_figures(runs[name], directory / name)
    >>> (directory / "findings").mkdir()
    >>> _ = draw_findings(evidence, directory / "findings")
    >>> path = directory / "index.html"
    >>> write_page(path, runs=runs, claims=claims, evidence=evidence)
    >>> "What was found" in path.read_text(encoding="utf-8")
    True
    """
    text = _PAGE.substitute(
        style=STYLE_SHEET,
        version=__version__,
        runs=_runs(runs),
        claims=_claims(claims) if claims else "",
        figures=_figures(runs, path.parent),
        findings=_findings(evidence, path.parent) if evidence is not None else "",
    )
    path.write_text(text, encoding="utf-8")
