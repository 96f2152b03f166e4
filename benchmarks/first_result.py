"""How long a first result takes after a fresh start: compiled anew, and with kernels on disk.

    python benchmarks/first_result.py [--rounds 5]

Each figure is the wall time from the start of a process of its own, interpreter and imports
included, to the moment at which it has carried out one trial of 15 s in lanes; then it ends, which
is not timed.
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
print("carried out", flush=True)
"""
KINDS = (("corrected", "explicit"), ("corrected", "implicit"), ("published", "explicit"))


def seconds(law: str, form: str, kernels: Path) -> float:
    """Wall time of one process until it has its result."""
    line = [sys.executable, "-c", WORK.format(law=law, form=form)]
    here = {**os.environ, "PARKPROOF_CACHE_DIR": str(kernels)}
    begin = time.perf_counter()
    with subprocess.Popen(line, stdout=subprocess.PIPE, text=True, env=here) as process:
        said = process.stdout.readline() if process.stdout else ""
        taken = time.perf_counter() - begin
    if not said or process.returncode:
        raise RuntimeError(f"the process that was timed failed with status {process.returncode}")
    return taken


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
