"""Wall time of a campaign: on one thread, on two, and on two workers of a cluster over TCP.

    python benchmarks/campaign.py [--trials 65536] [--rounds 3]

The campaign is paper_bounds.toml in the explicit form, without its report. Ratios are taken round
by round; their medians are printed. A cluster is timed twice: when its workers have only just had
their first few trials, and once more. It needs the extra "cluster".
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.progress import track

from parkproof.campaign.definition import read_campaign
from parkproof.campaign.run import run_campaign

BOUNDS = Path(__file__).with_name("paper_bounds.toml")
PORT = 18786
ADDRESS = f"tcp://127.0.0.1:{PORT}"
DASK_SETTINGS = {
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "500ms",
}
"""Settings with which Dask looks at itself less often, as in docs/campaigns.md."""


@contextmanager
def cluster(workers: int) -> Iterator[None]:
    """A scheduler and workers of one thread each, as processes of their own."""
    dask = [sys.executable, "-m", "dask"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = [*dask, "scheduler", "--host", "127.0.0.1", "--port", str(PORT), "--no-dashboard"]
    worker = [*dask, "worker", ADDRESS, "--nthreads", "1", "--no-dashboard"]
    commands = [scheduler, *[worker] * workers]
    running = [subprocess.Popen(command, **quiet) for command in commands]  # type: ignore[call-overload]
    try:
        yield
    finally:
        for process in reversed(running):
            process.terminate()
        for process in running:
            process.wait()


def seconds(trials: int, *, threads: int = 1, scheduler: str | None = None) -> float:
    """Wall time of the campaign."""
    campaign = read_campaign(BOUNDS, overrides=["run.discretisation=explicit", f"trials={trials}"])
    with tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        run_campaign(campaign, Path(folder) / "out", threads=threads, scheduler=scheduler)
        return time.perf_counter() - begin


def main() -> None:
    """Time all three in turn."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--trials", type=int, default=65_536)
    parser.add_argument("--rounds", type=int, default=3)
    asked = parser.parse_args()
    os.environ.update(DASK_SETTINGS)  # of this process, which imports Dask later, and its children
    times: list[tuple[float, float, float, float]] = []
    seconds(512)
    for _ in track(range(asked.rounds), description="rounds"):
        one, two = seconds(asked.trials), seconds(asked.trials, threads=2)
        with cluster(2):  # its processes take some time even when they have nothing to do
            seconds(512, scheduler=ADDRESS)  # workers import and compile, as threads have
            first, later = (seconds(asked.trials, scheduler=ADDRESS) for _ in range(2))
            times.append((one, two, first, later))
    one, two, first, later = (statistics.median(column) for column in zip(*times, strict=True))
    print(f"{asked.trials} trials of 15 s at 1 ms, medians of {asked.rounds} rounds")
    print(f"one thread {one:.1f} s, two {two:.1f} s, two workers {first:.1f} s, then {later:.1f} s")
    print(f"one thread / two: {statistics.median(a / b for a, b, _, _ in times):.2f}")
    print(f"two workers / two threads: {statistics.median(d / b for _, b, _, d in times):.2f}")
    print(f"the same, just started: {statistics.median(c / b for _, b, c, _ in times):.2f}")


if __name__ == "__main__":
    main()
