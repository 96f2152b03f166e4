"""Compiled kernels on disk, so that only the first run of a version has to compile.

They are in ``$PARKPROOF_CACHE_DIR``, or else where the platform keeps what can be made again. A
folder belongs to one state of this package's sources, since numba itself would not notice an edit
in a function that a kernel calls; folders that no run has used for long are removed. Whatever goes
wrong with files, be it a full disk, a folder that may not be written or a damaged file, costs no
more than compiling again.
"""

import contextlib
import hashlib
import os
import re
import shutil
import sys
import time
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core import caching, config

import parkproof

KEPT_FOR = 60 * 86400.0
"""Seconds without use after which a folder of other sources is removed."""


def cache_folder() -> Path:
    """Give the folder for kernels of the present sources; it need not exist.

    Returns
    -------
    Path
        The folder.

    Examples
    --------
    >>> cache_folder() == cache_folder()
    True
    """
    return _user_folder() / f"kernels-{_state_of_sources()}"


def _user_folder() -> Path:
    """Where the user wants such files, or the platform."""
    if given := os.environ.get("PARKPROOF_CACHE_DIR"):
        return Path(given).expanduser()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", "~")).expanduser() / "parkproof" / "cache"
    if sys.platform == "darwin":
        return Path("~/Library/Caches/parkproof").expanduser()
    return Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser() / "parkproof"


@cache
def _state_of_sources() -> str:
    """A short name for all that a kernel is compiled from but the processor, which numba checks."""
    folder = Path(parkproof.__file__).parent
    digest = hashlib.sha256(f"{numba.__version__} {sys.version}".encode())
    for part in ("scalar.py", "laws", "model", "simulation"):
        for path in [folder / part, *sorted((folder / part).rglob("*.py"))]:
            if path.is_file():
                digest.update(path.relative_to(folder).as_posix().encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _note_use(folder: Path) -> None:
    """Remember that a folder is used, and remove others that have not been for long."""
    with contextlib.suppress(OSError):
        os.utime(folder)
        for other in folder.parent.iterdir():
            named = re.fullmatch(r"kernels-[0-9a-f]{16}", other.name)
            if named and other.stat().st_mtime < time.time() - KEPT_FOR:
                shutil.rmtree(other, ignore_errors=True)


class _InOneFolder(caching.CompileResultCacheImpl):
    """Files in the folder given to numba, and nowhere else."""

    _locator_classes = caching.CompileResultCacheImpl._locator_classes[:1]


class _Kept(caching.FunctionCache):
    """numba's own cache, for a kernel that a name says everything about."""

    _impl_class = _InOneFolder

    def __init__(self, function: Any, name: str, folder: Path) -> None:
        super().__init__(function)
        self._kernel, self._folder = name, folder

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        # numba would take the functions that a kernel is put together from, which compare unequal
        return sig, codegen.magic_tuple(), self._kernel

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            found = super().load_overload(sig, target_context)
            if found is not None:
                _note_use(self._folder)
            return found
        except Exception:  # a damaged file can raise anything
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)
        _note_use(self._folder)


def keep(kernel: Any, name: str) -> Any:
    """Let a kernel be loaded from disk instead of compiled, and saved there once compiled.

    Parameters
    ----------
    kernel : numba dispatcher
        Not yet compiled.
    name : str
        What tells it from other kernels of the same function.

    Returns
    -------
    numba dispatcher
        The same.

    Examples
    --------
    >>> kernel = keep(numba.njit(lambda x: x + 1), "an example")
    >>> callable(kernel)
    True
    """
    settings: Any = config
    before = settings.CACHE_DIR
    try:
        folder = cache_folder()
        settings.CACHE_DIR = str(folder)
        kernel._cache = _Kept(kernel.py_func, name, folder)
    except (OSError, RuntimeError):  # nowhere to write
        pass
    finally:
        settings.CACHE_DIR = before
    return kernel
