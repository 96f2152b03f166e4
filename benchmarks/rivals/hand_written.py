"""Parkproof's lanes against the same work by hand, in C with AVX-512: ratios of one run, one core.

Run it from the repository root::

    python benchmarks/rivals/hand_written.py

It needs a C compiler. Where the processor has no AVX-512 it says so, and gives the lanes' own time.
The exit status is 1 if the C does not find the lanes' settling times, as it would then not do the
same work.
"""

import argparse
import ctypes
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import replace
from parkproof_lanes import kernels
from run import machine, stay_on_one_core
from work import Floats, Work, make_work

from parkproof.laws.parameters import LawParameters
from parkproof.simulation.ensemble import simulate_trials
from parkproof.simulation.metrics import RESIDUAL_WINDOW
from parkproof.simulation.trials import trials_of

TRIALS = 256
ALIKE = 0.99
"""Share of the times at which steps end that must be alike or one period apart."""

PARAMETERS = (
    "lambda1", "q0", "L1", "L2", "l3", "q1", "l1", "inv_q1", "inv_e1", "r1", "K1", "k3", "H1",
    "hold3", "inv_q2", "r2", "runup_speed", "steer_low", "steer_high", "tolerance1", "tolerance2",
    "tolerance3", "x1_leave", "x2_leave", "phi1", "phi2", "gamma_min1", "gamma_min2", "alpha1",
    "alpha2", "period",
)  # fmt: skip
"""In the order of hand_written.c, which then has the time from which residuals count."""

LANES = ROWS = 64
WAY, STEP, SIN, COS, TURN_S, TURN_C, MEAN, AMP, ALPHA, END = 5, 6, 10, 14, 18, 22, 26, 30, 34, 36
LOW, HIGH, RATE_SQUARE = 50, 51, 57
"""Rows of a block of hand_written.c."""


class Timed(NamedTuple):
    """Time in ns for each trial and step, and when Steps 1 to 3 ended in s: a column a trial."""

    ns: float
    ends: Floats


def compiled(folder: Path) -> ctypes.CDLL | None:
    """The hand-written C, if this machine can carry it out."""
    if "avx512" not in machine():
        print(f"{machine()}: no AVX-512, which the hand-written C needs; only the lanes' own time")
        return None
    compiler = os.environ.get("CC") or shutil.which("cc")
    if compiler is None:
        print("no C compiler: install one, for example the Debian package gcc")
        return None
    source, library = Path(__file__).with_suffix(".c"), folder / "hand_written.so"
    options = ["-O3", "-march=native", "-shared", "-fPIC", "-o", str(library), str(source), "-lm"]
    subprocess.run([compiler, *options], check=True)
    return ctypes.CDLL(str(library))


def address(numbers: Floats) -> ctypes.c_void_p:
    """Where an array is."""
    return numbers.ctypes.data_as(ctypes.c_void_p)


