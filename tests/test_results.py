import errno
import json
import math
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyarrow import parquet

import parkproof
from parkproof.bounds import Bounds, Limits
from parkproof.errors import InputError
from parkproof.laws.gains import Gains, Switching
from parkproof.model.overhead import HomographyTable
from parkproof.model.signals import Constant, Noise
from parkproof.model.truth import Truth
from parkproof.output import MANIFEST, write_whole
from parkproof.results import (
    UNITS,
    notes_of,
    output_directory,
    read_trajectory,
    summary_of,
    write_summary,
    write_trajectory,
)
from parkproof.scenario import Robot, RunSettings, Scenario, Start
from parkproof.scenario_file import scenario_from_dict, template
from parkproof.simulation.run import COLUMNS, Run, simulate

SCENARIO = Callable[..., Scenario]
LOOSE = Switching(tolerance=(0.1, 0.1, 0.1))


@pytest.fixture(scope="module")
def run(section4: SCENARIO) -> Run:
    return simulate(
        section4(truth="noise", duration=8.0, control_period=0.01, switching=LOOSE, title="ünï")
    )


def make_result(path: Path, text: str = "old") -> None:
    with output_directory(path) as work:
        (work / "published").mkdir()
        (work / "summary.json").write_text(text)
        (work / "published" / "figure3.png").write_text(text)


def write_then(error: BaseException, path: Path, *, overwrite: bool = False) -> None:
    with output_directory(path, overwrite=overwrite) as work:
        (work / "summary.json").write_text("half")
        raise error


def record_then(error: BaseException, path: Path) -> None:
    kept: list[str] = []
    with output_directory(path, overwrite=True, kept=kept) as work:
        (work / "run.mcap").write_text("sound")
        (work / "run.mp4").write_text("half")
        kept.append("run.mcap")
        raise error


def everything_below(path: Path) -> list[str]:
    return sorted(p.relative_to(path).as_posix() for p in path.rglob("*"))


def test_files_that_are_sound_are_left_beside_a_result_that_fails(tmp_path):
    earlier = tmp_path / "run"
    make_result(earlier)
    for error in (OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()):
        with pytest.raises((InputError, KeyboardInterrupt)) as raised:
            record_then(error, earlier)
        assert "-broken-off" in raised.value.__notes__[0]
    names = sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.mcap"))
    assert names == ["run-broken-off-2/run.mcap", "run-broken-off/run.mcap"]
    assert not list(tmp_path.rglob("*.mp4"))
    assert (earlier / "summary.json").read_text() == "old"
    assert not list(tmp_path.glob(".run*"))


def test_what_could_not_be_written_is_named_as_the_user_named_it(tmp_path):
    with (
        pytest.raises(InputError, match=re.escape(f"cannot write {tmp_path}/run/none/goal.json: ")),
        output_directory(tmp_path / "run") as work,
    ):
        write_whole(work / "none" / "goal.json", "{}")
    assert not list(tmp_path.iterdir())


def test_a_result_that_fails_before_a_file_is_sound_leaves_nothing(tmp_path):
    with pytest.raises(ZeroDivisionError), output_directory(tmp_path / "run", kept=["a"]):
        _ = 1 // 0
    assert not list(tmp_path.iterdir())


def test_a_result_appears_only_when_it_is_complete(tmp_path: Path) -> None:
    target = tmp_path / "deep" / "out"
    with output_directory(target) as work:
        (work / "a.txt").write_text("1")
        assert work.parent == target.parent
        assert not target.exists()
    assert everything_below(target) == [MANIFEST, "a.txt"]
    assert everything_below(tmp_path / "deep") == ["out", f"out/{MANIFEST}", "out/a.txt"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit, InputError])
def test_nothing_remains_after_an_exception(tmp_path: Path, error: type[BaseException]) -> None:
    with pytest.raises(error):
        write_then(error(), tmp_path / "new" / "out")
    assert everything_below(tmp_path) == []


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_an_earlier_result_survives_an_exception(
    tmp_path: Path, error: type[BaseException]
) -> None:
    make_result(tmp_path / "out")
    before = everything_below(tmp_path)
    with pytest.raises(error):
        write_then(error(), tmp_path / "out", overwrite=True)
    assert everything_below(tmp_path) == before
    assert (tmp_path / "out" / "summary.json").read_text() == "old"


def test_a_failed_swap_brings_the_earlier_result_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_result(tmp_path / "out")
    before = everything_below(tmp_path)
    rename = Path.rename

    def fail_on_the_new_one(self: Path, target: Path) -> Path:
        if ".new-" in self.name:
            raise KeyboardInterrupt
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", fail_on_the_new_one)
    with (
        pytest.raises(KeyboardInterrupt),
        output_directory(tmp_path / "out", overwrite=True) as work,
    ):
        (work / "summary.json").write_text("new")
    assert everything_below(tmp_path) == before


