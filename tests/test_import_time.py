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


def test_an_ensemble_does_not_import_linear_algebra_as_numba_would() -> None:
    ensemble = "from parkproof import section4, simulate_ensemble\nsimulate_ensemble([section4()])"
    modules = modules_after(ensemble)
    assert "numba.np.arraymath" in modules
    assert "scipy.linalg" not in modules


def test_numba_s_linear_algebra_works_after_an_ensemble_all_the_same() -> None:
    both = (
        "import parkproof.simulation.compiler, numba, numpy as np\n"
        "assert numba.njit(lambda a: a @ a)(2.0 * np.eye(2)).tolist() == [[4.0, 0.0], [0.0, 4.0]]"
    )
    assert "scipy.linalg.cython_blas" in modules_after(both)


def test_laws_never_import_what_is_true() -> None:
    loaded = modules_after("import parkproof.laws.controller, parkproof.laws.robustify")
    assert "parkproof.laws.corrected" in loaded
    assert "parkproof.model.truth" not in loaded
