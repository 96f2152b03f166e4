"""How long a first result takes after a fresh start: compiled anew, and with kernels on disk.

    python benchmarks/first_result.py [--rounds 5]

Each figure is the wall time of a process of its own, interpreter and imports included, in which one
trial of 15 s is carried out in lanes.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

WORK = """
from parkproof import section4, simulate_ensemble
simulate_ensemble([section4("{law}", discretisation="{form}")])
"""
KINDS = (("corrected", "explicit"), ("corrected", "implicit"), ("published", "explicit"))


def seconds(law: str, form: str, kernels: Path) -> float:
    """Wall time of one process."""
    begin = time.perf_counter()
    subprocess.run(
        [sys.executable, "-c", WORK.format(law=law, form=form)],
        check=True,
        env={**os.environ, "PARKPROOF_CACHE_DIR": str(kernels)},
    )
    return time.perf_counter() - begin


def main() -> None:
    """Time all in turn, and print medians and ranges."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=5, help="repetitions, of which medians")
    rounds = parser.parse_args().rounds
    times: dict[tuple[str, str, str], list[float]] = {}
    for _ in range(rounds):
        for law, form in KINDS:
            with tempfile.TemporaryDirectory() as folder:
                for when in ("compiled anew", "kernels on disk"):
                    taken = seconds(law, form, Path(folder))
                    times.setdefault((law, form, when), []).append(taken)
    for (law, form, when), each in times.items():
        print(
            f"{law}, {form}, {when}: {statistics.median(each):.1f} s "
            f"({min(each):.1f} to {max(each):.1f})"
        )


if __name__ == "__main__":
    main()
