"""A million parks: both laws in both forms, from everywhere inside the paper's bounds.

Run it from the repository root::

    python benchmarks/million.py [--trials 1000000] [--out campaigns/million]

It carries out the campaign paper_bounds.toml four times, and once the template of "parkproof init
--kind campaign", whose robots start with any heading and turn first. Each leaves its report; then
the table of docs/campaigns.md is printed, and its picture drawn. Stopped at any moment, the same
command goes on.
"""

import argparse
import resource
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from parkproof.campaign.definition import read_campaign
from parkproof.campaign.run import run_campaign
from parkproof.campaign.table import file_of, outcomes_of, read_rows, written_ranges
from parkproof.cli.campaign import processors
from parkproof.cli.console import counted, progress
from parkproof.report.campaign import write_report
from parkproof.report.style import BLUE, GREEN, VERMILION, drawing, new_figure, save
from parkproof.report.success import success_of
from parkproof.scenario_file import template

BOUNDS = Path(__file__).with_name("paper_bounds.toml")


class Kind(NamedTuple):
    """A campaign: what it is called, its folder, what it sets, and its line in the picture."""

    name: str
    folder: str
    settings: tuple[str, ...]
    colour: str
    dashes: str


KINDS = (
    Kind("published, explicit", "published-explicit",
         ("law=published", "run.discretisation=explicit"), VERMILION, "--"),
    Kind("published, implicit", "published-implicit", ("law=published",), VERMILION, "-"),
    Kind("corrected, explicit", "corrected-explicit",
         ("run.discretisation=explicit",), BLUE, "--"),
    Kind("corrected, implicit", "corrected-implicit", (), BLUE, "-"),
    Kind("corrected, implicit, any heading", "any-heading", (), GREEN, "-"),
)  # fmt: skip


class Found(NamedTuple):
    """What a campaign came to: outcomes, times of those that parked, residuals, and wall time."""

    outcomes: dict[str, int]
    totals: NDArray[np.float64]
    residuals: NDArray[np.float64]
    seconds: float | None


def carried_out(kind: Kind, out: Path, trials: int) -> Found:
    """Carry a campaign out, or what is missing of it, with its report, and read its rows."""
    file = BOUNDS
    if kind.folder == "any-heading":
        file = out / "any-heading.toml"
        file.write_text(template("campaign"), encoding="utf-8")
    campaign = read_campaign(file, overrides=[*kind.settings, f"trials={trials}"])
    directory = out / kind.folder
    resumed = bool(written_ranges(directory)) if directory.exists() else False
    begin = time.perf_counter()
    with counted(kind.name, quiet=False) as count:
        run_campaign(campaign, directory, threads=processors(), progress=count)
    with progress(quiet=False) as report:
        write_report(directory, threads=processors(), progress=report)
    seconds = None if resumed else time.perf_counter() - begin
    totals, residuals = [], []
    for first, last in written_ranges(directory):
        rows = read_rows(
            file_of(directory, (first, last)), last - first, columns=["total", "residual"]
        )
        totals.append(rows["total"].to_numpy())
        residuals.append(rows["residual"].to_numpy())
    return Found(outcomes_of(directory), np.concatenate(totals), np.concatenate(residuals), seconds)


def report(found: dict[str, Found], trials: int) -> None:
    """Print the table."""
    table = Table("law and form", "parked", "95 % interval", "time to park, s", "other outcomes",
                  "wall, s")  # fmt: skip
    for name, (outcomes, totals, _, seconds) in found.items():
        parked = outcomes.get("parked", 0)
        success = success_of(parked, trials)
        times = totals[np.isfinite(totals)]
        quantiles = np.quantile(times, (0.5, 0.99, 1.0)) if times.size else (np.nan,) * 3
        others = ", ".join(f"{n:,} {o}" for o, n in outcomes.items() if o != "parked" and n)
        table.add_row(
            name,
            f"{parked:,}",
            f"{100 * success.low:.4f} to {100 * success.high:.4f} %",
            "median {:.2f}, 99 % {:.2f}, most {:.2f}".format(*quantiles),
            others or "none",
            "resumed" if seconds is None else f"{seconds:.0f}",
        )
    Console(width=160).print(table)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{processors()} processors; peak memory {peak:.0f} MiB")


def draw(found: dict[str, Found], path: Path) -> None:
    """Draw which share has parked by which time, and how far those that ran to the end are off."""
    with drawing():
        figure = new_figure(8.0, 3.8)
        left, right = figure.subplots(1, 2)
        figure.subplots_adjust(left=0.08, right=0.97, top=0.97, bottom=0.31, wspace=0.25)
        for kind in KINDS:
            _, totals, residuals, _ = found[kind.name]
            line = {"color": kind.colour, "linestyle": kind.dashes, "label": kind.name}
            shares = np.linspace(0.0, 1.0, 2001)
            times = np.quantile(np.nan_to_num(totals, nan=np.inf), shares, method="lower")
            there = np.isfinite(times)
            left.plot(times[there], 100.0 * shares[there], **line)
            known = residuals[np.isfinite(residuals)]
            if known.size:
                right.plot(np.quantile(known, shares), 100.0 * shares, **line)
        left.set(xlabel="time in s", ylabel="parked by then, %", xlim=(0.0, 15.0), ylim=(0, 101))
        right.set(xscale="log", xlabel="largest error in the last 2 s", ylabel="trials below, %")
        right.set(ylim=(0, 101))
        handles, labels = left.get_legend_handles_labels()
        figure.legend(handles, labels, loc="lower center", ncols=3, frameon=False)
        save(figure, path)


def main() -> None:
    """Carry out all that is missing, then say what was found."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--trials", type=int, default=1_000_000, help="of each campaign")
    parser.add_argument("--out", type=Path, default=Path("campaigns/million"))
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    found = {kind.name: carried_out(kind, asked.out, asked.trials) for kind in KINDS}
    report(found, asked.trials)
    draw(found, asked.out / "million.png")
    print(f"picture: {asked.out / 'million.png'}")


if __name__ == "__main__":
    main()
