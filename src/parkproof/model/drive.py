"""The differential drive: two driven wheels on one axle, a free castor, no slip.

The mass centre lies midway between the wheels, as in section 2 of the paper; the wheels' own
inertia is counted in the mass and the inertia given.
"""

from dataclasses import dataclass, fields
from typing import NamedTuple

from parkproof.model.unicycle import Velocity
from parkproof.scalar import scalar
from parkproof.validate import finite, positive


class Wheels(NamedTuple):
    """One number for each driven wheel: speeds in rad/s, or torques in N m.

    Parameters
    ----------
    right, left : float
        The right and the left wheel's number, positive forwards.

    Examples
    --------
    >>> from parkproof.model.drive import Wheels
    >>> Wheels(right=4.0, left=2.0).left
    2.0
    """

    right: float
    left: float


class Acceleration(NamedTuple):
    """Rates of the two velocities of a unicycle.

    Parameters
    ----------
    v_dot : float
        Rate of the forward speed in m/s².
    omega_dot : float
        Rate of the turn rate in rad/s².

    Examples
    --------
    >>> from parkproof.model.drive import Acceleration
    >>> Acceleration(v_dot=0.5, omega_dot=0.0).v_dot
    0.5
    """

    v_dot: float
    omega_dot: float


@scalar
def body_from_wheels(
    right: float, left: float, wheel_radius: float, half_track: float
) -> tuple[float, float]:
    """Body velocity from wheel speeds: v = r(w_r + w_l)/2, ω = r(w_r − w_l)/(2R).

    Parameters
    ----------
    right, left : float
        Wheel speeds in rad/s.
    wheel_radius : float
        r in m.
    half_track : float
        R in m, half the distance between the wheels.

    Returns
    -------
    tuple of float
        (v, ω) in m/s and rad/s.

    Examples
    --------
    >>> from parkproof.model.drive import body_from_wheels
    >>> body_from_wheels(3.0, 1.0, 0.5, 0.25)
    (1.0, 2.0)
    """
    return (
        0.5 * wheel_radius * (right + left),
        0.5 * wheel_radius * (right - left) / half_track,
    )


@scalar
def wheels_from_body(
    v: float, omega: float, wheel_radius: float, half_track: float
) -> tuple[float, float]:
    """Wheel speeds from body velocity: (v ± Rω)/r.

    Parameters
    ----------
    v, omega : float
        Body velocity in m/s and rad/s.
    wheel_radius, half_track : float
        r and R in m.

    Returns
    -------
    tuple of float
        (right, left) in rad/s.

    Examples
    --------
    >>> from parkproof.model.drive import wheels_from_body
    >>> wheels_from_body(1.0, 2.0, 0.5, 0.25)
    (3.0, 1.0)
    """
    return (v + half_track * omega) / wheel_radius, (v - half_track * omega) / wheel_radius


@scalar
def acceleration_from_torques(
    right: float, left: float, wheel_radius: float, half_track: float, mass: float, inertia: float
) -> tuple[float, float]:
    """Body acceleration from wheel torques: m v̇ = (T_r + T_l)/r, I ω̇ = (T_r − T_l)R/r.

    Parameters
    ----------
    right, left : float
        Wheel torques in N m.
    wheel_radius, half_track : float
        r and R in m.
    mass : float
        m in kg.
    inertia : float
        I in kg m², about the vertical through the middle of the axle.

    Returns
    -------
    tuple of float
        (v̇, ω̇) in m/s² and rad/s².

    Examples
    --------
    >>> from parkproof.model.drive import acceleration_from_torques
    >>> acceleration_from_torques(3.0, 1.0, 0.5, 0.25, 4.0, 0.5)
    (2.0, 2.0)
    """
    return (
        (right + left) / (wheel_radius * mass),
        (right - left) * half_track / (wheel_radius * inertia),
    )


