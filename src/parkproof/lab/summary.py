"""Sums a run of the laboratory up: summary.json, and the trajectory that `parkproof park` writes.

States are those of the goal's image frame, in its unit: the run as the laws saw it. There the
robot's image is a unicycle, and its turn rate is βω (`parkproof.model.image_unicycle`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from parkproof import __version__
from parkproof.lab.entries import Event
from parkproof.results import strict, write_columns
from parkproof.simulation.metrics import Metrics, metrics_of
from parkproof.simulation.run import COLUMNS, HOLD, SettlingTime

IN_CHART = math.radians(89.99)
"""Beyond this heading tan ψ is no coordinate, and x2, u0, u1 are left out."""


class HowEnded(Protocol):
    """How a run ended: a member of an enum of outcomes."""

    @property
    def value(self) -> str:
        """In a word or two."""

    @property
    def sentence(self) -> str:
        """In words."""


class Sample(msgspec.Struct, frozen=True, kw_only=True):
    """The robot at one moment, as estimated from its image.

    Attributes
    ----------
    t : float
        Time since the run began, in s.
    x0, x1, psi : float
        Image pose in the goal's image frame; image unit and rad.
    v, omega : float
        Speed in m/s and turn rate in rad/s that the robot was told, or has.
    step : int
        The step of the law.
    beta : float
        Gain of the turn rate in the goal's image frame, positive.
    tau : tuple of 2 floats
        Inputs of a torque-commanded robot; NaN where they are not kept.
    """

    t: float
    x0: float
    x1: float
    psi: float
    v: float
    omega: float
    step: int
    beta: float = 1.0
    tau: tuple[float, float] = (math.nan, math.nan)


class FrameCounts(msgspec.Struct, frozen=True, kw_only=True):
    """How the frames of a run fared.

    Attributes
    ----------
    seen : int
        Frames in which the tag was found.
    without_tag : int
        Frames in which it was not.
    missing : int
        Times that no frame came.
    dropped : int
        Frames that the camera took and that never came: gaps in their numbers.
    out_of_view : int or None
        Frames in which the tag's black square was not wholly in the picture; None where that is not
        known.
    """

    seen: int
    without_tag: int = 0
    missing: int = 0
    dropped: int = 0
    out_of_view: int | None = None


class Error(msgspec.Struct, frozen=True, kw_only=True):
    """How far from its goal the robot is at the end.

    Attributes
    ----------
    distance : float
        In the unit that its name in the summary says.
    heading_deg : float
        In degrees.
    """

    distance: float
    heading_deg: float


class Setting(msgspec.Struct, frozen=True, kw_only=True):
    """What pictures of a run need to know of its setting.

    Attributes
    ----------
    law : str
        The law.
    title : str
        What the run is called.
    view_outline : tuple of pairs
        Corners of the camera's picture in the goal's image frame, in order.
    """

    law: str
    title: str = ""
    view_outline: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class LabRun:
    """A run of the laboratory, at its end.

    Attributes
    ----------
    scenario : Setting
        What it is called, its law, what the camera sees.
    outcome : HowEnded
        How it ended: a member of an enum, with a ``sentence``.
    parked : bool
        Whether it ended parked.
    ended : float
        When it ended, in s since it began.
    samples : sequence of Sample
        The estimate of each frame in which the tag was found, in order of time.
    frames : FrameCounts
        How the frames fared.
    latencies : sequence of float
        From each image in to its command out, in s.
    image_error, true_error : Error or None
        At the end: in px, and in m where the truth is known.
    events : sequence of Event
        What happened.
    notes : sequence of str
        What else is worth knowing, such as a recording that is not whole.
    settings : dict
        All that a replay needs.

    Examples
    --------
    >>> from parkproof.simulation.outcome import Outcome
    >>> samples = [Sample(t=0.0, x0=-1.0, x1=0.5, psi=0.1, v=0.2, omega=0.0, step=2)]
    >>> run = LabRun(scenario=Setting(law="corrected"), outcome=Outcome.STILL_MOVING, parked=False,
    ...              ended=0.0, samples=samples, frames=FrameCounts(seen=1), latencies=[0.004])
    >>> run.trajectory["x1"].tolist()
    [0.5]
    """

    scenario: Setting
    outcome: HowEnded
    parked: bool
    ended: float
    samples: Sequence[Sample]
    frames: FrameCounts
    latencies: Sequence[float] = ()
    image_error: Error | None = None
    true_error: Error | None = None
    events: Sequence[Event] = ()
    notes: Sequence[str] = ()
    settings: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def trajectory(self) -> dict[str, NDArray[Any]]:
        """Columns as those of a simulated run; see `parkproof.simulation.run.COLUMNS`."""
        rows = [_row(sample) for sample in self.samples]
        table = np.array(rows, np.float64).reshape(-1, len(COLUMNS))
        columns: dict[str, NDArray[Any]] = dict(zip(COLUMNS, table.T.copy(), strict=True))
        columns["step"] = columns["step"].astype(np.int32)
        return columns

    @cached_property
    def settling_time(self) -> SettlingTime:
        """When the steps last ended."""
        ends, _, _ = self._ends
        steps: dict[str, float | None] = {
            str(i): ends.get(i) for i in range(HOLD) if i > 0 or 0 in ends
        }
        return SettlingTime(total=ends.get(HOLD - 1) if self.parked else None, steps=steps)

    @property
    def returns(self) -> int:
        """How often the law went back to an earlier step."""
        return self._ends[1]

    @cached_property
    def metrics(self) -> Metrics:
        """Residual, excursion and so on; of a run with a sample at least."""
        return metrics_of(self.trajectory, end_of_step2=self._ends[2])

    @cached_property
    def _ends(self) -> tuple[dict[int, float], int, float | None]:
        """When each step last ended, how often an earlier one came back, when 2 first ended."""
        ends: dict[int, float] = {}
        returns, first = 0, None
        for before, now in pairwise(self.samples):
            if now.step > before.step:
                ends[before.step] = now.t
                if before.step == 2 and first is None:
                    first = now.t
            elif now.step < before.step:
                returns += 1
                ends = {i: t for i, t in ends.items() if i < now.step}
        return ends, returns, first


def _row(sample: Sample) -> tuple[float, ...]:
    """A sample in the columns of a trajectory."""
    psi = math.remainder(sample.psi, 2.0 * math.pi)
    x2 = u0 = u1 = math.nan
    if abs(psi) < IN_CHART:
        c = math.cos(psi)
        x2, u0, u1 = math.tan(psi), sample.v * c, sample.beta * sample.omega / (c * c)
    return (
        sample.t, sample.x0, sample.x1, x2, u0, u1, sample.v, sample.omega, *sample.tau,
        sample.x0, sample.x1, psi, sample.step,
    )  # fmt: skip


def summary_of(run: LabRun) -> dict[str, Any]:
    """Sum a run up in plain numbers, strings, lists and dicts.

    Parameters
    ----------
    run : LabRun
        The run.

    Returns
    -------
    dict
        Outcome, errors at the end, frames, latency, events, settling times, metrics, and
        ``settings``. What is not a finite number is None.

    Examples
    --------
    >>> from parkproof.simulation.outcome import Outcome
    >>> sample = Sample(t=0.0, x0=-1.0, x1=0.5, psi=0.1, v=0.2, omega=0.0, step=2)
    >>> run = LabRun(scenario=Setting(law="corrected"), outcome=Outcome.STILL_MOVING, parked=False,
    ...              ended=0.0, samples=[sample], frames=FrameCounts(seen=1),
    ...              latencies=[0.004, 0.006])
    >>> summary = summary_of(run)
    >>> summary["outcome"], summary["latency"]["median"]
    ('still moving', 0.005)
    """
    metrics = msgspec.to_builtins(run.metrics) if run.samples else {}
    if all(math.isnan(tau) for sample in run.samples for tau in sample.tau):
        for name in ("peak_tau", "rms_tau", "total_variation_tau"):
            metrics.pop(name, None)
    summary = {
        "title": run.scenario.title,
        "law": run.scenario.law,
        "outcome": run.outcome.value,
        "sentence": run.outcome.sentence,
        "notes": list(run.notes),
        "ended": run.ended,
        "image_error": _error(run.image_error, "px"),
        "true_error": _error(run.true_error, "m"),
        "frames": msgspec.to_builtins(run.frames),
        "latency": _latency(run.latencies),
        "events": [
            {"t": event.t, "name": event.name, "sentence": event.sentence} for event in run.events
        ],
        "settling_time": msgspec.to_builtins(run.settling_time),
        "returns": run.returns,
        **metrics,
        "version": __version__,
        "settings": msgspec.to_builtins(run.settings),
    }
    plain: dict[str, Any] = strict(summary)
    return plain


def _error(error: Error | None, unit: str) -> dict[str, float] | None:
    if error is None:
        return None
    return {f"distance_{unit}": error.distance, "heading_deg": error.heading_deg}


def _latency(latencies: Sequence[float]) -> dict[str, Any] | None:
    """Image in to command out."""
    if not len(latencies):
        return None
    median, high = np.quantile(np.asarray(latencies, np.float64), (0.5, 0.99)).tolist()
    return {
        "what": "image in to command out, in s",
        "median": median,
        "percentile_99": high,
        "greatest": float(max(latencies)),
        "count": len(latencies),
    }


def write_summary(run: LabRun, path: Path | str) -> None:
    """Write `summary_of` a run as JSON.

    Parameters
    ----------
    run : LabRun
        The run.
    path : Path or str
        The file, usually summary.json.

    Raises
    ------
    OSError
        If it cannot be written; `parkproof.output.output_directory` turns it into an `InputError`.

    Examples
    --------
    >>> write_summary(lab_run, directory / "summary.json")
    """
    text = msgspec.json.format(msgspec.json.encode(summary_of(run)), indent=2)
    Path(path).write_bytes(text + b"\n")


def write_trajectory(run: LabRun, path: Path | str) -> None:
    """Write the samples of a run as Parquet, with the columns of a simulated run.

    Parameters
    ----------
    run : LabRun
        The run.
    path : Path or str
        The file, usually trajectory.parquet; `parkproof.results.read_trajectory` reads it.

    Raises
    ------
    OSError
        If it cannot be written; `parkproof.output.output_directory` turns it into an `InputError`.

    Examples
    --------
    >>> write_trajectory(lab_run, directory / "trajectory.parquet")
    """
    write_columns(run.trajectory, path, law=run.scenario.law, title=run.scenario.title)
