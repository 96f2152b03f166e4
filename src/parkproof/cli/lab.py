"""``parkproof lab``: park from pixels, in the simulated laboratory or in a real one."""

import signal
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

if TYPE_CHECKING:
    from parkproof.cli.lab_results import LabResults
    from parkproof.lab.loop import Finished, Watch
    from parkproof.lab.simulated import Judged


def lab(
    *,
    out: Path | None = None,
    seed: int | None = None,
    start: int | None = None,
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
    start : int, optional
        Which random start in it; default 0.
    hard : bool
        With 150 ms latency, a tenth of the frames dropped, and a distorting lens.
    world : Path, optional
        A file that describes a simulated laboratory; "parkproof init --kind world" writes one.
    goal : Path, optional
        What "parkproof teach" wrote; needed for a real laboratory.
    camera : str, optional
        A real camera: its number, an address, a video or a folder of pictures.
    robot : str, optional
        A real robot: udp://host:port, or a file with its address, limits and wheels;
        "parkproof init --kind robot" writes one.
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
    from parkproof.cli.console import facts_table, print_files, progress, stdout_console, write
    from parkproof.cli.lab_results import LabResults, summary_facts
    from parkproof.errors import InputError
    from parkproof.extras import require
    from parkproof.lab.outcome import LabOutcome
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
    if start is not None and seed is None and not hard:
        raise InputError(
            f"--start {start}: numbers the starts in a laboratory that is drawn; write --seed 0 "
            "besides, or leave it out"
        )
    chosen = read_settings(settings or ())
    directory = Path("runs") / "lab" if out is None else out
    kept: list[str] = []
    with (
        output_directory(directory, overwrite=overwrite, kept=kept) as work,
        progress(quiet=quiet) as report,
    ):
        results = LabResults(
            work, chosen, report, sound=kept, video=not no_video, recording=not no_recording
        )
        if goal is not None and camera is not None and robot is not None:
            finished, summary = _real(results, goal, camera, robot)
        else:
            drawn = None if seed is None and not hard else (seed or 0, start or 0, hard)
            finished, summary = _simulated(results, drawn, world, goal)
        names = sorted(path.name for path in work.iterdir())
    if as_json:
        write((directory / "summary.json").read_text(encoding="utf-8"))
    elif not quiet:
        console = stdout_console()
        console.print(facts_table(summary_facts(summary)))
        print_files(console, directory, names)
    if finished.outcome is LabOutcome.INTERRUPTED:  # what there is of the run is kept
        return 128 + signal.Signals[finished.stopped_by or "SIGINT"]
    return 1 if check and finished.outcome is not LabOutcome.PARKED else 0


def _simulated(
    results: "LabResults",
    drawn: tuple[int, int, bool] | None,
    world_file: Path | None,
    goal_file: Path | None,
) -> "tuple[Finished, dict[str, Any]]":
    """Park in a simulated laboratory."""
    from parkproof.lab.goal import Goal
    from parkproof.lab.simulated import floor_pose, run_simulated, shown_goal
    from parkproof.lab.world.random_world import random_world
    from parkproof.lab.world.settings import example_world, read_world
    from parkproof.lab.world.world import World

    if world_file is not None:
        given = read_world(world_file)
    elif drawn is not None:
        seed, start, hard = drawn
        given = random_world(seed, start=start, hard=hard)
    else:
        given = example_world()
    taught = None if goal_file is None else Goal.read(goal_file)
    with World(given) as world:
        if taught is None:
            goal, wanted = shown_goal(world), None
        else:
            goal, wanted = taught, floor_pose(world, taught)

        def run(recorder: Any, watch: "Watch") -> "Judged":
            return run_simulated(
                world,
                goal,
                settings=results.settings,
                recorder=recorder,
                watch=watch,
                wanted=wanted,
            )

        judged = results.carry_out(goal, world.robot, world.clock, run, realtime=False)
    return judged.run, results.write(
        goal, judged.run, image_error=judged.image_error, true_error=judged.true_error
    )


def _real(
    results: "LabResults", goal_file: Path, source: str, address: str
) -> "tuple[Finished, dict[str, Any]]":
    """Park in a real laboratory."""
    from parkproof.lab.cameras import open_camera
    from parkproof.lab.devices import WallClock
    from parkproof.lab.goal import Goal
    from parkproof.lab.last_error import last_error
    from parkproof.lab.loop import run_lab
    from parkproof.lab.robot_file import robot_named

    goal, known = Goal.read(goal_file), robot_named(address)
    camera = open_camera(source, rate=results.settings.rate, paced=True)
    try:
        robot = known.open()

        def run(recorder: Any, watch: "Watch") -> "Finished":
            return run_lab(
                camera,
                robot,
                WallClock(),
                goal,
                settings=results.settings,
                recorder=recorder,
                watch=watch,
            )

        finished = results.carry_out(goal, robot, WallClock(), run, realtime=True)
    finally:
        camera.close()
    error = last_error(finished.samples, unit=goal.unit)
    return finished, results.write(goal, finished, image_error=error)
