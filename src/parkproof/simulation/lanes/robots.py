"""Robots that take accelerations or velocities, in lanes.

Their own state is in the rows OWN0 … OWN4: x, y, θ, v and the robot's ω. Rows S0 … S4 are an exact
measurement of it in the coordinates of the step in force, so that whatever watches, measures and
hands in lanes is the same for all robots. Compiled code: ``b`` is the buffer of
`parkproof.simulation.lanes.buffer`.
"""

import math

from parkproof.laws.commands import acceleration_command, kept_velocity, velocity_command
from parkproof.model.chained import body_inputs, chart_of
from parkproof.model.image_unicycle import gains_under
from parkproof.model.unicycle import wrap_angle
from parkproof.scalar import cosine, sine
from parkproof.simulation.compiler import inlined

from .buffer import (
    ACT1,
    ACT2,
    BETA,
    BLOCK,
    CHART,
    KEPT_CHART,
    KEPT_OMEGA,
    KEPT_U0,
    KEPT_U1,
    KEPT_V,
    OWN0,
    OWN1,
    OWN2,
    OWN3,
    OWN4,
    PATH,
    POSE0,
    POSE1,
    POSE2,
    POSE3,
    POSE4,
    RAW2,
    RAW3,
    RAW4,
    RAW_CHART,
    S0,
    S1,
    S2,
    S3,
    S4,
    SEEN0,
    SEEN1,
    SEEN2,
    SEEN3,
    SEEN4,
    SEEN_BETA,
    STEP,
    TAU1,
    TAU2,
)
from .image import homography_of
from .memory import like
from .plant import disturbed, move, state_at
from .sensor import take
from .signals import signals_of_step
from .sums import add_to

# ----------------------------------------------------------------------------- what is true


@inlined
def plain_gain(_b, _camera, _j):
    """Turn gain β under the paper's camera."""
    return 1.0


@inlined
def gain_here(b, camera, j):
    """Turn gain β at a lane's pose."""
    theta = b[OWN2 + j]
    c, s = cosine(theta), sine(theta)
    _, beta = gains_under(homography_of(camera, j), b[OWN0 + j], b[OWN1 + j], c, s)
    return beta


@inlined
def begin_robots(b, camera, gain_at):
    """Take the starts, given as poses or as chained states, for the robots' own states."""
    for j in range(BLOCK):
        theta, v, omega = b[S2 + j], b[S3 + j], b[S4 + j]
        if b[CHART + j] == 1.0:
            v, omega = body_inputs(v, omega, theta)
            theta = math.atan(theta)
        b[OWN0 + j], b[OWN1 + j], b[OWN2 + j], b[OWN3 + j] = b[S0 + j], b[S1 + j], theta, v
        b[OWN4 + j] = omega / gain_at(b, camera, j)
        b[KEPT_U0 + j], b[KEPT_U1 + j], b[KEPT_CHART + j] = v, omega, 0.0
        b[KEPT_V + j], b[KEPT_OMEGA + j] = v, omega


@inlined
def show_lane(b, j):
    """Write what is true of a lane into S0 … S4, in the coordinates of its step."""
    theta, v, omega = b[POSE2 + j], b[POSE3 + j], b[POSE4 + j]
    x2, u0, u1 = chart_of(theta, v, omega)
    charted = b[STEP + j] >= 1.0 and abs(theta) < 0.5 * math.pi
    b[S0 + j], b[S1 + j] = b[POSE0 + j], b[POSE1 + j]
    b[S2 + j] = x2 if charted else theta
    b[S3 + j] = u0 if charted else v
    b[S4 + j] = u1 if charted else omega
    b[CHART + j] = 1.0 if charted else 0.0


@inlined
def show(b, camera, gain_at):
    """Measure all lanes exactly."""
    for j in range(BLOCK):
        b[BETA + j] = gain_at(b, camera, j)
        b[POSE0 + j], b[POSE1 + j], b[POSE3 + j] = b[OWN0 + j], b[OWN1 + j], b[OWN3 + j]
        b[POSE2 + j] = wrap_angle(b[OWN2 + j])
        b[POSE4 + j] = b[BETA + j] * b[OWN4 + j]
        show_lane(b, j)


@inlined
def idle(b, j):
    """Let a lane that has ended stand at the goal."""
    for i in range(5):
        b[OWN0 + i * BLOCK + j] = 0.0
        b[KEPT_U0 + i * BLOCK + j] = 0.0


# ----------------------------------------------------------------------------- what is seen


