"""Parkproof's lanes against what people would use for the same work: one table, one run, one core.

Run it from the repository root::

    python benchmarks/rivals/run.py

Rivals that are not installed are named with what to install. The exit status is 1 if one of them
does not find Parkproof's settling times, as it would then not do the same work.
"""

import argparse
import importlib
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import NamedTuple

import numpy as np
from parkproof_lanes import prepare as prepare_lanes
from parkproof_plain import by_euler
from work import DURATION, Found, Work, make_work

TRIALS = 1024
"""Of Parkproof's lanes at a time."""

CHECKED = 3
"""Trials whose settling times are compared."""

SPREAD = 0.02
"""Largest relative difference of the metrics: rivals must keep them, but need not round alike."""


EULER = "Parkproof's lanes, plant by Euler"
"""What all are compared with: the same plant as most rivals'."""

DEFAULT = "Parkproof's lanes, plant by Runge-Kutta (default)"
SINGLE = "Parkproof's lanes, plant by Euler, single precision (rivals: double)"

SMALL = 0.05
"""Metrics below this are compared as if they were so large."""


class Rival(NamedTuple):
    """One row of the table: its module here, its trials at a time, and what to install.

    ``euler`` is whether its plant is by Euler's method; ``leaves_out`` is what it leaves out beside
    what all rivals do.
    """

    name: str
    module: str
    trials: int
    packages: tuple[str, ...]
    euler: bool
    leaves_out: str


RIVALS = (
    Rival("diffrax: Euler steps, vmap, jit", "diffrax_lanes", 1024, ("diffrax", "jax"), True, ""),
    Rival("numba, scalar, with libm", "numba_scalar", 256, ("numba",), True, ""),
    Rival("numpy over lanes", "numpy_lanes", 2048, ("numpy",), True, ""),
    Rival("Drake: one LeafSystem in Python", "drake_system", 1, ("drake",), True,
          "all of a diagram"),
    Rival("Drake: plant and controller, a diagram", "drake_diagram", 1, ("drake",), True, ""),
    Rival("python-control: one nonlinear system", "control_system", 1, ("control",), True,
          "all interconnection"),
    Rival("python-control: plant and controller, interconnected", "control_interconnect", 1,
          ("control",), True, ""),
    Rival("scipy: solve_ivp per sample", "scipy_samples", 1, ("scipy",), False, ""),
    Rival("Parkproof's plain reference, simulate()", "parkproof_plain", 1, ("parkproof",), False,
          "nothing, and keeps every sample"),
)  # fmt: skip


class Measured(NamedTuple):
    """A rival ready to be timed, and how well it agrees."""

    rival: Rival
    run: Callable[[], Found]
    agreement: str
    agrees: bool


def arguments() -> argparse.Namespace:
    """What was asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=5, help="repetitions, of which medians")
    names = [rival.module for rival in RIVALS]
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="RIVAL",
                        help=f"some of {', '.join(names)}")  # fmt: skip
    asked = parser.parse_args()
    if asked.rounds < 1:
        parser.error(f"--rounds {asked.rounds}: must be at least 1; write --rounds 5")
    return asked


def stay_on_one_core() -> None:
    """Bind this process, and the threads that rivals will start, to one core."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    else:
        print("this system binds no process to a core: rivals may use several", file=sys.stderr)


def machine() -> str:
    """Processor and its vector instructions."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    fields = dict(line.split(":", 1) for line in lines if ":" in line)
    fields = {name.strip(): value.strip() for name, value in fields.items()}
    flags = fields.get("flags", "").split()
    kind = next((kind for kind in ("avx512f", "avx2") if kind in flags), "no AVX2 seen")
    return f"{fields.get('model name', platform.processor() or platform.machine())} ({kind})"


def release(package: str) -> str:
    """A package's name and version."""
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return package


def compare(found: Found, expected: Found, period: float) -> tuple[str, bool]:
    """How far settling times lie apart, and whether that and the metrics are close enough."""
    ends, metrics = found.ends[:CHECKED], found.metrics[:CHECKED]
    apart = float(np.max(np.abs(ends - expected.ends)))
    scale = np.maximum(np.abs(expected.metrics), SMALL)
    spread = float(np.max(np.abs(metrics - expected.metrics) / scale))
    agrees = apart <= 1.001 * period and spread <= SPREAD
    return f"{'' if agrees else 'NO: '}{1e3 * apart:.0f} ms, {spread:.1g}", agrees


def make_ready(rival: Rival, work: Work, expected: dict[bool, Found]) -> Measured | str:
    """Compile and compare a rival, or say what is missing."""
    try:
        module = importlib.import_module(rival.module)
    except ImportError as error:
        return (
            f"{rival.name}: not measured ({error}); to have it, "
            f"`pip install {' '.join(rival.packages)}`"
        )
    checked = module.prepare(work.first(max(CHECKED, rival.trials)))
    agreement, agrees = compare(checked(), expected[rival.euler], work.period)
    run = checked if rival.trials >= CHECKED else module.prepare(work.first(rival.trials))
    return Measured(rival, run, agreement, agrees)


