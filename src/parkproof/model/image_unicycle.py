"""The image of a unicycle is a unicycle, under any pinhole camera.

Let a homography take the floor to the image, with Jacobian J at the robot, whose heading is
e(θ) = (cos θ, sin θ). Its **image heading** ψ is the direction of J e(θ); with a = |J e(θ)| and
β = det J/a² the image point P moves, exactly, as

    Ṗ = a v (cos ψ, sin ψ),   ψ̇ = β ω,

because a homography takes lines to lines: only ω turns ψ. So a > 0 and β, whose sign is the
image's handedness, are all that the camera changes. With image rates
``unicycle_rates(a * v, beta * omega, cos ψ, sin ψ)`` the image pose is a state of its own, and the
gains follow from it through the inverse homography, image to floor (`image_gains`).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from parkproof.errors import InputError
from parkproof.model.camera import Homography, homography_jacobian, project_point
from parkproof.model.unicycle import Pose
from parkproof.scalar import scalar
from parkproof.validate import finite, positive


class ImageUnicycle(NamedTuple):
    """The robot as its image shows it.

    Parameters
    ----------
    pose : Pose
        Image point and image heading ψ in (−π, π].
    a : float
        Speed gain, image unit per m, positive.
    beta : float
        Turn gain ψ̇/ω, negative where the image is mirrored.

    Examples
    --------
    >>> from parkproof.model.image_unicycle import ImageUnicycle
    >>> from parkproof.model.unicycle import Pose
    >>> ImageUnicycle(Pose(0.0, 0.0, 0.0), a=200.0, beta=-1.0).beta
    -1.0
    """

    pose: Pose
    a: float
    beta: float


class GainBounds(NamedTuple):
    """Least and greatest gains of an image unicycle over a region and all headings.

    Parameters
    ----------
    a_min, a_max : float
        Bounds of a, image unit per m.
    beta_min, beta_max : float
        Bounds of β.

    Examples
    --------
    >>> from parkproof.model.image_unicycle import GainBounds
    >>> GainBounds(0.5, 1.5, 1.0, 1.0).a_max
    1.5
    """

    a_min: float
    a_max: float
    beta_min: float
    beta_max: float


@scalar
def image_direction(
    j00: float, j01: float, j10: float, j11: float, c: float, s: float
) -> tuple[float, float, float, float]:
    """Image heading and gains from the Jacobian floor → image and the heading on the floor.

    Parameters
    ----------
    j00, j01, j10, j11 : float
        Jacobian, row by row (`parkproof.model.camera.homography_jacobian`), not singular.
    c, s : float
        cos θ and sin θ.

    Returns
    -------
    tuple of float
        (cos ψ, sin ψ, a, β) with a = |J e(θ)|, β = det J/a².

    Examples
    --------
    >>> from parkproof.model.image_unicycle import image_direction
    >>> image_direction(3.0, 0.0, 0.0, 2.0, 0.0, 1.0)
    (0.0, 1.0, 2.0, 1.5)
    """
    x = j00 * c + j01 * s
    y = j10 * c + j11 * s
    a = math.sqrt(x * x + y * y)
    return x / a, y / a, a, (j00 * j11 - j01 * j10) / (a * a)


@scalar
def image_gains(
    g00: float,
    g01: float,
    g02: float,
    g10: float,
    g11: float,
    g12: float,
    g20: float,
    g21: float,
    g22: float,
    X: float,
    Y: float,
    c: float,
    s: float,
) -> tuple[float, float]:
    """Gains at an image pose, from the homography image → floor.

    With DG its Jacobian at (X, Y): a = 1/|DG e(ψ)| and β = 1/(det DG a²), since DG is the inverse
    of J and DG e(ψ) = e(θ)/a.

    Parameters
    ----------
    g00, g01, g02, g10, g11, g12, g20, g21, g22 : float
        Homography image → floor, row by row, positive depth at the point.
    X, Y : float
        Image point.
    c, s : float
        cos ψ and sin ψ of the image heading.

    Returns
    -------
    tuple of float
        (a, β).

    Examples
    --------
    >>> from parkproof.model.image_unicycle import image_gains
    >>> image_gains(0.5, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 1.0, 7.0, 9.0, 0.0, 1.0)
    (4.0, 0.5)
    """
    d00, d01, d10, d11 = homography_jacobian(g00, g01, g02, g10, g11, g12, g20, g21, g22, X, Y)
    x = d00 * c + d01 * s
    y = d10 * c + d11 * s
    squared = x * x + y * y
    return 1.0 / math.sqrt(squared), squared / (d00 * d11 - d01 * d10)


@scalar
def image_gain_rates(
    g00: float,
    g01: float,
    g02: float,
    g10: float,
    g11: float,
    g12: float,
    g20: float,
    g21: float,
    g22: float,
    X: float,
    Y: float,
    c: float,
    s: float,
    v: float,
    omega: float,
) -> tuple[float, float]:
    """Rates of the gains while the robot moves: what a feed-forward that ignores them leaves over.

    With k = (g20, g21), w the depth at (X, Y), f = DG e(ψ), n = DG e(ψ + π/2) and r = f·n/|f|²:
    ȧ/a = 2av k·e(ψ)/w − rβω and β̇/β = 2rβω − av k·e(ψ)/w.

    Parameters
    ----------
    g00, g01, g02, g10, g11, g12, g20, g21, g22 : float
        Homography image → floor, row by row, positive depth at the point.
    X, Y : float
        Image point.
    c, s : float
        cos ψ and sin ψ of the image heading.
    v, omega : float
        Speed in m/s and turn rate in rad/s, on the floor.

    Returns
    -------
    tuple of float
        (ȧ, β̇).

    Examples
    --------
    >>> from parkproof.model.image_unicycle import image_gain_rates
    >>> image_gain_rates(
    ...     0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.25, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0
    ... )
    (2.0, -0.5)
    """
    d00, d01, d10, d11 = homography_jacobian(g00, g01, g02, g10, g11, g12, g20, g21, g22, X, Y)
    fx = d00 * c + d01 * s
    fy = d10 * c + d11 * s
    squared = fx * fx + fy * fy
    a = 1.0 / math.sqrt(squared)
    beta = squared / (d00 * d11 - d01 * d10)
    turning = (fx * (d01 * c - d00 * s) + fy * (d11 * c - d10 * s)) / squared * beta * omega
    driving = a * v * (g20 * c + g21 * s) / (g20 * X + g21 * Y + g22)
    return a * (2.0 * driving - turning), beta * (2.0 * turning - driving)


def image_of(homography: Homography, pose: Pose) -> ImageUnicycle:
    """Image pose and gains of a robot; with the inverse homography, the floor pose of an image.

    Parameters
    ----------
    homography : Homography
        Floor → image. With image → floor, the result is the floor pose, 1/a and 1/β.
    pose : Pose
        The robot, in front of the camera.

    Returns
    -------
    ImageUnicycle
        Image point, image heading ψ, a and β.

    Raises
    ------
    InputError
        If the pose is not finite or lies behind the camera.

    Examples
    --------
    >>> from parkproof.model.camera import CeilingCamera
    >>> from parkproof.model.image_unicycle import image_of
    >>> from parkproof.model.unicycle import Pose
    >>> floor_to_image = CeilingCamera(alpha=(3.0, 2.0)).homography()
    >>> image = image_of(floor_to_image, Pose(1.0, 1.0, 0.0))
    >>> image.pose, image.a, round(image.beta, 4)
    (Pose(x=3.0, y=2.0, theta=0.0), 3.0, 0.6667)
    >>> image_of(floor_to_image.inverse(), image.pose).pose
    Pose(x=1.0, y=1.0, theta=0.0)
    """
    theta = finite("theta", pose.theta)
    X, Y = homography.project(pose.x, pose.y)
    jacobian = homography_jacobian(*homography.entries, pose.x, pose.y)
    c, s, a, beta = image_direction(*jacobian, math.cos(theta), math.sin(theta))
    return ImageUnicycle(Pose(X, Y, math.atan2(s, c)), a, beta)


def goal_similarity(goal: Pose, unit: float, *, mirrored: bool) -> Homography:
    """Map from pixels to goal image coordinates, from the picture of the goal alone.

    They are centred at the goal's image p*, with the first axis along its image heading ψ*, in the
    given unit; in a mirrored image the second axis is flipped, so that β > 0 in them.

    Parameters
    ----------
    goal : Pose
        Image pose (p*, ψ*) of the robot when it is parked, px and rad.
    unit : float
        Unit of the new coordinates in px, for example the side of the robot's tag; positive.
    mirrored : bool
        Whether β < 0 in the picture, as when v points down and the camera looks down.

    Returns
    -------
    Homography
        Pixels → goal image coordinates, a similarity.

    Raises
    ------
    InputError
        If a number is not finite, or the unit not positive.

    Examples
    --------
    >>> from parkproof.model.image_unicycle import goal_similarity
    >>> from parkproof.model.unicycle import Pose
    >>> goal_similarity(Pose(320.0, 240.0, 0.0), 40.0, mirrored=True).project(360.0, 260.0)
    (1.0, -0.5)
    """
    x, y, psi = (finite(name, value) for name, value in goal._asdict().items())
    unit = positive("unit", unit, example=40.0)
    c, s = math.cos(psi) / unit, math.sin(psi) / unit
    flip = -1.0 if mirrored else 1.0
    return Homography(
        (
            c,
            s,
            -(c * x + s * y),
            -flip * s,
            flip * c,
            flip * (s * x - c * y),
            0.0,
            0.0,
            1.0,
        )
    )


def goal_homography(camera: Homography, goal: Pose, unit: float) -> Homography:
    """Map from the floor to goal image coordinates (`goal_similarity`), in which β > 0.

    Parameters
    ----------
    camera : Homography
        Floor → pixels.
    goal : Pose
        Where the robot shall park, on the floor.
    unit : float
        Unit of the new coordinates in px, positive.

    Returns
    -------
    Homography
        Floor → goal image coordinates: the goal's image is the origin, with heading 0.

    Raises
    ------
    InputError
        If a number is not finite, the unit not positive, or the goal behind the camera.

    Examples
    --------
    >>> from parkproof.model.camera import PinholeCamera
    >>> from parkproof.model.image_unicycle import goal_homography, image_of
    >>> from parkproof.model.unicycle import Pose
    >>> camera = PinholeCamera(
    ...     position=(0.0, 0.0), height=3.0, focal_length=600.0, image_size=(641, 481)
    ... )
    >>> to_goal = goal_homography(camera.homography(), goal=Pose(0.0, 0.0, 0.0), unit=40.0)
    >>> to_goal.project(1.0, 0.5)
    (5.0, 2.5)
    >>> image_of(to_goal, Pose(1.0, 0.5, 0.0)).beta
    1.0
    """
    shown = image_of(camera, goal)
    return goal_similarity(shown.pose, unit, mirrored=shown.beta < 0.0) @ camera


def gain_bounds(
    homography: Homography, corners: Sequence[tuple[float, float]], samples: int = 64
) -> GainBounds:
    """Bounds of a and β over a polygon of the image and all headings: sampled along its border.

    Along a line through an image point in the direction of its heading, a and β are monotone, so
    their extremes lie on the border; there the positions are sampled, so the bounds can fall short
    by O(1/samples²). Over headings they are exact: a is between the singular values of J.

    Parameters
    ----------
    homography : Homography
        Floor → image.
    corners : sequence of tuple of float
        Corners of the polygon in image coordinates, in order; at least three.
    samples : int
        Positions on each edge, at least 1 (its ends are among them).

    Returns
    -------
    GainBounds
        (a_min, a_max, beta_min, beta_max).

    Raises
    ------
    InputError
        If there are fewer than three corners, one is not finite, a number of samples below 1, or
        the polygon reaches the horizon.

    Examples
    --------
    >>> from parkproof.model.camera import CeilingCamera
    >>> from parkproof.model.image_unicycle import gain_bounds
    >>> view = ((0.0, 0.0), (640.0, 0.0), (640.0, 480.0), (0.0, 480.0))
    >>> gain_bounds(CeilingCamera(alpha=(200.0, 100.0)).homography(), view)
    GainBounds(a_min=100.0, a_max=200.0, beta_min=0.5, beta_max=2.0)
    """
    if len(corners) < 3 or samples < 1:
        raise InputError(
            f"corners, samples = {len(corners)}, {samples}: must be at least 3 corners and 1 "
            "sample an edge; write for example corners = camera.corners(), samples = 64"
        )
    to_floor = homography.inverse()
    for X, Y in corners:
        if not to_floor.depth(finite("X", X), finite("Y", Y)) > 0.0:
            raise InputError(
                f"corner ({X:.6g}, {Y:.6g}): lies on or above the horizon, where the floor has no "
                "image; keep the view below the horizon, or tilt the camera less"
            )
    a_min, a_max, ratio, handedness = math.inf, 0.0, 1.0, 1.0
    for (X0, Y0), (X1, Y1) in zip(corners, [*corners[1:], corners[0]], strict=True):
        for k in range(samples):
            t = k / samples
            x, y, _ = project_point(*to_floor.entries, X0 + t * (X1 - X0), Y0 + t * (Y1 - Y0))
            j00, j01, j10, j11 = homography_jacobian(*homography.entries, x, y)
            # Singular values of J: their sum and difference are these two lengths.
            greatest = 0.5 * (math.hypot(j00 + j11, j10 - j01) + math.hypot(j00 - j11, j10 + j01))
            det = j00 * j11 - j01 * j10
            least = abs(det) / greatest
            a_min, a_max = min(a_min, least), max(a_max, greatest)
            ratio = max(ratio, greatest / least)
            handedness = math.copysign(1.0, det)
    beta_min, beta_max = sorted((handedness * ratio, handedness / ratio))
    return GainBounds(a_min, a_max, beta_min, beta_max)
