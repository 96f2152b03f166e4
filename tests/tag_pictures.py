"""Synthetic pictures of tags with known homographies, for tests of the laboratory."""

import math
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from parkproof.model.homography import Homography

CELL = 20
"""Texture pixels a cell; a tag with its white margin has 10 × 10 cells."""


@cache
def texture(tag_id: int) -> NDArray[np.uint8]:
    """A tag with its white margin, as it is printed. OpenCV's is turned by half a turn."""
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    marker = cv2.aruco.generateImageMarker(family, tag_id, 8 * CELL)[::-1, ::-1]
    return np.pad(marker, CELL, constant_values=255)


def view(
    centre: tuple[float, float],
    side: float,
    *,
    turn: float = 0.0,
    tilt: float = 0.0,
    roll: float = 0.0,
    aspect: float = 1.0,
    focal: float = 600.0,
    size: tuple[int, int] = (640, 480),
) -> Homography:
    """Homography from the frame of a tag to px under a pinhole camera above it.

    The tag's x axis is turned by ``turn`` on the floor, the camera tilted about an axis and then
    rolled; the side is that of a tag that the camera sees straight on.
    """
    c, s = math.cos(tilt), math.sin(tilt)
    rotation = _about_z(roll) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    rotation = rotation @ np.diag([1.0, -1.0, -1.0]) @ _about_z(turn)
    middle = ((size[0] - 1) / 2, (size[1] - 1) / 2)
    camera = np.array([[focal, 0, middle[0]], [0, focal * aspect, middle[1]], [0, 0, 1.0]])
    ray = np.linalg.solve(camera, [*centre, 1.0])
    matrix = camera @ np.column_stack([rotation[:, 0], rotation[:, 1], ray * focal / side])
    return Homography(tuple(float(x) for x in (matrix / matrix[2, 2]).ravel()))


def _about_z(angle: float) -> NDArray[np.float64]:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def picture(
    *tags: tuple[int, Homography],
    size: tuple[int, int] = (640, 480),
    blur: float = 0.6,
    noise: float = 3.0,
    seed: int = 0,
) -> NDArray[np.uint8]:
    """Grey picture of tags on a plain floor, each pixel the mean of 4 × 4 points."""
    fine = np.full((4 * size[1], 4 * size[0]), 140.0, np.float32)
    finer = np.array([[4.0, 0, 1.5], [0, 4.0, 1.5], [0, 0, 1.0]])
    for tag_id, homography in tags:
        shown = texture(tag_id)
        ink = 30.0 + 190.0 / 255.0 * shown.astype(np.float32)
        half = (shown.shape[0] - 1) / 2
        to_tag = np.array([[1.0, 0, -half], [0, -1.0, half], [0, 0, 8.0 * CELL]]) / (8.0 * CELL)
        matrix = finer @ np.array(homography.entries).reshape(3, 3) @ to_tag
        shape = (fine.shape[1], fine.shape[0])
        inside = cv2.warpPerspective(np.ones_like(ink), matrix, shape, flags=cv2.INTER_NEAREST)
        drawn = cv2.warpPerspective(ink, matrix, shape, borderMode=cv2.BORDER_REPLICATE)
        fine = np.where(inside > 0, drawn, fine)
    grey = cv2.resize(fine, size, interpolation=cv2.INTER_AREA)
    if blur:
        grey = cv2.GaussianBlur(grey, (0, 0), blur)
    grey = grey + np.random.default_rng(seed).normal(0.0, noise, grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)
