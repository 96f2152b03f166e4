"""Pictures that the world is covered with: a mottled floor, and the robot's tag."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.lab.devices import Image

FLOOR_TEXELS = 512
FLOOR_METRES = 2.0
"""The floor's picture repeats after this."""

TAG_CELLS = 8
"""Cells along the side of a tag36h11's black square."""

PLATE_CELLS = 10
"""With the white margin that the detector needs: one cell on every side."""


def floor_texture(*, brightness: float, contrast: float, rng: np.random.Generator) -> Image:
    """Draw mottled concrete that repeats without a seam.

    Parameters
    ----------
    brightness, contrast : float
        Mean and standard deviation of the grey level.
    rng : numpy.random.Generator
        Draws it.

    Returns
    -------
    array of uint8, shape (512, 512)
        Grey.

    Examples
    --------
    >>> texture = floor_texture(brightness=130.0, contrast=14.0, rng=np.random.default_rng(0))
    >>> texture.shape, round(texture.mean())
    ((512, 512), 130)
    """
    # Spectrum of stains at all sizes: amplitude falling with spatial frequency.
    frequency = np.fft.fftfreq(FLOOR_TEXELS) * FLOOR_TEXELS
    radius = np.hypot(frequency[:, None], frequency[None, :])
    white: NDArray[Any] = np.fft.fft2(rng.standard_normal((FLOOR_TEXELS, FLOOR_TEXELS)))
    stains = np.fft.ifft2(white / (3.0 + radius)).real
    stains = (stains - stains.mean()) / stains.std()
    levels = np.clip(np.rint(brightness + contrast * stains), 0, 255)
    return np.asarray(levels, dtype=np.uint8)


def tag_texture(tag_id: int, *, cell: int = 32) -> Image:
    """Draw a tag36h11 with its white margin, upright as AprilTag's own libraries have it.

    Parameters
    ----------
    tag_id : int
        Number of the tag, 0 to 586.
    cell : int
        Size of a cell in px.

    Returns
    -------
    array of uint8, shape (10 cell, 10 cell)
        Black and white.

    Examples
    --------
    >>> tag_texture(0, cell=1).shape
    (10, 10)
    """
    import cv2

    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    square = cv2.aruco.generateImageMarker(family, tag_id, TAG_CELLS * cell, borderBits=1)
    # OpenCV's copy of the family is turned by 180° from AprilTag's.
    plate = np.pad(cv2.rotate(square, cv2.ROTATE_180), cell, constant_values=255)
    return np.asarray(plate, dtype=np.uint8)


def png(image: Image) -> bytes:
    """Encode a grey picture as PNG.

    Parameters
    ----------
    image : array of uint8
        Grey.

    Returns
    -------
    bytes
        The file.

    Examples
    --------
    >>> png(np.zeros((4, 4), np.uint8))[1:4]
    b'PNG'
    """
    import cv2

    _, data = cv2.imencode(".png", image)
    return bytes(data)
