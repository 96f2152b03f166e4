"""A run of the laboratory is summed up with the files and pictures of a simulated run."""

import enum
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from parkproof.lab.entries import Event
from parkproof.lab.summary import (
    Error,
    FrameCounts,
    LabRun,
    Sample,
    Setting,
    summary_of,
    write_summary,
    write_trajectory,
)
from parkproof.report.lab import lab_pictures
from parkproof.results import read_trajectory
from parkproof.simulation.run import COLUMNS


class Ended(enum.Enum):
    """Outcomes like those of the loop."""

    PARKED = "parked"
    REFUSED = "refused"

    @property
    def sentence(self) -> str:
        return f"It ended {self.value}."


def samples(steps: list[int], **changes: Any) -> list[Sample]:
    """A robot that comes closer in a curve, a sample each 1/30 s."""
    n = len(steps)
    return [
        Sample(
            **(
                {
                    "t": k / 30.0,
                    "x0": -3.0 * (1 - k / n),
                    "x1": (1 - k / n) ** 2,
                    "psi": 0.4 * (1 - k / n),
                    "v": 0.2,
                    "omega": -0.1,
                    "step": step,
                    "beta": 0.8,
                }
                | changes
            )
        )
        for k, step in enumerate(steps)
    ]


def lab_run(given: list[Sample], **changes: Any) -> LabRun:
    return LabRun(
        **(
            {
                "scenario": Setting(
                    law="corrected", title="ünï", view_outline=((-5, -4), (4, -4), (4, 4), (-5, 4))
                ),
                "outcome": Ended.PARKED,
                "parked": True,
                "ended": 3.0,
                "samples": given,
                "frames": FrameCounts(seen=len(given), missing=2, dropped=1, out_of_view=0),
            }
            | changes
        )
    )


STEPS = [0] * 10 + [1] * 20 + [2] * 30 + [3] * 20 + [4] * 10


def test_the_summary_says_how_the_run_went(tmp_path: Path) -> None:
    run = lab_run(
        samples(STEPS),
        latencies=[0.001 * k for k in range(1, 101)],
        image_error=Error(distance=0.4, heading_deg=0.2),
        true_error=Error(distance=0.003, heading_deg=0.1),
        events=[Event(t=0.5, name="tag lost", sentence="tag lost: stopped", level=1)],
        notes=["recording stopped: No space left on device"],
        settings={"gains": {"l1": 0.5}},
    )
    write_summary(run, tmp_path / "summary.json")
    summary = json.loads((tmp_path / "summary.json").read_text("utf-8"))
    assert summary == summary_of(run)
    assert (summary["outcome"], summary["sentence"]) == ("parked", "It ended parked.")
    assert summary["image_error"] == {"distance_px": 0.4, "heading_deg": 0.2}
    assert summary["true_error"] == {"distance_m": 0.003, "heading_deg": 0.1}
    frames = {"seen": 90, "without_tag": 0, "missing": 2, "dropped": 1, "out_of_view": 0}
    assert summary["frames"] == frames
    assert summary["latency"]["median"] == pytest.approx(0.0505)
    assert summary["latency"]["percentile_99"] == pytest.approx(0.09901)
    assert summary["latency"]["count"] == 100
    assert summary["events"] == [{"t": 0.5, "name": "tag lost", "sentence": "tag lost: stopped"}]
    assert summary["notes"] == ["recording stopped: No space left on device"]
    assert summary["settings"] == {"gains": {"l1": 0.5}}
    steps = {str(i): pytest.approx(n / 30.0) for i, n in enumerate((10, 30, 60, 80))}
    assert summary["settling_time"] == {"total": steps["3"], "steps": steps}
    assert summary["path_length"] > 3.0
    assert "peak_tau" not in summary


def test_a_step_that_comes_back_settles_later() -> None:
    run = lab_run(samples([1, 2, 3, 2, 3, 4]))
    assert run.returns == 1
    assert run.settling_time.steps == {
        "1": pytest.approx(1 / 30),
        "2": pytest.approx(4 / 30),
        "3": pytest.approx(5 / 30),
    }
    assert lab_run(samples([1, 2, 3, 4]), parked=False).settling_time.total is None


def test_the_trajectory_is_read_as_that_of_a_simulated_run(tmp_path: Path) -> None:
    run = lab_run(samples(STEPS))
    write_trajectory(run, tmp_path / "trajectory.parquet")
    back = read_trajectory(tmp_path / "trajectory.parquet")
    assert tuple(back) == COLUMNS
    psi = np.array([sample.psi for sample in run.samples])
    np.testing.assert_allclose(back["x2"], np.tan(psi))
    np.testing.assert_allclose(back["u0"], 0.2 * np.cos(psi))
    np.testing.assert_allclose(back["u1"], 0.8 * -0.1 / np.cos(psi) ** 2)
    np.testing.assert_array_equal(back["step"], STEPS)
    assert back["step"].dtype == np.int32
    assert np.isnan(back["tau1"]).all()
    assert (back["omega"] == -0.1).all()


def test_a_heading_beyond_the_chart_has_no_chained_state() -> None:
    run = lab_run(samples([0, 0], psi=math.pi / 2) + samples([0], psi=1.5 * math.pi + 0.1))
    assert np.isnan(run.trajectory["x2"][:2]).all()
    assert run.trajectory["theta"][2] == pytest.approx(-math.pi / 2 + 0.1)
    assert math.isfinite(run.trajectory["u1"][2])


def test_a_torque_robot_has_its_inputs(tmp_path: Path) -> None:
    run = lab_run(samples(STEPS, tau=(1.0, -2.0)))
    assert summary_of(run)["peak_tau"] == [1.0, 2.0]
    names = {path.name for path in lab_pictures(run, tmp_path)}
    assert "figure5.png" in names


def test_the_pictures_are_those_of_a_simulated_run(tmp_path: Path) -> None:
    files = lab_pictures(lab_run(samples(STEPS)), tmp_path)
    assert {path.name for path in files} == {
        "path.png", "path.svg", "overview.png",
        *(f"figure{k}.{ending}" for k in (3, 4, 6, 7, 8) for ending in ("png", "svg")),
    }  # fmt: skip
    assert set(tmp_path.iterdir()) == set(files)
    assert all(path.stat().st_size > 5_000 for path in files)


def test_a_run_in_which_the_robot_was_never_seen_is_summed_up_too(tmp_path: Path) -> None:
    run = lab_run([], outcome=Ended.REFUSED, parked=False, ended=1.0)
    summary = summary_of(run)
    assert (summary["outcome"], summary["ended"], summary["latency"]) == ("refused", 1.0, None)
    write_trajectory(run, tmp_path / "trajectory.parquet")
    assert len(read_trajectory(tmp_path / "trajectory.parquet")["t"]) == 0
    assert lab_pictures(run, tmp_path) == []
