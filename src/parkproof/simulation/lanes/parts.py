"""What a kernel is put together from, for each kind of robot, camera and measurement.

Each part is compiled only into the kernels that use it, so that the plain case, robots of kind
"chained" under the paper's camera, pays for none of the others.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from parkproof.laws.controller import RobotKind
from parkproof.simulation.compiler import inlined

from . import image, plant, robots, sensor, signals
from .buffer import S2, S3, S4

Compiled = Callable[..., Any]


class Parts(NamedTuple):
    """Compiled functions of a kernel.

    Attributes
    ----------
    begin : callable
        (b, camera): before the first sample.
    look : callable
        (b, camera, ring, k, sensing, keys): measure, and hand the controllers what is due.
    pose : callable
        (b, j) → heading, speed and turn rate of a lane that turns, as its controller has them.
    settle : callable
        (b, j): coordinates of a lane whose step has changed.
    pictured : callable
        (camera, j, x, y) → whether a lane's camera sees a point.
    gain : callable
        (b, j) → turn gain β.
    act : callable
        (b, h): what robots are sent for τ.
    go : callable
        (b, camera, turning, tones, kinds, t, h, steps, k): the k-th control period.
    idle : callable
        (b, j): let a lane that has ended stand still.
    """

    begin: Compiled
    look: Compiled
    pose: Compiled
    settle: Compiled
    pictured: Compiled
    gain: Compiled
    act: Compiled
    go: Compiled
    idle: Compiled


@inlined
def true_pose(b, j):
    """Heading, speed and turn rate of a lane that turns, measured exactly."""
    return b[S2 + j], b[S3 + j], b[S4 + j]


@inlined
def nothing(_b, _other):
    """Do nothing."""


def parts_of(robot: RobotKind, *, camera: bool, exact: bool, euler: bool = False) -> Parts:
    """Choose the parts of a kernel.

    Parameters
    ----------
    robot : "chained", "torque" or "velocity"
        What the robots are commanded by.
    camera : bool
        Whether each lane has a camera of its own, or all have the paper's.
    exact : bool
        Whether measurements are without noise and latency.
    euler : bool
        Whether to integrate by Euler's method; for robots of kind "chained" under the paper's
        camera.

    Returns
    -------
    Parts
        Functions that `parkproof.simulation.lanes.block` puts together.

    Examples
    --------
    >>> parts_of("chained", camera=False, exact=True).act is nothing
    True
    """
    pictured = image.in_picture if camera else image.everywhere
    gain = image.gain_of if camera else image.no_gain
    parts = _chained(camera, exact, euler) if robot == "chained" else _own(robot, camera, exact)
    return parts._replace(pictured=pictured, gain=gain)


def _chained(camera: bool, exact: bool, euler: bool) -> Parts:
    """Parts for robots that take τ: their state is in S0 … S4, in either coordinates."""
    find_gains = image.find_gains if camera else nothing
    inside = image.image_step_in_chart if camera else plant.step_in_chart
    outside = image.image_step_outside if camera else plant.step_outside
    go = plant.advancing(signals.signals_of_step, inside, outside)
    if euler:
        go = plant.advancing(signals.signals_at_start, plant.euler_in_chart, plant.euler_outside)
    see = sensor.see

    @inlined
    def look_exactly(b, camera, _ring, _k, _sensing, _keys):
        find_gains(b, camera)

    @inlined
    def look(b, camera, ring, k, sensing, keys):
        find_gains(b, camera)
        see(b, ring, k, sensing, keys)

    return Parts(
        begin=nothing,
        look=look_exactly if exact else look,
        pose=true_pose if exact else sensor.seen_pose,
        settle=plant.change_coordinates,
        pictured=image.everywhere,
        gain=image.no_gain,
        act=nothing,
        go=go,
        idle=nothing,
    )


def _own(robot: RobotKind, camera: bool, exact: bool) -> Parts:
    """Parts for robots with v and ω of their own."""
    torque = robot == "torque"
    gain_at = robots.gain_here if camera else robots.plain_gain
    step = image.image_step_of_robot if camera else plant.step_outside
    rates = robots.acceleration_rates if torque else robots.no_rates
    rely = robots.rely_on_measured if torque else robots.rely_on_kept
    begin_robots, show, see_pose = robots.begin_robots, robots.show, robots.see_pose
    advance = robots.advance_robots

    @inlined
    def begin(b, camera):
        begin_robots(b, camera, gain_at)

    @inlined
    def look(b, camera, ring, k, sensing, keys):
        show(b, camera, gain_at)
        see_pose(b, ring, k, sensing, keys, exact)
        rely(b)

    @inlined
    def go(b, camera, _turning, tones, kinds, t, h, steps, k):
        advance(b, camera, tones, kinds, t, h, steps, k, rates, step)

    return Parts(
        begin=begin,
        look=look,
        pose=robots.measured_turn if torque else robots.kept_turn,
        settle=robots.show_lane,
        pictured=image.everywhere,
        gain=image.no_gain,
        act=robots.accelerate if torque else robots.drive,
        go=go,
        idle=robots.idle,
    )
