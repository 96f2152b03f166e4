"""Trials of a campaign that contradict a certificate."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.report.measured import Compared, proven_numbers
from parkproof.report.trial_table import PARKED, TrialTable

Flags = NDArray[np.bool_]

NAMED = 20
"""At most so many trials are named."""


@dataclass(frozen=True)
class Violation:
    """A trial that a certificate speaks of, and that does not keep what is proved.

    Attributes
    ----------
    trial : int
        Its number.
    broken : tuple of Compared
        The numbers it exceeds; an infinite total time where it did not park.
    """

    trial: int
    broken: tuple[Compared, ...]


@dataclass(frozen=True)
class AgainstProof:
    """A campaign beside a certificate.

    Attributes
    ----------
    compared : tuple of Compared
        Every proven number beside the worst of the trials that it speaks of.
    covered : array of bool
        Which trials the certificate speaks of, in the order of the table.
    outside : dict of str to int
        Why it does not speak of the others, and of how many; a trial may count more than once.
    violating : int
        Number of trials that contradict it.
    named : tuple of Violation
        The first of them.
    """

    compared: tuple[Compared, ...]
    covered: Flags
    outside: dict[str, int]
    violating: int
    named: tuple[Violation, ...]


def against_proof(
    certificate: dict[str, Any],
    table: TrialTable,
    outside: dict[str, Flags],
    *,
    long_enough: Flags,
) -> AgainstProof:
    """Compare every trial that a certificate speaks of with every number that is proved.

    Nothing is allowed for sampling: the theorem speaks of continuous time, trials have a control
    period.

    Parameters
    ----------
    certificate : dict
        The certificate.
    table : TrialTable
        The trials.
    outside : dict of str to array of bool
        Which trials break which assumption, in the order of the table.
    long_enough : array of bool
        Which trials last as long as the proven time; others need not park.

    Returns
    -------
    AgainstProof
        The comparison.
    """
    codes = table.outcomes
    covered = ~np.logical_or.reduce([np.zeros(len(table), dtype=bool), *outside.values()])
    broken = np.zeros(len(table), dtype=bool)
    numbers = proven_numbers(certificate["claim"])
    worst = []
    for one in numbers:
        sizes = one.sizes(table.column(one.column))
        if one.name == "total_time":
            sizes = _times(sizes, codes, long_enough)
        broken |= covered & (sizes > one.bound)
        worst.append(float(np.fmax.reduce(sizes[covered], initial=-math.inf)))
    rows = np.flatnonzero(broken)
    few = rows[:NAMED]
    return AgainstProof(
        compared=tuple(
            Compared(one.name, one.bound, most) for one, most in zip(numbers, worst, strict=True)
        )
        if covered.any()
        else (),
        covered=covered,
        outside={reason: int(flags.sum()) for reason, flags in outside.items() if flags.any()},
        violating=len(rows),
        named=_named(certificate, table, few, long_enough[few]),
    )


def _times(total: NDArray[np.float64], codes: NDArray[np.int8], long_enough: Flags) -> Any:
    """Times until parked; infinite where a trial that was long enough did not park."""
    return np.where(codes == PARKED, total, np.where(long_enough, math.inf, math.nan))


def _named(
    certificate: dict[str, Any], table: TrialTable, rows: NDArray[np.intp], long_enough: Flags
) -> tuple[Violation, ...]:
    """What a few trials break."""
    if not rows.size:
        return ()
    codes, trials = table.outcomes[rows], table.trials[rows]
    found: list[list[Compared]] = [[] for _ in rows]
    for one in proven_numbers(certificate["claim"]):
        sizes = one.sizes(table.column(one.column)[rows])
        if one.name == "total_time":
            sizes = _times(sizes, codes, long_enough)
        for broken, size in zip(found, sizes.tolist(), strict=True):
            if size > one.bound:
                broken.append(Compared(one.name, one.bound, size))
    return tuple(
        Violation(int(trial), tuple(broken)) for trial, broken in zip(trials, found, strict=True)
    )
