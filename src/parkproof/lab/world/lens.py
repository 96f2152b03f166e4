"""Radial lens distortion, OpenCV's k1, and its inverse."""

import math
from dataclasses import dataclass

from parkproof.errors import InputError
from parkproof.validate import finite, positive

Point = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Lens:
    """A lens: with (x, y) normalised and r² = x² + y², (x, y) appears at (1 + k1 r²)(x, y).

    Parameters
    ----------
    image_size : two ints
        Width and height of the picture in px.
    focal_length : float
        f_x in px.
    aspect : float
        f_y/f_x.
    k1 : float
        Coefficient of r²; negative for a barrel.

    Raises
    ------
    InputError
        If a barrel folds the picture: no ideal point would appear at its corners.

    Examples
    --------
    >>> lens = Lens(image_size=(641, 481), focal_length=600.0, aspect=1.0, k1=-0.15)
    >>> u, v = lens.distort(620.0, 240.0)
    >>> round(u, 9)
    608.75
    >>> round(lens.undistort(u, v)[0], 9)
    620.0
    """

    image_size: tuple[int, int]
    focal_length: float
    aspect: float
    k1: float = 0.0

    def __post_init__(self) -> None:
        positive("focal_length", self.focal_length, example=600.0)
        positive("aspect", self.aspect)
        finite("k1", self.k1)
        u, v = self._centre
        corner = math.hypot(
            (u + 0.5) / self.focal_length, (v + 0.5) / (self.focal_length * self.aspect)
        )
        # A barrel's greatest image radius is (2/3) r_fold; a margin keeps the slope off zero.
        if self.k1 < 0.0 and not corner < 0.9 * (2.0 / 3.0) * self.fold:
            least = -0.115 / (corner * corner)
            raise InputError(
                f"k1 = {self.k1:g}: such a barrel does not fill the picture of a focal length of "
                f"{self.focal_length:g} px; write k1 = {least:.2g} or nearer to 0, or a longer "
                "focal_length"
            )

    @property
    def _centre(self) -> Point:
        return 0.5 * (self.image_size[0] - 1), 0.5 * (self.image_size[1] - 1)

    @property
    def fold(self) -> float:
        """Normalised radius from which on a barrel folds back; infinite without one."""
        return math.sqrt(-1.0 / (3.0 * self.k1)) if self.k1 < 0.0 else math.inf

    def _normalised(self, u: float, v: float) -> Point:
        u0, v0 = self._centre
        return (u - u0) / self.focal_length, (v - v0) / (self.focal_length * self.aspect)

    def _scaled(self, x: float, y: float, factor: float) -> Point:
        u0, v0 = self._centre
        return (
            u0 + self.focal_length * factor * x,
            v0 + self.focal_length * self.aspect * factor * y,
        )

    def distort(self, u: float, v: float) -> Point | None:
        """Where a point of the pinhole camera's picture appears.

        Parameters
        ----------
        u, v : float
            Ideal point in px.

        Returns
        -------
        tuple of float or None
            Its place in px; None if it is so far out that the model folds it back.
        """
        if self.k1 == 0.0:
            return u, v
        x, y = self._normalised(u, v)
        squared = x * x + y * y
        if math.sqrt(squared) > self.fold:
            return None
        return self._scaled(x, y, 1.0 + self.k1 * squared)

    def undistort(self, u: float, v: float) -> Point:
        """Ideal point that appears at a pixel of the picture.

        Parameters
        ----------
        u, v : float
            Point of the picture in px.

        Returns
        -------
        tuple of float
            Point of the pinhole camera's picture in px.
        """
        if self.k1 == 0.0:
            return u, v
        x, y = self._normalised(u, v)
        shown = math.hypot(x, y)
        if shown == 0.0:
            return u, v
        r = shown
        for _ in range(50):  # Newton's method; the slope is positive inside the fold
            step = (r * (1.0 + self.k1 * r * r) - shown) / (1.0 + 3.0 * self.k1 * r * r)
            r -= step
            if abs(step) < 1e-15:
                break
        return self._scaled(x, y, r / shown)

    def ideal_corners(self) -> tuple[Point, ...]:
        """Corners of the picture, in order, taken back to the pinhole camera's picture in px."""
        u, v = self.image_size[0] - 0.5, self.image_size[1] - 0.5
        return tuple(
            self.undistort(*corner) for corner in ((-0.5, -0.5), (u, -0.5), (u, v), (-0.5, v))
        )
