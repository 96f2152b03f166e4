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
from typing import NamedTuple

from parkproof.model.homography import Homography, Nine, homography_jacobian
from parkproof.model.unicycle import Pose
from parkproof.scalar import scalar
from parkproof.validate import finite


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
def gains_under(camera: Nine, x: float, y: float, c: float, s: float) -> tuple[float, float]:
    """Gains at an image pose (`image_gains`), the homography given as one.

    Parameters
    ----------
    camera : nine floats
        Homography image → floor, row by row, positive depth at the point.
    x, y : float
        Image point.
    c, s : float
        cos ψ and sin ψ of the image heading.

    Returns
    -------
    tuple of float
        (a, β).

    Examples
    --------
    >>> from parkproof.model.image_unicycle import gains_under
    >>> gains_under((0.5, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 1.0), 7.0, 9.0, 0.0, 1.0)
    (4.0, 0.5)
    """
    g00, g01, g02, g10, g11, g12, g20, g21, g22 = camera
    return image_gains(g00, g01, g02, g10, g11, g12, g20, g21, g22, x, y, c, s)


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
