"""Without an extra, or with one alone, commands do what documents say, or what to install."""

import subprocess
import sys
from pathlib import Path

import pytest

EXTRAS = {
    "core": set(),
    "proof": {"flint", "scipy", "clarabel"},
    "campaign": {"scipy"},
    "cluster": {"scipy", "distributed", "dask"},
    "lab": {"mujoco", "pyapriltags", "cv2", "av", "mcap", "mcap_ros2"},
}
OPTIONAL = set().union(*EXTRAS.values())

WITHOUT = """
import sys
sys.modules.update(dict.fromkeys({missing!r}))
from parkproof.cli import main
sys.exit(main(sys.argv[1:]))
"""


def called(extra: str, folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    """A command, where what other extras bring is not installed."""
    code = WITHOUT.format(missing=sorted(OPTIONAL - EXTRAS[extra]))
    line = [sys.executable, "-c", code, *command]
    return subprocess.run(line, check=False, capture_output=True, text=True, cwd=folder)


@pytest.mark.parametrize(
    ("extra", "commands"),
    [
        (
            "core",
            (
                "init --out s.toml",
                "park s.toml --out run --set run.duration=1 --quiet",
                "check s.toml",
                "schema",
            ),
        ),
        (
            "campaign",
            (
                "init --kind campaign --out c.toml",
                "campaign c.toml --out r --trials 64 --set run.duration=1 --quiet",
                "replay r 3 --quiet",
                "init --out s.toml",
                "falsify s.toml --runs 64 --set run.duration=1 --quiet",
            ),
        ),
        (
            "proof",
            (
                "init --kind corrected --out s.toml",
                "certify s.toml --out c.json --quiet",
            ),
        ),
    ],
)
def test_an_extra_is_enough_for_its_commands(
    tmp_path: Path, extra: str, commands: tuple[str, ...]
) -> None:
    for command in commands:
        done = called(extra, tmp_path, *command.split())
        assert done.returncode in (0, 1), (command, done.stderr[-2000:])
        assert "Traceback" not in done.stderr, command


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
    called("core", tmp_path, "init", "--out", "s.toml")
    called("core", tmp_path, "init", "--kind", "campaign", "--out", "c.toml")
    (tmp_path / "c.json").write_text("{}")
    done = called("core", tmp_path, *command.split())
    assert done.returncode == 2
    assert f"pip install 'parkproof[{wanted}]'" in " ".join(done.stderr.split()), done.stderr