def block_of(work: Work, first: int, *, halves: int) -> Floats:
    """The trials of one block, laid out for the C; ``halves`` is how often waves turn in a step."""
    room = np.zeros(ROWS * LANES + 8)
    begin = -(room.ctypes.data // 8) % 8  # registers are read from multiples of 64 bytes
    block = room[begin : begin + ROWS * LANES].reshape(ROWS, LANES)
    here = slice(first, first + LANES)
    starts, truths = work.starts[here].T, work.truths[here].T
    block[:5], block[WAY], block[STEP] = starts, work.ways[here], 1.0
    block[ALPHA : ALPHA + 2], block[END : END + 4] = truths[:2], -1.0
    mean, amplitude, omega, phase = (truths[2 + i :: 4] for i in range(4))
    angle = omega * work.period / halves
    rows = ((SIN, np.sin(phase)), (COS, np.cos(phase)), (TURN_S, np.sin(angle)))
    for row, values in (*rows, (TURN_C, np.cos(angle)), (MEAN, mean), (AMP, amplitude)):
        block[row : row + 4] = values
    block[LOW], block[HIGH], block[RATE_SQUARE] = starts[0], starts[0], 1.0
    return block


def by_hand(library: ctypes.CDLL, work: Work, *, fourth_order: bool) -> Timed:
    """The hand-written C; laying its arrays out is not timed."""
    p: LawParameters = work.parameters
    late = work.samples * work.period - RESIDUAL_WINDOW
    numbers = np.array([*(getattr(p, name) for name in PARAMETERS), late])
    blocks = [
        block_of(work, first, halves=2 if fourth_order else 1) for first in range(0, TRIALS, LANES)
    ]
    begin = time.perf_counter()
    for block in blocks:
        library.carry_out(
            address(block), address(numbers), ctypes.c_long(work.samples), int(fourth_order)
        )
    taken = time.perf_counter() - begin
    ends = np.hstack([block[END : END + 3] for block in blocks])
    return Timed(1e9 * taken / TRIALS / work.samples, ends)


def in_lanes(work: Work, **kind: Any) -> Callable[[], Timed]:
    """Parkproof's lanes, one thread, with all that is done before and after the kernel."""
    shared, trials = work.scenarios[0], trials_of(work.scenarios)
    if kind.pop("implicit", False):
        shared = replace(shared, run=replace(shared.run, discretisation="implicit"))
    precision = kind.pop("precision", "double")

    def run() -> Timed:
        with kernels(**kind):
            begin = time.perf_counter()
            rows = simulate_trials(shared, trials, precision=precision)
            taken = time.perf_counter() - begin
        ends = np.nan_to_num(np.array([rows[f"end{i}"] for i in (1, 2, 3)]), nan=-1.0)
        return Timed(1e9 * taken / TRIALS / work.samples, ends)

    run()
    return run


def main() -> int:
    """Time all of them in turn, and print medians."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=9, help="repetitions, of which medians")
    rounds = parser.parse_args().rounds
    stay_on_one_core()
    work = make_work(TRIALS)
    runs = {
        "lanes, Euler": in_lanes(work, euler=True),
        "lanes, Runge-Kutta": in_lanes(work),
        "lanes, implicit form, Runge-Kutta": in_lanes(work, implicit=True),
        "lanes, Euler, single precision": in_lanes(work, euler=True, precision="single"),
    }
    with tempfile.TemporaryDirectory() as folder:
        library = compiled(Path(folder))
        if library is not None:
            runs["by hand, Euler"] = partial(by_hand, library, work, fourth_order=False)
            runs["by hand, Runge-Kutta"] = partial(by_hand, library, work, fourth_order=True)
        times: dict[str, list[float]] = {name: [] for name in runs}
        ends = {}
        for _ in range(rounds):
            for name, run in runs.items():
                ns, ends[name] = run()
                times[name].append(ns)
    return 0 if report(times, ends, work.period) else 1


def report(times: dict[str, list[float]], ends: dict[str, Floats], period: float) -> bool:
    """Print medians, and medians of ratios within a round; say whether the C agrees."""
    agrees = True
    rounds = len(times["lanes, Euler"])
    print(f"{machine()}\n{TRIALS} trials of 15 s at 1 ms, medians of {rounds} rounds")
    for name, each in times.items():
        print(f"{name:36} {statistics.median(each):6.1f} ns a trial and step")
    implicit = zip(
        times["lanes, implicit form, Runge-Kutta"], times["lanes, Runge-Kutta"], strict=True
    )
    print(f"implicit / explicit: {statistics.median(a / b for a, b in implicit):.2f}")
    for plant in ("Euler", "Runge-Kutta"):
        if (hand := f"by hand, {plant}") in times:
            pairs = zip(times[f"lanes, {plant}"], times[hand], strict=True)
            apart = np.abs(ends[hand] - ends[f"lanes, {plant}"]) <= 1.01 * period
            agrees = agrees and bool(np.mean(apart) >= ALIKE)
            print(
                f"lanes / by hand, {plant}: {statistics.median(a / b for a, b in pairs):.2f}; "
                f"{100 * np.mean(apart):.1f} % of the times at which Steps 1 to 3 end alike or "
                "one period apart"
            )
    return agrees


if __name__ == "__main__":
    sys.exit(main())
