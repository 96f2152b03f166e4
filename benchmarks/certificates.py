"""What of Step 2 is proved, for the published gains and for others; prints the table of the docs.

Needs ``parkproof[proof]``. Run it from the repository root; it takes about four minutes::

    python benchmarks/certificates.py
"""

import time
from typing import NamedTuple

from flint import arb, ctx

from parkproof.laws.gains import Gains
from parkproof.proof.checker.lemmas import level_of, prove_rate, seconds
from parkproof.proof.checker.squares import ThreeChainWithSquares
from parkproof.proof.not_certifiable import no_weights_exist
from parkproof.proof.weights import Weights, best_weights, best_weights_with_squares

PUBLISHED = (2.0, 4.2, 21.0)
USUAL, UNIT, NARROW = (0.5, 1.5), (1.0, 1.0), (0.8, 1.25)


class Case(NamedTuple):
    """Gains, what is uncertain, the form of V, and the share of the sampled rate to prove."""

    q1: str
    l: tuple[float, float, float]  # noqa: E741  (the paper's name)
    b1: tuple[float, float] = USUAL
    b2: tuple[float, float] = UNIT
    varies: bool = False
    squares: bool = False
    share: float = 0.97


CERTIFIED = (
    Case("7/9", PUBLISHED),
    Case("7/9", PUBLISHED, squares=True),
    Case("9/11", PUBLISHED),
    Case("9/11", PUBLISHED, squares=True),
    Case("13/15", PUBLISHED),
    Case("13/15", PUBLISHED, squares=True),
    Case("9/11", PUBLISHED, b1=(0.05, 1.5), varies=True),
    Case("9/11", PUBLISHED, b2=NARROW, squares=True),
    Case("9/11", PUBLISHED, b2=NARROW, varies=True, squares=True),
    Case("9/11", (1.65, 4.65, 21.71), b2=NARROW),
    Case("7/9", (1.56, 4.58, 28.49), b2=NARROW),
    Case("5/7", (1.39, 4.41, 49.07), b2=NARROW),
    Case("9/11", (1.57, 4.77, 21.93), b2=NARROW, varies=True),
    Case("7/9", (1.49, 4.57, 29.15), b2=NARROW, varies=True),
    Case("9/11", (1.74, 4.98, 20.08), b2=NARROW, squares=True),
    Case("5/7", (1.49, 4.75, 47.25), b2=NARROW, squares=True),
    Case("7/9", (1.6, 5.02, 26.72), b2=NARROW, varies=True, squares=True),
    Case("9/11", (1.0, 1.775, 4.57), share=0.2),
    Case("9/11", (1.0, 0.3, 2.5), squares=True, share=0.2),
)
"""The published gains, gains made for an uncertain b2, and two with a small l3 at l1 = 1."""

RULED_OUT = (
    Case("5/7", PUBLISHED, b1=(1.0, 1.0), squares=True),
    Case("5/7", PUBLISHED, b1=(1.5, 1.5), squares=True),
    Case("5/7", PUBLISHED, varies=True, squares=True),
    Case("9/11", PUBLISHED, b2=NARROW),
)


def name(case: Case) -> str:
    """The first columns."""
    kind = "varying" if case.varies else "constant"
    form = "with squares" if case.squares else "the paper's"
    return f"| {case.q1} | {case.l} | {case.b1} {kind} | {case.b2} | {form} |"


def weights_of(case: Case) -> Weights:
    """Weights for the shortest time from (1, 0, 0), or for a rate at all."""
    given = {"b1": case.b1, "b2": case.b2, "varies": case.varies}
    start = (1.0, 0.0, 0.0) if case.share > 0.5 else None
    gains = Gains(q1=case.q1, l=case.l)
    if case.squares:
        return best_weights_with_squares(gains, start=start, **given)
    k, rate = best_weights(gains, start=start, **given)
    return Weights(k, (0.0, 0.0), rate)


def certified(case: Case) -> str:
    """Seek weights, prove the rate, and bound the time from |x1| <= 1 at rest."""
    begin = time.perf_counter()
    found = weights_of(case)
    loop = ThreeChainWithSquares(case.q1, case.l, found.k, 1.0 if case.varies else None, found.s)
    rate = float(f"{case.share * found.rate:.3g}")
    boxes = prove_rate(loop, rate, [case.b1, case.b2])
    box = [(arb(-1), arb(1)), (arb(0), arb(0)), (arb(0), arb(0))]
    bounds = [seconds(loop, rate, level_of(loop, box, b1), arb(0)).upper() for b1 in case.b1]
    # At (1, 0, 0) all coordinates on the cube are 1.
    _, xi2 = loop.coordinates((arb(1), arb(1), arb(1)))
    tau = float(loop.input_gain * xi2**loop.input_power)
    weights = f"k = {found.k}" + (f", s = {found.s}" if case.squares else "")
    proved = f"{rate:g} | {float(max(bounds)):.2f} s" if boxes else "not proved | "
    numbers = f"{found.rate:.4g} | {proved} | {tau:.0f} | {boxes:,}"
    return f"{name(case)} {weights} | {numbers} | {time.perf_counter() - begin:.0f} s |"


def main() -> None:
    """Print both tables."""
    ctx.prec = 64
    print("| q1 | l | b1 | b2 | V | weights | sampled c | proved c | settled within | ", end="")
    print("input at the start | boxes | took |")
    print("|" + " --- |" * 12)
    for case in CERTIFIED:
        print(certified(case), flush=True)
    print("\n| q1 | l | b1 | b2 | V | states that rule it out |\n|" + " --- |" * 6)
    for case in RULED_OUT:
        gains = Gains(q1=case.q1, l=case.l)
        witnesses = no_weights_exist(
            gains, b1=case.b1, b2=case.b2, varies=case.varies, squares=case.squares
        )
        print(f"{name(case)} {len(witnesses) or 'none found'} |", flush=True)


if __name__ == "__main__":
    main()
