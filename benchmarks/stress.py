"""A certificate against adversarial runs: every proven number beside the worst of them.

Run it from the repository root::

    python benchmarks/stress.py certificate.json --runs 10000

Half of the starts lie at corners of the certificate's box, most truths at the ends of its bounds,
against the input, or waves between them. The exit status is 0 if all runs stayed within.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from parkproof.report.measured import compare, sampling_bands, stressed_runs
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.outcome import Outcome

BATCH = 1024


def arguments() -> argparse.Namespace:
    """What was asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("certificate", type=Path)
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--period", type=float, default=1e-3, help="control period in s")
    parser.add_argument("--threads", type=int, default=2)
    return parser.parse_args()


def main() -> int:
    """Carry the runs out in batches, compare, and print a table."""
    asked = arguments()
    certificate = json.loads(asked.certificate.read_text(encoding="utf-8"))
    runs = stressed_runs(
        certificate, count=asked.runs, seed=asked.seed, control_period=asked.period
    )
    begin, parts = time.perf_counter(), []
    for first in range(0, len(runs), BATCH):
        parts.append(simulate_ensemble(runs[first : first + BATCH], threads=asked.threads))
        done = min(first + BATCH, len(runs))
        print(f"{done} of {len(runs)} runs", end="\r", file=sys.stderr, flush=True)
    rows: dict[str, Any] = {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}
    seconds = time.perf_counter() - begin
    parked = sum(outcome is Outcome.PARKED for outcome in rows["outcome"])
    print(
        f"{len(runs)} runs, {asked.period:g} s period, implicit form, seed {asked.seed}, "
        f"{seconds:.0f} s: {parked} parked"
    )
    print("\n| number | proven | worst run | worst / proven |\n| --- | --- | --- | --- |")
    found = compare(certificate, rows)
    for one in found:
        print(f"| {one.name} | {one.proven:.4g} | {one.worst:.4g} | {one.ratio:.3f} |")
    beyond = [one for one in found if not one.within]
    if not beyond:
        print("\nAll runs stayed within every proven number.")
        return 0
    excess = ", ".join(f"{one.name} by {one.worst - one.proven:.3g}" for one in beyond)
    one, two = sampling_bands(certificate, asked.period)
    print(
        f"\nBeyond what is proven: {excess}. The proof is of continuous time; this period lets "
        f"u0 stray by {one:.2g} and u1 by {two:.2g}, and ends each step up to a period late."
    )
    return 1


if __name__ == "__main__":
    sys.exit(main())
