"""A law with its memory: `command = controller.step(measurement)`."""

import math
from typing import Literal, NamedTuple

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.laws.commands import Kept, acceleration_command, kept_velocity, velocity_command
from parkproof.laws.gains import Gains, Switching
from parkproof.laws.inputs import explicit_inputs, implicit_inputs, predicted, with_direct
from parkproof.laws.parameters import Discretisation, LawParameters, law_parameters
from parkproof.laws.table import law_named
from parkproof.laws.turn import turn_channels, turned
from parkproof.model.chained import ChainedState, body_inputs, chart_of
from parkproof.model.unicycle import wrap_angle
from parkproof.validate import finite

RobotKind = Literal["chained", "torque", "velocity"]


class Measurement(NamedTuple):
    """What a controller is given at a sample; make one with `measured_state` or `measured_pose`.

    Attributes
    ----------
    t : float
        Time in s.
    x0, x1, x2, u0, u1 : float
        State of (6); x2, u0, u1 are infinite or NaN where the heading lies outside the chart.
    theta, v, omega : float
        Heading in (−π, π], speed, and turn rate of the heading (in the image).
    beta : float
        Measured gain β from the robot's turn rate to that of the heading; 1 under the paper's
        camera.
    """

    t: float
    x0: float
    x1: float
    x2: float
    u0: float
    u1: float
    theta: float
    v: float
    omega: float
    beta: float


def measured_state(t: float, state: ChainedState, beta: float = 1.0) -> Measurement:
    """Make a measurement from a chained state.

    Parameters
    ----------
    t : float
        Time in s.
    state : ChainedState
        x0, x1, x2, u0, u1.
    beta : float
        Measured gain β.

    Returns
    -------
    Measurement
        The same state, with heading, speed and turn rate beside it.

    Examples
    --------
    >>> measured_state(0.0, ChainedState(0.0, 0.0, 0.0, 2.0, 1.0)).v
    2.0
    """
    x0, x1, x2, u0, u1 = state
    v, omega = body_inputs(u0, u1, x2)
    return Measurement(t, x0, x1, x2, u0, u1, math.atan(x2), v, omega, beta)


def measured_pose(
    t: float,
    x: float,
    y: float,
    theta: float,
    *,
    v: float = 0.0,
    omega: float = 0.0,
    beta: float = 1.0,
) -> Measurement:
    """Make a measurement from an image pose and, for a torque-commanded robot, its velocity.

    Parameters
    ----------
    t : float
        Time in s.
    x, y : float
        Position in the goal's image frame.
    theta : float
        Heading in that frame, in rad.
    v, omega : float
        Speed, and turn rate of the heading. Not needed for a velocity-commanded robot.
    beta : float
        Measured gain β.

    Returns
    -------
    Measurement
        With the chained state beside it where |θ| < 90°.

    Examples
    --------
    >>> measured_pose(0.0, 1.0, 0.5, 2.0).x2
    inf
    """
    theta = wrap_angle(theta)
    x2, u0, u1 = chart_of(theta, v, omega)
    return Measurement(t, x, y, x2, u0, u1, theta, v, omega, beta)


class Command(NamedTuple):
    """What a controller asks for, held until the next sample.

    Attributes
    ----------
    step : int
        Step in force: 0 turn, 1 run-up, 2 approach, 3 return, 4 hold or stopped.
    tau1, tau2 : float
        The inputs of (6), or, in Step 0, those of v and ω.
    speed, turn_rate : float
        For a velocity-commanded robot: v and ω to send; otherwise NaN.
    acceleration, turn_acceleration : float
        For a torque-commanded robot: v̇ and ω̇ to produce, with the quadratic terms (D7) fed
        forward; otherwise NaN.
    """

    step: int
    tau1: float
    tau2: float
    speed: float = math.nan
    turn_rate: float = math.nan
    acceleration: float = math.nan
    turn_acceleration: float = math.nan


