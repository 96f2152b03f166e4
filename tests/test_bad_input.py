"""Bad input as a user meets it: one line with cause and remedy, the right status, nothing left."""

import errno
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from parkproof.cli import main

SCENARIO = """\
law = "corrected"
[bounds]
alpha = [0.5, 1.5]
gamma = [1.0, 2.0]
disturbance = 2.5
[start]
pose = [-1.0, 0.1, 0.0]
[run]
duration = 1.0
control_period = 0.01
"""

EDITS = [
    # what is wrong, text to replace, by what, and what the message must say
    ("missing law", 'law = "corrected"', "", r"law.*corrected"),
    ("unknown law", '"corrected"', '"perfect"', r"law.*corrected.*perfect"),
    ("missing start", "[start]\npose = [-1.0, 0.1, 0.0]", "", r"start.*(pose|state)"),
    ("unknown key", "duration", "durration", r"durration.*duration"),
    ("broken TOML", "alpha = [0.5, 1.5]", "alpha = [0.5,", r"line \d.*not valid TOML"),
    ("zero tolerance", "[run]", "[switching]\ntolerance = [0.0, 1e-2, 1e-2]\n[run]",
     r"tolerance.*greater than 0"),
    ("wrong type", "duration = 1.0", 'duration = "long"', r"duration.*number"),
    ("NaN", "duration = 1.0", "duration = nan", r"duration.*finite"),
    ("infinite", "disturbance = 2.5", "disturbance = inf", r"disturbance.*finite"),
    ("negative bound", "alpha = [0.5, 1.5]", "alpha = [-0.5, 1.5]", r"alpha.*greater than 0"),
    ("crossed bounds", "gamma = [1.0, 2.0]", "gamma = [2.0, 1.0]", r"gamma.*2"),
    ("negative disturbance", "disturbance = 2.5", "disturbance = -1.0", r"disturbance.*-1"),
    ("q1 outside", "[start]", '[gains]\nq1 = "1/2"\n[start]', r"q1 = 1/2.*\(2/3, 1\).*9/11"),
    ("q2 outside", "[start]", "[gains]\nq2 = 1.5\n[start]", r"q2 = 1.5.*\(1/2, 1\)"),
    ("even ratio", 'law = "corrected"', 'law = "published"\ngains.q1 = "7/8"',
     r"q1 = 7/8.*odd integers.*9/11"),
    ("zero period", "control_period = 0.01", "control_period = 0.0",
     r"control_period.*greater than 0"),
    ("huge period", "control_period = 0.01", "control_period = 1e9", r"control_period.*duration"),
    ("tiny period", "control_period = 0.01", "control_period = 1e-12", r"samples.*at most"),
    ("zero duration", "duration = 1.0", "duration = 0", r"duration.*greater than 0"),
    ("truth outside", "[run]", "[truth]\nalpha = [2.0, 1.0]\n[run]", r"alpha.*outside_bounds"),
]  # fmt: skip


def files_in(directory):
    return sorted(path.name for path in Path(directory).iterdir())


def refused(capsys, *arguments, saying=""):
    """Call the command, check that it refuses as it should, and return what it said."""
    status = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    assert status == 2, err
    assert out == ""
    assert err.startswith("parkproof: ")
    assert err.endswith("\n")
    assert err.count("\n") == 1
    assert "Traceback" not in err
    assert re.search(saying, err), err
    return err


