"""Carries an image pose over the latency, with the commands already sent.

Between the moment of a picture and the moment at which a command acts, the robot carries out
commands that are known. So the image unicycle is integrated with them, from the pose that was seen
to the one that the next command will meet.
"""

import math
from collections import deque
from collections.abc import Iterator
from typing import NamedTuple

from parkproof.model.unicycle import wrap_angle

KEPT = 2.0
"""For how many seconds commands are remembered."""


class Motion(NamedTuple):
    """How the robot's own speeds follow from commands: v = speed·v̂, ω = turn·ω̂ + skew·v̂.

    Attributes
    ----------
    speed, turn : float
        Gains of the commands v̂ and ω̂; 1 for a perfect robot.
    skew : float
        Turn rate per speed in rad/m, from unequal wheels; 0 for a perfect robot.
    """

    speed: float = 1.0
    turn: float = 1.0
    skew: float = 0.0


class Response(NamedTuple):
    """How a speed answers: its rate is own·sent + cross·other + rest − friction·tanh(speed/slow).

    Attributes
    ----------
    own, cross : float
        Gains of the acceleration sent for this speed, and of that for the other one.
    rest : float
        Acceleration that nothing else explains.
    friction : float
        Of dry friction.
    slow : float
        Speed at which it begins.
    """

    own: float = 1.0
    cross: float = 0.0
    rest: float = 0.0
    friction: float = 0.0
    slow: float = 1.0

    def rate(self, speed: float, sent: float, other: float) -> float:
        """Rate of a speed, with accelerations sent for it and for the other one."""
        friction = self.friction * math.tanh(speed / self.slow)
        return self.own * sent + self.cross * other + self.rest - friction


class Moving(NamedTuple):
    """How a robot moves, in its own units, and how it answers.

    Attributes
    ----------
    v, omega : float
        Speed in m/s and turn rate in rad/s.
    along, turning : Response
        How they answer.
    """

    v: float = 0.0
    omega: float = 0.0
    along: Response = Response()
    turning: Response = Response()


class GoalPose(NamedTuple):
    """Pose in the goal's image frame.

    Attributes
    ----------
    x, y : float
        Position in goal units.
    theta : float
        Heading in rad.
    """

    x: float
    y: float
    theta: float


class _Sent(NamedTuple):
    t: float
    v: float
    omega: float


class CommandHistory:
    """The commands that were sent, each held until the next.

    Examples
    --------
    >>> history = CommandHistory()
    >>> history.add(0.0, 1.0, 0.0)
    >>> history.add(0.5, 2.0, 1.0)
    >>> history.totals(0.25, 1.0)
    (1.25, 0.5)
    """

    def __init__(self) -> None:
        self._sent: deque[_Sent] = deque()

    def add(self, t: float, v: float, omega: float) -> None:
        """Remember a command.

        Parameters
        ----------
        t : float
            When it was sent, in s; not before the last one.
        v, omega : float
            Speed in m/s and turn rate in rad/s.
        """
        self._sent.append(_Sent(t, v, omega))
        while len(self._sent) > 1 and self._sent[1].t < t - KEPT:
            self._sent.popleft()

    def replace_last(
        self,
        v: float,
        omega: float,
        *,
        halted: float | None = None,
        rest: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Correct the last command, which was not sent as remembered.

        Parameters
        ----------
        v, omega : float
            What was sent instead.
        halted : float, optional
            When the robot was stopped before that, in s.
        rest : two floats
            What stands for that stop.
        """
        last = self._sent.pop()
        if halted is not None and halted < last.t:
            self.add(halted, *rest)
        self.add(last.t, v, omega)

    def pieces(self, start: float, end: float) -> Iterator[tuple[float, float, float]]:
        """Durations with the commands in force: (dt, v, ω), from one time to another.

        Before the first command the robot stood still.
        """
        before = _Sent(-math.inf, 0.0, 0.0)
        for after in (*self._sent, _Sent(math.inf, 0.0, 0.0)):
            low, high = max(start, before.t), min(end, after.t)
            if high > low:
                yield high - low, before.v, before.omega
            before = after

    def totals(self, start: float, end: float) -> tuple[float, float]:
        """Way and angle commanded between two times, ∫v dt and ∫ω dt."""
        pieces = list(self.pieces(start, end))
        return sum(dt * v for dt, v, _ in pieces), sum(dt * omega for dt, _, omega in pieces)


def advanced(pose: GoalPose, dt: float, v: float, omega: float) -> GoalPose:
    """Move an image unicycle along an arc: ẋ = v cos θ, ẏ = v sin θ, θ̇ = ω, exactly.

    Parameters
    ----------
    pose : GoalPose
        Where it is.
    dt : float
        For how long, in s.
    v, omega : float
        Image speed, and turn rate of the image heading.

    Returns
    -------
    GoalPose
        Where it comes to.

    Examples
    --------
    >>> advanced(GoalPose(0.0, 0.0, 0.0), 1.0, 2.0, 0.0)
    GoalPose(x=2.0, y=0.0, theta=0.0)
    """
    half = 0.5 * omega * dt
    chord = v * dt * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
    heading = pose.theta + half
    return GoalPose(
        pose.x + chord * math.cos(heading),
        pose.y + chord * math.sin(heading),
        wrap_angle(pose.theta + 2.0 * half),
    )


def predicted_pose(
    pose: GoalPose,
    history: CommandHistory,
    *,
    start: float,
    end: float,
    a: float,
    beta: float,
    motion: Motion,
) -> GoalPose:
    """Carry a pose from one time to another.

    Parameters
    ----------
    pose : GoalPose
        At the start.
    history : CommandHistory
        What was sent.
    start, end : float
        Between which commands act, in s.
    a : float
        Image speed per speed of the robot, goal units per m.
    beta : float
        Turn rate of the image heading per turn rate of the robot.
    motion : Motion
        How the robot answers to commands.

    Returns
    -------
    GoalPose
        At the end.

    Examples
    --------
    >>> history = CommandHistory()
    >>> history.add(0.0, 0.5, 0.0)
    >>> predicted_pose(GoalPose(0.0, 0.0, 0.0), history, start=0.0, end=0.2, a=10.0, beta=1.0,
    ...                motion=Motion())
    GoalPose(x=1.0, y=0.0, theta=0.0)
    """
    for dt, v, omega in history.pieces(start, end):
        turn = beta * (motion.turn * omega + motion.skew * v)
        pose = advanced(pose, dt, a * motion.speed * v, turn)
    return pose
