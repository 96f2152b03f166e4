"""The worst trials of a campaign: which they are, and their paths in the picture."""

from dataclasses import dataclass

import numpy as np

from parkproof.report.path_picture import draw_path, window_of
from parkproof.report.style import DrawnRun, bytes_of, drawing, new_figure
from parkproof.report.trial_table import OUTCOMES, PARKED, TrialTable
from parkproof.simulation.outcome import Outcome

COUNT = 10


@dataclass(frozen=True)
class WorstTrial:
    """One of the worst trials, as the table has it.

    Attributes
    ----------
    trial : int
        Its number.
    outcome : Outcome
        How it ended.
    total, residual, ended : float
        Time until parked, residual and end of the run in s; NaN where there is none.
    """

    trial: int
    outcome: Outcome
    total: float
    residual: float
    ended: float


def worst_of(table: TrialTable, *, count: int = COUNT) -> list[WorstTrial]:
    """Find the worst trials: not parked before parked, then slow before fast, then by residual.

    Parameters
    ----------
    table : TrialTable
        All trials.
    count : int
        How many.

    Returns
    -------
    list of WorstTrial
        The worst first; of equals the one with the smaller number.
    """
    codes, trials, total = table.outcomes, table.trials, table.column("total")
    # a trial without a residual ended early, and one without a time did not park
    residual = np.nan_to_num(table.column("residual"), nan=np.inf)
    slowness = np.nan_to_num(total, nan=np.inf)
    order = np.lexsort((-residual, -slowness, codes == PARKED))[
        :count
    ]  # stable: of equals the first
    ended = table.column("ended")
    return [
        WorstTrial(
            trial=int(trials[row]),
            outcome=OUTCOMES[codes[row]],
            total=float(total[row]),
            residual=float(residual[row]) if np.isfinite(residual[row]) else float("nan"),
            ended=float(ended[row]),
        )
        for row in order
    ]


def path_panel(run: DrawnRun) -> bytes:
    """Draw the path of a run, small enough for several beside each other.

    Parameters
    ----------
    run : DrawnRun
        The run.

    Returns
    -------
    bytes
        PNG.

    Examples
    --------
    >>> path_panel(run)[1:4]
    b'PNG'
    """
    with drawing():
        figure = new_figure(5.6, 4.2)
        axes = figure.add_axes((0.145, 0.115, 0.84, 0.805))
        draw_path(axes, run)
        if window_of(run)[1]:  # all of the path is inside: leave room for arcs of turns, too
            axes.set_xlim(_wider(axes.get_xlim()))
            axes.set_ylim(_wider(axes.get_ylim()))
    return bytes_of(figure, "png", dpi=110.0)


def _wider(ends: tuple[float, float]) -> tuple[float, float]:
    """A range a little wider about its middle."""
    middle, half = 0.5 * (ends[0] + ends[1]), 0.56 * (ends[1] - ends[0])
    return middle - half, middle + half
