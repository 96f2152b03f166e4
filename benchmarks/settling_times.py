"""Settling times of compiled lanes against the plain run, trial by trial.

    python benchmarks/settling_times.py [--trials 1000]

Both have the same law, start and truth; the plain run has the library's power and sine, lanes have
polynomials, and waves that are turned on from step to step. With the same primitives both are the
same to the last bit: tests/test_same_primitives.py. Lanes in single precision are compared, too.
"""

import argparse
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import NDArray
from rich.progress import track

sys.path.insert(0, str(Path(__file__).parent / "rivals"))

from work import Work, make_work

from parkproof import Scenario, simulate
from parkproof.simulation.ensemble import simulate_trials
from parkproof.simulation.trials import Precision, trials_of


def plain_ends(scenario: Scenario) -> list[float]:
    """When Steps 1 to 3 end in the plain run, in s; −1 where they do not."""
    steps = simulate(scenario).settling_time.steps
    ends = [steps.get(str(i)) for i in (1, 2, 3)]
    return [-1.0 if end is None else end for end in ends]


def lane_ends(work: Work, precision: Precision) -> NDArray[np.float64]:
    """The same in lanes, a row a trial."""
    rows = simulate_trials(work.scenarios[0], trials_of(work.scenarios), precision=precision)
    return np.nan_to_num(np.array([rows[f"end{i}"] for i in (1, 2, 3)]).T, nan=-1.0)


def main() -> None:
    """Carry all out, and say how far apart they are."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--trials", type=int, default=1000)
    count = parser.parse_args().trials
    work = make_work(count)
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        found = pool.map(plain_ends, work.scenarios, chunksize=4)
        plain = np.array(list(track(found, description="plain runs", total=count)))
    for precision in get_args(Precision):
        apart = np.round(np.abs(plain - lane_ends(work, precision)) / work.period)
        for name, periods in (("Steps 1 to 3", apart), ("the whole run (Step 3)", apart[:, 2])):
            shares = ", ".join(
                f"{100 * np.mean(periods <= most):.2f} % within {most}" for most in (0, 1, 3)
            )
            print(f"{precision}: {name}: {shares} periods, at most {periods.max():.0f}")


if __name__ == "__main__":
    main()
