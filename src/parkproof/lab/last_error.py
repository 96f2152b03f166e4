"""How far from its goal a robot is, where nothing knows it but the pictures."""

import math
from collections.abc import Sequence

from parkproof.lab.summary import Error, Sample


def last_error(samples: Sequence[Sample], *, unit: float) -> Error | None:
    """How far the robot was from its goal when it was last seen, as estimated.

    Parameters
    ----------
    samples : sequence of Sample
        Of the run.
    unit : float
        Px of a goal unit.

    Returns
    -------
    Error or None
        In px; None if the robot was never seen.

    Examples
    --------
    >>> sample = Sample(t=0.0, x0=0.03, x1=-0.04, psi=0.0, v=0.0, omega=0.0, step=4)
    >>> last_error([sample], unit=40.0)
    Error(distance=2.0, heading_deg=0.0)
    """
    if not samples:
        return None
    last = samples[-1]
    heading = math.remainder(last.psi, 2.0 * math.pi)
    return Error(
        distance=unit * math.hypot(last.x0, last.x1), heading_deg=math.degrees(abs(heading))
    )
