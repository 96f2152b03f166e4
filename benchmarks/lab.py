"""Random cameras, robots and starts in the simulated laboratory: how many park, and how well.

    python benchmarks/lab.py --cameras 100 --starts 3 [--hard] [--torque] [--out FILE] [--workers 2]

Needs the extra "lab". One line a run is appended to the file, and runs that are in it are not
repeated, so that the benchmark can be interrupted. Then the table is printed.
"""

import argparse
import csv
import math
import statistics
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

FIELDS = (
    "seed", "start", "hard", "torque", "outcome", "parked_after", "px", "deg", "floor_cm",
    "floor_deg", "allowed_cm", "out_of_view", "frames", "courses", "alarms", "median_ms", "p99_ms",
    "speed", "side_px", "parkable",
)  # fmt: skip

KEY = FIELDS[:4]
"""What names a run."""


def run(seed: int, start: int, hard: int, torque: int) -> dict:
    """One run; numbers of the picture are the worst while the robot was held for 10 s."""
    import cv2
    from msgspec.structs import replace

    from parkproof.lab.settings import LabSettings
    from parkproof.lab.simulated import run_simulated, shown_goal
    from parkproof.lab.world import World
    from parkproof.lab.world.random_world import random_world

    cv2.setNumThreads(1)
    drawn = random_world(seed, start=start, hard=bool(hard))
    if torque:
        drawn = replace(drawn, robot=replace(drawn.robot, commanded_by="torque"))
    with World(drawn) as world:
        goal = shown_goal(world)
        begun, simulated = time.perf_counter(), world.t
        judged = run_simulated(world, goal, settings=LabSettings())
        taken = time.perf_counter() - begun
        found = judged.run
        simulated = world.t - simulated
        latencies = sorted(found.latencies)
        refused = found.outcome.value == "refused"
        return {
            "seed": seed,
            "start": start,
            "hard": hard,
            "torque": torque,
            "outcome": found.outcome.value,
            "parked_after": found.parked_at - found.began if found.parked_at else "",
            "px": round(judged.worst_image_error.distance, 3),
            "deg": round(judged.worst_image_error.heading_deg, 3),
            "floor_cm": round(100 * judged.true_error.distance, 4),
            "floor_deg": round(judged.true_error.heading_deg, 3),
            "allowed_cm": round(judged.floor_width / 1.5, 3),
            "out_of_view": found.frames.out_of_view,
            "frames": found.frames.seen + found.frames.without_tag,
            "courses": sum(event.name == "course" for event in found.events),
            "alarms": " ".join(event.name for event in found.events if event.level == 1),
            "median_ms": round(1e3 * statistics.median(latencies), 2),
            "p99_ms": round(1e3 * latencies[int(0.99 * (len(latencies) - 1))], 2),
            "speed": round(simulated / taken, 2),
            "side_px": round(goal.unit, 1),
            "parkable": int(parkable(world, goal)) if refused else "",
        }


def parkable(world, goal) -> bool:
    """Whether a refused start has a course if every gain is known exactly, with hardly a margin."""
    from parkproof.bounds import Bounds
    from parkproof.lab.arrival import Arrival
    from parkproof.lab.plan import Task, plan_course
    from parkproof.lab.predict import GoalPose
    from parkproof.lab.view import ImageView, tag_footprint
    from parkproof.model.image_unicycle import image_of
    from parkproof.model.unicycle import Pose

    start = image_of(goal.similarity @ world.to_pixels, Pose(*world.settings.start)).pose
    task = Task(
        view=ImageView(tuple(goal.corners())),
        margin=0.0,
        footprint=tag_footprint(goal.mount, 1.0),
        limits=world.robot.limits,
        side=goal.mount.side,
        bounds=Bounds(alpha=(1.0, 1.0)),
        arrival=Arrival(0.5 / goal.unit, 0.007),
        tolerance=(0.3 / goal.unit, 0.3 / goal.unit),
        thorough=True,
    )
    return plan_course(task, GoalPose(*start)) is not None


