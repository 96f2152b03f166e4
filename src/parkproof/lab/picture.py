"""What counts as a picture, and making it grey."""

from typing import cast

import numpy as np
from numpy.typing import NDArray

from parkproof.errors import InputError
from parkproof.extras import require
from parkproof.lab.devices import Image

LEAST_SIDE = 8
"""Pictures with fewer rows or columns cannot hold a tag, one pixel a cell."""


def as_picture(image: Image) -> Image:
    """A picture as it is, and a picture without a pixel in the place of anything else.

    Parameters
    ----------
    image : array of uint8
        Grey (rows × columns, or rows × columns × 1), or RGB; or what a camera gave in its place.

    Returns
    -------
    array of uint8
        Rows × columns, or rows × columns × 3.

    Examples
    --------
    >>> as_picture(np.zeros((1, 2, 3), np.uint8)).shape, as_picture(np.zeros((4, 4))).shape
    ((1, 2, 3), (0, 0))
    """
    if isinstance(image, np.ndarray) and image.dtype == np.uint8:
        if image.ndim == 3 and image.shape[2] == 1:
            return image[:, :, 0]
        if image.ndim == 2 or (image.ndim == 3 and image.shape[2] == 3):
            return image
    return np.zeros((0, 0), np.uint8)


def checked_picture(image: Image) -> Image:
    """Return a picture, or raise if it is none.

    Parameters
    ----------
    image : array of uint8
        Grey (rows × columns, or rows × columns × 1), or RGB.

    Returns
    -------
    array of uint8
        Rows × columns, or rows × columns × 3.

    Raises
    ------
    InputError
        If it is not such an array, or has too few pixels.

    Examples
    --------
    >>> checked_picture(np.zeros((48, 64, 1), np.uint8)).shape
    (48, 64)
    """
    shape = getattr(image, "shape", None)
    if not isinstance(image, np.ndarray) or shape is None or image.dtype != np.uint8:
        kind = image.dtype if isinstance(image, np.ndarray) else type(image).__name__
        raise InputError(
            f"picture of {kind}: must be an array of uint8, 0 black to 255 white; convert it, for "
            "example with image.astype(numpy.uint8)"
        )
    if image.ndim == 3 and shape[2] == 1:
        image = image[:, :, 0]
    if not (image.ndim == 2 or (image.ndim == 3 and shape[2] == 3)):
        raise InputError(
            f"picture of shape {shape}: must be rows × columns, or rows × columns × 3 in the order "
            "red, green, blue; leave out what is more, such as a layer of opacity"
        )
    if min(shape[:2]) < LEAST_SIDE:
        raise InputError(
            f"picture of {shape[0]} × {shape[1]} pixels: must have at least {LEAST_SIDE} rows and "
            "columns to show a tag; check what the camera gives"
        )
    return image


def grey(image: Image) -> NDArray[np.uint8]:
    """Check a picture, and make it grey.

    Parameters
    ----------
    image : array of uint8
        Grey, or RGB.

    Returns
    -------
    array of uint8
        Rows × columns.

    Raises
    ------
    InputError
        If it is no picture: not such an array, or without a pixel.

    Examples
    --------
    >>> grey(np.zeros((48, 64, 3), np.uint8)).shape
    (48, 64)
    >>> grey(np.zeros((0, 64), np.uint8))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: picture of 0 × 64 pixels: ...
    """
    image = checked_picture(image)
    if image.ndim == 2:
        return np.ascontiguousarray(image)
    require("cv2", extra="lab", purpose="finding tags")
    import cv2

    return cast("NDArray[np.uint8]", cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
