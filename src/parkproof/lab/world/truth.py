"""What is true in a simulated world at a moment."""

from typing import NamedTuple

from parkproof.lab.world.settings import FloorPose


class Truth(NamedTuple):
    """What is true at a moment.

    Parameters
    ----------
    t : float
        Time in s.
    x, y, theta : float
        Middle of the axle in m, and heading in rad.
    v, omega : float
        Speed along the heading in m/s and turn rate in rad/s.
    commanded_v, commanded_omega : float
        The command in force; accelerations of a robot that takes those, 0 while it brakes.
    in_view : bool
        Whether the whole black square of the tag is in the picture.

    Examples
    --------
    >>> Truth(0.0, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 0.0, True).x
    0.1
    """

    t: float
    x: float
    y: float
    theta: float
    v: float
    omega: float
    commanded_v: float
    commanded_omega: float
    in_view: bool

    @property
    def pose(self) -> FloorPose:
        """(x, y, θ)."""
        return self.x, self.y, self.theta
