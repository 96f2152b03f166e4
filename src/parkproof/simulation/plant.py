"""The true plant, between two samples: commands held, signals and state running on.

Three kinds: (6) itself ("chained"), a robot commanded by accelerations ("torque"), and one by
velocities ("velocity"), each under the paper's camera or under a homography. Integrated by the same
Runge-Kutta steps as in compiled lanes, well below the control period's effect (see the convergence
study in the documentation).
"""

import math

from parkproof.laws.controller import Command, Measurement, RobotKind, measured_pose, measured_state
from parkproof.model.chained import ChainedState, body_inputs, chained_inputs, extension_rate
from parkproof.model.homography import Nine
from parkproof.model.image_unicycle import gains_under
from parkproof.model.signals import signal_value
from parkproof.model.truth import Channel, Resolved, channel, scales
from parkproof.model.unicycle import wrap_angle
from parkproof.scalar import cosine, sign, sine
from parkproof.scenario import Scenario
from parkproof.simulation.image_steps import image_chained_step, image_turning_step
from parkproof.simulation.steps import Scales, chained_step, time_in_period, turning_step

State = tuple[float, float, float, float, float]

Times = tuple[float, float, float]
"""Start, middle and end of an integration step, or values then."""

SixFloats = tuple[float, float, float, float, float, float]

ONE: Resolved = (1.0, ())
STILL: SixFloats = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


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
    camera : nine floats, optional
        Homography from the goal's image frame to the floor, row by row; the paper's camera if there
        is none.
    scales : three signals
        Under the paper's camera, α1, α2 and b2 as mean and tones; b2 is for robots of kind
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
    >>> plant = Plant(robot="chained", channels=channels, pose=(0.0, 0.0, 0.0),
    ...               velocity=(1.0, 0.0))
    >>> plant.advance(Command(1, 0.0, 0.0), 0.0, 0.5, 1)
    >>> plant.measurement(0.5).x0
    0.5
    """

    def __init__(
        self,
        *,
        robot: RobotKind,
        channels: tuple[Channel, Channel],
        camera: Nine | None = None,
        scales: tuple[Resolved, Resolved, Resolved] = (ONE, ONE, ONE),
        pose: tuple[float, float, float],
        velocity: tuple[float, float],
        chained: ChainedState | None = None,
    ) -> None:
        self._robot = robot
        self._channels = channels
        self._camera = camera
        self._scales = scales
        self._in_chart = False
        self._state: State = (*pose, *velocity)
        if robot != "chained":
            x, y, theta = pose
            beta = self._beta(x, y, cosine(theta), sine(theta))
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
            beta = self._beta(x0, x1, c, x2 * c)
            return measured_state(t, ChainedState(*self._state), beta)
        x, y, theta, v, omega = self._state
        beta = self._beta(x, y, cosine(theta), sine(theta))
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
        first, second = command.tau1, command.tau2
        if self._robot == "chained":
            self._enter_or_leave_chart(command.step >= 1)
        elif self._robot == "torque":
            first, second = command.acceleration, command.turn_acceleration
        else:
            self._state = (*self._state[:3], command.speed, command.turn_rate)
        part = h / steps
        for i in range(steps):
            begin = time_in_period(t, h, i, steps)
            times = (begin, begin + 0.5 * part, time_in_period(t, h, i + 1, steps))
            rates = STILL
            if self._robot != "velocity":
                tau1, tau2 = command.tau1, command.tau2
                rates = (*self._rates(0, first, tau1, times), *self._rates(1, second, tau2, times))
            self._move(times, rates, part)

    def _rates(self, i: int, command: float, tau: float, times: Times) -> Times:
        """Rates of a channel's last state at three times."""
        start, middle, end = (channel_rate(self._channels[i], command, t, tau) for t in times)
        return start, middle, end

    def _move(self, times: Times, rates: SixFloats, h: float) -> None:
        """One integration step, with the rates of both channels' last states at three times."""
        if self._camera is None:
            start, middle, end = (self._scales_at(t) for t in times)
            step = chained_step if self._in_chart else turning_step
            self._state = step(*self._state, start, middle, end, *rates, h)
        elif self._in_chart:
            self._state = image_chained_step(*self._state, self._camera, *rates, h)
        else:
            own = self._robot != "chained"
            self._state = image_turning_step(*self._state, self._camera, own, *rates, h)

    def _scales_at(self, t: float) -> Scales:
        """α1, α2 and b2 at a time."""
        one, two, turn = self._scales
        return signal_value(*one, t), signal_value(*two, t), signal_value(*turn, t)

    def _beta(self, x: float, y: float, c: float, s: float) -> float:
        """Gain β at an image pose, from the robot's turn rate to that of its image."""
        return 1.0 if self._camera is None else gains_under(self._camera, x, y, c, s)[1]

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


def plant_of(scenario: Scenario) -> Plant:
    """Make the plant of a run, at its start.

    Parameters
    ----------
    scenario : Scenario
        What is to be run.

    Returns
    -------
    Plant
        At time 0.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> plant_of(Scenario(law="corrected", start=Start(pose=(-1.0, 0.1, 0.0)))).measurement(0.0).x0
    -1.0
    """
    return Plant(
        robot=scenario.robot.kind,
        channels=(
            channel(0, scenario.truth, scenario.bounds),
            channel(1, scenario.truth, scenario.bounds),
        ),
        camera=None if scenario.camera is None else scenario.camera.view.from_goal.entries,
        scales=scales(scenario.truth, scenario.bounds),
        pose=scenario.start_pose,
        velocity=scenario.start_velocity,
        chained=scenario.start.chained,
    )