def parked(row: dict) -> bool:
    """Whether a run reached all of the figures."""
    return (
        row["outcome"] == "parked"
        and float(row["px"]) <= 1.0
        and float(row["deg"]) <= 1.0
        and float(row["floor_cm"]) <= float(row["allowed_cm"])
        and float(row["floor_deg"]) <= 1.0
    )


def quantile(values: list[float], share: float) -> float:
    """The value below which this share lies; not a number where there are none."""
    ordered = sorted(values)
    if not ordered:
        return math.nan
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def summarise(rows: list[dict], console: Console) -> None:
    """Print the table."""
    accepted = [row for row in rows if row["outcome"] != "refused"]
    refused = len(rows) - len(accepted)
    good = [row for row in accepted if parked(row)]
    table = Table("what", "measured", title=f"{len(rows)} starts")

    def numbers(name: str, of: list[dict]) -> str:
        values = [float(row[name]) for row in of]
        if not values:
            return "none"
        return f"median {statistics.median(values):.3g}, worst {max(values):.3g}"

    sure = sum(row["parkable"] == "0" for row in rows)
    table.add_row(
        "refused before moving",
        f"{refused} ({100 * refused / len(rows):.1f} %), {sure} of them without a course even if "
        "every gain is known",
    )
    table.add_row(
        "parked and held for 10 s within 1 px, 1° and 1 cm",
        f"{len(good)} of {len(accepted)} ({100 * len(good) / max(len(accepted), 1):.1f} %)",
    )
    outside = sum(int(row["out_of_view"]) for row in rows)
    frames = sum(int(row["frames"]) for row in rows)
    table.add_row("frames with the robot out of view", f"{outside} of {frames}")
    table.add_row("error in the picture, px", numbers("px", good))
    table.add_row("error of the image heading, °", numbers("deg", good))
    table.add_row("error on the floor, cm", numbers("floor_cm", good))
    table.add_row("error of the heading, °", numbers("floor_deg", good))
    late = quantile([float(row["parked_after"]) for row in good], 0.95)
    table.add_row("time to park, s", f"{numbers('parked_after', good)}, 95 % within {late:.3g}")
    table.add_row("image in to command out, median of a run, ms", numbers("median_ms", accepted))
    table.add_row(
        "image in to command out, 99th percentile of a run, ms", numbers("p99_ms", accepted)
    )
    speeds = [float(row["speed"]) for row in accepted]
    least = min(speeds, default=math.nan)
    table.add_row(
        "speed, times real time", f"median {quantile(speeds, 0.5):.3g}, least {least:.3g}"
    )
    console.print(table)
    for row in accepted:
        if not parked(row) or int(row["out_of_view"]):
            console.print({name: row[name] for name in FIELDS})


def main() -> None:
    """Run what is missing, then print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cameras", type=int, default=100)
    parser.add_argument("--starts", type=int, default=3)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--hard", action="store_true")
    parser.add_argument("--torque", action="store_true")
    parser.add_argument("--out", type=Path, default=Path("lab.csv"))
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    console = Console(width=110)
    done = {}
    if given.out.exists():
        with given.out.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                key = tuple(int(row[name]) for name in KEY)
                done[key] = row
    seeds = range(given.first, given.first + given.cameras)
    kind = int(given.hard), int(given.torque)
    wanted = [(seed, start, *kind) for seed in seeds for start in range(given.starts)]
    missing = [key for key in wanted if key not in done]
    if missing:
        new = not given.out.exists()
        with (
            given.out.open("a", encoding="utf-8", newline="") as file,
            Progress(console=console) as progress,
            ProcessPoolExecutor(given.workers) as pool,
        ):
            writer = csv.DictWriter(file, FIELDS)
            if new:
                writer.writeheader()
            bar = progress.add_task("parking", total=len(missing))
            futures = {pool.submit(run, *key): key for key in missing}
            for future in as_completed(futures):
                row = future.result()
                writer.writerow(row)
                file.flush()
                done[futures[future]] = {name: str(value) for name, value in row.items()}
                progress.advance(bar)
    summarise([done[key] for key in wanted], console)


if __name__ == "__main__":
    main()
