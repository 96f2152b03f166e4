"""Cameras over a floor: the paper's ceiling camera, (2)-(4), and any pinhole camera.

Every camera here is, for the plane in which the robot's tag moves, a homography; everything that
the robot's image does follows from it (`parkproof.model.image_unicycle`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from parkproof.errors import InputError
from parkproof.scalar import cosine, scalar, sine
from parkproof.validate import finite, positive

Nine = tuple[float, float, float, float, float, float, float, float, float]
"""A 3 × 3 matrix, row by row."""

_SINGULAR = 1e-13
"""A determinant below this share of the sum of its terms' sizes is rounding."""


@scalar
def project_point(
    h00: float,
    h01: float,
    h02: float,
    h10: float,
    h11: float,
    h12: float,
    h20: float,
    h21: float,
    h22: float,
    x: float,
    y: float,
) -> tuple[float, float, float]:
    """Image of a point under a homography.

    Parameters
    ----------
    h00, h01, h02, h10, h11, h12, h20, h21, h22 : float
        The homography, row by row.
    x, y : float
        The point.

    Returns
    -------
    tuple of float
        (X, Y, w): the image, and the point's homogeneous depth w3 = h20 x + h21 y + h22, positive
        in front of the camera.

    Examples
    --------
    >>> from parkproof.model.camera import project_point
    >>> project_point(2.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 0.5, 1.0, 1.0, 2.0)
    (1.5, 2.0, 2.0)
    """
    w = h20 * x + h21 * y + h22
    return (h00 * x + h01 * y + h02) / w, (h10 * x + h11 * y + h12) / w, w


@scalar
def homography_jacobian(
    h00: float,
    h01: float,
    h02: float,
    h10: float,
    h11: float,
    h12: float,
    h20: float,
    h21: float,
    h22: float,
    x: float,
    y: float,
) -> tuple[float, float, float, float]:
    """Jacobian of a homography at a point: (first two rows − image ⊗ third row)/w3.

    Parameters
    ----------
    h00, h01, h02, h10, h11, h12, h20, h21, h22 : float
        The homography, row by row.
    x, y : float
        The point, not on the horizon (w3 ≠ 0).

    Returns
    -------
    tuple of float
        (∂X/∂x, ∂X/∂y, ∂Y/∂x, ∂Y/∂y).

    Examples
    --------
    >>> from parkproof.model.camera import homography_jacobian
    >>> homography_jacobian(2.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 0.5, 1.0, 1.0, 2.0)
    (1.0, -0.375, 0.0, 0.5)
    """
    X, Y, w = project_point(h00, h01, h02, h10, h11, h12, h20, h21, h22, x, y)
    return (h00 - X * h20) / w, (h01 - X * h21) / w, (h10 - Y * h20) / w, (h11 - Y * h21) / w


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


def _numbers(name: str, values: Sequence[float], count: int) -> tuple[float, ...]:
    """Return `count` finite numbers as a tuple, or refuse them by name."""
    if len(values) != count:
        raise InputError(
            f"{name} = {tuple(values)}: must be {count} numbers, not {len(values)}; "
            f"write {name} = ({', '.join(['...'] * count)})"
        )
    return tuple(finite(name, value) for value in values)


