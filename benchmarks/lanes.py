"""Speed of compiled lanes against the plain run, as medians of several rounds in one process.

Prints the numbers of docs/numerics.md. Run it from the repository root::

    python benchmarks/lanes.py
"""

import statistics
import time
from collections.abc import Callable

import numpy as np

from parkproof import Scenario, Start, section4, simulate, simulate_ensemble

ROUNDS = 5
TRIALS = 1024
DURATION = 15.0


def trials(count: int) -> list[Scenario]:
    """Section 4 under the corrected law from random starts."""
    rng = np.random.default_rng(1)
    low, high = (-1.0, -0.5, -0.5, -1.0, -1.0), (1.0, 0.5, 0.5, 3.0, 1.0)
    starts = rng.uniform(low, high, (count, 5)).tolist()
    return [
        section4("corrected", start=Start(state=tuple(start)), duration=DURATION)
        for start in starts
    ]


def seconds(work: Callable[[], object]) -> float:
    """Wall time of one call."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def main() -> None:
    """Time both, in turn, and print medians."""
    many = trials(TRIALS)
    first = seconds(lambda: simulate_ensemble(many[:1]))
    plain, one, two = [], [], []
    for k in range(ROUNDS):
        plain.append(seconds(lambda k=k: simulate(many[k])))  # type: ignore[misc]  # mypy and defaults
        one.append(seconds(lambda: simulate_ensemble(many)) / TRIALS)
        two.append(seconds(lambda: simulate_ensemble(many, threads=2)) / TRIALS)
    run, lane, threaded = (statistics.median(times) for times in (plain, one, two))
    steps = many[0].run.samples
    print(f"{TRIALS} trials of {DURATION:g} s at 1 ms, medians of {ROUNDS} rounds")
    print(f"first ensemble call, compiling included: {first:.1f} s")
    print(f"plain run: {run:.3f} s a trial, {1e9 * run / steps:.0f} ns a step")
    print(f"lanes, 1 thread: {1e3 * lane:.3f} ms a trial, {1e9 * lane / steps:.1f} ns a step")
    print(f"lanes, 2 threads: {1e3 * threaded:.3f} ms a trial")
    print(f"ratio plain / lanes: {run / lane:.0f} (1 thread), {run / threaded:.0f} (2 threads)")


if __name__ == "__main__":
    main()
