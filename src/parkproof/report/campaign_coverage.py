"""Which trials of a campaign a certificate speaks of, found anew from the campaign itself.

The table holds what was drawn, not what a signal of several parts then ranges over; the campaign
gives each trial's start and signals again, as they were carried out.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.campaign.draw import drawn_values
from parkproof.campaign.ensembles import ensembles
from parkproof.campaign.prepare import Prepared
from parkproof.report.coverage import other_than_certified, outside_assumptions, tighter_limits
from parkproof.report.trial_table import OUTCOMES, TrialTable

Flags = NDArray[np.bool_]

BATCH = 16_384
"""Trials at a time: their arrays take some 20 MB."""

TIGHTER = "ended at a limit tighter than what is proved"


@dataclass(frozen=True)
class Coverage:
    """What a certificate says of the trials of a campaign.

    Attributes
    ----------
    outside : dict of str to array of bool
        By assumption, which trials break it, in the order of the table.
    long_enough : array of bool
        Which trials last as long as the proven time.
    """

    outside: dict[str, Flags]
    long_enough: Flags


def coverage_of(certificate: dict[str, Any], prepared: Prepared, table: TrialTable) -> Coverage:
    """Hold every trial of a table against the assumptions of a certificate.

    Parameters
    ----------
    certificate : dict
        The certificate.
    prepared : Prepared
        The campaign of the table.
    table : TrialTable
        Its trials.

    Returns
    -------
    Coverage
        Flags a trial.
    """
    trials, codes = table.trials, table.outcomes
    outside: dict[str, Flags] = {}
    long_enough = np.ones(len(table), dtype=bool)

    def flag(reason: str, rows: NDArray[np.intp], flags: Flags | bool) -> None:
        if np.any(flags):
            outside.setdefault(reason, np.zeros(len(table), dtype=bool))[rows] |= flags

    for first in range(0, len(table), BATCH):
        numbers = trials[first : first + BATCH]
        begin, end = int(numbers[0]), int(numbers[-1]) + 1
        drawn = drawn_values(prepared.campaign, begin, end)
        drawn = {key: values[numbers - begin] for key, values in drawn.items()}
        for members, scenario, starts in ensembles(prepared, drawn, numbers, size=BATCH):
            rows = first + members
            for reason in other_than_certified(certificate, scenario):
                flag(reason, rows, True)
            for reason, flags in outside_assumptions(certificate, starts).items():
                flag(reason, rows, flags)
            tighter = [OUTCOMES.index(one) for one in tighter_limits(certificate, scenario)]
            flag(TIGHTER, rows, np.isin(codes[rows], tighter))
            proven = certificate["claim"]["total_time"]
            long_enough[rows] = scenario.run.samples * scenario.run.control_period >= proven
    return Coverage(outside, long_enough)
