"""Cameras over a floor: the paper's ceiling camera, (2)-(4), and any pinhole camera.

Every camera here is, for the plane in which the robot's tag moves, a homography; everything that
the robot's image does follows from it (`parkproof.model.image_unicycle`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from parkproof.errors import InputError
from parkproof.model.homography import Homography, numbers
from parkproof.scalar import cosine, scalar, sine
from parkproof.validate import finite, positive

Vector = tuple[float, float, float]
"""Components along the floor's x and y axes, and upward."""


@scalar
def ceiling_rates(
    v: float, omega: float, theta: float, alpha1: float, alpha2: float, theta0: float
) -> tuple[float, float, float]:
    """Image-plane kinematics (4): ẋ_m = α1 v cos(θ−θ0), ẏ_m = α2 v sin(θ−θ0), θ̇ = ω.

    Parameters
    ----------
    v, omega, theta : float
        Speed in m/s, turn rate in rad/s and heading in rad, on the floor.
    alpha1, alpha2 : float
        Scales of the two image axes, image unit per m.
    theta0 : float
        Turn of the camera in rad.

    Returns
    -------
    tuple of float
        (ẋ_m, ẏ_m, θ̇).

    Examples
    --------
    >>> from parkproof.model.camera import ceiling_rates
    >>> ceiling_rates(2.0, 0.1, 0.0, 1.5, 0.5, 0.0)
    (3.0, 0.0, 0.1)
    """
    return alpha1 * v * cosine(theta - theta0), alpha2 * v * sine(theta - theta0), omega


