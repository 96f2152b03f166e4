"""Sections of a campaign's page on what decides, and on the worst trials."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from parkproof.report.campaign_page import Heading, replay_of, source_of
from parkproof.report.deciders import Decider
from parkproof.report.html import number_text, picture
from parkproof.report.worst_trials import WorstTrial
from parkproof.simulation.outcome import Outcome


def sensitivity_section(heading: Heading, found: Sequence[Decider], *, trials: int) -> str:
    """Which uncertainty matters most.

    Parameters
    ----------
    heading : Heading
        What was run.
    found : sequence of Decider
        An output each.
    trials : int
        Carried out for it.

    Returns
    -------
    str
        HTML.
    """
    said = [
        f"<h3>{escape(one.question)}</h3><p>{escape(one.answer)}</p>"
        for one in found
        if one.drawing is None
    ]
    drawn = [
        f"<div><h3>{escape(one.question)}</h3>{picture(one.drawing, one.answer, kind='svg')}</div>"
        for one in found
        if one.drawing is not None
    ]
    explained = (
        "<p>Sobol' indices: the share of an output's variance that a drawn quantity accounts for "
        "alone (first order), and together with all others (total). Lines: 95 % intervals, from "
        "400 resamples. A trial that does not park counts with the duration of the run, and a "
        "distance with its logarithm.</p>"
        if trials
        else ""
    )
    source = (
        source_of(heading, trials, "further trials from the same distributions") if trials else ""
    )
    return (
        "<h2>Which uncertainty matters most</h2>"
        f'{explained}{"".join(said)}<div class="grid">{"".join(drawn)}</div>{source}'
    )


@dataclass(frozen=True)
class Rerun:
    """A trial that was carried out again to be drawn.

    Attributes
    ----------
    trial : WorstTrial
        As the table has it.
    drawing : bytes
        Its path, PNG.
    outcome : Outcome
        How the new run ended.
    """

    trial: WorstTrial
    drawing: bytes
    outcome: Outcome


def worst_section(heading: Heading, found: Sequence[Rerun]) -> str:
    """The worst trials with their paths.

    Parameters
    ----------
    heading : Heading
        What was run.
    found : sequence of Rerun
        The worst first.

    Returns
    -------
    str
        HTML.
    """
    if not found:
        return ""
    title = "The worst trial" if len(found) == 1 else f"The {len(found)} worst trials"
    images = []
    for one in found:
        trial = one.trial
        when = (
            f" after {number_text(trial.total)} s"
            if trial.outcome is Outcome.PARKED
            else f", run ended at {number_text(trial.ended)} s"
        )
        text = f"Trial {trial.trial}: {trial.outcome.value}{when}"
        if not math.isnan(trial.residual):
            text += f", residual {number_text(trial.residual)}"
        note = f"<br>{replay_of(heading, trial.trial)}"
        if one.outcome is not trial.outcome:
            note += (
                f"<br>Carried out again in plain arithmetic, it ended: {escape(one.outcome.value)}."
            )
        images.append(picture(one.drawing, text, note=note))
    return (
        f"<h2>{title}</h2>"
        "<p>Those that did not park first, then the slowest, then those with the largest residual; "
        "the first of equals. Each was carried out again to be drawn.</p>"
        f'<div class="grid">{"".join(images)}</div>' + source_of(heading, heading.trials)
    )
