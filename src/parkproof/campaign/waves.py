"""Signals whose parameters differ from trial to trial, as arrays of means and tones."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.model.signals import TONES, Constant, Noise, Sine, Square, noise_spectrum

Parametric = Constant | Sine | Square | Noise
"""Signals that have parameters."""

Floats = NDArray[np.float64]


def means_and_tones(
    signal: Parametric, drawn: Mapping[str, Floats], count: int
) -> tuple[Floats, Floats]:
    """Resolve a signal for many trials, each as its ``mean_and_tones`` would.

    Parameters
    ----------
    signal : Parametric
        What is not drawn.
    drawn : mapping of str to array
        Values of the parameters that are: ``value``, or ``mean``, ``amplitude`` and so on.
    count : int
        Number of trials.

    Returns
    -------
    (count,) and (m, 4, count) arrays
        Mean; amplitude, ω, phase and squareness of m tones.

    Examples
    --------
    >>> mean, tones = means_and_tones(Sine(amplitude=1.0, omega=2.0),
    ...                               {"amplitude": np.array([0.1, 0.2])}, 2)
    >>> mean.tolist(), tones[0, 0].tolist()
    ([0.0, 0.0], [0.1, 0.2])
    """

    def of(name: str) -> Floats:
        return np.asarray(drawn[name] if name in drawn else np.full(count, getattr(signal, name)))

    if isinstance(signal, Constant):
        return of("value"), np.empty((0, 4, count))
    if isinstance(signal, Sine | Square):
        square = np.full(count, 1.0 if isinstance(signal, Square) else 0.0)
        return of("mean"), np.stack([of("amplitude"), of("omega"), of("phase"), square])[None]
    return of("mean"), _noise_tones(of("amplitude"), of("bandwidth"), of("seed"))


def _noise_tones(amplitude: Floats, bandwidth: Floats, seed: NDArray[Any]) -> Floats:
    """Tones of noise; equal seeds are worked out once."""
    tones = np.zeros((TONES, 4, len(seed)))
    seeds, which = np.unique(seed, return_inverse=True)
    spectra = [noise_spectrum(int(one)) for one in seeds]
    places, phases, weights = (np.stack(parts)[which].T for parts in zip(*spectra, strict=True))
    sums = np.array([weights.sum() for _, _, weights in spectra])[which]
    tones[:, 0] = amplitude * weights / sums
    tones[:, 1] = bandwidth * places / TONES
    tones[:, 2] = phases
    return tones
