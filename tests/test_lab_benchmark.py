"""The laboratory's benchmark sums up whatever its runs were."""

import importlib.util
import io
from pathlib import Path
from types import ModuleType

import pytest
from rich.console import Console


@pytest.fixture(scope="module")
def benchmark() -> ModuleType:
    path = Path(__file__).parents[1] / "benchmarks" / "lab.py"
    spec = importlib.util.spec_from_file_location("lab_benchmark", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def row(**changes: str) -> dict[str, str]:
    usual = {
        "seed": "0", "start": "0", "hard": "0", "torque": "0", "outcome": "parked",
        "parked_after": "9.5", "px": "0.1", "deg": "0.2", "floor_cm": "0.01", "floor_deg": "0.1",
        "allowed_cm": "1.0", "out_of_view": "0", "frames": "500", "courses": "1", "alarms": "",
        "median_ms": "2.0", "p99_ms": "6.0", "speed": "3.0", "side_px": "40", "parkable": "",
    }  # fmt: skip
    return usual | changes


def table(benchmark: ModuleType, *rows: dict[str, str]) -> str:
    out = io.StringIO()
    benchmark.summarise(list(rows), Console(file=out, width=160))
    return out.getvalue()


def test_the_worst_run_is_told_beside_the_median(benchmark):
    said = table(benchmark, row(), row(), row(p99_ms="31.5", median_ms="4.5"))
    assert "median 6, worst 31.5" in said
    assert "median 2, worst 4.5" in said
    assert "3 of 3" in said


def test_runs_of_which_none_is_good_are_summed_up(benchmark):
    assert "0 of 1 (0.0 %)" in table(benchmark, row(outcome="gave up", parked_after=""))
    refused = row(outcome="refused", parked_after="", parkable="0")
    assert "1 (100.0 %), 1 of them without a course" in table(benchmark, refused)
