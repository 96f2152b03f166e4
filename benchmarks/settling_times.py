"""Settling times of compiled lanes against the plain run, trial by trial.

    python benchmarks/settling_times.py [--trials 1000]

Both have the same law, start and truth; the plain run has the library's power and sine, lanes have
polynomials, and waves that are turned on from step to step. With the same primitives both are the
same to the last bit: tests/test_same_primitives.py.
"""

import argparse
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from rich.progress import track

sys.path.insert(0, str(Path(__file__).parent / "rivals"))

from work import make_work

from parkproof import Scenario, simulate
from parkproof.simulation.ensemble import simulate_trials
from parkproof.simulation.trials import trials_of


def plain_ends(scenario: Scenario) -> list[float]:
    """When Steps 1 to 3 end in the plain run, in s; −1 where they do not."""
    steps = simulate(scenario).settling_time.steps
    ends = [steps.get(str(i)) for i in (1, 2, 3)]
    return [-1.0 if end is None else end for end in ends]


def main() -> None:
    """Carry all out twice, and say how far apart they are."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--trials", type=int, default=1000)
    count = parser.parse_args().trials
    work = make_work(count)
    rows = simulate_trials(work.scenarios[0], trials_of(work.scenarios))
    lanes = np.nan_to_num(np.array([rows[f"end{i}"] for i in (1, 2, 3)]).T, nan=-1.0)
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        found = pool.map(plain_ends, work.scenarios, chunksize=4)
        plain = np.array(list(track(found, description="plain runs", total=count)))
    apart = np.round(np.abs(plain - lanes) / work.period)
    for name, periods in (("Steps 1 to 3", apart), ("the whole run (Step 3)", apart[:, 2])):
        print(
            f"{name}: {100 * np.mean(periods == 0):.2f} % alike, "
            f"{100 * np.mean(periods <= 1):.2f} % alike or one period apart, "
            f"at most {periods.max():.0f} periods"
        )


if __name__ == "__main__":
    main()
