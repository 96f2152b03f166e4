"""The files of a run: summary.json and trajectory.parquet."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from parkproof import __version__
from parkproof.errors import InputError
from parkproof.model.signals import Noise
from parkproof.output import output_directory
from parkproof.scenario import Scenario
from parkproof.scenario_file import resolved

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from parkproof.simulation.run import Run

__all__ = [
    "UNITS",
    "notes_of",
    "output_directory",
    "read_trajectory",
    "strict",
    "summary_of",
    "write_columns",
    "write_summary",
    "write_trajectory",
]

UNITS = {
    "t": "s",
    "x0": "image unit",
    "x1": "image unit",
    "x2": "1",
    "u0": "length/s",
    "u1": "1/s",
    "v": "length/s",
    "omega": "rad/s",
    "tau1": "length/s^2",
    "tau2": "1/s^2",
    "xm": "image unit",
    "ym": "image unit",
    "theta": "rad",
    "step": "0 turn, 1 run-up, 2 approach, 3 return, 4 hold or stopped",
}
"""Unit of each column; α_i turn the robot's unit of length into the image's."""


def notes_of(scenario: Scenario) -> list[str]:
    """Say what is worth knowing about a scenario before it runs.

    Parameters
    ----------
    scenario : Scenario
        What is going to be run.

    Returns
    -------
    list of str
        Sentences; often none.

    Examples
    --------
    >>> from parkproof.bounds import Bounds
    >>> from parkproof.scenario import Start
    >>> notes_of(Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0))))
    []
    >>> for note in notes_of(Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)),
    ...                               bounds=Bounds(disturbance=2.5))):
    ...     print(note)
    tolerance[0] = 0.001 is below the band 0.005 within which a period of 1 ms holds u0 ...
    """
    switching, run = scenario.switching, scenario.run
    notes = []
    for index, (name, i, step) in enumerate((("u0", 0, 1), ("u1", 1, 2), ("u0", 0, 3))):
        band, tolerance = _band(scenario, i, step), switching.tolerance[index]
        if band <= tolerance:
            continue
        consequence = (
            f"the law therefore ends Step {step} up to {band:.2g} further out"
            if run.discretisation == "implicit"
            else f"Step {step} ends only when a sample happens to fall inside"
        )
        notes.append(
            f"tolerance[{index}] = {tolerance:g} is below the band {band:.2g} within which a "
            f"period of {1e3 * run.control_period:g} ms holds {name} under the largest gain and "
            f"disturbance: {consequence}."
        )
    if run.delay_samples:
        notes.append(
            f"Measurements come {1e3 * run.delay:.4g} ms late, in whole control periods; until "
            "then the law is given that of the start."
        )
    for name in ("to_step2", "to_step3"):
        moment = getattr(switching, name)
        if scenario.law != "published" and not isinstance(moment, str) and moment < run.duration:
            notes.append(
                f"{name} = {moment:g} s: the {scenario.law} law leaves a step then only if it is "
                "inside its tolerance, else as soon as it is."
            )
        if not isinstance(moment, str) and moment >= run.duration:
            notes.append(
                f"{name} = {moment:g} s is not before the end of the run at {run.duration:g} s: "
                "the law will not get there."
            )
    steepest = switching.chart_tangents[1]
    steepness = scenario.gains.l[0] * abs(scenario.start_pose[1]) ** scenario.gains.exponents[1]
    if scenario.law == "corrected" and steepness > steepest:
        notes.append(
            f"From this start the law asks for a heading of "
            f"{math.degrees(math.atan(steepness)):.2f}°, where it would turn again: start nearer "
            "to the goal's line, or lower l1."
        )
    if (reason := _outside_guarantee(scenario)) is not None:
        notes.append(f"This run is outside the guarantee: {reason}.")
    return notes


def _band(scenario: Scenario, i: int, step: int) -> float:
    """How far from its surface sampling lets u0 (i = 0) or u1 (i = 1) stray in a step."""
    low, high = scenario.bounds.gamma_of(i)
    phi = scenario.bounds.disturbance_of(i)
    h = scenario.run.control_period
    # in the implicit form, and in the linear law below V_min, φ moves u by at most one period's
    # worth before the input, which undoes a deviation of u within a period, balances it
    linear = scenario.law == "homogeneous" and step == 2
    if linear or scenario.run.discretisation == "implicit":
        return h * high * phi / low
    gains = scenario.gains
    q0, q1, q2 = gains.exponents
    gain, power = {
        1: (gains.lambda1, q0),
        2: (gains.l[2], (3.0 * q1 - 2.0) / (2.0 * q1 - 1.0)),
        3: (gains.k[1], (2.0 * q2 - 1.0) / q2),
    }[step]
    # the amplitude at which u' = -gain |u|^power, held for a period, throws u to the other side
    cycle = float((0.5 * h * high / low * gain) ** (1.0 / (1.0 - power)))
    return max(cycle, h * (high * phi / low + phi))


def _outside_guarantee(scenario: Scenario) -> str | None:
    """Why nothing is promised for a run, or None if the theory's assumptions hold."""
    if scenario.truth.outside_bounds:
        return "truth.outside_bounds = true lets the truth leave what the controller knows"
    if scenario.limits.saturate:
        return "limits.saturate = true clips the inputs that the law asks for"
    run = scenario.run
    if any(run.deviations) or run.delay_samples:
        return "run.noise or run.latency spoil what the law is told"
    if scenario.robot.kind == "torque" and (
        scenario.camera is not None
        or scenario.bounds.gamma_of(0) != (1.0, 1.0)
        or scenario.bounds.gamma_of(1) != (1.0, 1.0)
        or max(scenario.bounds.disturbance_of(0), scenario.bounds.disturbance_of(1)) > 0.0
    ):
        return (
            "γ and φ act on the robot's own accelerations, and what becomes of them in (6) can "
            'exceed the bounds (robot.kind = "torque")'
        )
    return None


