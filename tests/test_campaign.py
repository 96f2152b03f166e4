"""Campaigns as a user runs them: stopped, killed, refused, gone on with, replayed."""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyarrow import parquet

from parkproof import __version__
from parkproof.campaign.definition import read_campaign
from parkproof.campaign.directory import CampaignDirectory, open_directory
from parkproof.campaign.run import run_campaign
from parkproof.cli import main
from parkproof.errors import InputError
from parkproof.simulation.outcome import Outcome

TRIALS = 1024
CAMPAIGN = f"""
title = "Test"
law = "corrected"
trials = {TRIALS}
seed = 5
[distributions]
"start.pose[0]" = {{ kind = "uniform", low = -2.0, high = -0.5 }}
"start.pose[1]" = {{ kind = "uniform", low = -0.5, high = 0.5 }}
"truth.alpha[0]" = {{ kind = "uniform", low = 0.5, high = 1.5 }}
"truth.disturbance[1].amplitude" = {{ kind = "uniform", low = 0.0, high = 2.5 }}
[start]
pose = [-1.0, 0.2, 0.0]
[bounds]
alpha = [0.5, 1.5]
disturbance = 2.5
[truth]
disturbance = [
  {{ kind = "constant", value = 0.0 }},
  {{ kind = "sine", amplitude = 1.0, omega = 2.0 }},
]
[limits]
view = [-2.5, 2.5, -2.0, 2.0]
[run]
duration = 3.0
control_period = 0.01
"""


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A directory of its own, with a campaign."""
    monkeypatch.chdir(tmp_path)
    Path("campaign.toml").write_text(CAMPAIGN, encoding="utf-8")


def names_in(path: Path | str) -> list[str]:
    return sorted(entry.name for entry in Path(path).iterdir())


def bits(path: Path) -> dict[str, Any]:
    """The table sorted by trial, to the bit."""
    assert all(name.endswith(".parquet") for name in names_in(path / "trials"))
    table = parquet.read_table(str(path / "trials")).sort_by("trial")
    assert table["trial"].to_pylist() == list(range(table.num_rows))
    return {
        name: column.to_numpy().view(np.int64).tolist()
        if str(column.type) == "double"
        else column.to_pylist()
        for name, column in zip(table.column_names, table.columns, strict=True)
    }


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The directory of a campaign that nothing disturbed, on one thread."""
    folder = tmp_path_factory.mktemp("reference")
    (folder / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    run_campaign(read_campaign(folder / "campaign.toml"), folder / "out", threads=1)
    return folder / "out"


@pytest.fixture
def again(reference: Path) -> Path:
    """A copy of its directory."""
    return Path(shutil.copytree(reference, "out"))


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """What is said on standard error when bad input is refused."""
    assert main([str(argument) for argument in arguments]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    return error


def record_of(path: Path) -> dict[str, Any]:
    return dict(json.loads((path / "campaign.json").read_text("utf-8")))


# ------------------------------------------------------------------------------- the table


def test_a_campaign_leaves_a_row_a_trial(reference: Path) -> None:
    table = parquet.read_table(str(reference / "trials"))
    assert sorted(table["trial"].to_pylist()) == list(range(TRIALS))
    assert set(table["outcome"].to_pylist()) <= {outcome.value for outcome in Outcome}
    drawn = [name for name in table.column_names if name.startswith("drawn.")]
    assert drawn == [
        "drawn.start.pose[0]", "drawn.start.pose[1]", "drawn.truth.alpha[0]",
        "drawn.truth.disturbance[1].amplitude",
    ]  # fmt: skip
    x = table["drawn.start.pose[0]"].to_numpy()
    assert -2.0 <= x.min() < -1.99 < -0.51 < x.max() <= -0.5
    assert {"total", "end3", "residual", "peak_tau2", "excursion", "x0"} < set(table.column_names)
    record = record_of(reference)
    asked = {name: record[name] for name in ("version", "law", "trials", "seed", "finished")}
    assert asked == {
        "version": __version__, "law": "corrected", "trials": TRIALS, "seed": 5, "finished": True
    }  # fmt: skip


def test_rows_do_not_depend_on_threads_or_on_growing(reference: Path) -> None:
    file = Path("campaign.toml")
    run_campaign(read_campaign(file, overrides=["trials=100"]), Path("out"), threads=2)
    assert record_of(Path("out"))["trials"] == 100
    run_campaign(read_campaign(file, overrides=["trials=300"]), Path("out"), threads=1)
    run_campaign(read_campaign(file), Path("out"), threads=3)
    assert bits(Path("out")) == bits(reference)
    assert len(names_in("out/trials")) > len(names_in(reference / "trials"))


def test_choices_that_split_trials_give_each_its_own_row() -> None:
    """A trial beside others under another limit is what it is alone."""
    text = CAMPAIGN.replace(
        "[start]", '"limits.view[1]" = { kind = "choice", values = [2.5, 2.6] }\n[start]'
    )
    Path("split.toml").write_text(text, encoding="utf-8")
    run_campaign(read_campaign(Path("split.toml")), Path("out"))
    table = parquet.read_table("out/trials").sort_by("trial")
    assert set(table["drawn.limits.view[1]"].to_pylist()) == {2.5, 2.6}
    assert table.num_rows == TRIALS
    x, first = table["drawn.start.pose[0]"].to_numpy(), table["largest_x0"].to_numpy()
    assert (first >= x).all()
    assert np.isfinite(first).all()


def test_a_campaign_ends_with_a_report(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", "campaign.toml", "--out", "out", "--trials", "70"]) == 0
    said = capsys.readouterr().out
    assert "Trials" in said
    assert "report.html" in said
    assert names_in("out/trials") == [
        "000000000000-000000000063.parquet",
        "000000000064-000000000069.parquet",
    ]
    assert "70 trials" in Path("out/report.html").read_text("utf-8")


# ------------------------------------------------------------------------------- going on


def test_an_interrupted_campaign_says_how_to_go_on_and_loses_nothing(
    reference: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    add, given = CampaignDirectory.add, ["campaign", "campaign.toml", "--out", "out", "--no-report"]

    def add_and_stop(self: CampaignDirectory, *arguments: Any) -> None:
        add(self, *arguments)
        if len(self.written) == 3:
            signal.raise_signal(signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(CampaignDirectory, "add", add_and_stop)
        assert main(given) == 130
    error = capsys.readouterr().err
    assert "stopped by Ctrl-C; the rows of" in error
    assert "trials are in out; the same command goes on from there" in error
    assert record_of(Path("out"))["finished"] is False
    assert len(names_in("out/trials")) == 3
    assert main([*given, "--quiet"]) == 0
    assert record_of(Path("out"))["finished"] is True
    assert bits(Path("out")) == bits(reference)


@pytest.fixture
def killed(reference: Path) -> Path:
    """What kill -9 leaves of a campaign that was writing; the reference is there to compare."""
    assert reference.exists()
    out = Path("out")
    command = [sys.executable, "-m", "parkproof", "campaign", "campaign.toml", "--out", str(out)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, start_new_session=True) as process:
        while process.poll() is None and not (
            (out / "trials").is_dir() and len(names_in(out / "trials")) >= 3
        ):
            time.sleep(0.001)
        process.kill()
    return out


def test_a_campaign_that_was_killed_goes_on_without_loss_or_repetition(
    killed: Path, reference: Path
) -> None:
    assert 0 < len(names_in(killed / "trials")) < len(names_in(reference / "trials"))
    times = {path: path.stat().st_mtime_ns for path in (killed / "trials").iterdir()}
    assert main(["campaign", "campaign.toml", "--out", "out", "--quiet", "--no-report"]) == 0
    assert all(path.stat().st_mtime_ns == then for path, then in times.items())
    assert bits(killed) == bits(reference)


def test_what_a_kill_leaves_half_written_is_taken_away(again: Path, reference: Path) -> None:
    gone = sorted((again / "trials").iterdir())[4]
    (again / ".parts").mkdir()
    (again / ".parts" / "1f3a").write_bytes(gone.read_bytes()[:1000])
    gone.unlink()
    assert main(["campaign", "campaign.toml", "--out", "out", "--quiet", "--no-report"]) == 0
    assert not (again / ".parts").exists()
    assert bits(again) == bits(reference)


def test_a_directory_that_was_killed_before_it_was_named_is_begun_anew(reference: Path) -> None:
    Path("out/.parts").mkdir(parents=True)
    Path("out/.lock").touch()
    Path("out/.parts/half").write_text("{")
    assert main(["campaign", "campaign.toml", "--out", "out", "--quiet", "--no-report"]) == 0
    assert bits(Path("out")) == bits(reference)


def test_a_disk_that_fills_is_one_sentence_and_the_rows_stay(
    reference: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    fsync, calls = os.fsync, iter(range(100))

    def full(descriptor: int) -> None:
        if next(calls) >= 9:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(descriptor)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        error = refused(capsys, "campaign", "campaign.toml", "--out", "out")
    assert "cannot write to out: No space left on device; the rows of" in error
    assert "make room, and the same command goes on" in error
    assert not Path("out/.parts").exists()
    assert len(names_in("out/trials")) > 0
    run_campaign(read_campaign(Path("campaign.toml")), Path("out"))
    assert bits(Path("out")) == bits(reference)


# ------------------------------------------------------------------------------- what is refused


def test_the_directory_of_another_campaign_is_refused(
    again: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = bits(again)
    given = ("campaign", "campaign.toml", "--out", again)
    error = refused(capsys, *given, "--set", "run.duration=2")
    assert "another campaign: run.duration is 3.0 there and 2.0 here; choose another" in error
    assert not (again / ".parts").exists()
    assert "seed is 5 there and 6 here" in refused(capsys, *given, "--set", "seed=6")
    assert "no trial is ever removed" in refused(capsys, *given, "--trials", 1000)
    record = record_of(again)
    (again / "campaign.json").write_text(json.dumps(record | {"version": "0.0.1"}))
    assert "begun with Parkproof 0.0.1" in refused(capsys, *given)
    (again / "campaign.json").write_text("{")
    assert "campaign.json: is damaged" in refused(capsys, *given)
    assert bits(again) == before


def test_a_directory_of_something_else_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    Path("out").mkdir()
    Path("out/diary.txt").write_text("precious")
    assert "holds diary.txt and no campaign" in refused(
        capsys, "campaign", "campaign.toml", "--out", "out"
    )
    assert names_in("out") == ["diary.txt"]
    assert "is a file" in refused(capsys, "campaign", "campaign.toml", "--out", "out/diary.txt")
    error = refused(capsys, "campaign", "campaign.toml", "--out", "/proc/out")
    assert "cannot write to /proc/out" in error


def test_rows_without_a_record_are_not_taken_for_those_of_this_campaign(
    again: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = names_in(again / "trials")
    (again / "campaign.json").unlink()
    error = refused(capsys, "campaign", "campaign.toml", "--out", again, "--set", "seed=6")
    assert "holds rows of trials, but no campaign.json" in error
    assert names_in(again / "trials") == before


def test_a_folder_that_cannot_be_made_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    Path("out").mkdir()
    for name in (".lock", "trials"):
        Path("out", name).touch()
    error = refused(capsys, "campaign", "campaign.toml", "--out", "out")
    assert "cannot write to out: " in error


def test_a_foreign_or_damaged_file_among_the_rows_is_named(
    again: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ("campaign", "campaign.toml", "--out", again)
    (again / "trials" / "notes.txt").touch()
    assert "notes.txt: is no file of this campaign" in refused(capsys, *given)
    (again / "trials" / "notes.txt").unlink()
    first = sorted((again / "trials").iterdir())[0]
    first.write_bytes(first.read_bytes()[:-9])
    assert f"{first.name}: is damaged; remove it" in refused(capsys, *given)
    first.unlink()
    twice = again / "trials" / "000000000100-000000000101.parquet"
    twice.write_bytes(b"")
    assert "is there twice" in refused(capsys, *given)


def test_two_processes_do_not_write_to_one_directory(
    again: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plain = record_of(again)["campaign"]
    with open_directory(again, plain):
        error = refused(capsys, "campaign", "campaign.toml", "--out", again)
        assert "another process is carrying this campaign out" in error
    with open_directory(again, plain) as opened:
        assert opened.missing() == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--trials", "0"], "trials = 0: a campaign needs at least 1"),
        (["--trials", str(2**31)], "a Sobol sequence has"),
        (["--trials", "many"], "Invalid value"),
        (["--threads", "0"], "--threads 0: must be from 1"),
        (["--threads", "2", "--scheduler", "tcp://127.0.0.1:9"], "leave --threads out"),
        (["--certificate", "nowhere.json"], "nowhere.json: no such file"),
        (["--scheduler", "here"], "is no address of a scheduler"),
        (["--set", "trails=3"], "did you mean trials?"),
        (["--set", "run.duration=-1"], "duration = -1.0: must be greater than 0"),
        (["--set", "bounds.alpha=[0.7, 1.0]"], "outside its bounds"),
        (
            ["--set", 'distributions={"run.seed" = {kind = "choice", values = ["a", "b"]}}'],
            "a seed is a whole number; write whole numbers",
        ),
    ],
)
def test_what_cannot_be_carried_out_is_refused_before_anything_is_written(
    capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    assert words in refused(capsys, "campaign", "campaign.toml", "--out", "out", *arguments)
    assert names_in(".") == ["campaign.toml"]


def test_files_that_are_no_campaign_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "--out", "scenario.toml"]) == 0
    capsys.readouterr()
    error = refused(capsys, "campaign", "scenario.toml")
    assert "trials is missing, so this is no campaign" in error
    missing = refused(capsys, "campaign", "nowhere.toml")
    assert "parkproof init --kind campaign --out nowhere.toml" in missing


# ------------------------------------------------------------------------------- replay


def test_a_trial_is_run_again_alone_and_written_as_a_scenario(
    reference: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for number in (3, 700):
        out = f"trial{number}"
        assert main(["replay", str(reference), str(number), "--out", out, "--no-pictures"]) == 0
        said = capsys.readouterr().out
        assert "In the campaign: " in said
        assert "same." in said or "control periods." in said
        row = parquet.read_table(str(reference / "trials")).sort_by("trial").slice(number, 1)
        outcome = row["outcome"][0].as_py()
        assert json.loads(Path(out, "summary.json").read_text())["outcome"] == outcome
        scenario = f"{out}/scenario.toml"
        assert main(["park", scenario, "--out", "again", "--no-pictures", "--overwrite"]) == 0
        one, other = (Path(place, "trajectory.parquet") for place in (out, "again"))
        assert parquet.read_table(one).equals(parquet.read_table(other))
        capsys.readouterr()


def test_a_trial_that_ends_otherwise_alone_is_told(again: Path, capsys: Any) -> None:
    file = sorted((again / "trials").iterdir())[0]
    table = parquet.read_table(file)
    column = table.column_names.index("outcome")
    parquet.write_table(table.set_column(column, "outcome", [["diverged"] * len(table)]), file)
    assert main(["replay", str(again), "3", "--no-pictures"]) == 1
    said = capsys.readouterr().out
    assert "In the campaign: diverged" in said
    assert "The outcomes differ." in said
    assert Path("runs/out-3/scenario.toml").exists()


def test_replays_of_what_is_not_there_are_refused(
    reference: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "say which trial" in refused(capsys, "replay", reference)
    assert "has no trial 1024 (it has trials 0 to 1,023)" in refused(
        capsys, "replay", reference, TRIALS
    )
    assert "is no directory of a campaign" in refused(capsys, "replay", "nowhere", 3)
    assert "is no campaign: a trial" in refused(capsys, "replay", "campaign.toml", 3)
    assert "no such file" in refused(capsys, "replay", "nowhere")
    assert names_in(".") == ["campaign.toml"]


def test_a_directory_is_opened_by_its_own_campaign_only(again: Path) -> None:
    plain = record_of(again)["campaign"]
    with pytest.raises(InputError, match="law is"), open_directory(again, plain | {"law": "x"}):
        pass
