"""``parkproof teach``: the goal, from one picture."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from parkproof.lab.devices import Camera
    from parkproof.lab.goal import Goal
    from parkproof.lab.image_pose import TagMount
    from parkproof.lab.tag import TagDetector

TRIES = 30
"""Frames that a camera gets to show the tag: the first ones are often dark."""

WAIT = 5.0
"""How long one frame may take, s."""


def teach(
    *,
    image: Path | None = None,
    camera: str | None = None,
    world: Path | None = None,
    out: Path = Path("goal.json"),
    tag_id: int = 0,
    offset: tuple[float, float] = (0.0, 0.0),
    angle_deg: float = 0.0,
    side: float = 0.1,
    overwrite: bool = False,
) -> int:
    """Take the goal from one picture of the parked robot.

    Put the robot where it shall park, and show it to the camera. The picture gives the place and
    the heading to reach, the unit of length, and bounds of the gains over the view. Nothing about
    the camera needs to be known; it must not move afterwards.

    Parameters
    ----------
    image : Path, optional
        A picture that the camera took.
    camera : str, optional
        Take one now: a camera's number, an address, or a video.
    world : Path, optional
        A file that describes a simulated laboratory; its robot is shown at its goal. How its tag
        sits on it is known.
    out : Path
        The goal; default goal.json.
    tag_id : int
        The robot's tag, 0 to 586; default 0.
    offset : tuple of float
        Middle of the axle in the tag's frame, x to its right and y up as it is read, in sides of
        the tag; default 0 0.
    angle_deg : float
        Direction of the robot's forward in the tag's frame, in degrees counter-clockwise from the
        tag's right; default 0.
    side : float
        Side of the tag's black square in m; default 0.1.
    overwrite : bool
        Replace the goal if there is one.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        If the picture cannot be read, or does not show the tag whole and once.

    Examples
    --------
    >>> teach(image=Path("parked.png"), tag_id=7)
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: cannot read parked.png: No such file or directory; ...
    """
    import math

    from parkproof.cli.console import facts_table, stdout_console
    from parkproof.cli.files import check_target, write_file
    from parkproof.errors import InputError
    from parkproof.lab.image_pose import TagMount
    from parkproof.lab.tag import TagDetector
    from parkproof.validate import finite

    if sum(given is not None for given in (image, camera, world)) != 1:
        raise InputError(
            "teach needs one picture of the parked robot: write one of --image FILE, --camera "
            "SOURCE and --world WORLD.toml"
        )
    angle = math.radians(finite("angle_deg", angle_deg))
    mount = TagMount(tag_id=tag_id, offset=offset, angle=angle, side=side)
    check_target(out, overwrite=overwrite)
    if world is not None:
        goal = _from_world(world)
    elif image is not None:
        from parkproof.lab.devices import Frame
        from parkproof.lab.teach import read_picture
        from parkproof.lab.teach import teach as take

        goal = take(Frame(read_picture(image), t=0.0, number=0), TagDetector(), mount)
    else:
        from parkproof.lab.cameras import open_camera

        goal = _from_camera(open_camera(str(camera)), TagDetector(), mount)
    write_file(out, goal.to_json(), overwrite=overwrite)
    console = stdout_console()
    console.print(facts_table(_facts(goal)))
    console.print(f"Wrote {out}; the camera must stay as it is.", soft_wrap=True)
    return 0


def _from_world(file: Path) -> "Goal":
    """The goal that a simulated laboratory shows."""
    from parkproof.lab.simulated import shown_goal
    from parkproof.lab.world import World
    from parkproof.lab.world.settings import read_world

    with World(read_world(file)) as there:
        return shown_goal(there)


def _from_camera(camera: "Camera", detector: "TagDetector", mount: "TagMount") -> "Goal":
    """Goal from the first frame that shows the tag; what is wrong with the last one otherwise."""
    from parkproof.errors import InputError
    from parkproof.lab.devices import Missing
    from parkproof.lab.teach import teach as take

    why: InputError | None = None
    try:
        for _ in range(TRIES):
            frame = camera.read(WAIT)
            if isinstance(frame, Missing):
                told = getattr(camera, "why_ended", "") if frame is Missing.ENDED else ""
                why = why or InputError(
                    f"{told or frame.sentence} before it showed the robot; check the camera's "
                    "number or address"
                )
                break
            try:
                return take(frame, detector, mount)
            except InputError as error:
                why = error
    finally:
        camera.close()
    raise why or InputError("the camera gave no frame; check its number or address")


def _facts(goal: "Goal") -> list[tuple[str, str]]:
    """What was taught, for people."""
    import math

    low, high = goal.gains.a
    return [
        ("tag", f"{goal.mount.tag_id}, side {goal.unit:.1f} px"),
        ("goal", f"({goal.u:.2f}, {goal.v:.2f}) px, heading {math.degrees(goal.psi):.2f}°"),
        ("picture", f"{goal.picture[0]} × {goal.picture[1]} px"
         + (", as in a mirror" if goal.flipped else "")),
        ("gain over the view", f"{low:.2f} to {high:.2f} goal units per side driven"),
    ]  # fmt: skip