def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full on this system")

    def fill_the_disk() -> None:
        with output_directory(tmp_path / "out") as work:
            (work / "big.bin").symlink_to("/dev/full")
            (work / "big.bin").write_bytes(b"0" * 10)

    with pytest.raises(InputError) as caught:
        fill_the_disk()
    assert "No space left on device; free some space" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert everything_below(tmp_path) == []


@pytest.mark.parametrize(
    ("number", "remedy"),
    [
        (errno.EDQUOT, "free some space"),
        (errno.EACCES, "may write to"),
        (errno.EIO, "choose another directory"),
    ],
)
def test_an_error_of_the_system_names_path_and_remedy(
    tmp_path: Path, number: int, remedy: str
) -> None:
    with pytest.raises(InputError, match=remedy) as caught, output_directory(tmp_path / "out"):
        raise OSError(number, "cause of it")
    assert str(tmp_path / "out") in str(caught.value)
    assert "cause of it" in str(caught.value)


def test_an_existing_path_is_refused_before_any_work(tmp_path: Path) -> None:
    make_result(tmp_path / "out")
    with pytest.raises(InputError, match=r"out already exists; write --overwrite"):
        output_directory(tmp_path / "out").__enter__()


def test_overwrite_replaces_an_earlier_result_whole(tmp_path: Path) -> None:
    make_result(tmp_path / "out")
    with output_directory(tmp_path / "out", overwrite=True) as work:
        (work / "summary.json").write_text("new")
    assert (tmp_path / "out" / "summary.json").read_text() == "new"
    assert everything_below(tmp_path) == ["out", f"out/{MANIFEST}", "out/summary.json"]


def test_overwrite_takes_an_empty_directory(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with output_directory(tmp_path / "out", overwrite=True) as work:
        (work / "a.txt").write_text("1")
    assert (tmp_path / "out" / "a.txt").exists()


@pytest.mark.parametrize("name", ["notes.md", "published/notes.md", ".git/config"])
def test_overwrite_never_deletes_what_parkproof_did_not_write(tmp_path: Path, name: str) -> None:
    make_result(tmp_path / "out")
    foreign = tmp_path / "out" / name
    foreign.parent.mkdir(exist_ok=True)
    foreign.write_text("mine")
    with pytest.raises(InputError, match=f"holds {name}, which Parkproof did not write"):
        output_directory(tmp_path / "out", overwrite=True).__enter__()
    assert foreign.read_text() == "mine"


def test_overwrite_refuses_a_directory_that_only_looks_like_a_result(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "summary.json").write_text("{}")
    with pytest.raises(InputError, match=r"holds summary\.json"):
        output_directory(tmp_path / "out", overwrite=True).__enter__()


def test_a_file_added_during_the_run_is_kept(tmp_path: Path) -> None:
    make_result(tmp_path / "out")

    def add_a_file_meanwhile() -> None:
        with output_directory(tmp_path / "out", overwrite=True) as work:
            (work / "summary.json").write_text("new")
            (tmp_path / "out" / "late.txt").write_text("mine")

    with pytest.raises(InputError, match=r"late\.txt"):
        add_a_file_meanwhile()
    assert (tmp_path / "out" / "late.txt").exists()
    assert (tmp_path / "out" / "summary.json").read_text() == "old"


@pytest.mark.parametrize("path", [".", "..", "", "/"])
def test_the_current_directory_and_its_parents_are_never_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, path: str
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    with pytest.raises(InputError, match="current directory"):
        output_directory(path, overwrite=True).__enter__()


def test_a_file_in_the_way_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match="is a file"):
        output_directory(tmp_path / "file", overwrite=True).__enter__()
    with pytest.raises(InputError, match="a file is in the way"):
        output_directory(tmp_path / "file" / "out").__enter__()
    assert (tmp_path / "file").read_text() == "mine"


def test_an_unwritable_parent_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Path, *_: Any, **__: Any) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", str(self))

    monkeypatch.setattr(Path, "mkdir", refuse)
    for target in (tmp_path / "out", tmp_path / "deep" / "out"):
        with pytest.raises(InputError, match="Permission denied; choose a directory that you may"):
            output_directory(target).__enter__()


def test_ctrl_c_leaves_nothing_in_a_process_of_its_own(tmp_path: Path) -> None:
    program = (
        "import os, signal, sys\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # may be ignored in here
        "from parkproof.output import output_directory\n"
        "with output_directory(sys.argv[1]) as work:\n"
        "    (work / 'a.txt').write_text('half')\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path / "out")], capture_output=True, check=False
    )
    assert b"KeyboardInterrupt" in done.stderr
    assert everything_below(tmp_path) == []


