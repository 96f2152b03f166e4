"""The commands, as a user runs them."""

import errno
import io
import json
import re
import signal
import subprocess
import sys
import time
import tomllib
import weakref
from pathlib import Path

import pytest

import parkproof.cli
from parkproof import __version__
from parkproof.cli import COMMANDS, main
from parkproof.cli.console import progress
from parkproof.cli.errors import guarded

SCENARIO = """\
title = "A short one [1]"
law = "corrected"
[bounds]
alpha = [0.5, 1.5]
[start]
pose = [-1.0, 0.1, 0.0]
[run]
duration = 12.0
control_period = 0.02
discretisation = "implicit"
"""


def said(capsys, *arguments, status=0):
    """Call the command and return what it printed."""
    assert main([str(argument) for argument in arguments]) == status
    out, err = capsys.readouterr()
    assert err == ""
    assert "\x1b" not in out
    assert "…" not in out
    return out


def words(text):
    return " ".join(text.split())


@pytest.fixture
def scenario(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "short.toml"
    path.write_text(SCENARIO)
    return path


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A run of the program itself, with its results."""
    here = tmp_path_factory.mktemp("finished")
    (here / "short.toml").write_text(SCENARIO)
    command = [sys.executable, "-m", "parkproof", "park", "short.toml", "--check"]
    result = subprocess.run(command, cwd=here, capture_output=True, text=True, check=False)
    return here / "runs" / "short", result


def test_a_run_prints_how_it_went_and_where_its_files_are(finished):
    _, result = finished
    assert (result.returncode, result.stderr) == (0, "")
    assert all(len(line) <= 80 for line in result.stdout.splitlines())
    text = words(result.stdout)
    for part in (
        "A short one [1] (corrected law)", "Outcome parked", "reached the goal and stayed there",
        "inside the bounds", "Step 1, run-up ended at", "Step 3, return ended at", "Residual",
        "Peak input τ1", "Chatter τ1", "Excursion", "Results in runs/short", "trajectory.parquet",
    ):  # fmt: skip
        assert part in text
    assert "\x1b" not in result.stdout


def test_a_run_leaves_its_files_and_the_scenario_that_repeats_it(finished, capsys):
    directory, _ = finished
    names = {path.name for path in directory.iterdir()}
    figures = {f"figure{i}.{ending}" for i in range(3, 9) for ending in ("png", "svg")}
    assert names == figures | {
        ".parkproof", "summary.json", "trajectory.parquet", "scenario.toml",
        "path.png", "path.svg", "overview.png", "animation.gif",
    }  # fmt: skip
    first = json.loads((directory / "summary.json").read_text())
    again = directory.parent / "again"
    out = said(
        capsys, "park", directory / "scenario.toml", "--out", again, "--json", "--no-pictures"
    )
    assert out == (again / "summary.json").read_text()
    assert json.loads(out) == first


def test_check_tells_a_run_that_did_not_park_by_its_status(scenario, capsys):
    arguments = [
        "park",
        scenario,
        "--set",
        "run.duration=0.5",
        "--overwrite",
        "--quiet",
        "--no-pictures",
    ]
    assert said(capsys, *arguments, "--check", status=1) == ""
    assert said(capsys, *arguments, status=0) == ""
    summary = json.loads(Path("runs/short/summary.json").read_text())
    assert summary["outcome"] == "still moving"
    assert summary["scenario"]["run"]["duration"] == 0.5


def test_an_earlier_result_is_replaced_when_asked(scenario, capsys):
    arguments = ["park", scenario, "--out", "out", "--quiet", "--no-pictures", "--set"]
    said(capsys, *arguments, "run.duration=0.5")
    said(capsys, *arguments, "run.duration=0.6", "--overwrite")
    assert json.loads(Path("out/summary.json").read_text())["ended"] == 0.6


def test_notes_and_the_missing_guarantee_are_printed(scenario, capsys):
    scenario.write_text(SCENARIO.replace("[start]", "disturbance = 2.5\n[start]"))
    settings = ["--no-pictures", "--set", "truth.outside_bounds=true", "--set", "run.duration=0.5"]
    text = words(said(capsys, "park", scenario, *settings))
    assert "Note: tolerance[0]" in text
    assert "Assumptions outside the guarantee" in text


def test_reproduce_prints_the_claims_and_where_the_page_is(tmp_path, capsys, monkeypatch):
    import parkproof.report.reproduce as report

    asked = []

    def made(directory, *, laws, progress):
        progress("simulating", 0.5)
        asked.append(laws)
        (directory / "index.html").write_text("<p>")
        claim = {"claim": "All reach 0 by 35 s", "where": "Section 4", "measured": "x1 ends at 4.2"}
        return {"claims": [{**claim, "verdict": "fails"}]}

    monkeypatch.setattr(report, "reproduce", made)
    monkeypatch.chdir(tmp_path)
    text = said(capsys, "reproduce")
    assert "All reach 0 by 35 s" in words(text)
    assert "fails" in text
    assert "reproduction/index.html" in text
    said(capsys, "reproduce", "--law", "published", "--overwrite", "--quiet")
    assert asked == [("published", "corrected"), ("published",)]


@pytest.mark.usefixtures("here")
def test_check_shows_both_forms_of_every_condition(capsys):
    assert main(["init", "--out", "paper.toml"]) == 0
    capsys.readouterr()
    text = said(capsys, "check", "paper.toml")
    for name in ("(15)", "(16)", "(17)", "(18)", "(19)", "(18')", "(19')"):
        assert name in text
    assert "11.35" in text  # (16) as printed
    assert "9.547" in text  # (16) in the sharp form
    assert "(W G q p^2 l2)/k2" in text
    assert "the law does not use them" in words(text)
    assert "Step 2: not satisfied" in text
    said(capsys, "check", "paper.toml", "--check", status=1)


@pytest.mark.usefixtures("here")
def test_check_gives_the_same_numbers_to_programs(capsys):
    main(["init", "--out", "paper.toml"])
    capsys.readouterr()
    data = json.loads(said(capsys, "check", "paper.toml", "--json"))
    second = data["step2"]["printed"][1]
    assert second["name"] == "(16)"
    assert second["value"] == pytest.approx(11.35, abs=0.005)
    assert second["value"] == pytest.approx(sum(second["terms"].values()))
    assert data["holds"] == {"step2": False, "step3": False}


@pytest.fixture
def homogeneous(tmp_path, monkeypatch, capsys):
    pytest.importorskip("flint", reason="needs parkproof[proof]")
    monkeypatch.chdir(tmp_path)
    main(["init", "--kind", "homogeneous", "--out", "own.toml"])
    capsys.readouterr()
    return "own.toml"


def test_check_judges_the_homogeneous_law_by_its_matrix_inequality(homogeneous, capsys):
    text = words(said(capsys, "check", homogeneous))
    assert "Step 2: satisfied by the matrix inequality." in text
    assert "largest |tau2| 20, at every state" in text
    assert "(16)" not in text
    assert "(19')" in text
    data = json.loads(said(capsys, "check", homogeneous, "--json"))
    inequality = data["step2"]["matrix_inequality"]
    assert inequality["b1"] == pytest.approx([0.4995, 1.5015])  # |u0| is 1 up to the tolerance
    assert 0.12 < inequality["rate"] < 0.125  # the template's 8.1 s
    assert data["step2"]["largest_tau2"] == pytest.approx(20.0, abs=1e-3)
    assert data["holds"] == {"step2": True, "step3": False}
    assert "k" not in data["weights"]


def test_check_fails_where_the_homogeneous_law_is_too_weak_or_its_bounds_too_wide(
    homogeneous, capsys
):
    quiet = ["--set", "truth.outside_bounds=true", "--json"]
    step3 = ["--set", "gains.k=[1.5, 20]", "--set", "gains.q2=0.95"]
    strong = said(capsys, "check", homogeneous, *quiet, *step3, "--check")
    assert json.loads(strong)["holds"] == {"step2": True, "step3": True}
    for setting, dominated in (("bounds.disturbance=25", False), ("bounds.alpha=[0.1,3]", True)):
        weak = ["check", homogeneous, *quiet, *step3, "--set", setting]
        data = json.loads(said(capsys, *weak, "--check", status=1))
        assert data["step2"]["matrix_inequality"]["rate"] is None
        assert data["step2"]["disturbance_dominated"]["holds"] is dominated
        assert data["holds"] == {"step2": False, "step3": True}


def test_check_says_what_to_install_where_it_cannot_judge(homogeneous, capsys, monkeypatch):
    monkeypatch.setattr("parkproof.extras.find_spec", lambda _: None)
    text = words(said(capsys, "check", homogeneous))
    assert "Step 2: not judged" in text
    assert "pip install 'parkproof[proof]'" in text
    assert "Step 3: not satisfied" in text
    assert json.loads(said(capsys, "check", homogeneous, "--json"))["holds"]["step2"] is None
    assert main(["check", homogeneous, "--check"]) == 2
    assert "pip install" in capsys.readouterr().err


def test_check_takes_gains_of_a_design_with_their_range_of_b2(homogeneous, capsys):
    given = tomllib.loads(Path(homogeneous).read_text())["gains"]
    Path("gains.toml").write_text(
        'law = "homogeneous"\n[bounds]\nalpha = [0.5, 1.5]\nb2 = [1.0, 1.01]\n'
        "[starts]\nx0 = [-1.0, 1.0]\nx1 = [-0.5, 0.5]\nx2 = [0.0, 0.0]\n"
        f"[gains]\nellipsoid = {given['ellipsoid']}\nfeedback = {given['feedback']}\n"
        "[switching]\ntolerance = [0.1, 0.01, 0.01]\n"
    )
    inequality = json.loads(said(capsys, "check", "gains.toml", "--json"))["step2"]
    assert inequality["matrix_inequality"]["b2"] == [1.0, 1.01]
    assert inequality["matrix_inequality"]["b1"] == pytest.approx([0.45, 1.65])
    # and so of a scenario's
    given = ["check", homogeneous, "--set", "bounds.b2=[0.1,3]", "--json", "--check"]
    inequality = json.loads(said(capsys, *given, status=1))["step2"]["matrix_inequality"]
    assert inequality["b2"] == [0.1, 3.0]
    assert not inequality["holds"]
    Path("spec.toml").write_text("[bounds]\n[design]\n")
    assert main(["check", "spec.toml"]) == 2
    assert "no [gains] to check" in capsys.readouterr().err


def test_check_does_not_judge_a_b2_that_the_papers_conditions_leave_out(tmp_path, capsys):
    path = tmp_path / "gains.toml"
    path.write_text(
        '[bounds]\nalpha = [0.5, 1.5]\n[gains]\nq1 = "13/15"\nl = [0.79, 5.1, 206.0]\n'
        'q2 = "7/9"\nk = [1.0, 80.0]\n[weights]\nk = [3.2, 451.0]\nk_step3 = 12.0\n'
    )
    assert json.loads(said(capsys, "check", path, "--json"))["holds"]["step2"] is True
    other = ["check", path, "--set", "bounds.b2=[0.8,1.25]"]
    assert "not judged: (15)-(17) are about b2 = 1" in words(said(capsys, *other))
    assert json.loads(said(capsys, *other, "--json", "--check", status=1))["holds"]["step2"] is None


@pytest.mark.parametrize("form", ["printed", "sharp"])
def test_search_writes_gains_that_check_accepts_and_passes(form, tmp_path, capsys):
    path = tmp_path / "gains.toml"
    text = said(capsys, "search", "--q1", "13/15", "--form", form, "--out", path)
    assert "Remark 3 as printed" in text
    assert "does not terminate" in text
    assert "no slacks change that" in words(text)
    assert tomllib.loads(path.read_text())["gains"]["q1"] == "13/15"
    said(capsys, "check", path, "--check", status=0)
    smaller_l3 = ["--set", "gains.l[2]=4", "--check"]
    said(capsys, "check", path, *smaller_l3, status=1)


def test_search_gives_passes_gains_and_conditions_to_programs(capsys):
    data = json.loads(said(capsys, "search", "--json"))
    assert data["remark3"]["outcome"] == "does not terminate"
    assert data["remark3"]["passes"][0]["l"] == 4.5
    assert all(condition["holds"] for condition in data["sequential"]["conditions"])
    assert data["remark4"]["gains"]["k3_tilde"] == pytest.approx(10.84, abs=0.01)


@pytest.mark.usefixtures("here")
def test_init_lists_its_kinds_and_writes_each(capsys):
    from parkproof.scenario_file import TEMPLATES

    listed = said(capsys, "init", "--list")
    for kind in TEMPLATES:
        assert kind in listed
        text = said(capsys, "init", "--kind", kind)
        assert tomllib.loads(text)["law"]
    assert "paper.toml" in said(capsys, "init", "--out", "paper.toml")
    assert Path("paper.toml").read_text() == said(capsys, "init")


@pytest.mark.skipif(not Path("/dev/null").is_char_device(), reason="needs /dev/null")
def test_a_device_is_written_to_and_not_replaced(capsys):
    said(capsys, "init", "--out", "/dev/null")
    assert Path("/dev/null").is_char_device()


def test_what_is_counted_is_shown_on_a_terminal_with_rate_and_time_left(capsys, monkeypatch):
    from parkproof.cli.console import counted

    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "120")
    with counted("trials") as count:
        count(500, 2000)
        for done in (1000, 1500):
            time.sleep(0.01)
            count(done, 2000)
    shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", capsys.readouterr().err)
    assert "1,500 of 2,000 trials" in shown
    assert re.search(r"[\d,]+ trials/s 0:00:\d\d left", shown)


def test_the_schema_is_printed_as_json(capsys):
    assert "law" in json.loads(said(capsys, "schema"))["required"]


def test_citation_names_the_paper_and_this_version(capsys):
    text = said(capsys, "citation")
    assert "10.5772/59307" in text
    assert f"version = {{{__version__}}}" in text


def test_the_citation_file_agrees_with_the_program():
    text = (Path(__file__).parents[1] / "CITATION.cff").read_text()
    assert f"\nversion: {__version__}\n" in text
    assert "doi: 10.5772/59307" in text
    from parkproof.references import citation

    for line in text.splitlines():
        if line.strip().startswith("- family-names:"):
            assert line.split()[-1] in citation()


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell"])
def test_completion_knows_the_commands_and_their_options(shell, capsys):
    assert main(["completion", shell]) == 0
    text = capsys.readouterr().out
    assert "reproduce" in text
    assert "overwrite" in text


def test_completion_is_installed_where_the_shell_looks(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    assert str(tmp_path) in said(capsys, "completion", "bash", "--install")
    assert any(path.is_file() for path in tmp_path.rglob("*parkproof*"))


def test_help_shows_every_command_in_order_with_the_first_line_of_its_own_help(capsys):
    text = words(said(capsys).replace("│", " "))
    assert text == words(said(capsys, "--help").replace("│", " "))
    places = [text.index(f" {name} {line}") for name, line in COMMANDS.items()]
    assert places == sorted(places)
    for name, line in COMMANDS.items():
        own = words(said(capsys, name, "--help").replace("│", " "))
        assert line in own
        assert "Examples" not in own


def test_the_version_is_printed(capsys):
    assert said(capsys, "--version") == f"parkproof {__version__}\n"


def test_help_loads_nothing_that_takes_long():
    heavy = {
        "numpy",
        "numba",
        "matplotlib",
        "pyarrow",
        "PIL",
        "msgspec",
        "parkproof.simulation.run",
    }
    code = (
        "import sys, parkproof; assert not {'numpy', 'rich', 'cyclopts'} & set(sys.modules)\n"
        "from parkproof.cli import main; main(['--help'])\n"
        f"print(sorted({heavy!r} & set(sys.modules)))"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout.splitlines()[-1] == "[]"


def test_a_stopped_program_restores_the_handlers_of_its_caller():
    import signal

    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    main(["--version"])
    assert before == [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]


def test_every_command_is_a_module_of_its_name():
    folder = Path(parkproof.cli.__file__).parent
    assert all((folder / f"{name}.py").exists() for name in COMMANDS)


class Gone(io.StringIO):
    """A terminal that was closed."""

    def isatty(self) -> bool:
        return True

    def write(self, _text: str) -> int:
        raise OSError(errno.EIO, "Input/output error")

    def flush(self) -> None:
        self.write("")


def test_a_terminal_that_is_closed_does_not_end_what_is_done(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Gone())
    with progress() as report:
        report("driving", 0.5)
        time.sleep(0.2)  # the bar is drawn now and then
        report("driving", 0.9)


def test_a_signal_that_only_a_robot_takes_has_its_status_and_a_sentence(capsys):
    def stopped() -> int:
        error = SystemExit(131)
        error.add_note("what is sound of it is in out-broken-off: run.mcap")
        raise error

    assert guarded(stopped) == 131
    said = capsys.readouterr().err
    assert said.startswith("parkproof: stopped by SIGQUIT; ")
    assert "out-broken-off: run.mcap" in said
    with pytest.raises(SystemExit):
        guarded(lambda: sys.exit(3))


def test_ctrl_c_inside_a_finaliser_stops_a_moment_later_without_a_traceback(capsys):
    class Thing:
        """What a library may drop at any moment."""

    def command() -> int:
        thing = Thing()
        kept = weakref.ref(thing, lambda _: signal.raise_signal(signal.SIGINT))
        del thing  # Python only reports what is raised in the callback
        time.sleep(5.0)
        return 0 if kept() is None else 1

    assert guarded(command) == 130
    said = capsys.readouterr().err
    assert said.startswith("parkproof: stopped by Ctrl-C")
    assert said.count("\n") == 1
