"""The files that a run leaves: its numbers, its scenario, its pictures."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from parkproof.cli.console import Report
    from parkproof.scenario import Scenario
    from parkproof.simulation.run import Run


def carry_out(scenario: "Scenario", directory: Path, report: "Report") -> "Run":
    """Simulate, and write the run's numbers.

    Parameters
    ----------
    scenario : Scenario
        What to run.
    directory : Path
        Where to write summary.json, trajectory.parquet and scenario.toml.
    report : callable
        Told how far it is.

    Returns
    -------
    Run
        What was run.

    Examples
    --------
    >>> carry_out(run.scenario, directory, lambda doing, fraction: None).outcome.value
    'parked'
    """
    from parkproof.results import write_summary, write_trajectory
    from parkproof.scenario_file import to_toml
    from parkproof.simulation.run import simulate

    report("simulating", 0.0)
    run = simulate(scenario, progress=lambda fraction: report("simulating", fraction))
    report("writing", 0.0)
    write_summary(run, directory / "summary.json")
    write_trajectory(run, directory / "trajectory.parquet")
    (directory / "scenario.toml").write_text(to_toml(scenario), encoding="utf-8")
    return run


def draw(run: "Run", directory: Path, report: "Report") -> None:
    """Draw all pictures of a run.

    Parameters
    ----------
    run : Run
        What was run.
    directory : Path
        Where to write them.
    report : callable
        Told how far it is.
    """
    from parkproof.report.animation import animation
    from parkproof.report.figures import paper_figures, plot
    from parkproof.report.path_picture import path_picture

    report("drawing", 0.0)
    paper_figures(run, directory)
    report("drawing", 0.5)
    for ending in ("png", "svg"):
        path_picture(run, directory / f"path.{ending}")
    plot(run, directory / "overview.png")
    report("drawing the animation", 0.8)
    animation(run, directory / "animation.gif")