def test_the_summary_says_what_happened_and_how_to_repeat_it(run: Run) -> None:
    summary = summary_of(run)
    assert summary["outcome"] == run.outcome.value
    assert summary["sentence"] == run.outcome.sentence
    assert summary["settling_time"]["total"] == run.settling_time.total
    assert list(summary["settling_time"]["steps"]) == ["1", "2", "3"]
    assert summary["version"] == parkproof.__version__
    assert summary["seed"] == [1, 2, 3, 4]
    assert summary["plant_step"] == pytest.approx(1e-3)
    assert scenario_from_dict(summary["scenario"], where="summary.json") == run.scenario
    for name in ("law", "residual", "peak_tau", "rms_tau", "total_variation_tau", "max_abs"):
        assert summary[name] is not None
    assert set(summary["max_abs"]) == {"x0", "x1", "x2", "u0", "u1"}


def test_the_summary_file_repeats_the_run_bit_for_bit(run: Run, tmp_path: Path) -> None:
    write_summary(run, tmp_path / "summary.json")
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    again = simulate(scenario_from_dict(summary["scenario"], where="summary.json"))
    for name in COLUMNS:
        np.testing.assert_array_equal(again.trajectory[name], run.trajectory[name])


def test_the_summary_is_strict_json_even_after_divergence(
    section4: SCENARIO, tmp_path: Path
) -> None:
    start = Start(pose=(-1.0, 0.5, 2.0))  # at the start the chart does not exist: NaN
    turning = simulate(section4(start=start, duration=0.1, control_period=0.01))
    metrics = turning.metrics
    assert math.isnan(metrics.final["x2"])
    write_summary(turning, tmp_path / "summary.json")

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    text = (tmp_path / "summary.json").read_text(encoding="utf-8")
    summary = json.loads(text, parse_constant=refuse)
    assert summary["final"]["x2"] is None


def test_the_summary_says_when_nothing_is_promised(section4: SCENARIO) -> None:
    outside = Truth(gamma=(Constant(3.0), Constant(1.0)), outside_bounds=True)
    short: dict[str, Any] = {"duration": 0.05, "control_period": 0.01}
    inside = summary_of(simulate(section4(**short)))
    assert inside["assumptions"].startswith("inside the bounds")
    for changes in ({"truth": outside}, {"limits": Limits(tau=(1.0, 1.0), saturate=True)}):
        summary = summary_of(simulate(section4(**short, **changes)))
        assert summary["assumptions"].startswith("outside the guarantee")
        assert any("outside the guarantee" in note for note in summary["notes"])


OVERHEAD = HomographyTable(matrix=(100, 0, 320, 0, 100, 240, 0, 0, 1), unit=100.0)


@pytest.mark.parametrize(
    "uncertain",
    [
        {"bounds": Bounds(gamma=((1.0, 2.0), (1.0, 1.0)))},
        {"bounds": Bounds(gamma=((1.0, 1.0), (0.5, 1.0)))},
        {"bounds": Bounds(disturbance=(0.1, 0.0))},
        {"bounds": Bounds(disturbance=(0.0, 0.1))},
        {"camera": OVERHEAD, "bounds": Bounds(alpha=(0.9, 1.1))},
    ],
)
def test_notes_promise_nothing_to_an_uncertain_torque_robot(uncertain: dict[str, Any]) -> None:
    def promised(kind: str, parts: dict[str, Any]) -> bool:
        scenario = Scenario(
            law="corrected",
            start=Start(pose=(-1.0, 0.1, 0.0)),
            robot=Robot(kind=kind),  # type: ignore[arg-type]  # one of its kinds
            switching=LOOSE,
            **parts,
        )
        return not any("outside the guarantee" in note for note in notes_of(scenario))

    assert promised("torque", {})
    assert promised("torque", {"bounds": Bounds(alpha=(0.5, 1.5))})
    assert not promised("torque", uncertain)
    assert promised("chained", uncertain)


def test_notes_of_the_torque_template_promise_nothing() -> None:
    scenario = scenario_from_dict(tomllib.loads(template("torque-robot")), where="template")
    assert "accelerations" in next(n for n in notes_of(scenario) if "outside the guarantee" in n)


