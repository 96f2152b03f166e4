"""Kernels on disk: found again, and never in the way."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import pytest

from parkproof.simulation.lanes import kept
from parkproof.simulation.lanes.kept import cache_folder, keep


def adder(amount: float, name: str) -> Any:
    """A function whose bytecode says nothing of the amount."""

    def add(x: float) -> float:
        return x + amount

    return keep(numba.njit(add), name)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PARKPROOF_CACHE_DIR", str(tmp_path / "kernels"))
    return tmp_path / "kernels"


def hits(kernel: Any) -> int:
    return sum(kernel.stats.cache_hits.values())


def test_a_kernel_is_compiled_once_and_then_loaded(folder: Path) -> None:
    first, second = adder(1.0, "one"), adder(1.0, "one")
    assert first(1.0) == second(1.0) == 2.0
    assert (hits(first), hits(second)) == (0, 1)
    assert any(folder.rglob("*.nbc"))


@pytest.mark.usefixtures("folder")
def test_kernels_are_told_apart_by_their_names() -> None:
    assert [adder(amount, f"{amount}")(1.0) for amount in (1.0, 2.0, 1.0)] == [2.0, 3.0, 2.0]


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_a_damaged_file_is_made_anew(folder: Path, suffix: str) -> None:
    adder(1.0, "one")(1.0)
    for path in folder.rglob(f"*.{suffix}"):
        path.write_bytes(b"\x80garbage")
    mended = adder(1.0, "one")
    assert (mended(1.0), hits(mended)) == (2.0, 0)
    again = adder(1.0, "one")
    assert (again(1.0), hits(again)) == (2.0, 1)


def test_where_nothing_can_be_written_kernels_are_compiled(folder: Path) -> None:
    folder.write_text("a file, not a folder")
    kernel = adder(1.0, "one")
    assert (kernel(1.0), hits(kernel)) == (2.0, 0)


def test_kernels_of_other_sources_are_removed_when_long_unused(folder: Path) -> None:
    old, recent, other = (folder / f"kernels-{name}" for name in ("0" * 16, "1" * 16, "of mine"))
    for path in (old, recent, other):
        path.mkdir(parents=True)
        (path / "a kernel").write_text("")
    for path in (old, other):
        os.utime(path, (0.0, 0.0))
    adder(1.0, "one")(1.0)
    assert {path.name for path in folder.iterdir()} == {
        recent.name, other.name, cache_folder().name
    }  # fmt: skip
    os.utime(cache_folder(), (0.0, 0.0))
    adder(1.0, "one")(1.0)  # loading is use, too
    assert cache_folder().stat().st_mtime > 0.0


@pytest.mark.usefixtures("folder")
def test_a_disk_that_is_full_costs_no_run(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = adder(1.0, "one")

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(kernel._cache._cache_file, "save", full)
    assert kernel(1.0) == 2.0
    assert hits(adder(1.0, "one")) == 0


def test_an_edit_of_any_source_is_another_folder(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "package"
    (package / "laws").mkdir(parents=True)
    for name in ("__init__.py", "scalar.py", "laws/corrected.py"):
        (package / name).write_text("x = 1\n")
    monkeypatch.setattr(kept.parkproof, "__file__", str(package / "__init__.py"))
    named = uncached(cache_folder)
    before = named()
    (package / "laws/corrected.py").write_text("x = 2\n")
    assert named() != before
    assert named().parent == folder


def uncached(function: Callable[[], Path]) -> Callable[[], Path]:
    """The folder as a new process would name it."""

    def call() -> Path:
        kept._state_of_sources.cache_clear()
        return function()

    return call


@pytest.fixture(autouse=True)
def _forget_sources() -> Any:
    yield
    kept._state_of_sources.cache_clear()
