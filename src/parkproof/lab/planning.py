"""Chooses the course of a run: from where the robot stands, with what is known of its gains."""

from collections.abc import Callable

from parkproof.bounds import Bounds
from parkproof.lab.arrival import Arrival
from parkproof.lab.devices import RobotLimits
from parkproof.lab.estimate import Estimate
from parkproof.lab.image_pose import TagMount
from parkproof.lab.pilot import Course
from parkproof.lab.plan import PACES, Drive, Task, driven_time, plan_course
from parkproof.lab.settings import LabSettings
from parkproof.lab.view import ImageView, tag_footprint

ROOM = 0.12
"""How far the tag stays inside the border in a course, in goal units."""

TRIED = (
    (1.0, 0.5, ROOM, False),
    (0.2, 0.5, ROOM, False),
    (0.0, 0.5, 0.02, True),
    (0.0, 0.25, 0.02, True),
    (0.0, 0.0, 0.02, True),
)
"""Shares of the gains' uncertainty, where their middle is taken to be between the least and the
greatest seen, room at the border, and whether to search thoroughly, for the courses that are tried
in turn."""

TOLERANCE = 0.6
"""Tolerances of Steps 2 and 3, as a share of that of arrival."""

BoundsFor = Callable[[float, float, float], Bounds]
"""Bounds of the gains for an error of the motors, a share of the uncertainty, and a middle."""


class Planner:
    """Plans courses for one robot, one goal and one view.

    Parameters
    ----------
    view : ImageView
        What the camera sees.
    mount : TagMount
        How the tag sits on the robot.
    limits : RobotLimits
        What the robot can do.
    arrival : Arrival
        When it has arrived.
    settings : LabSettings
        Law, gains, and the motors' error.
    drive : callable, optional
        How courses are driven in advance.
    quickest : float
        Largest time scale of Step 2.
    """

    def __init__(
        self,
        view: ImageView,
        mount: TagMount,
        limits: RobotLimits,
        *,
        arrival: Arrival,
        settings: LabSettings,
        drive: Drive = driven_time,
        quickest: float = PACES[0],
    ) -> None:
        self._view, self._mount, self._limits = view, mount, limits
        self._arrival, self._settings = arrival, settings
        self._drive, self._quickest = drive, quickest

    def course(
        self, estimate: Estimate, bounds: BoundsFor, *, scale: float, period: float, first: bool
    ) -> Course | None:
        """A course for all gains that are possible; failing that, for those that are likely.

        What then is not as foreseen, the guard at the border notices: it stops the robot, and
        another course is chosen from there.

        Parameters
        ----------
        estimate : Estimate
            Where the robot stands.
        bounds : callable
            Bounds of the gains.
        scale : float
            Greatest length in goal units that a side of the tag is known to have.
        period : float
            Time between commands in s.
        first : bool
            Whether nothing was learnt of the motors yet.

        Returns
        -------
        Course or None
            None if there is none.
        """
        footprint = tag_footprint(self._mount, scale)
        error = self._settings.motor_error * (1.0 if first else 0.5)
        for share, middle, room, thorough in TRIED:
            task = Task(
                view=self._view,
                margin=room,
                footprint=footprint,
                limits=self._limits,
                side=self._mount.side,
                bounds=bounds(error, share, middle),
                arrival=self._arrival,
                tolerance=(TOLERANCE * self._arrival.position,) * 2,
                law=self._settings.law,
                gains=self._settings.gains,
                thorough=thorough,
                quickest=self._quickest,
                drive=self._drive,
                period=period,
            )
            course = plan_course(task, estimate.pose, estimate.motion)
            if course is not None:
                return course
        return None
