"""Without an extra, or with one alone, commands do what documents say, or what to install."""

import re
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

PROJECT = tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text())["project"]
OF_USERS = {"proof", "campaign", "cluster", "lab"}

WITHOUT = """
import sys
sys.modules.update(dict.fromkeys({missing!r}))
from parkproof.cli import main
sys.exit(main(sys.argv[1:]))
"""


def modules_of(extra: str) -> set[str]:
    """What an extra brings, by the names under which it is imported."""
    names = {re.split(r"[^\w-]", each)[0] for each in PROJECT["optional-dependencies"][extra]}
    found = packages_distributions().items()
    return {module for module, owners in found if names & {each.lower() for each in owners}}


def called(extra: str, folder: Path, command: str) -> subprocess.CompletedProcess[str]:
    """A command, where what other extras bring is not installed."""
    optional = set().union(*map(modules_of, OF_USERS))
    here = modules_of(extra) if extra else set()
    code = WITHOUT.format(missing=sorted(optional - here))
    line = [sys.executable, "-c", code, *command.split()]
    return subprocess.run(line, check=False, capture_output=True, text=True, cwd=folder)


def test_what_extras_bring_is_found_by_its_name() -> None:
    assert {"flint", "scipy", "clarabel"} <= modules_of("proof")
    assert modules_of("campaign") == {"scipy"}
    assert "distributed" in modules_of("cluster")
    assert {"mujoco", "cv2", "av", "mcap"} <= modules_of("lab")


@pytest.mark.parametrize(
    ("extra", "commands"),
    [
        (
            "",
            (
                ("init --out s.toml", 0, "s.toml"),
                ("park s.toml --out run --set run.duration=1 --quiet", 0, "run/summary.json"),
                ("check s.toml", 0, ""),
                ("schema", 0, ""),
            ),
        ),
        (
            "campaign",
            (
                ("init --kind campaign --out c.toml", 0, "c.toml"),
                ("campaign c.toml --out r --trials 64 --set run.duration=1 --quiet", 0,
                 "r/report.html"),
                ("replay r 3 --quiet", 0, "runs/r-3/summary.json"),
                ("init --out s.toml", 0, "s.toml"),
                ("falsify s.toml --runs 64 --set run.duration=1 --quiet", 1, "falsified.toml"),
            ),
        ),
        (
            "cluster",
            (
                ("init --kind campaign --out c.toml", 0, "c.toml"),
                ("campaign c.toml --out r --trials 64 --set run.duration=1 --quiet", 0,
                 "r/report.html"),
            ),
        ),
        (
            "proof",
            (
                ("init --kind homogeneous --out s.toml", 0, "s.toml"),
                ("check s.toml", 0, ""),
                ("certify s.toml --set switching.hysteresis=14 --out c.json --quiet", 0, "c.json"),
                ("verify c.json", 0, ""),
            ),
        ),
        ("lab", (("lab --set duration=0.5 --out seen --quiet", 0, "seen/run.mcap"),)),
    ],
)  # fmt: skip
def test_an_extra_is_enough_for_its_commands(
    tmp_path: Path, extra: str, commands: tuple[tuple[str, int, str], ...]
) -> None:
    for command, status, written in commands:
        done = called(extra, tmp_path, command)
        assert (done.returncode, "Traceback" in done.stderr) == (status, False), (command, done)
        assert (tmp_path / written).exists(), command


@pytest.mark.parametrize(
    ("command", "wanted"),
    [
        ("campaign c.toml --out r", "campaign"),
        ("falsify s.toml", "campaign"),
        ("certify s.toml", "proof"),
        ("design s.toml", "proof"),
        ("verify c.json", "proof"),
        ("lab", "lab"),
    ],
)
def test_without_its_extra_a_command_says_what_to_install(
    tmp_path: Path, command: str, wanted: str
) -> None:
    called("", tmp_path, "init --out s.toml")
    called("", tmp_path, "init --kind campaign --out c.toml")
    (tmp_path / "c.json").write_text("{}")
    done = called("", tmp_path, command)
    assert done.returncode == 2
    assert f"pip install 'parkproof[{wanted}]'" in " ".join(done.stderr.split()), done.stderr
