"""What ``parkproof falsify`` prints: the worst of every number, alarms, and how to replay."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from parkproof.falsification.claims import TIME, word
from parkproof.falsification.confirm import FINER, Exceeded, Replayed
from parkproof.falsification.search import Falsification, Worst
from parkproof.simulation.outcome import Outcome

if TYPE_CHECKING:
    from rich.console import Console

    from parkproof.falsification.read import Target


def nearest(found: Sequence[Worst]) -> Worst:
    """The run that comes nearest to its bound, or goes farthest beyond.

    Parameters
    ----------
    found : sequence of Worst
        At least one.

    Returns
    -------
    Worst
        The first where none has a bound.

    Examples
    --------
    >>> nearest([])
    Traceback (most recent call last):
    ...
    ValueError: ...
    """
    return max(found, key=lambda one: -math.inf if math.isnan(one.share) else one.share)


def print_falsification(
    console: "Console", found: Falsification, target: "Target", exceeded: Sequence[Exceeded]
) -> None:
    """Print a table of all numbers, and a line for each that is exceeded.

    Parameters
    ----------
    console : Console
        Where to print.
    found : Falsification
        What the search found.
    target : Target
        What it was for.
    exceeded : sequence of Exceeded
        Each run that goes beyond its bound.
    """
    from rich import box
    from rich.table import Table

    if found.interrupted:
        console.print("Interrupted: this is the worst until then, not run again.")
    what = "proved" if target.proved else "limit"
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("number", no_wrap=True)
    for name in (what, "worst found", f"found / {what}"):
        table.add_column(name, justify="right", no_wrap=True)
    for one in found.worst:
        bound, share = one.claim.bound, one.share
        size = one.outcome.value if math.isinf(one.size) else f"{one.size:.4g}"
        table.add_row(
            word(one.claim),
            "none" if math.isinf(bound) else f"{bound:.4g}",
            size,
            "" if math.isnan(share) else ("broken" if math.isinf(share) else f"{share:.3f}"),
        )
    console.print(f"{found.runs} runs", style="bold")
    console.print(table)
    for beyond in exceeded:
        console.print(_sentence(beyond, proved=target.proved), soft_wrap=True)
    if not exceeded:
        console.print(f"No run went beyond what is {'proved' if target.proved else 'asked'}.")


def _sentence(exceeded: Exceeded, *, proved: bool) -> str:
    """Say of a number that it is exceeded, and whether sampling alone did that."""
    one = exceeded.worst
    said = f"{word(one.claim)} = {one.size:.6g}, and {one.claim.bound:.6g} is the bound"
    if one.claim.name == TIME and math.isinf(one.size):
        said = f"a run does not park ({one.outcome.value})"
    if not proved:
        return f"BROKEN: {said}."
    if exceeded.finer is None:
        return f"ALARM: {said}; it was not sampled more finely."
    period = one.scenario.run.control_period / FINER
    if exceeded.holds_up:
        return f"ALARM: {said}; so it is where the run is sampled every {period:g} s."
    return (
        f"Note: {said}; sampled every {period:g} s the same run comes to {exceeded.finer:.6g}: the "
        "proof is of continuous time, and this is what sampling adds."
    )


def record_of(
    found: Falsification,
    target: "Target",
    exceeded: Sequence[Exceeded],
    worst: Worst,
    replay: Replayed | None,
    out: Path,
) -> dict[str, Any]:
    """Make of a search what ``--json`` prints; None where there is no such number.

    Parameters
    ----------
    found : Falsification
        What the search found.
    target : Target
        What it was for.
    exceeded : sequence of Exceeded
        Each run that goes beyond its bound.
    worst : Worst
        The run that was written.
    replay : Replayed or None
        The same run by the plain reference.
    out : Path
        Its scenario.

    Returns
    -------
    dict
        Numbers, texts, lists and dicts.
    """
    beyond = {one.worst.claim.name: one for one in exceeded}
    written: dict[str, Any] = {"number": word(worst.claim), "scenario": str(out), "replay": None}
    if replay is not None:
        written["replay"] = {
            "outcome": replay.outcome.value, "size": _finite(replay.size), "same": replay.same
        }  # fmt: skip
    return {
        "proved": target.proved,
        "runs": found.runs,
        "numbers": [_number(one, beyond.get(one.claim.name)) for one in found.worst],
        "written": written,
    }


def _number(one: Worst, exceeded: Exceeded | None) -> dict[str, Any]:
    """What was found for one number."""
    again = None if exceeded is None or exceeded.finer is None else _finite(exceeded.finer)
    return {
        "number": word(one.claim),
        "bound": _finite(one.claim.bound),
        "worst": _finite(one.size),
        "share": _finite(one.share),
        "outcome": one.outcome.value,
        "exceeded": exceeded is not None,
        "sampled_finely": again,
        "broken": exceeded is not None and exceeded.holds_up,
    }


def _finite(number: float) -> float | None:
    """The number, or None for one that JSON has not."""
    return float(number) if math.isfinite(number) else None


def print_replay(console: "Console", worst: Worst, replay: Replayed | None, out: Path) -> None:
    """Say which run was written, how it went when it was carried out again, and how to do so.

    Parameters
    ----------
    console : Console
        Where to print.
    worst : Worst
        The run.
    replay : Replayed or None
        The same run by the plain reference.
    out : Path
        Its scenario.
    """
    name = word(worst.claim)
    console.print()
    if replay is not None:
        alike = "the same" if replay.same else "NOT the same"
        console.print(
            f"Run again by the plain simulator: {_ended(replay.outcome, replay.size, name)}; "
            f"in the search: {_ended(worst.outcome, worst.size, name)}: {alike}.",
            soft_wrap=True,
        )
    console.print(
        f"Wrote the worst run for {name} to {out}; replay it with: parkproof park {out}",
        soft_wrap=True,
    )


def _ended(outcome: Outcome, size: float, name: str) -> str:
    """How a run ended, and what it came to."""
    return outcome.value if math.isinf(size) else f"{outcome.value}, {name} = {size:.6g}"
