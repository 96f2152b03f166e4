"""``parkproof camera``: what a camera gives, and how late it shows what the robot does."""

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

if TYPE_CHECKING:
    from collections.abc import Callable

    from parkproof.lab.devices import Camera, Clock, Frame, Robot
    from parkproof.lab.measure_latency import LatencyMeasurement

LOOK = 2.0
"""How long to look through a camera, in s."""


def camera(
    *,
    latency: bool = False,
    source: str | None = None,
    robot: str | None = None,
    world: Path | None = None,
    tag_id: int = 0,
    duration: float = 20.0,
    angle_deg: float = 17.0,
    seed: int = 0,
    as_json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """Look through a camera, or measure how late it shows what the robot does.

    Says what pictures the camera gives and how often, and whether the tag is in them. With
    --latency the robot is turned to and fro on the spot, gently, and the delay from a command to
    its image is fitted to what is seen. Without --source the simulated laboratory is used.

    Parameters
    ----------
    latency : bool
        Measure the delay. The robot moves.
    source : str, optional
        The camera: its number, an address, a video file or a folder of pictures.
    robot : str, optional
        The robot whose delay is measured: udp://host:port, or a file that describes it.
    world : Path, optional
        A file that describes a simulated laboratory.
    tag_id : int
        The id of the robot's tag.
    duration : float
        How long the robot turns, in s.
    angle_deg : float
        How far it turns to either side.
    seed : int
        Of the times at which it turns back.
    as_json : bool
        Print the numbers as JSON instead of a table.

    Returns
    -------
    int
        Exit status; 1 if the delay could not be measured.

    Raises
    ------
    InputError
        If something is missing, or there is no such camera or robot.

    Examples
    --------
    >>> camera(latency=True, source="usb:0")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: --latency needs --source SOURCE and --robot ADDRESS together; ...
    """
    from parkproof.errors import InputError
    from parkproof.extras import require
    from parkproof.validate import positive

    require("cv2", "pyapriltags", extra="lab", purpose="parkproof camera")
    if latency and (source is None) != (robot is None):
        raise InputError(
            "--latency needs --source SOURCE and --robot ADDRESS together; without both, the "
            "simulated laboratory is measured"
        )
    if robot is not None and not latency:
        raise InputError("--robot is for --latency, which moves it: write --latency, or no --robot")
    if source is not None and world is not None:
        raise InputError("--source and --world exclude each other: write one of them")
    positive("duration", duration, example=20.0)
    angle = math.radians(positive("angle_deg", angle_deg, example=17.0))

    if source is None:
        return _simulated(world, as_json, None if not latency else (duration, angle, seed))
    from parkproof.lab.cameras import open_camera
    from parkproof.lab.devices import WallClock
    from parkproof.lab.robot_file import robot_named
    from parkproof.lab.watchdog import StoppingRobot

    heading = _heading_of(tag_id)
    known = None if robot is None else robot_named(robot)
    eye = open_camera(source)
    try:
        if known is None:
            return _tell(_look(eye, WallClock(), heading), as_json)
        clock = WallClock()
        with StoppingRobot(known.open(), clock=clock) as safe:
            return _measure(safe, eye, clock, heading, (duration, angle, seed), as_json)
    finally:
        eye.close()


def _simulated(file: Path | None, as_json: bool, turning: tuple[float, float, int] | None) -> int:
    """The same in a simulated laboratory."""
    from parkproof.extras import require

    require("mujoco", extra="lab", purpose="the simulated laboratory")
    from parkproof.errors import InputError
    from parkproof.lab.world import World
    from parkproof.lab.world.devices import WorldAcceleratedRobot
    from parkproof.lab.world.settings import example_world, read_world

    settings = example_world() if file is None else read_world(file)
    heading = _heading_of(settings.robot.tag_id)
    with World(settings) as there:
        if turning is None:
            return _tell(_look(there.camera, there.clock, heading), as_json)
        if isinstance(there.robot, WorldAcceleratedRobot):
            raise InputError(
                f'{file}: commanded_by = "torque": the latency is measured with a robot that takes '
                'velocities; write commanded_by = "velocity"'
            )
        return _measure(there.robot, there.camera, there.clock, heading, turning, as_json)


def _heading_of(tag_id: int) -> "Callable[[Frame], float | None]":
    """What finds the heading of the robot's tag in a frame."""
    from parkproof.lab.image_pose import TagMount, expected, image_pose
    from parkproof.lab.tag import Detection, TagDetector

    detector, mount = TagDetector(), TagMount(tag_id=tag_id)
    near = None

    def heading(frame: "Frame") -> float | None:
        nonlocal near
        found = detector.find(frame.image, tag_id, near=near)
        if not isinstance(found, Detection):
            near = None
            return None
        pose = image_pose(found.homography, mount)
        near = expected(pose, mount)
        return pose.psi

    return heading


def _look(
    eye: "Camera", clock: "Clock", heading: "Callable[[Frame], float | None]"
) -> dict[str, Any]:
    """What a camera gives in a while."""
    from parkproof.lab.devices import Frame, Missing

    begin = clock.now()
    times, numbers, tags, shape = [], [], 0, (0, 0)
    while clock.now() - begin < LOOK:
        frame = eye.read(0.1)
        if frame is Missing.ENDED:
            break
        if isinstance(frame, Frame):
            times.append(frame.t)
            numbers.append(frame.number)
            shape = frame.image.shape[:2]
            tags += heading(frame) is not None
    span = times[-1] - times[0] if len(times) > 1 else 0.0
    return {
        "width": shape[1],
        "height": shape[0],
        "frames": len(times),
        "rate": (len(times) - 1) / span if span > 0.0 else None,
        "left_out": numbers[-1] - numbers[0] + 1 - len(numbers) if numbers else 0,
        "with_tag": tags,
    }


def _measure(
    robot: "Robot",
    eye: "Camera",
    clock: "Clock",
    heading: "Callable[[Frame], float | None]",
    turning: tuple[float, float, int],
    as_json: bool,
) -> int:
    """Turn the robot, and tell the delay."""
    from parkproof.lab.measure_latency import measure_latency, watch

    duration, angle, seed = turning
    done = measure_latency(
        robot, watch(eye, heading), clock=clock, duration=duration, angle=angle, seed=seed
    )
    _tell(_numbers(done), as_json)
    return 0 if done.fit.measured else 1


def _numbers(done: "LatencyMeasurement") -> dict[str, Any]:
    """A measurement as plain numbers; those that are none are null."""
    fit = done.fit
    known = {
        "delay": fit.delay,
        "delay_error": fit.delay_error,
        "lag": fit.lag,
        "delay_and_lag": fit.total,
        "delay_and_lag_error": fit.total_error,
        "age_of_frames": done.age,
        "command_to_image": fit.total + done.age,
        "gain": fit.gain,
    }
    numbers: dict[str, Any] = {
        name: value if math.isfinite(value) else None for name, value in known.items()
    }
    sentence = fit.outcome.sentence + (f" ({done.detail})" if done.detail else "")
    seen = {"frames": done.frames, "with_tag": len(done.seen)}
    return {"outcome": fit.outcome.name.lower(), "sentence": sentence} | numbers | seen


NAMES = {
    "sentence": "outcome",
    "delay": "delay of the robot",
    "delay_error": "  known to",
    "lag": "lag of the robot",
    "delay_and_lag": "delay and lag together",
    "delay_and_lag_error": "  known to",
    "age_of_frames": "age of frames when they come",
    "command_to_image": "from command to image",
    "gain": "turn in the image for a turn",
    "frames": "frames",
    "with_tag": "frames with the tag",
    "left_out": "frames left out between them",
    "rate": "frames per second",
}
"""How the numbers are called in the table."""


def _tell(numbers: dict[str, Any], as_json: bool) -> int:
    """Print numbers; those in seconds in milliseconds."""
    from parkproof.cli.console import facts_table, stdout_console, write

    if as_json:
        write(json.dumps(numbers, indent=2) + "\n")
        return 0
    facts = []
    if "width" in numbers:
        facts.append(("pixels", f"{numbers['width']}×{numbers['height']}"))
    for key, name in NAMES.items():
        value = numbers.get(key)
        if value is None:
            continue
        if isinstance(value, float):
            seconds = key not in {"gain", "rate"}
            text = f"{1e3 * value:.1f} ms" if seconds else f"{value:.2f}"
        else:
            text = str(value)
        facts.append((name, f"± {text}" if key.endswith("_error") else text))
    stdout_console().print(facts_table(facts))
    return 0
