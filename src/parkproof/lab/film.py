"""Films a run: the video with what is known drawn on it, and a strip of its pictures."""

import math
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from parkproof.lab.answer import Answer, Phase
from parkproof.lab.devices import Frame, Image, Missing
from parkproof.lab.goal import Goal
from parkproof.lab.overlay import Bar, Overlay, overlay
from parkproof.lab.picture import as_picture
from parkproof.lab.tag_square import SQUARE
from parkproof.lab.video import RunVideo, strip
from parkproof.model.homography import Homography

SHOWN = 2.0
"""For how long an event is shown, in s."""

RESTED = 1.0
"""A strip ends when the robot has been parked for so long, in s."""

STRIP = 9
"""Pictures in a strip."""

KEPT = 240
"""Pictures kept for the strip; where there are more, every second one is dropped."""

Points = list[tuple[float, float]]


class Film:
    """Told of every frame, it writes a video and keeps pictures for a strip.

    Parameters
    ----------
    path : Path
        The video.
    goal : Goal
        Where the robot shall park.
    rate : float
        Frames per s.
    realtime : bool
        Whether the loop may not wait for the video.
    """

    def __init__(self, path: Path, goal: Goal, rate: float, *, realtime: bool) -> None:
        self._goal = goal
        self._video = RunVideo(path, goal.picture, rate, realtime=realtime)
        self._began: float | None = None
        self._path: Points = []
        self._steps: list[int] = []
        self._event, self._alarm, self._since = "", False, -math.inf
        self._course_began, self._foreseen = 0.0, math.nan
        self._kept: list[tuple[Image, Overlay]] = []
        self._every, self._count = 1, 0
        self._parked_since: float | None = None
        tag = Homography(goal.homography)
        self._goal_tag = np.array([tag.project(i, j) for i, j in SQUARE])

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._video.close()

    @property
    def fault(self) -> str | None:
        """Why there is no whole video, or None."""
        return self._video.fault

    def add(self, reading: Frame | Missing, answer: Answer) -> None:
        """Take in a frame.

        Parameters
        ----------
        reading : Frame or Missing
            What the camera gave; nothing is shown where it gave nothing.
        answer : Answer
            What it led to.
        """
        if self._began is None:
            self._began = answer.t
        for event in answer.events:
            self._event, self._alarm, self._since = event.sentence, event.level > 0, answer.t
            if event.name == "course":
                self._course_began, self._foreseen = answer.t, answer.foreseen
        if isinstance(reading, Missing):
            return
        info, image = self._overlay(answer), as_picture(reading.image)
        self._video.add(image, info)
        if answer.phase is Phase.PARKED:
            self._parked_since = self._parked_since or answer.t
        else:
            self._parked_since = None
        rested = self._parked_since is not None and answer.t - self._parked_since > RESTED
        whole = image.shape[1::-1] == self._goal.picture
        if self._count % self._every == 0 and not rested and whole:
            self._kept.append((image.copy(), info))
            if len(self._kept) > KEPT:
                del self._kept[1::2]
                self._every *= 2
        self._count += 1

    def _overlay(self, answer: Answer) -> Overlay:
        """What is known at a frame."""
        goal, estimate = self._goal, answer.estimate
        pose = error_px = error_deg = None
        planned = None
        if estimate is not None:
            u, v = goal.to_pixels(*estimate.pose[:2])
            flip = -1.0 if goal.mirrored else 1.0
            pose = (u, v, goal.psi + flip * estimate.pose.theta)
            self._path.append((u, v))
            self._steps.append(max(answer.step, 0))
            error_px = math.hypot(u - goal.u, v - goal.v)
            error_deg = math.degrees(abs(estimate.pose.theta))
            planned = np.array([(u, v), goal.to_pixels(*estimate.ahead[:2])])
        assert self._began is not None  # set when the frame was taken in
        shown = answer.t - self._since <= SHOWN or answer.alarm is not None
        bar = None
        if math.isfinite(self._foreseen) and answer.phase is not Phase.PARKED:
            bar = Bar(
                f"foreseen: {self._foreseen:.1f} s", answer.t - self._course_began, self._foreseen
            )
        return Overlay(
            t=answer.t - self._began,
            goal=(goal.u, goal.v, goal.psi),
            step=answer.step if answer.step >= 0 else None,
            v=answer.v,
            omega=answer.omega,
            pose=pose,
            tag=None if answer.tag is None else np.array(answer.tag.corners),
            goal_tag=self._goal_tag,
            path=np.array(self._path) if self._path else None,
            path_steps=np.array(self._steps) if self._path else None,
            planned=planned,
            error_px=error_px,
            error_deg=error_deg,
            bar=bar,
            event=self._event if shown and self._event else None,
            alarm=self._alarm,
        )

    def write_strip(self, path: Path) -> None:
        """Write the strip; nothing if no frame came.

        Parameters
        ----------
        path : Path
            The picture.
        """
        if not self._kept:
            return
        last = len(self._kept) - 1
        chosen = sorted({round(i * last / (STRIP - 1)) for i in range(STRIP)})
        strip([overlay(*self._kept[i]) for i in chosen], path)