@pytest.mark.parametrize(("factor", "noted"), [(0.99, False), (1.01, True)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_notes_name_a_start_from_which_the_law_would_turn_again(
    factor: float, noted: bool, side: float
) -> None:
    """ξ1 = 0 at |x2| = l1|x1|^q1; with chart_limit = 60° the law turns again at 88.5°."""
    l1, q1 = 1.5, 9 / 11
    aside = (factor * math.tan(math.radians(88.5)) / l1) ** (1.0 / q1)
    scenario = Scenario(
        law="corrected",
        start=Start(pose=(-1.0, side * aside, 0.0)),
        gains=Gains(l=(l1, 4.2, 21.0), q1="9/11"),
        switching=Switching(tolerance=(0.1, 0.1, 0.1), chart_limit=60.0),
    )
    assert any("where it would turn again" in note for note in notes_of(scenario)) is noted


@pytest.mark.parametrize(
    ("index", "gain", "power"), [(0, 1.0, 1 / 3), (1, 21.0, 5 / 7), (2, 6.5, 5 / 7)]
)
def test_notes_of_the_explicit_form_draw_the_line_at_its_limit_cycle(
    index: int, gain: float, power: float
) -> None:
    """u̇ = −γ_M/γ_m·gain·⌈u⌋^power, held for a period, throws u from the band's edge across."""
    h, ratio = 0.03, 2.0
    band = (0.5 * h * ratio * gain) ** (1.0 / (1.0 - power))
    assert band - h * ratio * gain * band**power == pytest.approx(-band)
    noted = {}
    for factor in (0.99, 1.01):
        tolerance = [10.0, 10.0, 10.0]
        tolerance[index] = factor * band
        scenario = Scenario(
            law="corrected",
            start=Start(pose=(-1.0, 0.1, 0.0)),
            bounds=Bounds(gamma=(0.5, 1.0)),
            truth=Truth(),
            switching=Switching(tolerance=(tolerance[0], tolerance[1], tolerance[2])),
            run=RunSettings(control_period=h),
        )
        noted[factor] = any(f"tolerance[{index}]" in note for note in notes_of(scenario))
    assert noted == {0.99: True, 1.01: False}


def test_notes_name_a_tolerance_below_its_band(section4: SCENARIO) -> None:
    explicit = notes_of(section4(control_period=1e-3))
    assert len(explicit) == 1
    assert "tolerance[0] = 0.001 is below the band 0.0075" in explicit[0]
    implicit = notes_of(section4(control_period=1e-3, discretisation="implicit"))
    assert "the band 0.005 within which a period of 1 ms holds u0" in implicit[0]
    assert len(notes_of(section4(control_period=1e-2))) == 3
    assert notes_of(section4(control_period=1e-2, switching=LOOSE)) == []


def test_notes_name_a_switching_time_that_never_comes(section4: SCENARIO) -> None:
    notes = notes_of(section4(duration=20.0, switching=Switching(to_step3=25.0)))
    assert any("to_step3 = 25 s is not before the end of the run at 20 s" in n for n in notes)


def test_a_trajectory_comes_back_as_it_was(run: Run, tmp_path: Path) -> None:
    write_trajectory(run, tmp_path / "trajectory.parquet")
    back = read_trajectory(tmp_path / "trajectory.parquet")
    assert tuple(back) == COLUMNS
    for name in COLUMNS:
        assert back[name].dtype == (np.int32 if name == "step" else np.float64)
        np.testing.assert_array_equal(back[name], run.trajectory[name])


def test_a_trajectory_file_says_its_units_and_version(run: Run, tmp_path: Path) -> None:
    write_trajectory(run, tmp_path / "trajectory.parquet")
    schema = parquet.read_schema(tmp_path / "trajectory.parquet")
    assert schema.metadata[b"parkproof"] == parkproof.__version__.encode()
    assert schema.metadata[b"title"].decode() == "ünï"
    assert set(UNITS) == set(COLUMNS)
    assert schema.field("theta").metadata[b"unit"] == b"rad"


@pytest.mark.parametrize("record_period", [0.1, 0.07, 0.001, 3.0, 100.0])
def test_a_thinned_trajectory_keeps_its_ends(
    section4: SCENARIO, tmp_path: Path, record_period: float
) -> None:
    thin = simulate(section4(duration=0.57, control_period=0.01, record_period=record_period))
    write_trajectory(thin, tmp_path / "trajectory.parquet")
    back = read_trajectory(tmp_path / "trajectory.parquet")
    t = thin.trajectory["t"]
    assert back["t"][0] == t[0]
    assert back["t"][-1] == t[-1]
    assert set(back["t"]) <= set(t)
    expected = min(len(t), math.ceil(0.57 / record_period) + 1)
    assert abs(len(back["t"]) - expected) <= 1
    if record_period == 0.1:
        np.testing.assert_allclose(back["t"], [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.57], atol=1e-12)


def test_what_is_no_trajectory_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_trajectory(tmp_path / "missing.parquet")
    (tmp_path / "text.parquet").write_text("no")
    with pytest.raises(InputError, match="not a Parquet file"):
        read_trajectory(tmp_path / "text.parquet")


def test_noise_seeds_are_listed_in_order(section4: SCENARIO) -> None:
    calm = Constant(1.0)
    truth = Truth(
        gamma=(calm, calm), disturbance=(calm, Noise(amplitude=1.0, bandwidth=5.0, seed=9))
    )
    short = simulate(section4(truth=truth, duration=0.05, control_period=0.01))
    assert summary_of(short)["seed"] == [9]
