"""What decides how a campaign's trials end: its outputs, their Sobol' indices, and an answer."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.report.html import number_text
from parkproof.report.sensitivity import Sensitivity
from parkproof.report.sensitivity_picture import ranked, sensitivity_bars
from parkproof.simulation.outcome import Outcome

Array = NDArray[np.float64]

QUESTIONS = ("Whether it parks", "Time until parked", "Largest distance from the goal")
"""The outputs. A trial that does not park counts with the run's duration; of a distance the
logarithm is taken."""

RARE = 0.01
"""Share of trials that park, or do not, below which nothing is said about why."""

NEAREST = 1e-9
"""Smallest distance whose logarithm is taken."""


@dataclass(frozen=True)
class Decider:
    """What decides one output, or why that cannot be said.

    Attributes
    ----------
    question : str
        What the output is, in plain text.
    answer : str
        In plain text.
    drawing : bytes or None
        Bars, SVG.
    """

    question: str
    answer: str
    drawing: bytes | None = None


def outputs_of(rows: Mapping[str, Any], duration: float) -> Array:
    """The outputs of trials, all of them finite.

    Parameters
    ----------
    rows : mapping
        Outcomes and metrics, from `simulate_ensemble`.
    duration : float
        Of a trial in s.

    Returns
    -------
    array (3, trials)
        In the order of QUESTIONS.

    Examples
    --------
    >>> rows = {"outcome": np.array([Outcome.PARKED, Outcome.MISSED]),
    ...         "total": np.array([7.0, np.nan]), "excursion": np.array([0.1, np.inf])}
    >>> outputs_of(rows, 15.0)[:2].tolist()
    [[1.0, 0.0], [7.0, 15.0]]
    """
    parked = np.asarray(rows["outcome"] == Outcome.PARKED)
    far = np.nan_to_num(rows["excursion"], nan=1.0 / NEAREST, posinf=1.0 / NEAREST)
    return np.array(
        [
            parked.astype(np.float64),
            np.where(parked, rows["total"], duration),
            np.log10(np.maximum(far, NEAREST)),
        ]
    )


def deciders_of(found: Sensitivity) -> list[Decider]:
    """Answer each question, as far as the indices allow.

    Parameters
    ----------
    found : Sensitivity
        Of `outputs_of`.

    Returns
    -------
    list of Decider
        One for each of QUESTIONS.
    """
    return [_answer(found, output, question) for output, question in enumerate(QUESTIONS)]


def _answer(found: Sensitivity, output: int, question: str) -> Decider:
    values = found.values[output]
    count = len(values)
    if output == 0:
        parked = int(values.sum())
        if min(parked, count - parked) < RARE * count:
            few = "parked" if parked < count - parked else "did not park"
            return Decider(
                question,
                f"{parked:,} of {count:,} independent trials parked: too few {few} to say what "
                "decides it.",
            )
    if not np.ptp(values) > 0.0:
        return Decider(question, f"The same in all of {count:,} independent trials.")
    first = ranked(found, output)[0]
    alone, total = found.first[output, first], found.total[output, first]
    low, high = found.total_range[:, output, first]
    answer = (
        f"Most depends on {found.inputs[first]}: {number_text(alone)} of the variance alone, "
        f"{number_text(total)} ({number_text(low)} to {number_text(high)}) with others"
    )
    return Decider(question, answer, sensitivity_bars(found, output))