@pytest.fixture
def scenario(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "scenario.toml"
    path.write_text(SCENARIO)
    return path


@pytest.mark.parametrize(
    ("old", "new", "saying"), [e[1:] for e in EDITS], ids=[e[0] for e in EDITS]
)
def test_a_scenario_that_breaks_a_rule_is_refused_in_one_line(scenario, capsys, old, new, saying):
    assert old in SCENARIO
    scenario.write_text(SCENARIO.replace(old, new))
    refused(capsys, "park", "scenario.toml", saying=saying)
    assert files_in(".") == ["scenario.toml"]


def test_truth_outside_its_bounds_runs_when_declared_and_says_so(scenario, capsys):
    text = SCENARIO.replace("[run]", "[truth]\nalpha = [2.0, 1.0]\noutside_bounds = true\n[run]")
    scenario.write_text(text)
    assert main(["park", "scenario.toml", "--no-pictures"]) == 0
    assert "outside the guarantee" in " ".join(capsys.readouterr().out.split())


def test_files_that_are_no_scenario_are_refused(scenario, capsys):
    here = scenario.parent
    (here / "empty.toml").touch()
    (here / "image.toml").write_bytes(b"\x89PNG\r\n\x1a\n\xff")
    (here / "folder.toml").mkdir()
    for command in ("park", "check"):
        refused(capsys, command, "nowhere.toml", saying="no such file.*parkproof init")
        refused(capsys, command, "empty.toml", saying="empty.*parkproof init")
        refused(capsys, command, "image.toml", saying="not UTF-8")
        refused(capsys, command, "folder.toml", saying="directory")
    refused(capsys, "park", "strange\nname.toml", saying=r"strange.*name\.toml")
    refused(capsys, "park", "", saying="directory|no such file")


def test_overrides_that_do_not_fit_are_refused(scenario, capsys):
    refused(capsys, "park", scenario, "--set", "run.durration=3", saying="did you mean run.dur")
    refused(capsys, "park", scenario, "--set", "run.duration", saying="key=value")
    refused(capsys, "park", scenario, "--set", "run.duration=-1", saying="greater than 0")
    refused(capsys, "park", scenario, "--set", saying="--set requires")


def test_what_lies_in_the_way_of_results_is_never_replaced_unasked(scenario, capsys):
    results = scenario.parent / "results"
    results.mkdir()
    (results / "diary.txt").write_text("precious")
    refused(capsys, "park", scenario, "--out", results, saying="already exists.*--overwrite")
    refused(capsys, "park", scenario, "--out", results, "--overwrite", saying="diary.txt.*another")
    refused(capsys, "park", scenario, "--out", scenario, saying="is a file")
    refused(capsys, "park", scenario, "--out", ".", "--overwrite", saying="current directory")
    refused(capsys, "reproduce", "--out", results, saying="already exists")
    assert (results / "diary.txt").read_text() == "precious"
    assert files_in(scenario.parent) == ["results", "scenario.toml"]


def test_a_directory_that_cannot_be_made_is_refused(scenario, capsys):
    refused(capsys, "park", scenario, "--out", scenario / "below", saying="cannot write.*file")
    refused(capsys, "park", scenario, "--out", "/proc/results", saying="cannot write.*choose")
    refused(capsys, "park", scenario, "--out", "x" * 300, saying="cannot write.*shorter")


def test_a_full_disk_leaves_nothing_of_the_result(scenario, capsys, monkeypatch):
    import parkproof.results

    def full(_, path):
        path.write_bytes(b"half")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(parkproof.results, "write_trajectory", full)
    refused(capsys, "park", scenario, "--out", "deep/results", saying="No space left.*free some")
    assert files_in(".") == ["scenario.toml"]


def test_running_out_of_memory_names_the_remedy(scenario, capsys, monkeypatch):
    import parkproof.simulation.run

    def hungry(*_, **__):
        raise MemoryError

    monkeypatch.setattr(parkproof.simulation.run, "simulate", hungry)
    refused(capsys, "park", scenario, saying="out of memory; write a longer control_period")
    assert files_in(".") == ["scenario.toml"]


def test_single_files_are_whole_or_not_there(scenario, capsys, monkeypatch):
    refused(capsys, "init", "--out", scenario, saying="already exists; write --overwrite")
    assert scenario.read_text() == SCENARIO
    refused(capsys, "init", "--out", scenario.parent, saying="is a directory")
    refused(capsys, "init", "--out", "nowhere/a.toml", saying="cannot use nowhere/a.toml")
    refused(capsys, "init", "--out", "/dev/full", saying="No space left on device; free some space")

    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    refused(capsys, "search", "--out", "gains.toml", saying="gains.toml: No space left")
    assert files_in(".") == ["scenario.toml"]


def test_command_lines_that_make_no_sense_are_refused(scenario, capsys):
    refused(capsys, "prak", saying='"prak". Did you mean "park"')
    refused(capsys, "park", saying="SCENARIO requires an argument. See: parkproof park --help")
    refused(capsys, "park", scenario, "more", saying='unexpected argument "more"')
    refused(capsys, "park", scenario, "--overwrit", saying="--overwrit. Did you mean --overwrite")
    refused(capsys, "reproduce", "--law", "perfect", saying="perfect.*published.*corrected.*both")
    refused(capsys, "init", "--kind", "papre", saying='did you mean "paper".*adversary')
    refused(capsys, "completion", "tcsh", saying="tcsh.*bash")


def test_searches_refuse_what_they_cannot_use(capsys):
    refused(capsys, "search", "--q1", "1/2", saying=r"q1 = 1/2.*\(2/3, 1\)")
    refused(capsys, "search", "--q2", "nine", saying="q2 = 'nine'.*9/11")
    refused(capsys, "search", "--alpha-max", "nan", saying="alpha_max = nan")
    refused(capsys, "search", "--alpha-max", "wide", saying="wide.*float")
    refused(capsys, "search", "--slack", "0", saying="slack.*greater than 0|k11.*greater than 0")
    refused(capsys, "search", "--margin", "-1", saying="margin = -1.*greater than 0")
    refused(capsys, "search", "--form", "blunt", saying="blunt.*printed.*sharp")


def started(*arguments, cwd, **options):
    """Start the program as a user does."""

    def restore():  # a shell that runs the tests in the background has Ctrl-C ignored
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    return subprocess.Popen(
        [sys.executable, "-m", "parkproof", *arguments],
        cwd=cwd,
        text=True,
        stdout=options.pop("stdout", subprocess.PIPE),
        stderr=subprocess.PIPE,
        preexec_fn=restore,  # noqa: PLW1509
        **options,
    )


@pytest.mark.parametrize(
    ("number", "status", "cause"),
    [(signal.SIGINT, 130, "Ctrl-C"), (signal.SIGTERM, 143, "SIGTERM")],
)
def test_a_run_that_is_stopped_says_so_and_leaves_nothing(scenario, number, status, cause):
    here = scenario.parent
    process = started("park", scenario.name, "--set", "run.duration=10000", cwd=here)
    patience = time.monotonic() + 60.0
    while not list(here.glob("runs/.*")):  # the run has begun once its hidden directory is there
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < patience
        time.sleep(0.02)
    time.sleep(0.2)
    process.send_signal(number)
    process.send_signal(number)  # sent twice, as some terminals and supervisors do
    out, err = process.communicate(timeout=60)
    assert process.returncode == status, err
    assert out == ""
    assert err == (
        f"parkproof: stopped by {cause}; no half-written result is left; run the command again\n"
    )
    assert files_in(here) == ["scenario.toml"]


def test_a_reader_that_has_had_enough_is_no_error(scenario):
    arguments = ["park", scenario.name, "--json", "--check", "--no-pictures"]
    with started(*arguments, cwd=scenario.parent) as process:
        process.stdout.close()
        assert process.stderr.read() == ""
        assert process.wait(timeout=60) == 1  # the status is that of the run, which was too short
    assert (scenario.parent / "runs/scenario/summary.json").exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_an_output_that_cannot_be_written_is_an_error(tmp_path):
    with Path("/dev/full").open("w") as full:
        process = started("schema", cwd=tmp_path, stdout=full)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 2
    assert err == (
        "parkproof: cannot write the output: No space left on device; free some space, or write to "
        "another disk\n"
    )
