"""What a newcomer reads is true: examples run, names exist, tables agree with the code."""

import ast
import importlib
import inspect
import json
import os
import pkgutil
import re
import shlex
import stat
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from types import ModuleType

import matplotlib
import pytest

import parkproof
from parkproof.cli import main
from parkproof.scenario_file.schema import scenario_schema

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "parkproof"
README = ROOT / "README.md"
PAGES = [README, *sorted((ROOT / "docs").glob("*.md"))]

Rows = list[list[str]]


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of a language on a page."""
    text = page.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)


def tables(text: str) -> Iterator[tuple[str, Rows]]:
    """Each table of a page under its heading: (heading, rows of cells, the head left out)."""
    for part in re.split(r"^#+ ", text, flags=re.MULTILINE):
        heading, _, body = part.partition("\n")
        lines = [line for line in body.splitlines() if line.startswith("|")]
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
        if rows:
            yield heading, rows[2:]


# ------------------------------------------------------------------------------- examples


def test_python_blocks_of_the_readme_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(matplotlib, "rcParams", matplotlib.rcParams.copy())
    (block,) = blocks(README, "python")
    assert len(block.split("\n")) <= 11, "ten lines of Python"
    exec(compile(block, "README.md", "exec"), {})
    assert capsys.readouterr().out.startswith("The robot reached the goal")
    assert (tmp_path / "run.png").stat().st_size > 10_000


def test_commands_of_the_readme_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (block,) = blocks(README, "console")
    for line in block.splitlines():
        program, *arguments = shlex.split(line)
        assert (program, main(arguments)) == ("parkproof", 0)
    assert "parked" in capsys.readouterr().out
    assert (tmp_path / "runs" / "parking" / "path.png").exists()
    summary = json.loads((tmp_path / "runs" / "parking" / "summary.json").read_text("utf-8"))
    assert summary["outcome"] == "parked"


def test_every_command_that_the_pages_name_exists(capsys: pytest.CaptureFixture[str]) -> None:
    named = {
        name
        for page in PAGES
        for name in re.findall(r"`parkproof ([a-z]+)", page.read_text("utf-8"))
    }
    assert {"park", "init", "check", "search", "citation"} <= named
    for name in sorted(named):
        assert main([name, "--help"]) == 0, name
    assert "Usage" in capsys.readouterr().out


def test_the_smallest_scenario_is_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (block,) = blocks(ROOT / "docs" / "scenario.md", "toml")
    file = tmp_path / "smallest.toml"
    file.write_text(block, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["park", str(file), "--quiet", "--check", "--no-pictures"]) == 0


# ------------------------------------------------------------------------------- the two commands


def test_set_up_is_two_lines_and_ci_runs_the_second() -> None:
    reproduce, tests = (block.rstrip("\n") for block in blocks(README, "sh"))
    assert "\n" not in reproduce + tests
    for line in (reproduce, tests):
        assert line.startswith("python3 -m venv .venv && .venv/bin/pip install ")
    assert reproduce.endswith("&& .venv/bin/parkproof reproduce --overwrite --out reproduction")
    assert tests.endswith("&& .venv/bin/pytest")
    script = ROOT / ".ci" / "run"
    taken = re.search(
        r"^command=\$\(grep -m 1 '(.+)' README\.md\)$", script.read_text("utf-8"), re.M
    )
    assert taken is not None
    readme = README.read_text("utf-8").splitlines()
    assert next(line for line in readme if re.search(taken[1], line)) == tests
    assert script.read_text("utf-8").endswith('\neval "$command"\n')


@pytest.mark.skipif(os.name != "posix", reason="executable bits are POSIX")
def test_ci_script_is_executable() -> None:
    assert (ROOT / ".ci" / "run").stat().st_mode & stat.S_IXUSR


# ------------------------------------------------------------------------------- pages


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    text = page.read_text("utf-8")
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert (page.parent / target).exists(), target
    for anchor in re.findall(r"\]\(#([^)]+)\)", text):
        headings = [line.lstrip("# ") for line in text.splitlines() if line.startswith("#")]
        assert anchor in [heading.lower().replace(" ", "-") for heading in headings]


def test_every_page_is_linked_from_the_readme() -> None:
    text = README.read_text("utf-8")
    for page in PAGES[1:]:
        assert f"(docs/{page.name})" in text


def test_every_picture_is_shown_and_small() -> None:
    shown = {
        (page.parent / target).resolve()
        for page in PAGES
        for target in re.findall(r"!\[[^\]]+\]\(([^)]+)\)", page.read_text("utf-8"))
    }
    there = {path.resolve() for path in (ROOT / "docs" / "pictures").iterdir()}
    assert shown == there
    assert all(path.stat().st_size < 200_000 for path in there)


def names_in(test_file: Path) -> set[str]:
    """The test functions of a file."""
    tree = ast.parse(test_file.read_text("utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_tests_and_files_that_a_page_names_exist(page: Path) -> None:
    text = page.read_text("utf-8")
    for file, name in re.findall(r"(test_\w+\.py)::(\w+)", text):
        assert name in names_in(ROOT / "tests" / file), f"{file}::{name}"
    for name in re.findall(r"`([\w/]+\.(?:py|pyi|md|json|toml))`", text):
        places = (ROOT, SOURCE, ROOT / "tests", ROOT / "docs")
        made = {"summary.json", "scenario.toml", "gains.toml", "certificate.json", "goal.json"}
        made.add("campaign.json")
        assert name in made or any((place / name).exists() for place in places), name


def test_every_row_of_the_validation_table_is_whole() -> None:
    text = (ROOT / "docs" / "validation.md").read_text("utf-8")
    rows = [row for _, found in tables(text) for row in found]
    assert len(rows) > 40
    words = ("tested", "sampled", "measured", "damaged scan", "the formula", "proved by machine")
    for component, _, code, tests, status in rows:
        assert component
        paths = re.findall(r"`([^`]+)`", code)
        assert paths, component
        assert all((SOURCE / path).is_file() for path in paths), component
        assert re.fullmatch(r"(`test_\w+\.py::\w+`(, )?)+", tests), component
        assert status.startswith(words), component


# ------------------------------------------------------------------------------- the scenario file


def documented_keys() -> dict[str, Rows]:
    """Keys of docs/scenario.md by the name of the structure in the schema."""
    structures = {
        "Top level": "", "[bounds]": "Bounds", "[gains]": "Gains", "[weights]": "Weights",
        "[truth]": "Truth", '"constant"': "Constant", '"sine"': "Sine", '"square"': "Square",
        '"switched"': "Switched", '"noise"': "Noise", '"pinhole"': "PinholeTable",
        '"homography"': "HomographyTable",
        "[robot]": "Robot", "[start]": "Start", "[switching]": "Switching", "[run]": "RunSettings",
        "[limits]": "Limits",
    }  # fmt: skip
    text = (ROOT / "docs" / "scenario.md").read_text("utf-8")
    return {structures[heading.removeprefix("kind = ")]: rows for heading, rows in tables(text)}


def test_the_scenario_page_has_every_key_with_its_default() -> None:
    schema = scenario_schema()
    documented = documented_keys()
    tables_of_the_file = schema["$defs"] | {"": schema}
    assert set(documented) | {"Adversary"} == set(tables_of_the_file)
    for name, rows in documented.items():
        known = dict(tables_of_the_file[name]["properties"])
        known = {key: value for key, value in known.items() if "$ref" not in value}
        if name != "Robot":
            known.pop("kind", None)  # in the heading
        known.pop("camera", None)
        assert {row[0].strip("`") for row in rows} == set(known), name
        for key, _, default, *_ in rows:
            place, given = f"{name}.{key}", known[key.strip("`")]
            required = key.strip("`") in tables_of_the_file[name].get("required", ())
            assert (default == "required") == required, place
            stated = given.get("default")
            if stated is not None and not any(isinstance(x, dict) for x in listed(stated)):
                assert json.loads(default.strip("`")) == plain(stated), place


def listed(value: object) -> list[object]:
    return list(value) if isinstance(value, list | tuple) else [value]


def plain(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value


# ------------------------------------------------------------------------------- the code


def imports_of(file: Path) -> Iterator[str]:
    """Top-level parts of parkproof that a module imports, wherever in it."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module == "parkproof":
            yield from (alias.name for alias in node.names if alias.name != "__version__")
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("parkproof."):
            yield (node.module or "").split(".")[1]


