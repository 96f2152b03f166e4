"""One trial of a campaign again, alone, by the plain reference, beside its row."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from parkproof.campaign.definition import campaign_from_dict
from parkproof.campaign.directory import RECORD, read_record
from parkproof.campaign.prepare import prepare
from parkproof.campaign.table import row_of
from parkproof.scenario import Scenario
from parkproof.simulation.run import Run
from parkproof.simulation.trials import Precision


@dataclass(frozen=True)
class Trial:
    """A trial of a campaign.

    Attributes
    ----------
    scenario : Scenario
        That repeats it.
    row : dict of str to object
        What the campaign found.
    precision : "double" or "single"
        How precisely; a run of the scenario is in doubles.

    Examples
    --------
    >>> Trial(run.scenario, {"outcome": "parked", "total": run.settling_time.total}).same(run)
    True
    """

    scenario: Scenario
    row: dict[str, Any]
    precision: Precision = "double"

    def same(self, run: Run) -> bool:
        """Whether a run of it ends as the campaign's did.

        Parameters
        ----------
        run : Run
            Of its scenario.

        Returns
        -------
        bool
            Whether the outcomes are the same; times may differ by a few periods.

        Examples
        --------
        See `Trial`.
        """
        return bool(self.row["outcome"] == run.outcome.value)

    def compared(self, run: Run) -> str:
        """Say how a run of it compares with the campaign's.

        Parameters
        ----------
        run : Run
            Of its scenario.

        Returns
        -------
        str
            A sentence.

        Examples
        --------
        >>> Trial(run.scenario, {"outcome": "diverged", "total": float("nan")}).compared(run)
        'In the campaign: diverged. Alone: parked after ... s. The outcomes differ.'
        """
        total = run.settling_time.total
        there = _said(self.row["outcome"], self.row["total"])
        alone = _said(run.outcome.value, math.nan if total is None else total)
        how = "" if self.precision == "double" else ", in single precision"
        said = f"In the campaign{how}: {there}. Alone: {alone}."
        if not self.same(run):
            return f"{said} The outcomes differ."
        if total is None:
            return f"{said} The outcomes are the same."
        off = total - self.row["total"]
        periods = round(off / self.scenario.run.control_period)
        if periods == 0:
            return f"{said} Both are the same."
        return f"{said} The settling times differ by {off:.3g} s, {abs(periods)} control periods."


def _said(outcome: str, total: float) -> str:
    return outcome if math.isnan(total) else f"{outcome} after {total:.4f} s"


def is_campaign(path: Path) -> bool:
    """Whether a path is the directory of a campaign.

    Parameters
    ----------
    path : Path
        Any.

    Returns
    -------
    bool
        Whether it has a campaign.json.

    Examples
    --------
    >>> is_campaign(directory)
    False
    """
    return (path / RECORD).is_file()


def trial_of(path: Path, trial: int) -> Trial:
    """Find a trial of a campaign.

    Parameters
    ----------
    path : Path
        The directory of a campaign.
    trial : int
        Number of the trial, from 0.

    Returns
    -------
    Trial
        Its scenario and its row.

    Raises
    ------
    InputError
        If the directory is no campaign's, or has no such trial.

    Examples
    --------
    >>> trial_of(directory, 0)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: ...: is no directory of a campaign (it has no campaign.json); ...
    """
    record = read_record(path)
    row = row_of(path, trial)
    campaign = campaign_from_dict(record["campaign"], where=str(path / RECORD))
    scenario = prepare(campaign, where=str(path / RECORD), check=False).scenario_of(trial)
    return Trial(scenario, row, campaign.precision)
