"""Integration steps under a camera that is a homography, whose gains vary along the way.

The classical Runge-Kutta method with the input held, as in `parkproof.simulation.steps`, but for
the gains a and β, which follow from pose and camera: the homography from image to floor.
"""

import math

from parkproof.model.chained import chained_rates
from parkproof.model.homography import Nine
from parkproof.model.image_unicycle import gains_under
from parkproof.model.unicycle import unicycle_rates
from parkproof.scalar import cosine, scalar, sine
from parkproof.simulation.steps import FiveFloats


@scalar
def image_chained_rates(
    camera: Nine, x0: float, x1: float, x2: float, u0: float, u1: float
) -> tuple[float, float, float]:
    """Rates of the chained form (5) in the image: ẋ0 = a u0, ẋ1 = a x2 u0, ẋ2 = u1.

    Parameters
    ----------
    camera : nine floats
        Homography from image to floor, row by row.
    x0, x1, x2, u0, u1 : float
        State.

    Returns
    -------
    tuple of 3 floats
        (ẋ0, ẋ1, ẋ2).

    Examples
    --------
    >>> camera = (0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0)
    >>> image_chained_rates(camera, 0.0, 0.0, 0.0, 1.0, 3.0)
    (2.0, 0.0, 3.0)
    """
    c = 1.0 / math.sqrt(1.0 + x2 * x2)
    a, _ = gains_under(camera, x0, x1, c, x2 * c)
    return chained_rates(x2, u0, u1, a, a, 1.0)


@scalar
def image_pose_rates(
    camera: Nine, own: bool, x: float, y: float, theta: float, v: float, omega: float
) -> tuple[float, float, float]:
    """Rates of an image pose: ẋ = a v cos θ, ẏ = a v sin θ, θ̇ = β ω.

    Parameters
    ----------
    camera : nine floats
        Homography from image to floor, row by row.
    own : bool
        Whether ω is the robot's own turn rate, or that of its heading in the image: θ̇ = ω.
    x, y, theta, v, omega : float
        State.

    Returns
    -------
    tuple of 3 floats
        (ẋ, ẏ, θ̇).

    Examples
    --------
    >>> camera = (0.5, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 1.0)
    >>> image_pose_rates(camera, True, 0.0, 0.0, 0.0, 1.0, 3.0)
    (2.0, 0.0, 6.0)
    """
    c, s = cosine(theta), sine(theta)
    a, beta = gains_under(camera, x, y, c, s)
    return unicycle_rates(a * v, beta * omega if own else omega, c, s)


@scalar
def image_chained_step(
    x0: float,
    x1: float,
    x2: float,
    u0: float,
    u1: float,
    camera: Nine,
    start1: float,
    middle1: float,
    end1: float,
    start2: float,
    middle2: float,
    end2: float,
    h: float,
) -> FiveFloats:
    """One Runge-Kutta step of the extended chained form (6) in the image.

    Parameters
    ----------
    x0, x1, x2, u0, u1 : float
        State.
    camera : nine floats
        Homography from image to floor, row by row.
    start1, middle1, end1, start2, middle2, end2 : float
        u̇0 and u̇1 at the step's start, middle and end.
    h : float
        Step in s.

    Returns
    -------
    tuple of 5 floats
        State at the step's end.

    Examples
    --------
    >>> camera = (0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0)
    >>> image_chained_step(0.0, 0.0, 0.0, 1.0, 0.0, camera, *[0.0] * 6, 0.1)
    (0.2, 0.0, 0.0, 1.0, 0.0)
    """
    half = 0.5 * h
    p0, p1, p2 = image_chained_rates(camera, x0, x1, x2, u0, u1)
    q0, q1, q2 = image_chained_rates(
        camera,
        x0 + half * p0,
        x1 + half * p1,
        x2 + half * p2,
        u0 + half * start1,
        u1 + half * start2,
    )
    r0, r1, r2 = image_chained_rates(
        camera,
        x0 + half * q0,
        x1 + half * q1,
        x2 + half * q2,
        u0 + half * middle1,
        u1 + half * middle2,
    )
    s0, s1, s2 = image_chained_rates(
        camera, x0 + h * r0, x1 + h * r1, x2 + h * r2, u0 + h * middle1, u1 + h * middle2
    )
    w = h / 6.0
    return (
        x0 + w * (p0 + 2.0 * (q0 + r0) + s0),
        x1 + w * (p1 + 2.0 * (q1 + r1) + s1),
        x2 + w * (p2 + 2.0 * (q2 + r2) + s2),
        u0 + w * (start1 + 4.0 * middle1 + end1),
        u1 + w * (start2 + 4.0 * middle2 + end2),
    )


@scalar
def image_turning_step(
    x: float,
    y: float,
    theta: float,
    v: float,
    omega: float,
    camera: Nine,
    own: bool,
    start1: float,
    middle1: float,
    end1: float,
    start2: float,
    middle2: float,
    end2: float,
    h: float,
) -> FiveFloats:
    """One Runge-Kutta step of a pose in the image, the inputs acting on v and ω.

    Parameters
    ----------
    x, y, theta, v, omega : float
        State.
    camera : nine floats
        Homography from image to floor, row by row.
    own : bool
        Whether ω is the robot's own turn rate, or that of its heading in the image.
    start1, middle1, end1, start2, middle2, end2 : float
        v̇ and ω̇ at the step's start, middle and end.
    h : float
        Step in s.

    Returns
    -------
    tuple of 5 floats
        State at the step's end.

    Examples
    --------
    >>> camera = (0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0)
    >>> x, y, *_ = image_turning_step(0.0, 0.0, 0.0, 1.0, 0.0, camera, True, *[0.0] * 6, 0.1)
    >>> round(x, 12), round(y, 12)
    (0.2, 0.0)
    """
    half = 0.5 * h
    p0, p1, p2 = image_pose_rates(camera, own, x, y, theta, v, omega)
    q0, q1, q2 = image_pose_rates(
        camera,
        own,
        x + half * p0,
        y + half * p1,
        theta + half * p2,
        v + half * start1,
        omega + half * start2,
    )
    r0, r1, r2 = image_pose_rates(
        camera,
        own,
        x + half * q0,
        y + half * q1,
        theta + half * q2,
        v + half * middle1,
        omega + half * middle2,
    )
    s0, s1, s2 = image_pose_rates(
        camera,
        own,
        x + h * r0,
        y + h * r1,
        theta + h * r2,
        v + h * middle1,
        omega + h * middle2,
    )
    w = h / 6.0
    return (
        x + w * (p0 + 2.0 * (q0 + r0) + s0),
        y + w * (p1 + 2.0 * (q1 + r1) + s1),
        theta + w * (p2 + 2.0 * (q2 + r2) + s2),
        v + w * (start1 + 4.0 * middle1 + end1),
        omega + w * (start2 + 4.0 * middle2 + end2),
    )
