"""Loading MuJoCo so that it renders without a screen."""

import ctypes
import ctypes.util
import importlib
import os
import sys
from typing import Any

from parkproof.errors import InputError
from parkproof.extras import require

_LIBRARIES = {
    "osmesa": ("OSMesa", "libosmesa6"),
    "egl": ("EGL", "libegl1 libgl1"),
}
"""Value of MUJOCO_GL: what it loads, and the Debian packages that bring it."""


_REMEDY = "on Debian run: apt-get install libosmesa6, and leave MUJOCO_GL unset"


def load_mujoco() -> Any:
    """Import MuJoCo, with OSMesa (software, no screen) unless MUJOCO_GL says otherwise.

    Returns
    -------
    module
        ``mujoco``.

    Raises
    ------
    InputError
        If MuJoCo or the library that it renders with is not installed.

    Examples
    --------
    >>> load_mujoco().__name__
    'mujoco'
    """
    require("mujoco", "cv2", extra="lab", purpose="the simulated world")
    if sys.platform == "linux" and not _backend():
        # The same software on every Linux machine, with a screen or without: the same pictures.
        os.environ["MUJOCO_GL"] = "osmesa"
    backend = _backend()
    library, package = _LIBRARIES.get(backend, ("", ""))
    if library and ctypes.util.find_library(library) is None:
        raise InputError(
            f"the simulated world renders with MUJOCO_GL={backend}, whose library lib{library} is "
            f"not installed; on Debian run: apt-get install {package}"
        )
    try:
        return importlib.import_module("mujoco")
    except (AttributeError, ImportError, OSError, RuntimeError) as error:
        raise InputError(
            f"MuJoCo does not load with MUJOCO_GL={backend or 'unset'} ({_first_line(error)}); "
            f"{_REMEDY}"
        ) from error


def open_context(model: Any, *, width: int, height: int) -> tuple[Any, Any]:
    """Make a place to render a model in, of the kind that MUJOCO_GL names.

    MuJoCo settles for a kind when it is first imported, which may have been before our choice.

    Parameters
    ----------
    model : mujoco.MjModel
        What will be rendered.
    width, height : int
        Size of the picture in px.

    Returns
    -------
    tuple of GLContext and mujoco.MjrContext
        The system's context, which is current, and MuJoCo's in it; to be freed in reverse order.

    Raises
    ------
    InputError
        If the system has none of this kind.

    Examples
    --------
    >>> model = load_mujoco().MjModel.from_xml_string("<mujoco/>")
    >>> gl, context = open_context(model, width=64, height=48)
    >>> context.free()
    >>> gl.free()
    """
    mujoco = load_mujoco()
    backend = _backend()
    try:
        place = importlib.import_module(f"mujoco.{backend}") if backend in _LIBRARIES else mujoco
        gl = place.GLContext(width, height)
        gl.make_current()
        context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
    except (AttributeError, ImportError, OSError, RuntimeError, mujoco.FatalError) as error:
        raise InputError(
            f"MuJoCo cannot render with MUJOCO_GL={backend or 'unset'} on this machine "
            f"({_first_line(error)}); {_REMEDY}"
        ) from error
    return gl, context


def _backend() -> str:
    return os.environ.get("MUJOCO_GL", "").strip().lower()


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0]
