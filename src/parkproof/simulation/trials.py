"""Starts and truths of many trials as arrays, which the compiled lanes read."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.model.overhead import Overhead
from parkproof.model.truth import Resolved, channel, scales
from parkproof.scenario import Scenario
from parkproof.simulation.noise import keys_of

Floats = NDArray[np.float64]

Precision = Literal["double", "single"]
"""How precisely trials are carried out."""

SIGNALS = 4
"""γ1, γ2, φ1, φ2: the signals of the inputs."""

SCALES = 3
"""α1, α2, b2: gains that may vary, too."""

CAMERA = 17
"""Nine numbers of a camera's homography from the goal's image frame to the floor, row by row, then
x and y of the corners of its picture in that frame, in order around it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Trials:
    """What differs between the trials of an ensemble; the last axis of every array is the trial.

    Attributes
    ----------
    state : (5, n) array
        x0, x1, x2, u0, u1 at the start, or x, y, θ, v, ω.
    in_chart : (n,) array
        1 where the start is a chained state, 0 where it is a pose.
    scale_mean, scale_tones : (3, n) and (3, m, 4, n) arrays
        Means of α1, α2 and b2, and their tones: amplitude, ω, phase, and 1 for a square wave.
        A tone of amplitude 0 is none, and m is 0 where no gain varies.
    mean, tones : (4, n) and (4, m, 4, n) arrays
        The same of γ1, γ2, φ1 and φ2; here m is at least 1.
    adversary : (2, n) array
        φ1^M and φ2^M where an adversary acts, else 0.
    keys : (2, n) array of whole numbers
        Keys of the noise of the measurements, from `parkproof.simulation.noise.keys_of`.
    camera : (17, n) or (0, n) array
        Each trial's camera, from `camera_numbers`; none where it is the paper's.

    Raises
    ------
    InputError
        If the arrays have other shapes, or there are no trials.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> trials = trials_of([Scenario(law="corrected", start=Start(pose=(x, 0.1, 0.0)))
    ...                     for x in (-2.0, -1.0)])
    >>> len(trials), trials.state[0].tolist()
    (2, [-2.0, -1.0])
    """

    state: Floats
    in_chart: Floats
    scale_mean: Floats
    scale_tones: Floats
    mean: Floats
    tones: Floats
    adversary: Floats
    keys: NDArray[np.int64]
    camera: Floats

    def __post_init__(self) -> None:
        n = self.in_chart.shape[-1]
        if n == 0:
            raise InputError("no trials: an ensemble needs at least one; give some")
        leading = {
            "state": (5,), "in_chart": (), "scale_mean": (SCALES,), "scale_tones": (SCALES, -1, 4),
            "mean": (SIGNALS,), "tones": (SIGNALS, -1, 4), "adversary": (2,), "keys": (2,),
            "camera": (CAMERA if len(self.camera) else 0,),
        }  # fmt: skip
        for name, wanted in leading.items():
            shape = getattr(self, name).shape
            fits = len(shape) == len(wanted) + 1 and all(
                want in {-1, have} for want, have in zip((*wanted, n), shape, strict=True)
            )
            if not fits:
                expected = ", ".join("m" if size == -1 else str(size) for size in (*wanted, n))
                raise InputError(f"{name} has the shape {shape}: must be ({expected})")

    def __len__(self) -> int:
        return int(self.in_chart.shape[-1])

    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """The arrays in the order above: what a kernel takes."""
        return tuple(getattr(self, field.name) for field in fields(self))

    def some(self, which: slice | NDArray[Any]) -> "Trials":
        """Give some of the trials.

        Parameters
        ----------
        which : slice or array
            Which; an array of whole numbers may name them in any order.

        Returns
        -------
        Trials
            These only.

        Examples
        --------
        >>> from parkproof.scenario import Start
        >>> trials = trials_of([Scenario(law="corrected", start=Start(pose=(x, 0.1, 0.0)))
        ...                     for x in (-2.0, -1.0)])
        >>> trials.some(np.array([1])).state[0].tolist()
        [-1.0]
        """
        return Trials(
            **{field.name: getattr(self, field.name)[..., which] for field in fields(self)}
        )

    @property
    def have_cameras(self) -> bool:
        """Whether each trial has a camera of its own, or all have the paper's."""
        return len(self.camera) > 0

    @property
    def jump(self) -> NDArray[np.bool_]:
        """Whether a signal of a trial is a square wave."""
        squares = np.concatenate((self.tones[:, :, 3], self.scale_tones[:, :, 3]), axis=None)
        return np.asarray((squares.reshape(-1, len(self)) > 0.0).any(axis=0), dtype=np.bool_)


