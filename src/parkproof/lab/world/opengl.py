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
    if sys.platform == "linux":
        # The same software on every Linux machine, with a screen or without: the same pictures.
        os.environ.setdefault("MUJOCO_GL", "osmesa")
    backend = _backend()
    library, package = _LIBRARIES.get(backend, ("", ""))
    if library and ctypes.util.find_library(library) is None:
        raise InputError(
            f"the simulated world renders with MUJOCO_GL={backend}, whose library lib{library} is "
            f"not installed; run: apt-get install {package}"
        )
    try:
        return importlib.import_module("mujoco")
    except (AttributeError, ImportError, OSError, RuntimeError) as error:
        raise InputError(
            f"mujoco does not load with MUJOCO_GL={backend or 'unset'} ({error}); run: apt-get "
            "install libosmesa6, and leave MUJOCO_GL unset"
        ) from error


def gl_context(width: int, height: int) -> Any:
    """Make a place to render in, of the kind that MUJOCO_GL names.

    MuJoCo decides for a kind when it is first imported, which may have been before our choice.

    Parameters
    ----------
    width, height : int
        Its size in px.

    Returns
    -------
    GLContext
        MuJoCo's, with ``make_current`` and ``free``.

    Examples
    --------
    >>> context = gl_context(64, 48)
    >>> context.make_current()
    >>> context.free()
    """
    mujoco = load_mujoco()
    backend = _backend()
    if backend in _LIBRARIES:
        return importlib.import_module(f"mujoco.{backend}").GLContext(width, height)
    return mujoco.GLContext(width, height)


def _backend() -> str:
    return os.environ.get("MUJOCO_GL", "").strip().lower()
