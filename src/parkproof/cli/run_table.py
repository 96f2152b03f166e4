"""The table that ``parkproof park`` prints at the end of a run."""

from typing import TYPE_CHECKING, Any

from parkproof.cli.console import facts_table
from parkproof.results import summary_of

if TYPE_CHECKING:
    from rich.console import Console

    from parkproof.simulation.run import Run

_STEPS = {"0": "turn", "1": "run-up", "2": "approach", "3": "return"}


def print_run(console: "Console", run: "Run") -> None:
    """Print how a run went.

    Parameters
    ----------
    console : Console
        Where to print.
    run : Run
        A run that has been carried out.

    Examples
    --------
    >>> print_run(console, run)
    """
    summary = summary_of(run)
    console.print(f"{summary['title'] or 'Untitled run'} ({summary['law']} law)", style="bold")
    console.print()
    console.print(facts_table(_facts(summary)))
    console.print()
    for note in summary["notes"]:
        console.print(f"Note: {note}", style="yellow")
    if summary["notes"]:
        console.print()


def _facts(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Names and values of the table."""
    times = summary["settling_time"]
    total = times["total"]
    bend = summary["least_distance_to_90_deg"]
    facts = [
        ("Outcome", summary["outcome"]),
        ("", summary["sentence"]),
        ("Assumptions", summary["assumptions"]),
        ("Settled after", "not settled" if total is None else f"{_number(total)} s"),
    ]
    for step, ended in times["steps"].items():
        name = f"  Step {step}, {_STEPS[step]}"
        facts.append((name, "did not end" if ended is None else f"ended at {_number(ended)} s"))
    if summary["returns"]:
        times_back = "once" if summary["returns"] == 1 else f"{summary['returns']} times"
        facts.append(("  Back to run-up", times_back))
    facts += [
        ("Run ended at", f"{_number(summary['ended'])} s"),
        ("Residual", f"{_number(summary['residual'])} (largest |x0|, |x1|, |x2| of the last 2 s)"),
        ("Peak input", _both(summary["peak_tau"])),
        ("RMS input", _both(summary["rms_tau"])),
        ("Chatter", f"{_both(summary['total_variation_tau'])} (total variation per second)"),
        ("Excursion", f"{_number(summary['excursion'])} image units from the goal"),
        ("Path length", f"{_number(summary['path_length'])} image units"),
        ("Heading", f"{_number(bend)}° from ±90° at the closest" if bend >= 0 else "beyond ±90°"),
        ("Largest speed", f"|v| {_number(summary['max_speed'])} length/s"),
        ("Largest turn rate", f"|ω| {_number(summary['max_turn_rate'])} rad/s"),
    ]
    return facts


def _both(values: list[float | None]) -> str:
    return f"τ1 {_number(values[0])}, τ2 {_number(values[1])}"


def _number(value: float | None) -> str:
    """A number a person can read; a summary holds null where there is no finite number."""
    return "not finite" if value is None else f"{value:.4g}"
