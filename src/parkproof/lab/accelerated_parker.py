"""From a frame to accelerations: a parker for robots whose motors are commanded by torque."""

import math

from parkproof.bounds import Bounds
from parkproof.lab.accelerated_pilot import AcceleratedPilot, accelerated_time
from parkproof.lab.devices import RobotLimits
from parkproof.lab.estimate import Estimate, Estimator
from parkproof.lab.goal import Goal
from parkproof.lab.observer import AcceleratedEstimator
from parkproof.lab.parker import Parker
from parkproof.lab.pilot import Course
from parkproof.lab.safety import SafetyLimits
from parkproof.lab.settings import LabSettings
from parkproof.lab.stall import AcceleratedStallWatch, StallWatch

STANDING, STANDING_TURN = 0.01, 0.1
"""Speed in m/s and turn rate in rad/s below which a robot that brakes is taken to stand."""

QUICKEST = 0.6
"""Largest time scale of Step 2: what the latency leaves of the paper's pace."""

BRAKE = (math.nan, math.nan)
"""What the history holds in place of accelerations while the robot brakes."""


IDLE = (0.0, 0.0)
"""Inputs of the law while it is not in force."""


class AcceleratedParker(Parker):
    """Parks a robot that takes accelerations, as it was shown.

    Its speeds are estimated from the pictures. While nothing new is seen it is not accelerated;
    when something is wrong it brakes.

    Parameters
    ----------
    goal : Goal
        Where to park.
    limits : RobotLimits
        What the robot can do.
    settings : LabSettings, optional
        Law, times and tolerances.
    safety : SafetyLimits, optional
        When something is wrong.
    """

    def __init__(
        self,
        goal: Goal,
        limits: RobotLimits,
        settings: LabSettings | None = None,
        safety: SafetyLimits | None = None,
    ) -> None:
        super().__init__(goal, limits, settings, safety, drive=accelerated_time, quickest=QUICKEST)
        self._driver: AcceleratedPilot | None = None
        self._now.tau = IDLE

    def _new_estimator(self) -> Estimator:
        self._observer = AcceleratedEstimator(delay=self._settings.delay)
        return self._observer

    def _new_stall_watch(self) -> StallWatch:
        return AcceleratedStallWatch(
            self._limits,
            delay=self._settings.delay,
            motor_error=self._settings.motor_error,
            disturbance=self._settings.disturbance,
        )

    def _remember(self, now: float) -> None:
        self._history.add(now, *(self._now.accelerations or BRAKE))

    def carried_out(self, sent: tuple[float, float] | None, *, halted: float | None = None) -> None:
        """See `Parker.carried_out`."""
        self._now.accelerations = sent
        self._history.replace_last(*(sent or BRAKE), halted=halted, rest=BRAKE)

    def _held(self) -> tuple[float, float]:
        """No acceleration while nothing new is seen: its speed would grow unseen."""
        self._now.tau = IDLE
        if self._now.accelerations is not None:
            self._now.accelerations = (0.0, 0.0)
        return self._now.sent

    def _slowed(self, _dt: float) -> tuple[float, float]:
        """Brake."""
        self._now.accelerations, self._now.tau = None, IDLE
        return 0.0, 0.0

    def _stands(self, estimate: Estimate) -> bool:
        return (
            self._now.accelerations is None
            and abs(estimate.v) <= STANDING * estimate.a
            and abs(estimate.omega) <= STANDING_TURN * estimate.beta
        )

    def _drive(self, estimate: Estimate, now: float, dt: float) -> tuple[float, float]:
        assert self._driver is not None  # a course was begun
        asked = self._driver.step(now, estimate.ahead, estimate.moving, beta=estimate.beta)
        self._in_step(asked.step, now)
        moving = estimate.moving
        if alarm := self._guard.of_motion(
            estimate, moving.v, moving.omega, scale=self._tracker.scale, step=asked.step
        ):
            self._stop(alarm, now)
            return self._slowed(dt)
        self._arrived(asked.parked, now)
        if asked.parked:
            return self._slowed(dt)
        self._now.accelerations, self._now.tau = (asked.v_dot, asked.omega_dot), asked.tau
        return estimate.moving.v, estimate.moving.omega

    def _take_pilot(self, course: Course) -> None:
        self._driver = AcceleratedPilot(
            course,
            self._bounds(self._settings.motor_error, 1.0),
            self._limits,
            side=self._goal.mount.side,
            period=self.period,
            arrival=self._arrival,
        )

    def _bounds(self, error: float, share: float, middle: float = 0.5) -> Bounds:
        """Bounds of a; and of γ and φ, in tag sides and rad, with the motors' whole error."""
        motors = 1.0 - self._settings.motor_error, 1.0 + self._settings.motor_error
        push, twist = self._settings.disturbance
        return Bounds(
            alpha=super()._bounds(error, share, middle).alpha_of(0),
            gamma=motors,
            disturbance=(push / self._goal.mount.side, twist),
        )
