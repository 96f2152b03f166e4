"""``parkproof lab``: park from pixels, in the simulated laboratory or in a real one."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

if TYPE_CHECKING:
    from parkproof.cli.console import Report
    from parkproof.lab.devices import Clock
    from parkproof.lab.goal import Goal
    from parkproof.lab.loop import Finished, Watch
    from parkproof.lab.settings import LabSettings
    from parkproof.lab.simulated import Judged

INTERRUPTED = 130
"""Exit status after Ctrl-C; what there is of the run is kept."""


def lab(
    *,
    out: Path | None = None,
    seed: int | None = None,
    start: int = 0,
    hard: bool = False,
    world: Path | None = None,
    goal: Path | None = None,
    camera: str | None = None,
    robot: str | None = None,
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None,
    no_video: bool = False,
    no_recording: bool = False,
    check: bool = False,
    as_json: Annotated[bool, Parameter(name="--json")] = False,
    overwrite: bool = False,
    quiet: bool = False,
) -> int:
    """Park a robot that a camera sees, from its pictures alone.

    Without a camera and a robot, a simulated laboratory is used: physics, a rendered picture, a
    robot with imperfect motors. Writes summary.json, trajectory.parquet, goal.json, run.mcap (all
    pictures, poses, commands and events), run.mp4, a strip of pictures and an overview.

    Parameters
    ----------
    out : Path, optional
        Directory for the results; default runs/lab.
    seed : int, optional
        A random simulated laboratory; default a fixed one.
    start : int
        Which random start in it.
    hard : bool
        With 150 ms latency, a tenth of the frames dropped, and a distorting lens.
    world : Path, optional
        A file that describes a simulated laboratory; "parkproof init --kind world" writes one.
    goal : Path, optional
        What "parkproof teach" wrote; needed for a real laboratory.
    camera : str, optional
        A real camera: its number, an address, a video or a folder of pictures.
    robot : str, optional
        A real robot: udp://host:port.
    settings : list of str, optional
        Override a setting, as in hold=30 or delay=0.08; may be repeated.
    no_video : bool
        Make no video and no strip.
    no_recording : bool
        Make no run.mcap.
    check : bool
        Exit with status 1 unless the robot parked.
    as_json : bool
        Print the summary as JSON instead of a table.
    overwrite : bool
        Replace an earlier result in that directory.
    quiet : bool
        Show neither progress nor the table.

    Returns
    -------
    int
        Exit status.
    """
    from parkproof.cli.console import print_files, progress, stdout_console, write
    from parkproof.errors import InputError
    from parkproof.extras import require
    from parkproof.lab.settings import read_settings
    from parkproof.output import output_directory

    require("cv2", "pyapriltags", "mujoco", "av", "mcap", extra="lab", purpose="the laboratory")
    real = [name for name, value in (("camera", camera), ("robot", robot)) if value is not None]
    if real and (len(real) < 2 or goal is None):
        raise InputError(
            "a real laboratory needs all of --camera SOURCE, --robot ADDRESS and --goal goal.json; "
            "without camera and robot a simulated one is used"
        )
    if (seed is not None or hard) and (real or world is not None):
        raise InputError("--seed and --hard draw a simulated laboratory: give no other one besides")
    chosen = read_settings(settings or ())
    directory = Path("runs") / "lab" if out is None else out
    with output_directory(directory, overwrite=overwrite) as work, progress(quiet=quiet) as report:
        making = _Making(work, chosen, report, video=not no_video, recording=not no_recording)
        if real:
            assert goal is not None  # checked above
            summary = _real(making, goal, str(camera), str(robot))
        else:
            summary = _simulated(making, seed, start, world, goal, hard=hard)
        names = sorted(path.name for path in work.iterdir())
    if as_json:
        write((directory / "summary.json").read_text(encoding="utf-8"))
    elif not quiet:
        console = stdout_console()
        _print(console, summary)
        print_files(console, directory, names)
    if summary["outcome"] == "interrupted":
        return INTERRUPTED
    return 1 if check and summary["outcome"] != "parked" else 0


class _Making:
    """What a run leaves in its directory."""

    def __init__(
        self,
        directory: Path,
        settings: "LabSettings",
        report: "Report",
        *,
        video: bool,
        recording: bool,
    ) -> None:
        self.directory, self.settings = directory, settings
        self._report, self._video, self._recording = report, video, recording
        self._known: dict[str, Any] = {}

    def carry_out(
        self,
        goal: "Goal",
        robot: Any,
        clock: "Clock",
        run: Any,
        *,
        realtime: bool,
    ) -> tuple[Any, list[str]]:
        """Run with recorder and film as wanted; what it gave, and what was not written whole."""
        import time
        from contextlib import ExitStack

        from parkproof.lab.film import Film
        from parkproof.lab.loop import replay_settings
        from parkproof.lab.record import Recorder
        from parkproof.lab.safety import SafetyLimits

        goal.write(self.directory / "goal.json")
        settings = self.settings
        self._known = replay_settings(goal, robot, settings, SafetyLimits())
        with ExitStack() as stack:
            recorder = film = None
            if self._recording:
                recorder = stack.enter_context(
                    Recorder(
                        self.directory / "run.mcap",
                        settings=self._known,
                        epoch=time.time() - clock.now(),
                        realtime=realtime,
                    )
                )
            if self._video:
                path = self.directory / "run.mp4"
                film = stack.enter_context(Film(path, goal, settings.rate, realtime=realtime))
            found = run(recorder, self._watch(film))
        faults = [each.fault for each in (recorder, film) if each is not None]
        if film is not None:
            self._report("drawing", 0.0)
            film.write_strip(self.directory / "strip.png")
        return found, [fault for fault in faults if fault]

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
        self, goal: "Goal", finished: "Finished", notes: list[str], judged: "Judged | None"
    ) -> dict[str, Any]:
        """Write summary, trajectory and overview."""
        from parkproof.lab.loop import LabOutcome
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
            image_error=finished.seen_error(goal) if judged is None else judged.image_error,
            true_error=None if judged is None else judged.true_error,
            events=finished.events,
            notes=[*notes, *([finished.note] if finished.note else [])],
            settings=self._known,
        )
        write_summary(run, self.directory / "summary.json")
        write_trajectory(run, self.directory / "trajectory.parquet")
        self._report("drawing", 0.5)
        lab_pictures(run, self.directory)
        return summary_of(run)


def _simulated(
    making: _Making,
    seed: int | None,
    start: int,
    world_file: Path | None,
    goal_file: Path | None,
    *,
    hard: bool,
) -> dict[str, Any]:
    """Park in a simulated laboratory."""
    from parkproof.lab.goal import Goal
    from parkproof.lab.simulated import run_simulated, shown_goal
    from parkproof.lab.world.random_world import random_world
    from parkproof.lab.world.settings import example_world, read_world
    from parkproof.lab.world.world import World

    if world_file is not None:
        given = read_world(world_file)
    elif seed is not None or hard:
        given = random_world(seed or 0, start=start, hard=hard)
    else:
        given = example_world()
    with World(given) as world:
        goal = shown_goal(world)
        if goal_file is not None:
            goal = Goal.read(goal_file)

        def run(recorder: Any, watch: "Watch") -> "Judged":
            return run_simulated(
                world, goal, settings=making.settings, recorder=recorder, watch=watch
            )

        judged, notes = making.carry_out(goal, world.robot, world.clock, run, realtime=False)
    return making.write(goal, judged.run, notes, judged)


def _real(making: _Making, goal_file: Path, source: str, address: str) -> dict[str, Any]:
    """Park in a real laboratory."""
    from parkproof.lab.cameras import open_camera
    from parkproof.lab.devices import WallClock
    from parkproof.lab.goal import Goal
    from parkproof.lab.loop import run_lab
    from parkproof.lab.robots import open_robot

    goal = Goal.read(goal_file)
    camera = open_camera(source, rate=making.settings.rate, paced=True)
    try:
        robot = open_robot(address)

        def run(recorder: Any, watch: "Watch") -> "Finished":
            return run_lab(
                camera,
                robot,
                WallClock(),
                goal,
                settings=making.settings,
                recorder=recorder,
                watch=watch,
            )

        finished, notes = making.carry_out(goal, robot, WallClock(), run, realtime=True)
    finally:
        camera.close()
    return making.write(goal, finished, notes, None)


def _print(console: Any, summary: dict[str, Any]) -> None:
    """The outcome in a table."""
    from parkproof.cli.console import facts_table

    facts = [("outcome", summary["sentence"])]
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
    facts += [("note", note) for note in summary.get("notes", [])]
    console.print(facts_table(facts))
