"""What lens and sensor make of the pinhole camera's picture: distortion, blur, exposure, noise."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.lab.devices import Image
from parkproof.lab.world.camera_settings import CameraSettings
from parkproof.lab.world.lens import Lens

_NOISE_STREAM = 3
_SLACK = 128
"""Frames cut their noise at random places from one picture that is larger by this many pixels."""


def render_size(lens: Lens) -> tuple[int, int]:
    """Size of the pinhole camera's picture that holds all the lens shows, with the same middle.

    Parameters
    ----------
    lens : Lens
        The lens, and the size of its picture.

    Returns
    -------
    tuple of int
        Width and height in px, as odd or even as the picture's.

    Examples
    --------
    >>> render_size(Lens(image_size=(640, 480), focal_length=600.0, aspect=1.0))
    (640, 480)
    >>> render_size(Lens(image_size=(640, 480), focal_length=600.0, aspect=1.0, k1=-0.15))
    (698, 524)
    """
    width, height = lens.image_size
    if lens.k1 == 0.0:
        return width, height
    # Lines through the middle stay lines, and a barrel draws the corners in most.
    u, v = lens.ideal_corners()[2]
    along = max(0, math.ceil(u + 1.5 - width)), max(0, math.ceil(v + 1.5 - height))
    return width + 2 * along[0], height + 2 * along[1]


class Sensor:
    """Turns renderings into frames; the same number of the frame gives the same noise.

    Parameters
    ----------
    settings : CameraSettings
        Distortion, blur, exposure and noise.
    seed : int
        The world's seed.

    Examples
    --------
    >>> sensor = Sensor(CameraSettings(), seed=0)
    >>> sensor.expose([np.full((480, 640, 3), 100, np.uint8)], number=0).shape
    (480, 640)
    """

    def __init__(self, settings: CameraSettings, seed: int) -> None:
        self._settings = settings
        self._seed = seed
        lens = settings.lens()
        self._maps = _undistorting_maps(lens) if lens.k1 else None
        width, height = settings.image_size
        shape = (height + _SLACK, width + _SLACK) + ((3,) if settings.colour else ())
        rng = np.random.default_rng((seed, _NOISE_STREAM))
        noise = settings.noise * rng.standard_normal(shape, dtype=np.float32)
        self._noise = np.rint(noise).astype(np.int16)

    def expose(self, renderings: Sequence[Image], *, number: int) -> Image:
        """Make a frame.

        Parameters
        ----------
        renderings : sequence of arrays of uint8, rows × columns × 3
            Ideal pictures in RGB, evenly over the time in which the shutter is open.
        number : int
            Number of the frame.

        Returns
        -------
        array of uint8
            Grey, or RGB.
        """
        import cv2

        settings = self._settings
        pictures: list[Any] = list(renderings)
        if not settings.colour:
            pictures = [cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY) for picture in pictures]
        image = pictures[0]
        if len(pictures) > 1:
            image = np.rint(np.mean(pictures, axis=0)).astype(np.uint8)
        if self._maps is not None:
            image = cv2.remap(image, *self._maps, cv2.INTER_LINEAR)
        if settings.blur > 0.0:
            image = cv2.GaussianBlur(image, (0, 0), settings.blur)
        if settings.exposure != 1.0:
            image = cv2.convertScaleAbs(image, alpha=settings.exposure)
        if settings.noise > 0.0:
            image = cv2.add(image, self._noise_of(number), dtype=cv2.CV_8U)
        return np.ascontiguousarray(image, dtype=np.uint8)

    def _noise_of(self, number: int) -> NDArray[np.int16]:
        rng = np.random.default_rng((self._seed, _NOISE_STREAM, number))
        row, column = rng.integers(0, _SLACK + 1, size=2)
        width, height = self._settings.image_size
        noise: NDArray[np.int16] = self._noise[row : row + height, column : column + width]
        return noise


def _undistorting_maps(lens: Lens) -> tuple[NDArray[np.int16], NDArray[np.uint16]]:
    """Where in the rendering each pixel of the frame looks, in OpenCV's fixed-point form."""
    import cv2

    width, height = lens.image_size
    rendered_width, rendered_height = render_size(lens)
    shift_u, shift_v = (rendered_width - width) // 2, (rendered_height - height) // 2
    u0, v0 = 0.5 * (width - 1), 0.5 * (height - 1)
    du, dv = np.meshgrid(np.arange(width) - u0, np.arange(height) - v0)
    shown = np.hypot(du / lens.focal_length, dv / (lens.focal_length * lens.aspect))
    radius = shown.copy()
    for _ in range(20):  # Newton's method; the slope is positive inside the fold
        squared = radius * radius
        radius -= (radius * (1.0 + lens.k1 * squared) - shown) / (1.0 + 3.0 * lens.k1 * squared)
    ratio = np.divide(radius, shown, out=np.ones_like(shown), where=shown > 0.0)
    u = (u0 + shift_u + du * ratio).astype(np.float32)
    v = (v0 + shift_v + dv * ratio).astype(np.float32)
    first, second = cv2.convertMaps(u, v, cv2.CV_16SC2)
    return first, second