@dataclass(frozen=True, slots=True)
class Homography:
    """An invertible projective map of planes, (x, y) ↦ (X, Y).

    Parameters
    ----------
    entries : sequence of float, length 9
        The 3 × 3 matrix, row by row, with the sign that makes w3 > 0 in front of the camera.

    Raises
    ------
    InputError
        If the entries are not nine finite numbers or the matrix is singular.

    Examples
    --------
    >>> from parkproof.model.camera import Homography
    >>> camera = Homography((2.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 0.5, 1.0))
    >>> camera.project(1.0, 2.0)
    (1.5, 2.0)
    >>> camera.inverse().project(1.5, 2.0)
    (1.0, 2.0)
    >>> Homography((1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: homography: the matrix is singular ...
    """

    entries: Nine

    def __post_init__(self) -> None:
        entries = _numbers("homography", self.entries, 9)
        object.__setattr__(self, "entries", entries)
        if not abs(self.determinant) > _SINGULAR * sum(map(abs, self._terms())):
            raise InputError(
                f"homography: the matrix is singular (determinant {self.determinant:.3g}), it must "
                "map the floor to a plane; give one made from four points, no three on a line"
            )

    def _terms(self) -> tuple[float, ...]:
        """Return the six terms of the determinant."""
        a, b, c, d, e, f, g, h, i = self.entries
        return a * e * i, b * f * g, c * d * h, -c * e * g, -b * d * i, -a * f * h

    @property
    def determinant(self) -> float:
        """Determinant of the matrix; its sign is the image's handedness where w3 > 0."""
        return sum(self._terms())

    def project(self, x: float, y: float) -> tuple[float, float]:
        """Image of a point.

        Parameters
        ----------
        x, y : float
            A point in front of the camera, w3 > 0.

        Returns
        -------
        tuple of float
            (X, Y).

        Raises
        ------
        InputError
            If the point is not finite, or lies on the horizon or behind the camera.
        """
        x, y = finite("x", x), finite("y", y)
        depth = self.depth(x, y)
        if not depth > 0.0:
            raise InputError(
                f"point ({x:.6g}, {y:.6g}): lies behind the camera (w3 = {depth:.3g}), must lie in "
                "front (w3 > 0); choose a point in view, or turn the camera towards it"
            )
        X, Y, _ = project_point(*self.entries, x, y)
        return X, Y

    def depth(self, x: float, y: float) -> float:
        """Homogeneous depth w3 of a point: positive in front of the camera.

        Parameters
        ----------
        x, y : float
            The point.

        Returns
        -------
        float
            h20 x + h21 y + h22.
        """
        return self.entries[6] * x + self.entries[7] * y + self.entries[8]

    def inverse(self) -> "Homography":
        """Return the map from image to floor, with w3 > 0 where this one has it.

        Returns
        -------
        Homography
            The inverse matrix.
        """
        a, b, c, d, e, f, g, h, i = self.entries
        det = self.determinant
        return Homography(
            (
                (e * i - f * h) / det,
                (c * h - b * i) / det,
                (b * f - c * e) / det,
                (f * g - d * i) / det,
                (a * i - c * g) / det,
                (c * d - a * f) / det,
                (d * h - e * g) / det,
                (b * g - a * h) / det,
                (a * e - b * d) / det,
            )
        )

    def __matmul__(self, first: "Homography") -> "Homography":
        """Compose: ``(self @ first).project(x, y) == self.project(*first.project(x, y))``."""
        rows, m = self.entries, first.entries
        a, b, c, d, e, f, g, h, i = (
            sum(rows[3 * row + k] * m[3 * k + column] for k in range(3))
            for row in range(3)
            for column in range(3)
        )
        return Homography((a, b, c, d, e, f, g, h, i))


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
        for alpha in _numbers("alpha", self.alpha, 2):
            positive("alpha", alpha)
        _numbers("centre", self.centre, 2)
        _numbers("image_origin", self.image_origin, 2)

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
        _numbers("position", self.position, 2)
        positive("height", self.height, example=2.5)
        positive("focal_length", self.focal_length, example=600.0)
        positive("aspect", self.aspect)
        for name in ("tilt", "roll", "pan", "skew"):
            finite(name, getattr(self, name))
        width, height = _numbers("image_size", self.image_size, 2)
        if not min(width, height) >= 1.0:
            raise InputError(
                f"image_size = {tuple(self.image_size)}: width and height must be at least 1 px; "
                "write for example image_size = (640, 480)"
            )
        if self.principal_point is not None:
            _numbers("principal_point", self.principal_point, 2)
        if not abs(self.tilt) < 0.5 * math.pi:
            raise InputError(
                f"tilt = {self.tilt:.6g} rad ({math.degrees(self.tilt):.6g}°): the optical axis "
                "must meet the floor, |tilt| < 90°; write for example tilt = 0.5"
            )

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
        cp, sp = math.cos(self.pan), math.sin(self.pan)
        ct, st = math.cos(self.tilt), math.sin(self.tilt)
        cr, sr = math.cos(self.roll), math.sin(self.roll)
        right, down, forward = (cp, sp, 0.0), (ct * sp, -ct * cp, -st), (-st * sp, st * cp, -ct)
        axis_u = tuple(cr * r + sr * d for r, d in zip(right, down, strict=True))
        axis_v = tuple(cr * d - sr * r for r, d in zip(right, down, strict=True))
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
