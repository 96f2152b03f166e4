"""From sightings of the tag to speeds, for a robot that takes accelerations.

Its speeds are not known from what it is sent. For its way and for its angle, a Kalman filter takes
in what the pictures show and what was sent, and finds the speed and how the robot answers:

    v̇ = own·v̇_sent + cross·ω̇_sent + rest − friction·tanh(v/slow),

and likewise ω̇. Own and cross are the motors' gains (the cross ones from unequal motors), friction
is dry, and the rest is what nothing else explains. Then pose and speeds are carried over the
latency by this model, with the accelerations already sent.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.lab.estimate import LONGEST_GAP, Estimator, Sighting
from parkproof.lab.predict import CommandHistory, GoalPose, Moving, Response, advanced
from parkproof.model.unicycle import wrap_angle

PART = 0.01
"""Longest step of prediction in s."""


@dataclass(frozen=True)
class Noise:
    """What a filter expects, in the units of its axis (m or rad).

    Attributes
    ----------
    seen : float
        Standard deviation of a way seen.
    own, cross, friction : float
        Standard deviations of the gains and of friction at first.
    rest, pushed : float
        What the rest, and the speed, change by at random in the root of a second.
    slow : float
        Speed at which friction begins.
    slid : float
        How far it may slide between two frames while it brakes.
    drift : float
        Share of those at first by which gains and friction change in the root of a second.
    """

    seen: float
    own: float
    cross: float
    friction: float
    rest: float
    pushed: float
    slow: float
    slid: float
    drift: float = 0.05


ALONG = Noise(
    seen=1e-4, own=0.15, cross=0.015, friction=0.1, rest=0.1, pushed=0.01, slow=0.005, slid=1e-3
)
TURNING = Noise(
    seen=1.5e-3, own=0.15, cross=2.0, friction=0.7, rest=1.0, pushed=0.1, slow=0.05, slid=1e-2
)


class _Axis:
    """The filter of one axis: way, speed, own, cross, rest, friction."""

    def __init__(self, noise: Noise) -> None:
        self._noise = noise
        self._x: NDArray[np.float64] = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        first = (noise.seen, 0.0, noise.own, noise.cross, noise.rest, noise.friction)
        self._P: NDArray[np.float64] = np.diag(np.square(first))
        lasting = noise.drift * np.array([noise.own, noise.cross, noise.friction])
        own, cross, friction = lasting
        self._Q = np.square([0.0, noise.pushed, own, cross, noise.rest, friction])
        self._seen = 0.0

    def begin(self) -> None:
        """At rest from now on; what was learnt stays."""
        self._seen = self._x[0] = 0.0
        self._stand(way=self._noise.seen)

    def update(self, moved: float, sent: list[tuple[float, float, float]]) -> None:
        """Take in what was seen, and what was sent (durations, own, other)."""
        for duration, own, other in sent:
            if math.isnan(own):
                self._brake()
                continue
            count = math.ceil(duration / PART)
            for _ in range(count):
                self._predict(duration / count, own, other)
        self._seen += moved
        gain = self._P[:, 0] / (self._P[0, 0] + self._noise.seen**2)
        self._x = self._x + gain * (self._seen - self._x[0])
        self._P = self._P - np.outer(gain, self._P[0])

    def _brake(self) -> None:
        """Stand; though it may have slid meanwhile."""
        self._stand(way=math.sqrt(self._P[0, 0] + self._noise.slid**2))

    def _stand(self, *, way: float) -> None:
        """No speed, and nothing that pushes; what was learnt stays."""
        self._x[[1, 4]] = 0.0
        for i, deviation in ((0, way), (1, 0.0), (4, self._noise.rest)):
            self._P[i, :] = self._P[:, i] = 0.0
            self._P[i, i] = deviation**2

    def _predict(self, h: float, own: float, other: float) -> None:
        x, slow = self._x, self._noise.slow
        grip = math.tanh(x[1] / slow)
        rate = self.response.rate(float(x[1]), own, other)
        F: Any = np.eye(6)
        F[0, 1] = h
        F[1, 1] -= h * x[5] * (1.0 - grip * grip) / slow
        F[1, 2:] = h * own, h * other, h, -h * grip
        F[0, 2:] = 0.5 * h * F[1, 2:]
        x[0] += h * (x[1] + 0.5 * h * rate)
        x[1] += h * rate
        self._P = F @ self._P @ F.T
        self._P[np.diag_indices(6)] += h * self._Q

    @property
    def speed(self) -> float:
        """Speed found."""
        return float(self._x[1])

    @property
    def response(self) -> Response:
        """Response found."""
        _, _, own, cross, rest, friction = (float(value) for value in self._x)
        friction = max(friction, 0.0)
        return Response(min(max(own, 0.5), 2.0), cross, rest, friction, self._noise.slow)


class AcceleratedEstimator(Estimator):
    """Filter, differentiator and predictor for a robot that takes accelerations.

    Parameters
    ----------
    delay : float
        Time in s from sending a command until the robot accelerates so.

    Examples
    --------
    >>> estimator, history = AcceleratedEstimator(delay=0.05), CommandHistory()
    >>> history.add(0.0, 0.1, 0.0)
    >>> for k in range(1, 31):
    ...     t = k / 30
    ...     x = 0.5 * max(0.0, t - 0.05) ** 2  # 10 units per m, at 0.1 m/s²
    ...     seen = Sighting(t, GoalPose(x, 0.0, 0.0), a=10.0, beta=1.0)
    ...     found = estimator.update(seen, history, now=t + 0.1)
    >>> round(found.moving.v, 2)
    0.11
    """

    def __init__(self, *, delay: float) -> None:
        super().__init__(delay=delay)
        self._axes = _Axis(ALONG), _Axis(TURNING)
        self._before: Sighting | None = None

    @property
    def moving(self) -> Moving:
        """How the robot moved when it was seen last."""
        along, turning = self._axes
        return Moving(along.speed, turning.speed, along.response, turning.response)

    def forget(self) -> None:
        """Begin anew with the next sighting, at rest."""
        super().forget()
        self.rest()

    def rest(self) -> None:
        """The robot brakes: it is taken to stand still from now on."""
        for axis in self._axes:
            axis.begin()

    def _ahead(
        self, pose: GoalPose, seen: Sighting, history: CommandHistory, now: float
    ) -> tuple[GoalPose, Moving]:
        """Pose when the next command acts, and how the robot moves then."""
        before, self._before = self._before, seen
        if before is None or not 0.0 < seen.t - before.t <= LONGEST_GAP:
            self.rest()
        else:
            self._observe(before, seen, history)
        start = seen.t - self._delay
        return carried(pose, self.moving, history, start=start, end=now, a=seen.a, beta=seen.beta)

    def _observe(self, before: Sighting, seen: Sighting, history: CommandHistory) -> None:
        """Find speeds and left-over accelerations from two sightings."""
        turn = wrap_angle(seen.pose.theta - before.pose.theta)
        middle = before.pose.theta + 0.5 * turn
        along = (seen.pose.x - before.pose.x) * math.cos(middle) + (
            seen.pose.y - before.pose.y
        ) * math.sin(middle)
        moved = along / (0.5 * (before.a + seen.a)), turn / (0.5 * (before.beta + seen.beta))
        pieces = list(history.pieces(before.t - self._delay, seen.t - self._delay))
        self._axes[0].update(moved[0], pieces)
        self._axes[1].update(moved[1], [(dt, omega_dot, v_dot) for dt, v_dot, omega_dot in pieces])

    def _learn(self, last: Sighting, seen: Sighting, turn: float, history: CommandHistory) -> None:
        """Nothing: how it answers to speeds that are sent is no question here."""


def carried(
    pose: GoalPose,
    moving: Moving,
    history: CommandHistory,
    *,
    start: float,
    end: float,
    a: float,
    beta: float,
) -> tuple[GoalPose, Moving]:
    """Carry pose and speeds from one time to another, with the accelerations sent meanwhile.

    Parameters
    ----------
    pose : GoalPose
        At the start.
    moving : Moving
        At the start.
    history : CommandHistory
        Accelerations that were sent; NaN where it was told to brake.
    start, end : float
        Between which they act, in s.
    a : float
        Image speed per speed of the robot, goal units per m.
    beta : float
        Turn rate of the image heading per turn rate of the robot.

    Returns
    -------
    GoalPose and Moving
        At the end.

    Examples
    --------
    >>> history = CommandHistory()
    >>> history.add(0.0, 0.5, 0.0)
    >>> pose, moving = carried(GoalPose(0.0, 0.0, 0.0), Moving(v=0.1), history,
    ...                        start=0.0, end=0.2, a=10.0, beta=1.0)
    >>> round(pose.x, 6), round(moving.v, 6)
    (0.3, 0.2)
    """
    v, omega, along, turning = moving
    for dt, v_dot, omega_dot in history.pieces(start, end):
        if math.isnan(v_dot):
            v = omega = 0.0
            continue
        count = math.ceil(dt / PART)
        h = dt / count
        for _ in range(count):
            v_next = v + h * along.rate(v, v_dot, omega_dot)
            omega_next = omega + h * turning.rate(omega, omega_dot, v_dot)
            pose = advanced(pose, h, 0.5 * a * (v + v_next), 0.5 * beta * (omega + omega_next))
            v, omega = v_next, omega_next
    return pose, Moving(v, omega, along, turning)