def summary_of(run: "Run") -> dict[str, Any]:
    """Sum a run up in plain numbers, strings, lists and dicts.

    Parameters
    ----------
    run : Run
        A run that has been carried out.

    Returns
    -------
    dict
        Law, outcome, settling times, metrics, notes, and all that is needed to repeat the run:
        ``scenario`` (resolved), ``version``, ``seed``. What is not a finite number is None.

    Examples
    --------
    >>> from parkproof.scenario import RunSettings, Start
    >>> from parkproof.simulation.run import simulate
    >>> run = simulate(Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)),
    ...                         run=RunSettings(duration=12.0, control_period=0.01)))
    >>> summary = summary_of(run)
    >>> summary["outcome"], summary["assumptions"]
    ('parked', 'inside the bounds: the truth stays inside what the controller knows')
    """
    from parkproof.simulation.run import plant_steps

    scenario = run.scenario
    reason = _outside_guarantee(scenario)
    summary = {
        "title": scenario.title,
        "law": scenario.law,
        "outcome": run.outcome.value,
        "sentence": run.outcome.sentence,
        "assumptions": (
            f"outside the guarantee: {reason}"
            if reason is not None
            else "inside the bounds: the truth stays inside what the controller knows"
        ),
        "notes": notes_of(scenario),
        "ended": run.ended,
        "settling_time": msgspec.to_builtins(run.settling_time),
        "returns": run.returns,
        **msgspec.to_builtins(run.metrics),
        "robot": scenario.robot.kind,
        "discretisation": scenario.run.discretisation,
        "control_period": scenario.run.control_period,
        "noise": scenario.run.noise,
        "latency": scenario.run.delay,
        "plant_step": scenario.run.control_period / plant_steps(scenario),
        "version": __version__,
        "seed": [signal.seed for signal in scenario.truth.signals if isinstance(signal, Noise)],
        "scenario": resolved(scenario),
    }
    plain: dict[str, Any] = strict(summary)
    return plain