class Controller:
    """One law with its memory: the step in force, the direction of travel, and held velocities.

    Parameters
    ----------
    law : str
        "published", "corrected" or "homogeneous".
    bounds : Bounds
        What may be known of the plant. A velocity-commanded robot has γ = 1 and φ = 0, because
        u0 and u1 live in the controller.
    gains : Gains
        Gains of the law.
    switching : Switching
        When steps end.
    control_period : float
        Time between calls of `step`, in s.
    discretisation : "explicit" or "implicit"
        Form of the law in sampled time.
    robot : "chained", "torque" or "velocity"
        What the robot is commanded by: τ of (6) itself, accelerations, or velocities.
    saturation : two floats, optional
        Clip |τ1|, |τ2| at these; outside every guarantee.

    Raises
    ------
    InputError
        If the law is unknown or lacks its gains, the period is not positive, or a
        velocity-commanded robot is given bounds other than γ = 1, φ = 0.

    Examples
    --------
    >>> controller = Controller(law="corrected", bounds=Bounds(alpha=(0.5, 1.5)),
    ...                         control_period=1 / 30, discretisation="implicit",
    ...                         robot="velocity")
    >>> command = controller.step(measured_pose(0.0, -1.0, 0.2, 0.1))
    >>> command.step, command.speed > 0.0
    (1, True)
    """

    def __init__(
        self,
        *,
        law: str,
        bounds: Bounds,
        gains: Gains | None = None,
        switching: Switching | None = None,
        control_period: float,
        discretisation: Discretisation = "explicit",
        robot: RobotKind = "chained",
        saturation: tuple[float, float] | None = None,
    ) -> None:
        known = [bounds.gamma_of(0), bounds.gamma_of(1)]
        phi = max(bounds.disturbance_of(0), bounds.disturbance_of(1))
        if robot == "velocity" and (known != [(1.0, 1.0)] * 2 or phi > 0.0):
            raise InputError(
                "a velocity-commanded robot keeps u0, u1 in the controller, so gamma = [1, 1] and "
                "disturbance = 0 hold exactly; leave both out of the bounds"
            )
        self._law = law_named(law)
        (gains or Gains()).check_law(law)
        self._robot = robot
        self._inputs = implicit_inputs if discretisation == "implicit" else explicit_inputs
        self.parameters: LawParameters = law_parameters(
            bounds=bounds,
            gains=gains or Gains(),
            switching=switching or Switching(),
            control_period=control_period,
            discretisation=discretisation,
            saturation=saturation,
        )
        self._step: float | None = None
        self._way = 1.0
        self._kept: Kept = (0.0, 0.0, 0.0, 0.0, 0.0)

    @property
    def way(self) -> float:
        """Direction of travel of Steps 1 and 2: 1 forward, −1 backward."""
        return self._way

    def hold_velocity(self, v: float, omega: float) -> None:
        """Tell the controller of a velocity-commanded robot how fast it already moves.

        Parameters
        ----------
        v, omega : float
            Speed, and turn rate of the heading in the image.

        Examples
        --------
        >>> controller = Controller(law="corrected", bounds=Bounds(), control_period=0.1,
        ...                         robot="velocity")
        >>> controller.hold_velocity(0.5, 0.0)
        >>> controller.step(measured_pose(0.0, -2.0, 0.0, 0.0)).speed > 0.5
        True
        """
        v, omega = finite("v", v), finite("omega", omega)
        self._kept = (v, omega, 0.0, v, omega)

    def step(self, measurement: Measurement) -> Command:
        """Take a measurement, move on to the next step if it is time, and answer a command.

        Parameters
        ----------
        measurement : Measurement
            From `measured_state` or `measured_pose`.

        Returns
        -------
        Command
            To be held until the next sample.

        Raises
        ------
        InputError
            If the heading is outside the chart and the law cannot turn.

        Examples
        --------
        >>> controller = Controller(law="published", bounds=Bounds(), control_period=0.001)
        >>> controller.step(measured_state(0.0, ChainedState(0.0, 0.3, 0.0, 9.0, 0.0))).tau1
        -2.0
        """
        m = self._with_held_velocity(measurement)
        self._advance_step(m)
        p = self.parameters
        if self._step == 0.0:
            _, _, kept_in_chart, v, omega = self._kept
            if kept_in_chart > 0.0:  # u0, u1 kept there say nothing of v and ω near ±90°
                m = m._replace(v=v, omega=omega)
            theta = m.theta + p.lookahead * m.omega
            tau1, tau2 = self._inputs(*turn_channels(theta, p), m.v, m.omega, p)
        else:
            if not math.isfinite(m.x2):
                raise InputError(
                    f"heading {math.degrees(m.theta):.1f}° is outside the chart |θ| < 90° and the "
                    f'law "{self._law.name}" cannot turn; use law = "corrected"'
                )
            x0, x1, x2 = predicted(m.x0, m.x1, m.x2, m.u0, m.u1, p)
            channels = self._law.channels(self._step, self._way, x0, x1, x2, m.u0, p)
            tau1, tau2 = self._inputs(*channels, m.u0, m.u1, p)
            direct = self._law.direct(self._step, self._way, x1, x2, m.u1, p)
            tau2 = with_direct(tau2, direct, p)
        return self._command(m, tau1, tau2)

    def _with_held_velocity(self, m: Measurement) -> Measurement:
        """The measurement, with the velocities that the controller of this robot keeps itself."""
        if self._robot != "velocity":
            return m
        u0, u1, v, omega = kept_velocity(*self._kept, m.x2)
        return m._replace(u0=u0, u1=u1, v=v, omega=omega)

    def _advance_step(self, m: Measurement) -> None:
        p, law, before = self.parameters, self._law, self._step
        if before is None:
            self._step = law.begin(m.x1, m.x2, m.u1, p)
        elif before == 0.0:
            done = turned(m.theta, m.v, m.omega, p)
            self._step = law.begin(m.x1, m.x2, m.u1, p) if done else 0.0
        else:
            self._step = law.switch(before, self._way, m.t, m.x0, m.x1, m.x2, m.u0, m.u1, p)
        if self._step == 1.0 and before != 1.0:
            self._way = law.direction(m.x0, m.x1, m.x2, m.u0, p)

    def _command(self, m: Measurement, tau1: float, tau2: float) -> Command:
        turning = self._step == 0.0
        step = int(self._step or 0.0)
        if self._robot == "chained":
            return Command(step, tau1, tau2)
        if self._robot == "torque":
            along, across = acceleration_command(turning, tau1, tau2, m.theta, m.v, m.omega, m.beta)
            return Command(step, tau1, tau2, acceleration=along, turn_acceleration=across)
        h = self.parameters.period
        self._kept = velocity_command(turning, tau1, tau2, m.v, m.omega, m.x2, m.u0, m.u1, h)
        _, _, _, v, omega = self._kept
        return Command(step, tau1, tau2, speed=v, turn_rate=omega / m.beta)