@scalar
def torques_from_acceleration(
    v_dot: float,
    omega_dot: float,
    wheel_radius: float,
    half_track: float,
    mass: float,
    inertia: float,
) -> tuple[float, float]:
    """Wheel torques that give a body acceleration: r(m v̇ ± I ω̇/R)/2.

    Parameters
    ----------
    v_dot, omega_dot : float
        Body acceleration in m/s² and rad/s².
    wheel_radius, half_track : float
        r and R in m.
    mass, inertia : float
        m in kg and I in kg m².

    Returns
    -------
    tuple of float
        (right, left) in N m.

    Examples
    --------
    >>> from parkproof.model.drive import torques_from_acceleration
    >>> torques_from_acceleration(2.0, 2.0, 0.5, 0.25, 4.0, 0.5)
    (3.0, 1.0)
    """
    total = mass * v_dot
    difference = inertia * omega_dot / half_track
    return 0.5 * wheel_radius * (total + difference), 0.5 * wheel_radius * (total - difference)


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferentialDrive:
    """A robot with two driven wheels, of known geometry and mass.

    Parameters
    ----------
    wheel_radius : float
        r in m, positive.
    half_track : float
        R in m, half the distance between the driven wheels, positive.
    mass : float
        m in kg, positive.
    inertia : float
        I in kg m² about the vertical through the middle of the axle, positive.

    Raises
    ------
    InputError
        If a parameter is not finite and positive, or an argument of a method is not finite.

    Examples
    --------
    >>> from parkproof.model.drive import DifferentialDrive
    >>> robot = DifferentialDrive(wheel_radius=0.5, half_track=0.25, mass=4.0, inertia=0.5)
    >>> robot.wheel_speeds(v=1.0, omega=2.0)
    Wheels(right=3.0, left=1.0)
    >>> robot.body_velocity(right=3.0, left=1.0)
    Velocity(v=1.0, omega=2.0)
    >>> robot.body_acceleration(*robot.wheel_torques(v_dot=2.0, omega_dot=-1.0))
    Acceleration(v_dot=2.0, omega_dot=-1.0)
    """

    wheel_radius: float
    half_track: float
    mass: float
    inertia: float

    def __post_init__(self) -> None:
        for field in fields(self):
            value = positive(field.name, getattr(self, field.name), example=0.1)
            object.__setattr__(self, field.name, value)

    def body_velocity(self, right: float, left: float) -> Velocity:
        """Body velocity at given wheel speeds (`body_from_wheels`).

        Parameters
        ----------
        right, left : float
            Wheel speeds in rad/s.

        Returns
        -------
        Velocity
            (v, ω) in m/s and rad/s.
        """
        right, left = finite("right", right), finite("left", left)
        return Velocity(*body_from_wheels(right, left, self.wheel_radius, self.half_track))

    def wheel_speeds(self, v: float, omega: float) -> Wheels:
        """Wheel speeds at a given body velocity (`wheels_from_body`).

        Parameters
        ----------
        v, omega : float
            Body velocity in m/s and rad/s.

        Returns
        -------
        Wheels
            Wheel speeds in rad/s.
        """
        v, omega = finite("v", v), finite("omega", omega)
        return Wheels(*wheels_from_body(v, omega, self.wheel_radius, self.half_track))

    def body_acceleration(self, right: float, left: float) -> Acceleration:
        """Body acceleration under given wheel torques (`acceleration_from_torques`).

        Parameters
        ----------
        right, left : float
            Wheel torques in N m.

        Returns
        -------
        Acceleration
            (v̇, ω̇) in m/s² and rad/s².
        """
        right, left = finite("right", right), finite("left", left)
        return Acceleration(
            *acceleration_from_torques(
                right, left, self.wheel_radius, self.half_track, self.mass, self.inertia
            )
        )

    def wheel_torques(self, v_dot: float, omega_dot: float) -> Wheels:
        """Wheel torques for a wanted body acceleration (`torques_from_acceleration`).

        Parameters
        ----------
        v_dot, omega_dot : float
            Body acceleration in m/s² and rad/s².

        Returns
        -------
        Wheels
            Wheel torques in N m.
        """
        v_dot, omega_dot = finite("v_dot", v_dot), finite("omega_dot", omega_dot)
        return Wheels(
            *torques_from_acceleration(
                v_dot, omega_dot, self.wheel_radius, self.half_track, self.mass, self.inertia
            )
        )