@dataclass(frozen=True, slots=True, kw_only=True)
class CeilingCamera:
    """The paper's camera (2), (3): image plane parallel to the floor.

    (x_m, y_m)ᵀ = diag(α1, α2) Rot(θ0) ((x, y)ᵀ − (c_x, c_y)ᵀ) + (O_c1, O_c2)ᵀ with
    Rot = [[cos θ0, sin θ0], [−sin θ0, cos θ0]].

    Parameters
    ----------
    alpha : tuple of float
        (α1, α2), image unit per m, positive.
    theta0 : float
        Turn of the camera in rad.
    centre : tuple of float
        (c_x, c_y), where the optical axis meets the floor, in m.
    image_origin : tuple of float
        (O_c1, O_c2), image of that point.

    Raises
    ------
    InputError
        If a number is not finite, or a scale is not positive.

    Examples
    --------
    >>> from parkproof.model.camera import CeilingCamera
    >>> camera = CeilingCamera(alpha=(1.5, 0.5), centre=(1.0, 0.0))
    >>> camera.project(3.0, 2.0)
    (3.0, 1.0)
    >>> camera.unproject(3.0, 1.0)
    (3.0, 2.0)
    """

    alpha: tuple[float, float]
    theta0: float = 0.0
    centre: tuple[float, float] = (0.0, 0.0)
    image_origin: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        finite("theta0", self.theta0)
        for alpha in numbers("alpha", self.alpha, 2):
            positive("alpha", alpha)
        numbers("centre", self.centre, 2)
        numbers("image_origin", self.image_origin, 2)

    def project(self, x: float, y: float) -> tuple[float, float]:
        """Image of a floor point, equation (2).

        Parameters
        ----------
        x, y : float
            Floor point in m.

        Returns
        -------
        tuple of float
            (x_m, y_m) in image units.
        """
        x, y = finite("x", x), finite("y", y)
        c, s = math.cos(self.theta0), math.sin(self.theta0)
        dx, dy = x - self.centre[0], y - self.centre[1]
        return (
            self.alpha[0] * (c * dx + s * dy) + self.image_origin[0],
            self.alpha[1] * (c * dy - s * dx) + self.image_origin[1],
        )

    def unproject(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Floor point of an image point, the inverse of (2).

        Parameters
        ----------
        x_m, y_m : float
            Image point in image units.

        Returns
        -------
        tuple of float
            (x, y) in m.
        """
        x_m, y_m = finite("x_m", x_m), finite("y_m", y_m)
        c, s = math.cos(self.theta0), math.sin(self.theta0)
        along = (x_m - self.image_origin[0]) / self.alpha[0]
        across = (y_m - self.image_origin[1]) / self.alpha[1]
        return (
            c * along - s * across + self.centre[0],
            s * along + c * across + self.centre[1],
        )

    def rates(self, v: float, omega: float, theta: float) -> tuple[float, float, float]:
        """Image-plane kinematics (4), see `ceiling_rates`.

        Parameters
        ----------
        v, omega, theta : float
            Speed in m/s, turn rate in rad/s and heading in rad, on the floor.

        Returns
        -------
        tuple of float
            (ẋ_m, ẏ_m, θ̇).
        """
        v, omega, theta = finite("v", v), finite("omega", omega), finite("theta", theta)
        return ceiling_rates(v, omega, theta, self.alpha[0], self.alpha[1], self.theta0)

    def homography(self) -> Homography:
        """Return the camera as a homography, floor (m) to image.

        Returns
        -------
        Homography
            An affine one: its last row is (0, 0, 1).
        """
        c, s = math.cos(self.theta0), math.sin(self.theta0)
        (a1, a2), (cx, cy), (o1, o2) = self.alpha, self.centre, self.image_origin
        return Homography(
            (
                a1 * c,
                a1 * s,
                o1 - a1 * (c * cx + s * cy),
                -a2 * s,
                a2 * c,
                o2 - a2 * (c * cy - s * cx),
                0.0,
                0.0,
                1.0,
            )
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PinholeCamera:
    """Any pinhole camera above the floor, without lens distortion.

    With pan = tilt = roll = 0 it looks straight down, u along the floor's x axis and v, pointing
    down in the image, along −y: so the turn gain β of the image is negative. Pan turns it about
    the vertical, counter-clockwise from above; tilt then raises its view towards the top of the
    image; roll then turns it about its own axis, u towards v.

    Parameters
    ----------
    position : tuple of float
        Floor coordinates of the optical centre in m.
    height : float
        Height of the optical centre over the floor in m.
    focal_length : float
        f_x in px, positive.
    image_size : tuple of int
        Width and height of the picture in px.
    tilt, roll, pan : float
        Angles in rad, |tilt| < π/2.
    aspect : float
        f_y/f_x, positive.
    skew : float
        Skew of the pixel axes in px.
    principal_point : tuple of float or None
        Image of the optical axis in px, pixel centres at whole numbers; None: the middle of the
        picture.

    Raises
    ------
    InputError
        If a number is not finite or out of its range.

    Examples
    --------
    >>> from parkproof.model.camera import PinholeCamera
    >>> camera = PinholeCamera(
    ...     position=(0.0, 0.0), height=3.0, focal_length=600.0, image_size=(641, 481)
    ... )
    >>> floor_to_pixels = camera.homography(plane_height=0.0)
    >>> floor_to_pixels.project(1.0, 0.5)
    (520.0, 140.0)
    """

    position: tuple[float, float]
    height: float
    focal_length: float
    image_size: tuple[int, int]
    tilt: float = 0.0
    roll: float = 0.0
    pan: float = 0.0
    aspect: float = 1.0
    skew: float = 0.0
    principal_point: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        numbers("position", self.position, 2)
        positive("height", self.height, example=2.5)
        positive("focal_length", self.focal_length, example=600.0)
        positive("aspect", self.aspect)
        for name in ("tilt", "roll", "pan", "skew"):
            finite(name, getattr(self, name))
        width, height = numbers("image_size", self.image_size, 2)
        if not min(width, height) >= 1.0:
            raise InputError(
                f"image_size = {tuple(self.image_size)}: width and height must be at least 1 px; "
                "write for example image_size = (640, 480)"
            )
        if self.principal_point is not None:
            numbers("principal_point", self.principal_point, 2)
        if not abs(self.tilt) < 0.5 * math.pi:
            raise InputError(
                f"tilt = {self.tilt:.6g} rad ({math.degrees(self.tilt):.6g}°): the optical axis "
                "must meet the floor, |tilt| < 90°; write for example tilt = 0.5"
            )

    def axes(self) -> tuple[Vector, Vector, Vector]:
        """Axes of the picture on the floor's axes.

        Returns
        -------
        tuple of three vectors
            Unit vectors along u, along v, and forward along the optical axis.
        """
        cp, sp = math.cos(self.pan), math.sin(self.pan)
        ct, st = math.cos(self.tilt), math.sin(self.tilt)
        cr, sr = math.cos(self.roll), math.sin(self.roll)
        right, down, forward = (cp, sp, 0.0), (ct * sp, -ct * cp, -st), (-st * sp, st * cp, -ct)

        def turned(p: float, q: float) -> Vector:
            x, y, z = (p * r + q * d for r, d in zip(right, down, strict=True))
            return x, y, z

        return turned(cr, sr), turned(-sr, cr), forward

    def homography(self, plane_height: float = 0.0) -> Homography:
        """Return the map from the plane in which the tag moves to pixels.

        Parameters
        ----------
        plane_height : float
            Height of the tag over the floor in m, below the camera.

        Returns
        -------
        Homography
            (x, y) in m to (u, v) in px, with w3 > 0 in front of the camera.

        Raises
        ------
        InputError
            If the camera is not above the plane.
        """
        plane_height = finite("plane_height", plane_height)
        if not self.height > plane_height:
            raise InputError(
                f"height = {self.height}: the camera must be above the tag's plane, which is at "
                f"plane_height = {plane_height}; write for example height = {plane_height + 2.5}"
            )
        axis_u, axis_v, forward = self.axes()
        drop = (-self.position[0], -self.position[1], plane_height - self.height)

        def row(axis: Sequence[float]) -> tuple[float, float, float]:
            return axis[0], axis[1], sum(p * q for p, q in zip(axis, drop, strict=True))

        width, height = self.image_size
        u0, v0 = self.principal_point or (0.5 * (width - 1), 0.5 * (height - 1))
        f = self.focal_length
        intrinsics = Homography((f, self.skew, u0, 0.0, f * self.aspect, v0, 0.0, 0.0, 1.0))
        return intrinsics @ Homography((*row(axis_u), *row(axis_v), *row(forward)))

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Corners of the picture, in order around it.

        Returns
        -------
        tuple of tuple of float
            Four points (u, v) in px, half a pixel outside the corner pixels' centres.
        """
        u, v = self.image_size[0] - 0.5, self.image_size[1] - 0.5
        return (-0.5, -0.5), (u, -0.5), (u, v), (-0.5, v)
