"""What a real camera does to a picture: lens distortion, blur, exposure, noise."""

import math
from typing import TYPE_CHECKING

import numpy as np

from parkproof.lab.world.settings import WorldCamera

if TYPE_CHECKING:
    from numpy.typing import NDArray

FIELDS = 6
"""Noise fields made in advance; each frame takes one, shifted at random. Drawing fresh noise for
every pixel would take longer than rendering."""

NEWTON_STEPS = 20
"""For the radius before distortion."""


def undistorted_radius(distorted: float, k1: float) -> float:
    """The radius r with r(1 + k1 r²) = ``distorted``, on the branch that begins at 0.

    Parameters
    ----------
    distorted : float
        Radius in the picture, in focal lengths.
    k1 : float
        Coefficient.

    Returns
    -------
    float
        Radius before distortion.

    Examples
    --------
    >>> r = undistorted_radius(0.6, -0.15)
    >>> round(r * (1 - 0.15 * r * r), 12)
    0.6
    """
    r = distorted
    for _ in range(NEWTON_STEPS):
        r -= (r * (1.0 + k1 * r * r) - distorted) / (1.0 + 3.0 * k1 * r * r)
    return r


def widening(camera: WorldCamera) -> float:
    """By how much wider to render so that the distorted picture is filled.

    Parameters
    ----------
    camera : WorldCamera
        The camera.

    Returns
    -------
    float
        At least 1.

    Examples
    --------
    >>> widening(WorldCamera())
    1.0
    """
    if camera.distortion >= 0.0:
        return 1.0
    width, height = camera.image_size
    corner = math.hypot(width, height / camera.aspect) / (2.0 * camera.focal_length)
    return 1.01 * undistorted_radius(corner, camera.distortion) / corner


class Sensor:
    """Turns rendered pictures into frames.

    Parameters
    ----------
    camera : WorldCamera
        What it does.
    rendered : tuple of int
        Width and height of what is rendered.
    rng : numpy.random.Generator
        For noise.
    """

    def __init__(
        self, camera: WorldCamera, rendered: tuple[int, int], rng: np.random.Generator
    ) -> None:
        self._camera, self._rng = camera, rng
        width, height = camera.image_size
        self._maps = self._distortion(rendered) if camera.distortion else None
        self._fields = [
            (camera.noise * rng.standard_normal((height, width))).astype(np.float32)
            for _ in range(FIELDS if camera.noise else 0)
        ]

    def _distortion(
        self, rendered: tuple[int, int]
    ) -> tuple["NDArray[np.float32]", "NDArray[np.float32]"]:
        """For each pixel, where to take it from."""
        camera = self._camera
        width, height = camera.image_size
        fx, fy = camera.focal_length, camera.focal_length * camera.aspect
        u = (np.arange(width) - 0.5 * (width - 1)) / fx
        v = (np.arange(height) - 0.5 * (height - 1)) / fy
        x, y = np.meshgrid(u, v)
        distorted = np.hypot(x, y)
        r = distorted.copy()
        k1 = camera.distortion
        for _ in range(NEWTON_STEPS):
            r -= (r * (1.0 + k1 * r * r) - distorted) / (1.0 + 3.0 * k1 * r * r)
        factor = np.divide(r, distorted, out=np.ones_like(r), where=distorted > 1e-12)
        columns = fx * x * factor + 0.5 * (rendered[0] - 1)
        rows = fy * y * factor + 0.5 * (rendered[1] - 1)
        return columns.astype(np.float32), rows.astype(np.float32)

    def frame(self, picture: "NDArray[np.uint8]") -> "NDArray[np.uint8]":
        """A grey frame.

        Parameters
        ----------
        picture : array
            As rendered: rows × columns × 3.

        Returns
        -------
        array
            Rows × columns.
        """
        import cv2

        grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
        if self._maps is not None:
            grey = cv2.remap(grey, *self._maps, cv2.INTER_LINEAR)
        if self._camera.blur:
            grey = cv2.GaussianBlur(grey, (0, 0), self._camera.blur)
        if self._camera.exposure == 1.0 and not self._fields:
            return np.asarray(grey, np.uint8)
        bright = grey.astype(np.float32) * np.float32(self._camera.exposure)
        if self._fields:
            field = self._fields[int(self._rng.integers(FIELDS))]
            shift = (int(self._rng.integers(field.shape[0])), int(self._rng.integers(8)))
            bright += np.roll(field, shift, axis=(0, 1))
        return np.asarray(cv2.convertScaleAbs(np.maximum(bright, 0.0)), np.uint8)
