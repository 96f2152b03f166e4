"""What a controller is given: the true measurement, with noise, and late."""

from collections import deque

from parkproof.laws.controller import Measurement, measured_pose, measured_state
from parkproof.model.chained import ChainedState
from parkproof.scenario import RunSettings
from parkproof.simulation.noise import CHANNELS, keys_of, standard_noise


class Sensor:
    """Noise and latency of a run's measurements; with neither, it hands on what it is given.

    Parameters
    ----------
    run : RunSettings
        Its noise, latency and seed.

    Examples
    --------
    >>> sensor = Sensor(RunSettings(control_period=0.1, latency=0.2))
    >>> [sensor.seen(k, measured_pose(0.1 * k, k, 0.0, 0.0), in_chart=False).x0 for k in range(5)]
    [0, 0, 0, 1, 2]
    """

    def __init__(self, run: RunSettings) -> None:
        self._deviations = run.deviations
        self._noisy = any(self._deviations)
        self._keys = keys_of(run.seed)
        self._late = run.delay_samples > 0
        self._past: deque[Measurement] = deque(maxlen=run.delay_samples + 1)

    def seen(self, sample: int, true: Measurement, *, in_chart: bool) -> Measurement:
        """What the controller is given at a sample.

        Parameters
        ----------
        sample : int
            Number of the sample; they come one after the other from 0.
        true : Measurement
            The exact measurement.
        in_chart : bool
            Whether noise is that of x0, x1, x2, u0, u1, or of x, y, θ, v, ω.

        Returns
        -------
        Measurement
            Of the time of the sample. Until the latency is over, that of the start.

        Examples
        --------
        See `Sensor`.
        """
        now = self._with_noise(sample, true, in_chart) if self._noisy else true
        if not self._late:
            return now
        self._past.append(now)
        return self._past[0]._replace(t=true.t)

    def _with_noise(self, sample: int, m: Measurement, in_chart: bool) -> Measurement:
        off = [
            deviation * standard_noise(*self._keys, sample, channel) if deviation > 0.0 else 0.0
            for channel, deviation in zip(range(CHANNELS), self._deviations, strict=True)
        ]
        if in_chart:
            given = (m.x0, m.x1, m.x2, m.u0, m.u1)
            state = ChainedState(*(value + error for value, error in zip(given, off, strict=True)))
            return measured_state(m.t, state, m.beta)
        x, y, theta = m.x0 + off[0], m.x1 + off[1], m.theta + off[2]
        v, omega = m.v + off[3], m.omega + off[4]
        return measured_pose(m.t, x, y, theta, v=v, omega=omega, beta=m.beta)
