"""A scenario: everything that one run needs, validated once.

A scenario file is this module's structures written as TOML (`parkproof.scenario_file` reads it).
"""

import math
from typing import Literal, cast

import msgspec
from msgspec.structs import force_setattr

from parkproof.bounds import Bounds, Limits
from parkproof.errors import InputError
from parkproof.laws.controller import RobotKind
from parkproof.laws.gains import Gains, Switching
from parkproof.laws.parameters import Discretisation, law_parameters
from parkproof.model.chained import ChainedState, body_inputs
from parkproof.model.overhead import Overhead, OverheadView
from parkproof.model.truth import Truth
from parkproof.model.unicycle import wrap_angle
from parkproof.validate import finite, not_negative, positive

DIVERGED_AT = 1e6
"""No state may start beyond this, and a run ends as diverged when one exceeds it."""

MAX_SAMPLES = 20_000_000
"""Most control periods in a run; more would not fit in memory."""


class Weights(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Weights of the Lyapunov functions: they enter the conditions (15)-(19), never the law.

    Parameters
    ----------
    k : two floats
        k1, k2 > 0 of Step 2.
    k_step3 : float
        k̃2 > 0 of Step 3.

    Raises
    ------
    InputError
        If a weight is not positive.

    Examples
    --------
    >>> Weights().k
    (2.4, 17.5)
    """

    k: tuple[float, float] = (2.4, 17.5)
    k_step3: float = 2.6

    def __post_init__(self) -> None:
        force_setattr(self, "k", tuple(positive("k", value) for value in self.k))
        force_setattr(self, "k_step3", positive("k_step3", self.k_step3))


class Start(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a run starts: a chained state, or a pose with a velocity.

    Parameters
    ----------
    state : five floats, optional
        x0, x1, x2, u0, u1.
    pose : three floats, optional
        x_m, y_m and θ (rad, any heading) in the goal's image frame.
    floor_pose : three floats, optional
        x, y and θ on the floor, for scenarios with a [camera].
    velocity : two floats
        v, and the turn rate ω of the heading in the image; goes with a pose.

    Raises
    ------
    InputError
        If not just one of state, pose and floor_pose is given, or a number is not finite.

    Examples
    --------
    >>> Start(pose=(-1.0, 0.2, 3.0)).velocity is None
    True
    """

    state: tuple[float, float, float, float, float] | None = None
    pose: tuple[float, float, float] | None = None
    floor_pose: tuple[float, float, float] | None = None
    velocity: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if sum(given is not None for given in (self.state, self.pose, self.floor_pose)) != 1:
            raise InputError(
                "[start] needs just one of state = [x0, x1, x2, u0, u1], pose = [x, y, theta] "
                "and, with a [camera], floor_pose = [x, y, theta]"
            )
        for name in ("state", "pose", "floor_pose", "velocity"):
            values = getattr(self, name) or ()
            if any(abs(value) >= DIVERGED_AT for value in values):
                raise InputError(
                    f"start.{name} = {list(values)}: every number must be below {DIVERGED_AT:g} "
                    "in size; start nearer, or scale the units"
                )
        if self.state is not None and self.velocity is not None:
            raise InputError("[start] velocity goes with a pose; state already holds u0 and u1")
        for name in ("state", "pose", "floor_pose", "velocity"):
            if (values := getattr(self, name)) is not None:
                force_setattr(self, name, tuple(finite(f"start.{name}", v) for v in values))

    @property
    def chained(self) -> ChainedState | None:
        """The start as a chained state, if it was given as one."""
        return None if self.state is None else ChainedState(*self.state)


class RunSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How long and how finely a run is carried out.

    Parameters
    ----------
    duration : float
        Length of the run in s; the run ends with its last whole control period.
    control_period : float
        Period h of the controller in s.
    discretisation : "explicit" or "implicit"
        Form of the law in sampled time.
    record_period : float, optional
        Time between rows of the trajectory file in s; default a row each control period. Metrics
        use every sample.
    plant_step : float, optional
        Largest integration step of the plant in s; default 1 ms, and 0.2 ms with square waves.
    noise : float or five floats
        Standard deviation of the noise of each measurement: of x0, x1, x2, u0, u1, or, while a
        robot turns and for robots of kind "torque" and "velocity", of x, y, θ, v, ω.
    latency : float
        How late measurements arrive, in s, rounded to whole control periods but never to none.
    seed : int
        The same seed gives the same noise.

    Raises
    ------
    InputError
        If a time is not positive, the run has less than one or more than 20 million samples, noise,
        latency or seed are negative, or the latency exceeds the duration.

    Examples
    --------
    >>> RunSettings(duration=35.0, control_period=1e-3).samples
    35000
    >>> RunSettings(latency=0.0301, control_period=0.01).delay_samples
    3
    """

    duration: float = 35.0
    control_period: float = 1e-3
    discretisation: Discretisation = "explicit"
    record_period: float | None = None
    plant_step: float | None = None
    noise: float | tuple[float, float, float, float, float] = 0.0
    latency: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        duration = positive("duration", self.duration, example=35.0)
        period = positive("control_period", self.control_period, example=0.001)
        force_setattr(self, "duration", duration)
        force_setattr(self, "control_period", period)
        if period > duration:
            raise InputError(
                f"control_period = {period:g}: longer than duration = {duration:g}; "
                "write a shorter period, for example 0.001"
            )
        if duration / period > MAX_SAMPLES:
            raise InputError(
                f"duration / control_period = {duration / period:.3g} samples: at most "
                f"{MAX_SAMPLES:,}; write a longer control_period or a shorter duration"
            )
        if self.record_period is not None:
            force_setattr(self, "record_period", positive("record_period", self.record_period))
        if self.plant_step is not None:
            step = positive("plant_step", self.plant_step, example=0.001)
            force_setattr(self, "plant_step", step)
            if duration / step > 10 * MAX_SAMPLES:
                raise InputError(
                    f"duration / plant_step = {duration / step:.3g} integration steps: at most "
                    f"{10 * MAX_SAMPLES:,}; write a longer plant_step"
                )

        self._check_measurements(duration)

    def _check_measurements(self, duration: float) -> None:
        given = self.noise if isinstance(self.noise, tuple | list) else (self.noise,) * 5
        noise = tuple(not_negative("noise", value) for value in given)
        if (largest := max(noise)) >= DIVERGED_AT:
            raise InputError(
                f"noise = {largest:g}: must be below {DIVERGED_AT:g}; write for example 0.001"
            )
        force_setattr(self, "noise", noise)
        force_setattr(self, "latency", not_negative("latency", self.latency))
        if self.latency > duration:
            raise InputError(
                f"latency = {self.latency:g}: longer than duration = {duration:g}; "
                "write a shorter latency, for example 0.03"
            )
        not_negative("seed", self.seed)

    @property
    def deviations(self) -> tuple[float, float, float, float, float]:
        """Standard deviations of the noise."""
        return cast(tuple[float, float, float, float, float], self.noise)  # normalised above

    @property
    def delay_samples(self) -> int:
        """Latency in control periods."""
        periods = round(self.latency / self.control_period)
        return max(1, periods) if self.latency > 0.0 else 0

    @property
    def delay(self) -> float:
        """Latency as it is carried out, in s."""
        return round(self.delay_samples * self.control_period, 12)

    @property
    def samples(self) -> int:
        """Number of whole control periods in the run."""
        return max(1, math.floor(self.duration / self.control_period + 1e-9))


class Robot(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the robot takes as commands.

    Parameters
    ----------
    kind : "chained", "torque" or "velocity"
        "chained": τ1, τ2 act on u0, u1 as in (6), the paper's idealisation. "torque": the robot
        takes accelerations of v and ω; the quadratic terms (D7) are fed forward. γ and φ then act
        on v̇ and ω̇, so that the disturbances of (6) become φ1 cos θ and φ2 sec² θ, and (γ − 1)
        times the fed-forward terms adds to them: larger than the bounds near ±90°. "velocity": it
        takes v and ω, and u0, u1 live in the controller.

    Examples
    --------
    >>> Robot().kind
    'chained'
    """

    kind: RobotKind = "chained"


class Scenario(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything that one run needs.

    Parameters
    ----------
    law : "published", "corrected" or "homogeneous"
        The law.
    start : Start
        Where the run starts.
    bounds : Bounds
        What the controller may know.
    truth : Truth
        What is true.
    gains, weights, switching, run, robot, limits
        See `Gains`, `Weights`, `Switching`, `RunSettings`, `Robot`, `Limits`.
    camera : PinholeTable or HomographyTable, optional
        The true camera, if it is not the paper's with truth.alpha. Leaving its picture ends a run.
    title : str
        For figures and reports.

    Raises
    ------
    InputError
        If parts contradict each other: truth outside its bounds, an exponent that the published law
        cannot use, a heading that it cannot turn, bounds that a velocity-commanded robot does not
        have.

    Examples
    --------
    >>> scenario = Scenario(law="corrected", start=Start(pose=(-2.0, 0.3, 0.1)))
    >>> scenario.gains.l
    (2.0, 4.2, 21.0)
    """

    title: str = ""
    law: Literal["published", "corrected", "homogeneous"]
    bounds: Bounds = Bounds()
    gains: Gains = Gains()
    weights: Weights | None = None
    truth: Truth = Truth()
    start: Start
    switching: Switching = Switching()
    run: RunSettings = RunSettings()
    robot: Robot = Robot()
    limits: Limits = Limits()
    camera: Overhead | None = None

    def __post_init__(self) -> None:
        if self.law == "published":
            self._check_published()
        self.gains.check_law(self.law)
        if self.robot.kind == "velocity":
            self._check_velocity_commanded()
        if self.truth.b2 != 1.0:
            self._check_b2()
        self.truth.check(self.bounds)
        if self.camera is not None:
            self._check_camera(self.camera.view)
        elif self.start.floor_pose is not None:
            raise InputError("start.floor_pose needs a [camera]; write start.pose without one")
        law_parameters(
            bounds=self.bounds,
            gains=self.gains,
            switching=self.switching,
            control_period=self.run.control_period,
        )
        x, y, _ = self.start_pose
        speed, turn_rate = self.start_velocity
        if max(abs(speed), abs(turn_rate)) >= DIVERGED_AT:
            raise InputError(
                f"start: v = {speed:.3g} and omega = {turn_rate:.3g} follow from the state; they "
                f"must be below {DIVERGED_AT:g} in size; start slower or straighter"
            )
        view = self.limits.view
        if view is not None and not (view[0] <= x <= view[1] and view[2] <= y <= view[3]):
            raise InputError(
                f"start ({x:g}, {y:g}) is outside limits.view = {list(view)}; "
                "start inside the view or widen it"
            )

    @property
    def start_pose(self) -> tuple[float, float, float]:
        """x_m, y_m and θ in (−π, π] at the start, in the goal's image frame."""
        start = self.start
        if start.floor_pose is not None and self.camera is not None:
            return self.camera.view.image_pose(start.floor_pose)
        if start.pose is not None:
            x, y, theta = start.pose
            return x, y, wrap_angle(theta)
        x0, x1, x2, _, _ = start.chained or ChainedState(0.0, 0.0, 0.0, 0.0, 0.0)
        return x0, x1, math.atan(x2)

    @property
    def view_outline(self) -> tuple[tuple[float, float], ...]:
        """Corners, in order, of what the camera sees in the goal's image frame; may be empty."""
        if self.camera is not None:
            return self.camera.view.corners
        if self.limits.view is None:
            return ()
        x_min, x_max, y_min, y_max = self.limits.view
        return (x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max)

    @property
    def start_velocity(self) -> tuple[float, float]:
        """Speed v, and turn rate of the heading in the image, at the start."""
        chained = self.start.chained
        if chained is not None:
            return body_inputs(chained.u0, chained.u1, chained.x2)
        return self.start.velocity or (0.0, 0.0)

    def _check_b2(self) -> None:
        if self.camera is not None:
            raise InputError(
                "truth.b2 is a gain of the paper's plant, and under a [camera] it follows from the "
                "camera: leave one of them out"
            )
        if self.robot.kind != "chained":
            raise InputError(
                f'truth.b2 is a gain of the chained form, and robot.kind = "{self.robot.kind}" '
                'takes v and ω or their rates: leave truth.b2 out, or write robot.kind = "chained"'
            )

    def _check_camera(self, view: OverheadView) -> None:
        if self.truth.alpha != (1.0, 1.0):
            raise InputError(
                "truth.alpha is the paper's camera and [camera] another: leave one of them out"
            )
        x, y, _ = self.start_pose
        if not view.sees(x, y):
            raise InputError(
                f"start ({x:g}, {y:g}) in the goal's image frame is outside the picture; "
                "start where the camera sees the robot"
            )
        if self.truth.outside_bounds:
            return
        seen = view.bounds
        for i in range(2):
            low, high = self.bounds.alpha_of(i)
            if seen.a_min < low or seen.a_max > high:
                raise InputError(
                    f"the camera's gain a ranges over [{seen.a_min:.3g}, {seen.a_max:.3g}] in its "
                    f"picture (sampled), outside bounds.alpha = [{low:g}, {high:g}]; widen the "
                    "bounds, or write outside_bounds = true under [truth]"
                )

    def _check_published(self) -> None:
        for name, q in zip(("q0", "q1", "q2"), self.gains.exponents, strict=True):
            if not q.is_odd_over_odd:
                raise InputError(
                    f"gains.{name} = {q}: the published law needs a ratio of odd integers, or its "
                    'powers have no real value for negative states; write for example "9/11", or '
                    'use law = "corrected", which takes signed powers'
                )
        if self.gains.runup_speed != 1.0 or self.gains.direction in {"toward", "backward"}:
            raise InputError(
                "the published law drives at u0 = 1: leave runup_speed and direction out of "
                '[gains], or use law = "corrected"'
            )
        heading = self.start_pose[2]
        if abs(heading) >= 0.5 * math.pi:
            degrees = math.degrees(heading)
            raise InputError(
                f"start heading {degrees:.1f}°: the published law exists for |θ| < 90° only; "
                'use law = "corrected", which turns first'
            )

    def _check_velocity_commanded(self) -> None:
        bounds, truth = self.bounds, self.truth
        known = [bounds.gamma_of(0), bounds.gamma_of(1)]
        if known != [(1.0, 1.0)] * 2 or max(bounds.disturbance_of(0), bounds.disturbance_of(1)) > 0:
            raise InputError(
                'robot.kind = "velocity": the robot keeps u0 and u1 in the controller, so '
                "gamma = 1 and disturbance = 0 hold exactly: leave both out of [bounds]"
            )
        if truth.gamma != Truth().gamma or truth.disturbance != Truth().disturbance:
            raise InputError(
                'robot.kind = "velocity": the robot keeps u0 and u1 in the controller, so '
                "gamma = 1 and disturbance = 0 hold exactly: leave both out of [truth]"
            )
