"""From a frame to velocities: a parker for the usual robot, whose motors follow speeds."""

from parkproof.lab.devices import RobotLimits
from parkproof.lab.estimate import Estimate, Estimator
from parkproof.lab.goal import Goal
from parkproof.lab.limits import limited
from parkproof.lab.parker import Parker
from parkproof.lab.pilot import Course, Pilot, Pulses
from parkproof.lab.plan import PACES, driven_time
from parkproof.lab.safety import SafetyLimits
from parkproof.lab.settings import LabSettings
from parkproof.lab.stall import StallWatch

FREE_TURN = 0.1
"""Share of the speed limit above which small turn rates need no pulses: the wheels turn anyway."""


class VelocityParker(Parker):
    """Parks a robot that takes velocities, as it was shown.

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
        super().__init__(goal, limits, settings, safety, drive=driven_time, quickest=PACES[0])
        self._pilot: Pilot | None = None
        self._pulses = Pulses(limits.least_speed), Pulses(limits.least_turn_rate)

    def carried_out(self, sent: tuple[float, float] | None, *, halted: float | None = None) -> None:
        """See `Parker.carried_out`."""
        self._now.sent = sent or (0.0, 0.0)
        self._history.replace_last(*self._now.sent, halted=halted)
        if halted is not None and self._pilot is not None:
            self._pilot.rest()

    def _new_estimator(self) -> Estimator:
        return Estimator(delay=self._settings.delay)

    def _new_stall_watch(self) -> StallWatch:
        return StallWatch(self._limits, delay=self._settings.delay)

    def _remember(self, now: float) -> None:
        """Keep what is sent, for the prediction."""
        self._history.add(now, *self._now.sent)

    def _held(self) -> tuple[float, float]:
        """What is sent while it is not yet clear that something is wrong."""
        return self._now.sent

    def _slowed(self, dt: float) -> tuple[float, float]:
        """What is sent to stop."""
        return limited(0.0, 0.0, *self._now.sent, dt, self._limits)

    def _stands(self, _estimate: Estimate) -> bool:
        """Whether the robot stands still."""
        return self._now.sent == (0.0, 0.0)

    def _drive(self, estimate: Estimate, now: float, dt: float) -> tuple[float, float]:
        """The command of the course, unless it leads out of the picture."""
        assert self._pilot is not None  # a course was begun
        asked = self._pilot.step(
            now, dt, estimate.ahead, beta=estimate.beta, motion=estimate.motion
        )
        self._in_step(asked.step, now)
        if alarm := self._guard.of_motion(
            estimate, asked.v, asked.omega, scale=self._tracker.scale, step=asked.step
        ):
            self._stop(alarm, now)
            return self._slowed(dt)
        self._arrived(asked.parked, now)
        return self._shaped(asked.v, asked.omega, dt)

    def _shaped(self, v: float, omega: float, dt: float) -> tuple[float, float]:
        """Pulses in place of what is below the robot's dead-band, within all limits."""
        shaped_v, shaped_omega = self._pulses[0].shaped(v, dt), omega
        if abs(shaped_v) < FREE_TURN * self._limits.speed:
            shaped_omega = self._pulses[1].shaped(omega, dt)
        return limited(shaped_v, shaped_omega, *self._now.sent, dt, self._limits)

    def _take_pilot(self, course: Course) -> None:
        """Have a course driven from now on."""
        self._pilot = Pilot(
            course,
            self._bounds(self._settings.motor_error, 1.0),
            self._limits,
            side=self._goal.mount.side,
            period=self.period,
            arrival=self._arrival,
        )