def strict(value: Any) -> Any:
    """Replace NaN and infinity, which JSON does not have, by None.

    Parameters
    ----------
    value : object
        Numbers, strings, lists, tuples and dicts of them.

    Returns
    -------
    object
        The same without them.

    Examples
    --------
    >>> strict({"a": [1.0, float("nan")]})
    {'a': [1.0, None]}
    """
    if isinstance(value, dict):
        return {key: strict(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [strict(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def write_summary(run: "Run", path: Path | str) -> None:
    """Write `summary_of` a run as JSON.

    Parameters
    ----------
    run : Run
        A run that has been carried out.
    path : Path or str
        The file, usually summary.json.

    Raises
    ------
    OSError
        If it cannot be written; `output_directory` turns it into an `InputError`.

    Examples
    --------
    >>> write_summary(run, directory / "summary.json")
    """
    text = msgspec.json.format(msgspec.json.encode(summary_of(run)), indent=2)
    Path(path).write_bytes(text + b"\n")


def _rows(t: "NDArray[np.float64]", period: float | None) -> "NDArray[np.intp]":
    """Indices of the rows to keep: about one each period, and always the first and the last."""
    import numpy as np

    if period is None or len(t) < 2:
        return np.arange(len(t))
    wanted = np.arange(t[0], t[-1], max(period, 0.5 * float(t[1] - t[0])))
    rows = np.searchsorted(t, wanted - 1e-9 * period)
    return np.unique(np.append(rows, len(t) - 1))


def write_trajectory(run: "Run", path: Path | str) -> None:
    """Write the samples of a run as Parquet, a row each ``run.record_period``.

    Parameters
    ----------
    run : Run
        A run that has been carried out.
    path : Path or str
        The file, usually trajectory.parquet. Its metadata hold the unit of each column, the law,
        the title and the version.

    Raises
    ------
    OSError
        If it cannot be written; `output_directory` turns it into an `InputError`.

    Examples
    --------
    >>> write_trajectory(run, directory / "trajectory.parquet")
    """
    scenario = run.scenario
    rows = _rows(run.trajectory["t"], scenario.run.record_period)
    columns = {name: values[rows] for name, values in run.trajectory.items()}
    write_columns(columns, path, law=scenario.law, title=scenario.title)


def write_columns(
    columns: "Mapping[str, NDArray[Any]]", path: Path | str, *, law: str, title: str
) -> None:
    """Write the columns of a trajectory as Parquet.

    Parameters
    ----------
    columns : mapping of str to array
        One array a column, all of one length; see `parkproof.simulation.run.COLUMNS`.
    path : Path or str
        The file, usually trajectory.parquet. Its metadata hold the unit of each column, the law,
        the title and the version.
    law, title : str
        Of the run.

    Raises
    ------
    OSError
        If it cannot be written; `output_directory` turns it into an `InputError`.

    Examples
    --------
    >>> write_columns(run.trajectory, directory / "trajectory.parquet", law="corrected", title="")
    """
    import pyarrow as pa
    from pyarrow import parquet

    from parkproof.simulation.run import COLUMNS

    schema = pa.schema(
        [
            pa.field(
                name,
                pa.int32() if name == "step" else pa.float64(),
                metadata={"unit": UNITS[name]},
            )
            for name in COLUMNS
        ],
        metadata={"parkproof": __version__, "law": law, "title": title},
    )
    table = pa.table([columns[name] for name in COLUMNS], schema=schema)
    parquet.write_table(
        table,
        str(path),
        compression="zstd",
        use_dictionary=["step"],
        use_byte_stream_split=[name for name in COLUMNS if name != "step"],
    )


def read_trajectory(path: Path | str) -> "dict[str, NDArray[np.float64]]":
    """Read a trajectory file.

    Parameters
    ----------
    path : Path or str
        A file that `write_trajectory` wrote.

    Returns
    -------
    dict of str to array
        One array a column; see `parkproof.simulation.run.COLUMNS`.

    Raises
    ------
    InputError
        If the file is missing, or is not a trajectory.

    Examples
    --------
    >>> write_trajectory(run, directory / "trajectory.parquet")
    >>> len(read_trajectory(directory / "trajectory.parquet")["t"])
    1201
    """
    import pyarrow as pa
    from pyarrow import parquet

    from parkproof.simulation.run import COLUMNS

    try:
        table = parquet.read_table(str(path))
    except (OSError, pa.ArrowException) as error:
        cause = "no such file" if isinstance(error, FileNotFoundError) else "not a Parquet file"
        raise InputError(
            f"{path}: {cause}; give the trajectory.parquet of a result directory"
        ) from error
    missing = [name for name in COLUMNS if name not in table.column_names]
    if missing:
        raise InputError(
            f"{path}: has no column {missing[0]}; give the trajectory.parquet of a result directory"
        )
    return {name: table[name].to_numpy() for name in table.column_names}