def test_no_module_imports_upward() -> None:
    (rows,) = [rows for heading, rows in tables((ROOT / "docs/layout.md").read_text("utf-8"))]
    layers = [re.findall(r"`(\w+)`", row[1]) for row in rows]
    place = {name: i for i, names in enumerate(layers) for name in names}
    there = {path.stem for path in SOURCE.iterdir() if path.suffix == ".py" or path.is_dir()}
    assert set(place) == there - {"__init__", "__pycache__"}
    for file in SOURCE.rglob("*.py"):
        own = file.relative_to(SOURCE).parts[0].removesuffix(".py")
        for imported in imports_of(file):
            assert own == "__init__" or place[imported] <= place[own], f"{own} → {imported}"


MODULES = [
    name
    for _, name, _ in pkgutil.walk_packages(parkproof.__path__, "parkproof.")
    if name != "parkproof.__main__"
]


def public_members(module: ModuleType) -> Iterator[tuple[str, object]]:
    """Public functions and classes that a module defines, and the classes' public methods."""
    for name, thing in vars(module).items():
        if name.startswith("_") or getattr(thing, "__module__", None) != module.__name__:
            continue
        if inspect.isfunction(thing) or inspect.isclass(thing):
            yield name, thing
        if inspect.isclass(thing):
            for method, function in vars(thing).items():
                if inspect.isfunction(function) and not method.startswith("_"):
                    yield f"{name}.{method}", function


