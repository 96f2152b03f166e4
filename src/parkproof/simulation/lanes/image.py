"""A camera of its own for each lane: nine numbers of its homography, eight of its outline.

Compiled code: ``camera`` is an array of `CAMERA_ROWS` × lanes, of no rows under the paper's camera,
and ``b`` is the buffer of `parkproof.simulation.lanes.buffer`.
"""

import math

from parkproof.model.image_unicycle import gains_under
from parkproof.model.overhead import is_inside
from parkproof.scalar import cosine, sine
from parkproof.simulation.compiler import inlined
from parkproof.simulation.image_steps import image_chained_step, image_turning_step

from .buffer import BETA, BLOCK, CHART, S0, S1, S2


@inlined
def homography_of(camera, j):
    """Homography of a lane's camera, from image to floor."""
    return (
        camera[0, j], camera[1, j], camera[2, j], camera[3, j], camera[4, j], camera[5, j],
        camera[6, j], camera[7, j], camera[8, j],
    )  # fmt: skip


@inlined
def everywhere(_camera, _j, _x, _y):
    """Whether the paper's camera sees a point: it sees all of the floor."""
    return True


@inlined
def in_picture(camera, j, x, y):
    """Whether a lane's camera sees a point."""
    outline = (
        camera[9, j], camera[10, j], camera[11, j], camera[12, j],
        camera[13, j], camera[14, j], camera[15, j], camera[16, j],
    )  # fmt: skip
    return is_inside(outline, x, y)


@inlined
def no_gain(_b, _j):
    """Turn gain β under the paper's camera."""
    return 1.0


@inlined
def gain_of(b, j):
    """Turn gain β of a lane's image."""
    return b[BETA + j]


@inlined
def find_gains(b, camera):
    """Turn gains of all lanes at their poses."""
    for j in range(BLOCK):
        x2 = b[S2 + j]
        charted = b[CHART + j] == 1.0
        across = 1.0 / math.sqrt(1.0 + x2 * x2)
        c = across if charted else cosine(x2)
        s = x2 * across if charted else sine(x2)
        _, b[BETA + j] = gains_under(homography_of(camera, j), b[S0 + j], b[S1 + j], c, s)


@inlined
def image_step_in_chart(_b, camera, j, state, one, two, h):
    """Integration step in the chart."""
    s0, s1, s2, s3, s4 = state
    (a1, m1, e1), (a2, m2, e2) = one, two
    homography = homography_of(camera, j)
    return image_chained_step(s0, s1, s2, s3, s4, homography, a1, m1, e1, a2, m2, e2, h)


@inlined
def image_step_outside(_b, camera, j, state, one, two, h):
    """Integration step outside the chart, where ω is that of the heading in the image."""
    s0, s1, s2, s3, s4 = state
    (a1, m1, e1), (a2, m2, e2) = one, two
    homography = homography_of(camera, j)
    return image_turning_step(s0, s1, s2, s3, s4, homography, False, a1, m1, e1, a2, m2, e2, h)


@inlined
def image_step_of_robot(_b, camera, j, state, one, two, h):
    """Integration step of a robot with its own v and ω."""
    s0, s1, s2, s3, s4 = state
    (a1, m1, e1), (a2, m2, e2) = one, two
    homography = homography_of(camera, j)
    return image_turning_step(s0, s1, s2, s3, s4, homography, True, a1, m1, e1, a2, m2, e2, h)