def _signals(trials: Sequence[Sequence[Resolved]], least: int) -> tuple[Floats, Floats]:
    """Means and tones of each trial's signals, with room for at least so many tones."""
    most = max(least, *(len(tones) for signals in trials for _, tones in signals))
    means = np.empty((len(trials[0]), len(trials)))
    waves = np.zeros((len(trials[0]), most, 4, len(trials)))
    for j, signals in enumerate(trials):
        for i, (mean, tones) in enumerate(signals):
            means[i, j] = mean
            for m, tone in enumerate(tones):
                waves[i, m, :, j] = tone
    return means, waves


def camera_numbers(camera: Overhead) -> tuple[float, ...]:
    """Give the numbers of a camera that lanes need.

    Parameters
    ----------
    camera : PinholeTable or HomographyTable
        The camera of a scenario.

    Returns
    -------
    17 floats
        See `CAMERA`.

    Examples
    --------
    >>> from parkproof.model.overhead import PinholeTable
    >>> len(camera_numbers(PinholeTable(height=3.0, focal_length=500.0, unit=40.0))) == CAMERA
    True
    """
    return (*camera.view.from_goal.entries, *camera.view.outline)


def trials_of(scenarios: Sequence[Scenario]) -> Trials:
    """Resolve scenarios to arrays.

    Parameters
    ----------
    scenarios : sequence of Scenario
        At least one. Only start, truth, camera and ``run.seed`` are looked at, and the bounds that
        an adversary exhausts.

    Returns
    -------
    Trials
        One trial for each.

    Raises
    ------
    InputError
        If there are none, or some have a camera of their own and others have not.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> trials_of([Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)))]).mean[:, 0]
    array([1., 1., 0., 0.])
    """
    if not scenarios:
        raise InputError("no trials: an ensemble needs at least one scenario; give some")
    cameras = [s.camera for s in scenarios if s.camera is not None]
    if len(cameras) not in {0, len(scenarios)}:
        raise InputError(
            f"{len(cameras)} of {len(scenarios)} trials have a [camera]: all of an ensemble must "
            "have one, or none; give the others one, or run two ensembles"
        )
    channels = [[channel(i, s.truth, s.bounds) for i in range(2)] for s in scenarios]
    n = len(scenarios)
    state, in_chart, adversary = np.empty((5, n)), np.empty(n), np.empty((2, n))
    keys = np.empty((2, n), dtype=np.int64)
    for j, (scenario, (one, two)) in enumerate(zip(scenarios, channels, strict=True)):
        chained = scenario.start.chained
        state[:, j] = chained or (*scenario.start_pose, *scenario.start_velocity)
        in_chart[j] = 1.0 if chained else 0.0
        keys[:, j] = keys_of(scenario.run.seed)
        adversary[:, j] = one.phi_adversary, two.phi_adversary
    inputs = [
        (*((c.gamma_mean, c.gamma_tones) for c in two), *((c.phi_mean, c.phi_tones) for c in two))
        for two in channels
    ]
    # where no α and no b2 varies there are no tones, and the kernel is done with them at once
    scale_mean, scale_tones = _signals([scales(s.truth, s.bounds) for s in scenarios], 0)
    mean, tones = _signals(inputs, 1)
    camera = np.array([camera_numbers(one) for one in cameras]).T if cameras else np.empty((0, n))
    return Trials(
        state=state,
        in_chart=in_chart,
        scale_mean=scale_mean,
        scale_tones=scale_tones,
        mean=mean,
        tones=tones,
        adversary=adversary,
        keys=keys,
        camera=camera,
    )