def documented_parameters(doc: str) -> set[str]:
    """Names under Parameters or Attributes of a NumPy docstring."""
    names: set[str] = set()
    for section in ("Parameters", "Attributes"):
        _, _, rest = doc.partition(f"{section}\n{'-' * len(section)}\n")
        for line in rest.partition("\n\n")[0].splitlines():
            if line and not line.startswith(" "):
                names.update(line.partition(" : ")[0].split(", "))
    return names


COMPILED = ("parkproof.simulation.lanes.", "parkproof.simulation.gpu.kernel")
"""Parts of kernels, which compiled code calls; their parameters are those of the buffer module."""


def parameters_of(thing: object) -> set[str]:
    """Parameters that a caller gives."""
    try:
        signature = inspect.signature(thing)  # type: ignore[arg-type]  # a function or a class
    except ValueError:
        return set()
    kinds = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    return {
        name
        for name, parameter in signature.parameters.items()
        if name not in {"self", "cls"} and not name.startswith("_") and parameter.kind not in kinds
    }


@pytest.mark.parametrize("name", MODULES)
def test_everything_public_is_documented(name: str) -> None:
    module = importlib.import_module(name)
    assert module.__doc__, "a module says what its one idea is"
    for member, thing in public_members(module):
        doc = inspect.getdoc(thing)
        assert doc, member
        compiled = name.startswith(COMPILED)
        if inspect.isfunction(thing) and "." not in member and not compiled:
            assert parameters_of(thing) <= documented_parameters(doc), member


def test_public_names_are_listed_once_and_document_every_parameter() -> None:
    stub = (SOURCE / "__init__.pyi").read_text("utf-8")
    names = list(dir(parkproof))
    assert sorted(set(names) - {"__version__"}) == sorted(re.findall(r"\b(\w+) as \1\b", stub))
    for name in names:
        thing = getattr(parkproof, name)
        if isinstance(thing, str):
            continue
        doc = inspect.getdoc(thing) or ""
        assert "Examples\n" in doc or inspect.isclass(thing), f"{name} has no example"
        if not (inspect.isclass(thing) and issubclass(thing, Enum)):
            assert parameters_of(thing) <= documented_parameters(doc), name
        methods = vars(thing).items() if inspect.isclass(thing) else ()
        for method, function in methods:
            if inspect.isfunction(function) and not method.startswith("_"):
                words = re.findall(r"\w+", inspect.getdoc(function) or "")
                assert parameters_of(function) <= set(words), f"{name}.{method}"


def lines_of_code(file: Path) -> int:
    """Lines that are neither blank nor comment nor docstring."""
    text = file.read_text("utf-8")
    strings = [
        range(node.lineno, (node.end_lineno or node.lineno) + 1)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    ]
    documentation = {line for lines in strings for line in lines}
    return sum(
        1
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.strip().startswith("#") and number not in documentation
    )


def test_no_module_is_long() -> None:
    long = {path.name: lines_of_code(path) for path in SOURCE.rglob("*.py")}
    assert {name: count for name, count in long.items() if count > 300} == {}


def tracked_files() -> Iterator[Path]:
    """Files of the repository, without what tools leave behind."""
    # in a linked working tree .git is a file, which says where the repository is
    yield from (path for path in ROOT.iterdir() if path.is_file() and path.name != ".git")
    for folder in ("src", "tests", "docs", "benchmarks", ".ci"):
        for path in (ROOT / folder).rglob("*"):
            if (
                path.is_file()
                and "__pycache__" not in path.parts
                and path.suffix not in {".png", ".jpg"}
            ):
                yield path


def test_no_file_names_a_download_host_or_a_place_on_a_machine() -> None:
    forbidden = re.compile(
        r"https?://\S*/simple\b|https?://\S+\.(?:whl|tar\.gz|tgz|deb)\b|index[-]url"
        r"|(?<![\w.:/])/(?:home|root|work|Users|mnt)/\w"
    )
    for path in tracked_files():
        if path != Path(__file__):
            found = forbidden.search(path.read_text("utf-8"))
            assert found is None, f"{path}: {found}"
