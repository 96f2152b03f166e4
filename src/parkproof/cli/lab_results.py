"""What a run of the laboratory leaves in its directory, and its table for people."""

import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from parkproof.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from parkproof.cli.console import Report
    from parkproof.lab.devices import Clock
    from parkproof.lab.goal import Goal
    from parkproof.lab.loop import Finished, Watch
    from parkproof.lab.settings import LabSettings
    from parkproof.lab.summary import Error

_Found = TypeVar("_Found")


class LabResults:
    """Has a run recorded and filmed, and writes what came of it.

    Parameters
    ----------
    directory : Path
        Where.
    settings : LabSettings
        Of the run.
    report : callable
        Shows progress.
    sound : list of str
        Takes the names of files that are whole, whatever comes after.
    video, recording : bool
        What is wanted.
    """

    def __init__(
        self,
        directory: Path,
        settings: "LabSettings",
        report: "Report",
        *,
        sound: list[str],
        video: bool,
        recording: bool,
    ) -> None:
        self.directory, self.settings = directory, settings
        self._sound = sound
        self._report, self._video, self._recording = report, video, recording
        self._notes: list[str] = []
        self._known: dict[str, Any] = {}

    def carry_out(
        self,
        goal: "Goal",
        robot: Any,
        clock: "Clock",
        run: "Callable[[Any, Watch], _Found]",
        *,
        realtime: bool,
    ) -> _Found:
        """Run with recorder and film as wanted.

        Parameters
        ----------
        goal : Goal
            Where to park.
        robot : Robot or AcceleratedRobot
            What is driven.
        clock : Clock
            Of the loop.
        run : callable
            Takes a recorder and a watch.
        realtime : bool
            Whether the loop may not wait.

        Returns
        -------
        object
            What the run gave.
        """
        from parkproof.lab.film import Film
        from parkproof.lab.loop import replay_settings
        from parkproof.lab.record import Recorder
        from parkproof.lab.safety import SafetyLimits

        goal.write(self.directory / "goal.json")
        self._known = replay_settings(goal, robot, self.settings, SafetyLimits())
        recorder = film = None
        try:
            with ExitStack() as stack:
                if self._recording:
                    path = self.directory / "run.mcap"
                    recorder = stack.enter_context(
                        Recorder(
                            path,
                            settings=self._known,
                            epoch=time.time() - clock.now(),
                            realtime=realtime,
                        )
                    )
                if self._video:
                    path = self.directory / "run.mp4"
                    film = stack.enter_context(
                        Film(path, goal, self.settings.rate, realtime=realtime)
                    )
                found = run(recorder, self._watch(film))
        finally:
            if recorder is not None and recorder.frames:
                self._keep_if_whole(self.directory / "run.mcap")
        faults = [each.fault for each in (recorder, film) if each is not None]
        self._notes = [fault for fault in faults if fault]
        if film is not None:
            self._report("drawing", 0.0)
            film.write_strip(self.directory / "strip.png")
        return found

    def _keep_if_whole(self, path: Path) -> None:
        """Have a recording outlive what may go wrong from now on."""
        from parkproof.lab.recording import Recording

        try:
            if Recording.open(path).whole:
                self._sound.append(path.name)
        except InputError:  # the disk was full before there was anything in it
            return

    def _watch(self, film: Any) -> "Watch":
        """Tell the film and the progress bar of every frame."""
        began: list[float] = []

        def watch(reading: Any, answer: Any) -> None:
            began.append(answer.t) if not began else None
            if film is not None:
                film.add(reading, answer)
            done = (answer.t - began[0]) / self.settings.duration
            self._report(f"{answer.phase.sentence}, {answer.t - began[0]:.0f} s", done)

        return watch

    def write(
        self,
        goal: "Goal",
        finished: "Finished",
        *,
        image_error: "Error | None",
        true_error: "Error | None" = None,
    ) -> dict[str, Any]:
        """Write summary, trajectory and overview.

        Parameters
        ----------
        goal : Goal
            Where to park.
        finished : Finished
            The run.
        image_error, true_error : Error, optional
            At the end.

        Returns
        -------
        dict
            The summary.
        """
        from parkproof.lab.outcome import LabOutcome
        from parkproof.lab.summary import (
            LabRun,
            Setting,
            summary_of,
            write_summary,
            write_trajectory,
        )
        from parkproof.report.lab import lab_pictures

        run = LabRun(
            scenario=Setting(
                law=self.settings.law,
                title="Laboratory",
                view_outline=tuple(goal.corners()),
            ),
            outcome=finished.outcome,
            parked=finished.outcome is LabOutcome.PARKED,
            ended=finished.ended - finished.began,
            samples=finished.samples,
            frames=finished.frames,
            latencies=finished.latencies,
            image_error=image_error,
            true_error=true_error,
            events=finished.events,
            notes=[*self._notes, *([finished.note] if finished.note else [])],
            settings=self._known,
        )
        write_summary(run, self.directory / "summary.json")
        write_trajectory(run, self.directory / "trajectory.parquet")
        self._report("drawing", 0.5)
        lab_pictures(run, self.directory)
        return summary_of(run)


def summary_facts(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """The outcome, for a table.

    Parameters
    ----------
    summary : dict
        Of summary.json.

    Returns
    -------
    list of pairs
        Names and what they are.

    Examples
    --------
    >>> frames = {"seen": 90, "without_tag": 1, "dropped": 0, "out_of_view": None}
    >>> summary_facts({"sentence": "Parked.", "frames": frames, "latency": None})[1]
    ('frames', '90 with the tag, 1 without, 0 dropped')
    """
    facts = [("outcome", str(summary["sentence"]))]
    frames, latency = summary["frames"], summary["latency"]
    for name, unit, error in (
        ("error in the picture", "px", summary.get("image_error")),
        ("error on the floor", "m", summary.get("true_error")),
    ):
        if error:
            distance, heading = error.values()
            facts.append((name, f"{distance:.3g} {unit}, {heading:.2f}°"))
    unseen = frames["out_of_view"]
    facts.append(
        (
            "frames",
            f"{frames['seen']} with the tag, {frames['without_tag']} without, "
            f"{frames['dropped']} dropped"
            + ("" if unseen is None else f", {unseen} with the tag out of view"),
        )
    )
    if latency:
        facts.append(("image in to command out", f"median {1e3 * latency['median']:.1f} ms"))
    return facts + [("note", note) for note in summary.get("notes", [])]
