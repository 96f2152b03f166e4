"""From drawn values straight to the arrays of the lanes, without a scenario object a trial."""

from collections.abc import Mapping, Sequence
from typing import Any, cast

import msgspec
import numpy as np
from numpy.typing import NDArray

from parkproof.campaign.waves import Parametric, means_and_tones
from parkproof.errors import InputError
from parkproof.model.signals import Adversary, Signal, Switched
from parkproof.model.unicycle import wrap_angle
from parkproof.scenario import Scenario
from parkproof.scenario_file.keys import Place
from parkproof.simulation.noise import keys_of
from parkproof.simulation.trials import Trials, trials_of

Drawn = Mapping[Place, NDArray[Any]]

_SIGNALS: dict[Place, tuple[str, int]] = {
    ("truth", "gamma", 0): ("inputs", 0),
    ("truth", "gamma", 1): ("inputs", 1),
    ("truth", "disturbance", 0): ("inputs", 2),
    ("truth", "disturbance", 1): ("inputs", 3),
    ("truth", "alpha", 0): ("scales", 0),
    ("truth", "alpha", 1): ("scales", 1),
    ("truth", "b2",): ("scales", 2),
}  # fmt: skip
"""Where each signal of the truth lies in the arrays."""

_STARTS = {"state": 0, "pose": 0, "velocity": 3}
"""Row of the first number of each key of a start."""

_SIZES = ("image_size",)
"""Keys of a camera that are no numbers to draw, but whole pixels."""


def signal_at(scenario: Scenario, place: Place) -> float | Signal:
    """Give the number or signal of the truth at a place.

    Parameters
    ----------
    scenario : Scenario
        Any.
    place : tuple
        Such as ``("truth", "gamma", 0)``.

    Returns
    -------
    float or Signal
        What is there.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> signal_at(Scenario(law="corrected", start=Start(pose=(0, 0, 0))), ("truth", "b2"))
    1.0
    """
    value = getattr(scenario.truth, str(place[1]))
    return cast(float | Signal, value if len(place) == 2 else value[place[2]])


def can_differ(scenario: Scenario, place: Place) -> bool:
    """Whether lanes of one ensemble can differ in a number.

    Parameters
    ----------
    scenario : Scenario
        What they share.
    place : tuple
        Keys and indices of the number.

    Returns
    -------
    bool
        True for numbers of the start, the camera and the truth's signals, and for the seed of the
        run.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> scenario = Scenario(law="corrected", start=Start(pose=(0, 0, 0)))
    >>> [can_differ(scenario, place) for place in (("start", "pose", 0), ("gains", "lambda1"))]
    [True, False]
    """
    if place == ("run", "seed"):
        return True
    if place[0] == "start":
        return len(place) == 3 and getattr(scenario.start, str(place[1])) is not None
    if place[0] == "camera":
        return len(place) > 1 and place[1] not in (*_SIZES, "kind") and scenario.camera is not None
    if place in _SIGNALS:
        return isinstance(signal_at(scenario, place), float)
    whole = place[:-1]
    if whole not in _SIGNALS:
        return False
    signal = signal_at(scenario, whole)
    fixed = float | Adversary | Switched
    return not isinstance(signal, fixed) and place[-1] in signal.__struct_fields__


def trials_from(scenario: Scenario, drawn: Drawn, numbers: Sequence[int]) -> Trials:
    """Make the arrays of trials.

    Parameters
    ----------
    scenario : Scenario
        What is not drawn.
    drawn : mapping of tuple to array
        Values by place, one a trial; `can_differ` says which places.
    numbers : sequence of int
        Numbers of the trials. Where measurements are noisy each trial has noise of its own, unless
        ``run.seed`` is drawn: that of ``run.seed`` plus its number.

    Returns
    -------
    Trials
        What `parkproof.simulation.trials.trials_of` makes of the same scenarios.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> scenario = Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)))
    >>> trials_from(scenario, {("start", "pose", 0): np.array([-2.0, -1.5])}, range(2)).state[0]
    array([-2. , -1.5])
    """
    count = len(numbers)
    template = trials_of([scenario]).arrays
    arrays = {
        name: np.repeat(array, count, axis=-1)
        for name, array in zip(Trials.__dataclass_fields__, template, strict=True)
    }
    seen = _through_cameras(scenario, drawn, numbers)
    if seen is not None:
        arrays["state"], arrays["camera"] = seen.state, seen.camera
    for place, values in drawn.items():
        if seen is None and place[0] == "start":
            row = _STARTS[str(place[1])] + int(place[2])
            heading = place[1:] == ("pose", 2)
            arrays["state"][row] = [wrap_angle(float(v)) for v in values] if heading else values
    for whole, (kind, row) in _SIGNALS.items():
        parts = {str(place[-1]): values for place, values in drawn.items() if place[:-1] == whole}
        means = arrays["mean" if kind == "inputs" else "scale_mean"]
        tones = arrays["tones" if kind == "inputs" else "scale_tones"]
        if whole in drawn:
            means[row] = drawn[whole]
        elif parts:
            signal = signal_at(scenario, whole)
            means[row], waves = means_and_tones(cast(Parametric, signal), parts, count)
            tones[row, : len(waves)] = waves
    seeds = _seeds(scenario, drawn, numbers)
    if seeds is not None:
        arrays["keys"] = np.array([keys_of(seed) for seed in seeds], dtype=np.int64).T
    return Trials(**arrays)


def _through_cameras(scenario: Scenario, drawn: Drawn, numbers: Sequence[int]) -> Trials | None:
    """Starts as each trial's camera sees them, and the cameras; None where none is drawn.

    These are scenarios one by one: what a camera allows depends on all of its numbers, and a start
    on the floor is elsewhere under each.
    """
    places = [place for place in drawn if place[0] in {"camera", "start"}]
    if not any(place[0] == "camera" or place[1] == "floor_pose" for place in places):
        return None
    trials = []
    for i, number in enumerate(numbers):
        values = {place: float(drawn[place][i]) for place in places}
        try:
            trials.append(
                msgspec.structs.replace(
                    scenario,
                    start=_with(scenario.start, "start", values),
                    camera=_with(scenario.camera, "camera", values),
                )
            )
        except InputError as error:
            raise InputError(f"trial {number}: {error}") from error
    return trials_of(trials)


def _with(structure: Any, name: str, values: Mapping[Place, float]) -> Any:
    """A part of a scenario with some of its numbers replaced."""
    changes: dict[str, Any] = {}
    for (whole, key, *index), value in values.items():
        if whole == name and index:
            numbers = list(changes.get(str(key), getattr(structure, str(key))))
            numbers[int(index[0])] = value
            changes[str(key)] = tuple(numbers)
        elif whole == name:
            changes[str(key)] = value
    return msgspec.structs.replace(structure, **changes)


def _seeds(scenario: Scenario, drawn: Drawn, numbers: Sequence[int]) -> list[int] | None:
    """Seeds of the measurements' noise, if trials have seeds of their own."""
    if ("run", "seed") in drawn:
        return [int(seed) for seed in drawn["run", "seed"]]
    if any(scenario.run.deviations):
        return [scenario.run.seed + number for number in numbers]
    return None
