"""The true plant, between two samples: commands held, signals and state running on.

Three kinds: (6) itself ("chained"), a robot commanded by accelerations ("torque"), and one by
velocities ("velocity"). Integrated by classical Runge-Kutta with steps well below the control
period's effect (see the convergence study in the documentation).
"""

import math
from collections.abc import Callable

from parkproof.laws.controller import Command, Measurement, RobotKind, measured_pose, measured_state
from parkproof.model.chained import (
    ChainedState,
    body_inputs,
    chained_inputs,
    chained_rates,
    extension_rate,
)
from parkproof.model.overhead import ImageGains
from parkproof.model.signals import signal_value
from parkproof.model.truth import Channel, Resolved
from parkproof.model.unicycle import wrap_angle
from parkproof.scalar import sign

State = tuple[float, float, float, float, float]

ONE: Resolved = (1.0, ())


def runge_kutta(rates: Callable[[float, State], State], t: float, state: State, h: float) -> State:
    """One step of the classical Runge-Kutta method.

    Parameters
    ----------
    rates : callable
        Takes t and the state, returns its derivative.
    t : float
        Time in s.
    state : tuple of 5 floats
        State at t.
    h : float
        Step in s.

    Returns
    -------
    tuple of 5 floats
        State at t + h, with an error of order h⁵.

    Examples
    --------
    >>> decay = lambda t, s: tuple(-x for x in s)
    >>> round(runge_kutta(decay, 0.0, (1.0, 0.0, 0.0, 0.0, 0.0), 0.1)[0], 5)
    0.90484
    """
    half = 0.5 * h
    a, b, c, d, e = state
    p = rates(t, state)
    q = rates(
        t + half,
        (a + half * p[0], b + half * p[1], c + half * p[2], d + half * p[3], e + half * p[4]),
    )
    r = rates(
        t + half,
        (a + half * q[0], b + half * q[1], c + half * q[2], d + half * q[3], e + half * q[4]),
    )
    s = rates(t + h, (a + h * r[0], b + h * r[1], c + h * r[2], d + h * r[3], e + h * r[4]))
    w = h / 6.0
    return (
        a + w * (p[0] + 2.0 * (q[0] + r[0]) + s[0]),
        b + w * (p[1] + 2.0 * (q[1] + r[1]) + s[1]),
        c + w * (p[2] + 2.0 * (q[2] + r[2]) + s[2]),
        d + w * (p[3] + 2.0 * (q[3] + r[3]) + s[3]),
        e + w * (p[4] + 2.0 * (q[4] + r[4]) + s[4]),
    )


def channel_rate(channel: Channel, command: float, t: float, against: float) -> float:
    """Rate γ(t)·command + φ(t) of a channel's last state; an adversary opposes the sign of τ.

    Parameters
    ----------
    channel : Channel
        The true gain and disturbance.
    command : float
        The input: τ, or the acceleration that a torque-commanded robot makes of it.
    t : float
        Time in s.
    against : float
        τ, whose sign is that of τ̃.

    Returns
    -------
    float
        The rate.

    Examples
    --------
    >>> channel_rate(Channel(1.5, (), 0.0, (), 2.5), 4.0, 0.0, 4.0)
    3.5
    """
    gamma = signal_value(channel.gamma_mean, channel.gamma_tones, t)
    phi = (
        -channel.phi_adversary * sign(against)
        if channel.phi_adversary > 0.0
        else signal_value(channel.phi_mean, channel.phi_tones, t)
    )
    return extension_rate(command, gamma, phi)


