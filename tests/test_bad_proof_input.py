"""What newcomers get wrong with design, certify and verify: one line, its status, nothing left."""

import re
import warnings
from pathlib import Path

import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")
pytest.importorskip("clarabel", reason="needs parkproof[proof]")

from parkproof.cli import main
from parkproof.laws.gains import Gains
from parkproof.proof.homogeneous_rate import proven_rate

SPEC = """\
[bounds]
alpha = [0.9, 1.1]
[limits]
tau = [30.0, 30.0]
[starts]
x0 = [-0.2, 0.2]
x1 = [-0.1, 0.1]
x2 = [0.0, 0.0]
[design]
engine = "homogeneous"
control_period = 0.005
"""


def never(*_, **__):
    raise AssertionError("long work was begun")


@pytest.fixture
def spec(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = Path("spec.toml")
    path.write_text(SPEC)
    return path


def answered(capsys, *arguments, status=2):
    """Call the command, and return its one line."""
    assert main([str(argument) for argument in arguments]) == status
    out, err = capsys.readouterr()
    said = err if status == 2 else out
    assert said.count("\n") == 1
    assert (out if status == 2 else err) == ""
    assert sorted(path.name for path in Path().iterdir() if path.suffix != ".json") == ["spec.toml"]
    return said


@pytest.mark.parametrize(
    ("setting", "saying"),
    [
        ("limits.tau=[1e300,1e300]", "tau.*within 1e\\+09"),
        ("design.control_period=100", "control_period = 100.*between 1e-05 and 1"),
        ("design.control_period=1e-9", "control_period = 1e-09.*between"),
        ("design.latency=1e9", "latency.*between 0 and 1"),
        ("design.noise=1e9", "noise.*between 0 and 1000"),
        ("bounds.alpha='wide'", r"\[bounds\] alpha: expected"),
    ],
)
def test_numbers_that_no_run_could_use_are_refused_before_the_search(
    setting, saying, spec, capsys, monkeypatch
):
    monkeypatch.setattr("parkproof.proof.design.design", never)
    assert re.search(saying, answered(capsys, "design", spec, "--set", setting))


@pytest.mark.parametrize(
    ("setting", "saying"),
    [
        ("bounds.disturbance=1e300", "disturbance.*between 1e-09 and 1e"),
        ("bounds.alpha=[1e-9,1e9]", "no Lyapunov function.*so wide a range; narrow it"),
    ],
)
def test_bounds_beyond_any_proof_have_no_design(setting, saying, spec, capsys):
    said = answered(capsys, "design", spec, "--set", setting, status=1)
    assert said.startswith("Nothing is proved: ")
    assert re.search(saying, said)


def test_an_effort_without_end_is_refused(spec, capsys):
    assert "at most 1000" in answered(capsys, "design", spec, "--effort", "1e300")


def test_numbers_beyond_floats_prove_no_rate():
    gains = Gains(ellipsoid=(2.0, 1.5, 0.25, 2.0, 0.5, 0.25), feedback=(-8.0, -8.0, -4.0))
    assert proven_rate(gains.ellipsoid, gains.feedback, b1=(1.0, 1.0), disturbance=1e300) is None


def test_missing_and_empty_specifications_are_pointed_to_a_template(spec, capsys):
    spec.write_text("")
    assert "parkproof init --kind design" in answered(capsys, "design", spec)
    missing = answered(capsys, "design", "nowhere.toml")
    assert "parkproof init --kind design --out nowhere.toml" in missing


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs a folder that takes no files")
def test_a_certificate_that_cannot_be_written_is_refused_before_the_proof(
    spec, capsys, monkeypatch
):
    monkeypatch.setattr("parkproof.proof.whole_run.certify", never)
    spec.write_text(SPEC + "[gains]\n")
    assert "cannot use /proc/c.json" in answered(capsys, "certify", spec, "--out", "/proc/c.json")


@pytest.mark.parametrize(
    ("content", "saying"),
    [
        (b"", "not JSON"),
        (b"plain words", "not JSON"),
        (b"\xff\xfe", "not UTF-8"),
        (b"[" * 200_000, "nested too deeply"),
        (b"{}", "not a parkproof-certificate-1"),
    ],
)
def test_files_that_are_no_certificate_are_refused_with_what_to_name(content, saying, spec, capsys):
    Path("some.json").write_bytes(content)
    said = answered(capsys, "verify", "some.json")
    assert saying in said
    assert "name a certificate.json" in said
    assert "Is a directory" in answered(capsys, "verify", spec.resolve().parent)


def test_a_search_stopped_before_it_found_anything_says_so(spec, capsys, monkeypatch):
    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("parkproof.proof.design.two_chain_link", stopped)
    said = answered(capsys, "design", spec, status=130)
    assert said == (
        "Interrupted: nothing is proved: the search was stopped before it found any gains.\n"
    )


def test_an_effort_that_is_no_power_of_two_warns_of_nothing(spec, capsys):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tight = ["--set", "limits.view=[-0.21, 0.21, -2.0, 2.0]", "--effort", "0.19"]
        assert "limits.view" in answered(capsys, "design", spec, *tight, status=1)
