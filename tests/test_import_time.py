"""Importing the package costs nothing; heavy libraries are imported when they are used."""

import json
import subprocess
import sys

import pytest

HEAVY = {"numpy", "numba", "llvmlite", "matplotlib", "pyarrow", "PIL", "scipy"}


def modules_after(statement: str) -> set[str]:
    """Top-level modules that a fresh interpreter holds after a statement."""
    code = f"{statement}\nimport sys, json\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout))


@pytest.mark.parametrize(
    "statement",
    ["import parkproof", "import parkproof.laws.controller", "import parkproof.scenario"],
)
def test_importing_does_not_import_heavy_libraries(statement: str) -> None:
    assert not HEAVY & modules_after(statement)


def test_simulating_one_run_does_not_import_the_compiler() -> None:
    assert not {"numba", "llvmlite"} & modules_after("import parkproof.simulation.run")


def test_laws_never_import_what_is_true() -> None:
    loaded = modules_after("import parkproof.laws.controller, parkproof.laws.robustify")
    assert "parkproof.laws.corrected" in loaded
    assert "parkproof.model.truth" not in loaded