class Plant:
    """The robot under its camera: what is true, and how it moves under a held command.

    Parameters
    ----------
    robot : "chained", "torque" or "velocity"
        What the robot is commanded by.
    channels : two Channels
        True input gains and disturbances. A velocity-commanded robot has none.
    image_gains : callable
        (x, y, cos θ, sin θ) → (g0, g1, β).
    scales : three signals
        α1, α2 and b2 as mean and tones. α1 and α2 multiply g0 and g1; b2 is for robots of kind
        "chained".
    pose : three floats
        Start (x, y, θ) in the goal's image frame.
    velocity : two floats
        Start (v, ω), ω being the turn rate of the heading in the image.
    chained : ChainedState, optional
        The start in chained form, if it was given so; it is then kept exactly.

    Examples
    --------
    >>> from parkproof.model.truth import Truth, channel
    >>> from parkproof.bounds import Bounds
    >>> channels = tuple(channel(i, Truth(), Bounds()) for i in range(2))
    >>> plant = Plant(robot="chained", channels=channels, image_gains=lambda x, y, c, s: (1, 1, 1),
    ...               pose=(0.0, 0.0, 0.0), velocity=(1.0, 0.0))
    >>> plant.advance(Command(1, 0.0, 0.0), 0.0, 0.5, 1)
    >>> plant.measurement(0.5).x0
    0.5
    """

    def __init__(
        self,
        *,
        robot: RobotKind,
        channels: tuple[Channel, Channel],
        image_gains: ImageGains,
        scales: tuple[Resolved, Resolved, Resolved] = (ONE, ONE, ONE),
        pose: tuple[float, float, float],
        velocity: tuple[float, float],
        chained: ChainedState | None = None,
    ) -> None:
        self._robot = robot
        self._channels = channels
        self._image_gains = image_gains
        self._alpha, self._b2 = scales[:2], scales[2]
        self._in_chart = False
        self._state: State = (*pose, *velocity)
        if robot != "chained":
            x, y, theta = pose
            _, _, beta = image_gains(x, y, math.cos(theta), math.sin(theta))
            self._state = (*pose, velocity[0], velocity[1] / beta)
        if chained is not None and robot == "chained":
            self._in_chart, self._state = True, (*chained,)

    @property
    def in_chart(self) -> bool:
        """Whether the state is x0, x1, x2, u0, u1, or x, y, θ, v, ω."""
        return self._in_chart

    def is_misled(self, command: Command) -> bool:
        """Whether the law takes a heading beyond ±90° for one in the chart, which has no such."""
        enters = self._robot == "chained" and command.step >= 1 and not self._in_chart
        return enters and abs(wrap_angle(self._state[2])) >= 0.5 * math.pi

    def measurement(self, t: float) -> Measurement:
        """Exact measurement of the present state.

        Parameters
        ----------
        t : float
            Time in s.

        Returns
        -------
        Measurement
            Pose and velocities, in the chart and outside it.

        Examples
        --------
        See `Plant`.
        """
        if self._in_chart:
            x0, x1, x2, _, _ = self._state
            c = 1.0 / math.sqrt(1.0 + x2 * x2)
            _, _, beta = self._image_gains(x0, x1, c, x2 * c)
            return measured_state(t, ChainedState(*self._state), beta)
        x, y, theta, v, omega = self._state
        _, _, beta = self._image_gains(x, y, math.cos(theta), math.sin(theta))
        rate = omega if self._robot == "chained" else beta * omega
        return measured_pose(t, x, y, theta, v=v, omega=rate, beta=beta)

    def advance(self, command: Command, t: float, h: float, steps: int) -> None:
        """Hold a command from t to t + h.

        Parameters
        ----------
        command : Command
            The controller's answer.
        t, h : float
            Time and period in s.
        steps : int
            Number of integration steps.

        Examples
        --------
        See `Plant`.
        """
        if self._robot == "chained":
            self._enter_or_leave_chart(command.step >= 1)
            rates = self._chained_rates if self._in_chart else self._turning_rates
            first, second = command.tau1, command.tau2
        elif self._robot == "torque":
            rates = self._torque_rates
            first, second = command.acceleration, command.turn_acceleration
        else:
            rates = self._velocity_rates
            first, second = command.speed, command.turn_rate
        self._first, self._second = first, second
        self._tau = (command.tau1, command.tau2)
        self._rates_at = math.nan  # the command is new
        state = self._state
        part = h / steps
        for i in range(steps):
            state = runge_kutta(rates, t + i * part, state, part)
        if self._robot == "velocity":
            state = (*state[:3], first, second)
        self._state = state

    def _enter_or_leave_chart(self, wanted: bool) -> None:
        """Change coordinates between (x0, x1, x2, u0, u1) and (x, y, θ, v, ω)."""
        if wanted == self._in_chart:
            return
        a, b, c, d, e = self._state
        if wanted:
            x2 = math.tan(c)
            self._state = (a, b, x2, *chained_inputs(d, e, x2))
        else:
            self._state = (a, b, math.atan(c), *body_inputs(d, e, c))
        self._in_chart = wanted

    def _input_rates(self, t: float) -> tuple[float, float]:
        """Rates of both channels' last states; they are asked for twice in the middle of a step."""
        if t != self._rates_at:
            one, two = self._channels
            self._rates_at = t
            self._rates = (
                channel_rate(one, self._first, t, self._tau[0]),
                channel_rate(two, self._second, t, self._tau[1]),
            )
        return self._rates

    def _gains(
        self, t: float, x: float, y: float, c: float, s: float
    ) -> tuple[float, float, float]:
        """Gains of the image at a pose and a time, and its turn gain."""
        g0, g1, beta = self._image_gains(x, y, c, s)
        one, two = self._alpha
        return signal_value(*one, t) * g0, signal_value(*two, t) * g1, beta

    def _chained_rates(self, t: float, state: State) -> State:
        x0, x1, x2, u0, u1 = state
        c = 1.0 / math.sqrt(1.0 + x2 * x2)
        g0, g1, _ = self._gains(t, x0, x1, c, x2 * c)
        b2 = signal_value(*self._b2, t)
        return (*chained_rates(x2, u0, u1, g0, g1, b2), *self._input_rates(t))

    def _turning_rates(self, t: float, state: State) -> State:
        x, y, theta, v, omega = state
        c, s = math.cos(theta), math.sin(theta)
        g0, g1, _ = self._gains(t, x, y, c, s)
        b2 = signal_value(*self._b2, t)
        return (g0 * v * c, g1 * v * s, b2 * omega, *self._input_rates(t))

    def _torque_rates(self, t: float, state: State) -> State:
        """The robot's own v and ω; its heading in the image turns at βω."""
        x, y, theta, v, omega = state
        c, s = math.cos(theta), math.sin(theta)
        g0, g1, beta = self._gains(t, x, y, c, s)
        return (g0 * v * c, g1 * v * s, beta * omega, *self._input_rates(t))

    def _velocity_rates(self, t: float, state: State) -> State:
        x, y, theta, _, _ = state
        c, s = math.cos(theta), math.sin(theta)
        g0, g1, beta = self._gains(t, x, y, c, s)
        v, omega = self._first, self._second
        return (g0 * v * c, g1 * v * s, beta * omega, 0.0, 0.0)