@inlined
def see_pose(b, ring, k, sensing, keys, exact):
    """Measure at sample k, and hand the controllers what is due."""
    if exact:
        for j in range(BLOCK):
            b[SEEN0 + j], b[SEEN1 + j], b[RAW2 + j] = b[POSE0 + j], b[POSE1 + j], b[POSE2 + j]
            b[RAW3 + j], b[RAW4 + j], b[SEEN_BETA + j] = b[POSE3 + j], b[POSE4 + j], b[BETA + j]
    else:
        now, due = k % ring.shape[0], max(k - sensing.delay, 0) % ring.shape[0]
        take(b, POSE0, ring, now, k, sensing, keys)
        for j in range(BLOCK):
            ring[now, 5, j] = b[BETA + j]
        for j in range(BLOCK):
            b[SEEN0 + j], b[SEEN1 + j] = ring[due, 0, j], ring[due, 1, j]
            b[RAW2 + j] = wrap_angle(ring[due, 2, j])
            b[RAW3 + j], b[RAW4 + j] = ring[due, 3, j], ring[due, 4, j]
            b[SEEN_BETA + j] = ring[due, 5, j]
    for j in range(BLOCK):
        b[RAW_CHART + j] = 0.0
        x2, u0, u1 = chart_of(b[RAW2 + j], b[RAW3 + j], b[RAW4 + j])
        b[SEEN2 + j], b[SEEN3 + j], b[SEEN4 + j] = x2, u0, u1


@inlined
def rely_on_measured(_b):
    """A torque-commanded robot's velocities are those measured."""


@inlined
def rely_on_kept(b):
    """A velocity-commanded robot's velocities are those that its controller keeps."""
    for j in range(BLOCK):
        u0, u1, v, omega = kept_velocity(
            b[KEPT_U0 + j], b[KEPT_U1 + j], b[KEPT_CHART + j], b[KEPT_V + j], b[KEPT_OMEGA + j],
            b[SEEN2 + j],
        )  # fmt: skip
        b[SEEN3 + j], b[SEEN4 + j], b[RAW3 + j], b[RAW4 + j] = u0, u1, v, omega


@inlined
def measured_turn(b, j):
    """Heading, speed and turn rate of a torque-commanded robot that turns."""
    return b[RAW2 + j], b[RAW3 + j], b[RAW4 + j]


@inlined
def kept_turn(b, j):
    """Heading, and speed and turn rate as sent, of a velocity-commanded robot that turns."""
    charted = b[KEPT_CHART + j] > 0.0  # u0, u1 kept there say nothing of v and ω near ±90°
    kept_v, kept_omega, raw_v, raw_omega = (
        b[KEPT_V + j],
        b[KEPT_OMEGA + j],
        b[RAW3 + j],
        b[RAW4 + j],
    )
    return b[RAW2 + j], kept_v if charted else raw_v, kept_omega if charted else raw_omega


# ----------------------------------------------------------------------------- what is done


@inlined
def accelerate(b, _h):
    """Send all torque-commanded robots their accelerations."""
    for j in range(BLOCK):
        b[ACT1 + j], b[ACT2 + j] = acceleration_command(
            b[STEP + j] == 0.0, b[TAU1 + j], b[TAU2 + j], b[RAW2 + j], b[RAW3 + j], b[RAW4 + j],
            b[SEEN_BETA + j],
        )  # fmt: skip


@inlined
def drive(b, h):
    """Send all velocity-commanded robots their velocities, which they have at once."""
    for j in range(BLOCK):
        _, v, omega = kept_turn(b, j)
        first, second, charted, v, omega = velocity_command(
            b[STEP + j] == 0.0, b[TAU1 + j], b[TAU2 + j], v, omega, b[SEEN2 + j], b[SEEN3 + j],
            b[SEEN4 + j], like(b, h),
        )  # fmt: skip
        b[KEPT_U0 + j], b[KEPT_U1 + j], b[KEPT_CHART + j] = first, second, charted
        b[KEPT_V + j], b[KEPT_OMEGA + j] = v, omega
        b[OWN3 + j], b[OWN4 + j] = v, omega / b[SEEN_BETA + j]


@inlined
def acceleration_rates(b, j, row):
    """Rates of v and ω of a torque-commanded robot."""
    return disturbed(b, j, row, ACT1)


@inlined
def no_rates(_b, _j, _row):
    """A velocity-commanded robot keeps its velocities over a period."""
    return 0.0, 0.0


@inlined
def advance_robots(b, camera, tones, kinds, t, h, steps, k, rates, step):
    """Move all robots by one control period; before the first, find the signals at its start."""
    part = like(b, h / steps)
    for i in range(-1 if k == 0 else 0, steps):
        signals_of_step(b, tones, kinds, t, h, i, steps, k)
        if i >= 0:
            for j in range(BLOCK):
                length = move(b, camera, j, state_at(b, j, OWN0), OWN0, part, rates, step)
                add_to(b, PATH, j, length)
