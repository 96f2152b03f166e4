"""The pinhole camera's ideal picture, rendered off-screen.

The camera does not move, so the empty floor is rendered once; then only a window around the robot
is, with the camera's axis shifted to the window's middle, and is put into the picture of the floor.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.lab.devices import Image
from parkproof.lab.world.opengl import load_mujoco, open_context
from parkproof.lab.world.settings import WorldSettings
from parkproof.lab.world.view import Point
from parkproof.model.homography import Homography

_BLOCK = 32
"""Windows are multiples of this in px."""

_HALF_SIZE = 1.1
"""Half the side of a square around the axle that holds the robot, in tracks."""


class Renderer:
    """Renders the robot at given positions. Close it when done.

    Parameters
    ----------
    settings : WorldSettings
        The world.
    model : mujoco.MjModel
        Its model (`parkproof.lab.world.model.world_model`); its camera is changed.
    size : two ints
        Width and height of the picture in px, as the model was made for.

    Examples
    --------
    >>> from parkproof.lab.world.model import world_model
    >>> settings = WorldSettings()
    >>> text, pictures = world_model(settings, render_size=(640, 480))
    >>> model = load_mujoco().MjModel.from_xml_string(text, pictures)
    >>> renderer = Renderer(settings, model, (640, 480))
    >>> renderer.picture(model.qpos0).shape
    (480, 640, 3)
    >>> renderer.close()
    """

    def __init__(self, settings: WorldSettings, model: Any, size: tuple[int, int]) -> None:
        self._mujoco = load_mujoco()
        mujoco = self._mujoco
        self._model = model
        self._size = size
        self._data = mujoco.MjData(model)
        self._pixel = float(model.cam_sensorsize[0][0]) / size[0]
        self._option = mujoco.MjvOption()
        self._scene = mujoco.MjvScene(model, maxgeom=64)
        self._camera = mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._camera.fixedcamid = 0
        self._gl: Any
        self._context: Any
        self._gl, self._context = open_context(model, width=size[0], height=size[1])
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._planes = _planes_of_the_robot(settings, size)
        self._half_size = _half_size(settings)
        self._floor = self._empty_floor()

    def close(self) -> None:
        """Give the graphics memory back. May be called twice."""
        if self._gl is not None:
            self._gl.make_current()
            self._context.free()
            self._gl.free()
            self._gl = self._context = None

    def picture(self, positions: NDArray[np.float64]) -> Image:
        """Render the world with the robot somewhere.

        Parameters
        ----------
        positions : array, shape (9,)
            Generalised positions of the model, as `Physics.state` gives them.

        Returns
        -------
        array of uint8, shape (rows, columns, 3)
            RGB.
        """
        picture = self._floor.copy()
        window = self._window(positions)
        if window is not None:
            left, top, width, height = window
            picture[top : top + height, left : left + width] = self._render(positions, window)
        return picture

    def whole_picture(self, positions: NDArray[np.float64]) -> Image:
        """Render the world without the shortcut of the window, which must not be seen.

        Parameters
        ----------
        positions : array, shape (9,)
            Generalised positions of the model.

        Returns
        -------
        array of uint8, shape (rows, columns, 3)
            RGB.
        """
        return self._render(positions, (0, 0, *self._size))

    def _empty_floor(self) -> Image:
        groups = self._option.geomgroup.copy()
        self._option.geomgroup[:] = 0
        self._option.geomgroup[1] = 1  # the floor's
        floor = self.whole_picture(self._model.qpos0)
        self._option.geomgroup[:] = groups
        return floor

    def _window(self, positions: NDArray[np.float64]) -> tuple[int, int, int, int] | None:
        """Left, top, width and height of a window that holds the robot's image; None: no image."""
        x, y = float(positions[0]), float(positions[1])
        points = _square(x, y, self._half_size, self._planes)
        width, height = self._size
        if points is None:
            return 0, 0, width, height
        left = max(0, math.floor(min(u for u, _ in points)) - 2)
        top = max(0, math.floor(min(v for _, v in points)) - 2)
        right = min(width, math.ceil(max(u for u, _ in points)) + 3)
        bottom = min(height, math.ceil(max(v for _, v in points)) + 3)
        if right <= left or bottom <= top:
            return None
        across = min(width, _BLOCK * math.ceil((right - left) / _BLOCK))
        down = min(height, _BLOCK * math.ceil((bottom - top) / _BLOCK))
        return min(left, width - across), min(top, height - down), across, down

    def _render(self, positions: NDArray[np.float64], window: tuple[int, int, int, int]) -> Image:
        mujoco, model = self._mujoco, self._model
        left, top, width, height = window
        model.cam_sensorsize[0] = width * self._pixel, height * self._pixel
        model.cam_intrinsic[0][2:] = (
            self._pixel * (left + 0.5 * width - 0.5 * self._size[0]),
            self._pixel * (top + 0.5 * height - 0.5 * self._size[1]),
        )
        self._data.qpos[:] = positions
        mujoco.mj_kinematics(model, self._data)
        mujoco.mj_camlight(model, self._data)
        mujoco.mjv_updateScene(
            model, self._data, self._option, None, self._camera,
            mujoco.mjtCatBit.mjCAT_ALL, self._scene,
        )  # fmt: skip
        image = np.empty((height, width, 3), np.uint8)
        rectangle = mujoco.MjrRect(0, 0, width, height)
        self._gl.make_current()
        mujoco.mjr_render(rectangle, self._scene, self._context)
        mujoco.mjr_readPixels(image, None, rectangle, self._context)
        return image[::-1]  # OpenGL's rows go up


def _half_size(settings: WorldSettings) -> float:
    """Half the side of a square around the axle that holds robot and tag at any heading."""
    robot = settings.robot
    plate = math.hypot(*robot.tag_offset) + robot.tag_side
    return max(_HALF_SIZE * robot.track, plate)


def _planes_of_the_robot(settings: WorldSettings, size: tuple[int, int]) -> list[Homography]:
    """From floor coordinates to the rendering's pixels, on the floor and above the robot."""
    camera = settings.camera
    shift_u = 0.5 * (size[0] - camera.image_size[0])
    shift_v = 0.5 * (size[1] - camera.image_size[1])
    shift = Homography((1.0, 0.0, shift_u, 0.0, 1.0, shift_v, 0.0, 0.0, 1.0))
    pinhole = camera.pinhole()
    top = settings.robot.tag_height + 0.01
    return [shift @ pinhole.homography(height) for height in (0.0, top)]


def _square(x: float, y: float, half: float, planes: Sequence[Homography]) -> list[Point] | None:
    """Images of the corners of a square in each plane; None if one lies behind the camera."""
    corners = [(x + p, y + q) for p in (-half, half) for q in (-half, half)]
    if any(plane.depth(*corner) <= 0.05 for plane in planes for corner in corners):
        return None
    return [plane.project(*corner) for plane in planes for corner in corners]