def nanoseconds(run: Callable[[], Found], trials: int, samples: int) -> float:
    """Processor time of one step of one trial, which other programs hardly change."""
    begin = time.process_time()
    run()
    return 1e9 * (time.process_time() - begin) / (trials * samples)


def number(value: float) -> str:
    """Three digits, or all of a large number."""
    return f"{value:.3g}" if value < 1000 else f"{float(f'{value:.3g}'):,.0f}"


def print_table(
    work: Work,
    apart: dict[str, tuple[str, bool]],
    own: dict[str, list[float]],
    rows: list[tuple[Measured, list[float]]],
) -> None:
    """Print the table, with what must be known to read it."""
    packages = {name for one, _ in rows for name in one.rival.packages} | {"parkproof", "numba"}
    base = own[EULER]
    print(
        f"Trials of {DURATION:g} s at {1e3 * work.period:g} ms, one core. Processor time, medians "
        f"of {len(base)} rounds, each of which times all in turn; ratios are taken round by round."
        "\n\n| | ns a lane-step | times Parkproof's by Euler (range) | trials at a time | apart | "
        "leaves out, too |\n| --- | --- | --- | --- | --- | --- |"
    )
    for name, times in own.items():
        print(f"| **{name}** | {number(statistics.median(times))} | {ratios(times, base)} | "
              f"{TRIALS} | {apart[name][0]} | |")  # fmt: skip
    for one, times in rows:
        print(
            f"| {one.rival.name} | {number(statistics.median(times))} | {ratios(times, base)} "
            f"| {one.rival.trials} | {one.agreement} | {one.rival.leaves_out} |"
        )
    print(
        "\nTo their advantage, rivals leave out the turn, a second choice of the direction of "
        "travel, limits, ends of a run, and what is largest while holding and in the last seconds. "
        "Their plant is by Euler's method, SciPy's its own, that of simulate() by Runge and "
        f"Kutta's. Apart: the largest differences, over the first {CHECKED} trials, of the ends of "
        "Steps 1 to 3, and (relative) of the 17 metrics that all keep, from "
        "Parkproof's controller with the plant by Euler's method or, where a plant is more exact, "
        "from Parkproof's lanes with theirs by Runge and Kutta's."
    )
    print(
        f"\nMeasured on: {machine()}; Python {platform.python_version()}, "
        f"{', '.join(release(name) for name in sorted(packages))}."
    )


def ratios(times: list[float], base: list[float]) -> str:
    """Median and range of the ratios within a round."""
    each = [time / one for time, one in zip(times, base, strict=True)]
    if each == [1.0] * len(each):
        return "1"
    return f"{number(statistics.median(each))} ({number(min(each))} to {number(max(each))})"


def main() -> int:
    """Time all in turn, round by round, and print the table."""
    asked = arguments()
    stay_on_one_core()
    work = make_work(max(rival.trials for rival in RIVALS))
    few, ours = work.first(CHECKED), work.first(TRIALS)
    lanes = {
        EULER: prepare_lanes(ours, euler=True),
        DEFAULT: prepare_lanes(ours),
        SINGLE: prepare_lanes(ours, euler=True, precision="single"),
    }
    warm = {name: run() for name, run in lanes.items()}
    expected = {
        True: by_euler(few),
        False: Found(*(values[:CHECKED] for values in warm[DEFAULT])),
    }
    apart = {name: compare(found, expected[name != DEFAULT], work.period)
             for name, found in warm.items()}  # fmt: skip
    chosen = [rival for rival in RIVALS if rival.module in asked.only]
    ready: list[Measured] = []
    missing: list[str] = []
    for rival in chosen:
        print(f"preparing {rival.name}", file=sys.stderr)
        made = make_ready(rival, work, expected)
        (missing if isinstance(made, str) else ready).append(made)  # type: ignore[arg-type]
    own: dict[str, list[float]] = {name: [] for name in lanes}
    theirs: list[list[float]] = [[] for _ in ready]
    for i in range(asked.rounds):
        print(f"round {i + 1} of {asked.rounds}", file=sys.stderr)
        for name, run in lanes.items():
            own[name].append(nanoseconds(run, len(ours.ways), work.samples))
        for one, times in zip(ready, theirs, strict=True):
            times.append(nanoseconds(one.run, one.rival.trials, work.samples))
    print_table(work, apart, own, list(zip(ready, theirs, strict=True)))
    for line in missing:
        print(f"\n{line}.")
    same = all(one.agrees for one in ready) and apart[EULER][1]
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
