"""Reading scenario files and files of gains."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar

import msgspec

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.laws.gains import Gains, Switching
from parkproof.scenario import Scenario, Weights
from parkproof.scenario_file.errors import sentence
from parkproof.scenario_file.overrides import apply_overrides
from parkproof.scenario_file.toml import load_toml
from parkproof.scenario_file.words import plain

_Struct = TypeVar("_Struct", bound=msgspec.Struct)


class GainsFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What `parkproof check` needs: bounds, gains, weights and tolerances, without a run.

    Parameters
    ----------
    bounds : Bounds
        What the controller may know.
    gains : Gains
        The gains to check.
    weights : Weights
        Weights of the Lyapunov functions; default the paper's.
    switching : Switching
        When the law switches; the tolerance of Step 1 is used where the law is homogeneous.
    law : "published", "corrected" or "homogeneous", optional
        The law, if the file names one.
    title : str
        For reports.

    Examples
    --------
    >>> GainsFile(bounds=Bounds(alpha=(0.5, 1.5)), gains=Gains()).weights.k
    (2.4, 17.5)
    """

    bounds: Bounds
    gains: Gains
    weights: Weights = Weights()
    switching: Switching = Switching()
    law: Literal["published", "corrected", "homogeneous"] | None = None
    title: str = ""

    def __post_init__(self) -> None:
        if self.law is not None:
            self.gains.check_law(self.law)


def read_scenario(path: Path, *, overrides: Sequence[str] = ()) -> Scenario:
    r"""Read a scenario file.

    Parameters
    ----------
    path : Path
        A TOML file; `parkproof.scenario_file.template` gives examples with every key explained.
    overrides : sequence of str
        Expressions ``key=value`` with dotted keys, such as ``run.duration=10`` or
        ``truth.gamma[0].mean=1.5``, applied before anything is checked.

    Returns
    -------
    Scenario
        Checked.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or is no valid scenario.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "scenario.toml"
    ...     _ = path.write_text('law = "corrected"\n[start]\npose = [-2.0, 0.3, 0.1]\n')
    ...     read_scenario(path, overrides=["run.duration=10"]).run.duration
    10.0
    """
    data = load_toml(Path(path))
    apply_overrides(data, overrides, Scenario)
    return scenario_from_dict(data, where=named_with(path, overrides))


def scenario_from_dict(data: Mapping[str, Any], *, where: str) -> Scenario:
    """Make a scenario of plain tables, lists, numbers and strings.

    Parameters
    ----------
    data : mapping
        Keys as in a scenario file.
    where : str
        What a message calls the data: the file's name.

    Returns
    -------
    Scenario
        Checked.

    Raises
    ------
    InputError
        If it is no valid scenario.

    Examples
    --------
    >>> scenario_from_dict({"law": "corrected", "start": {"pose": [0, 0, 0]}}, where="example").law
    'corrected'
    """
    return converted(data, Scenario, where)


def read_gains_file(path: Path, *, overrides: Sequence[str] = ()) -> GainsFile:
    r"""Read bounds, gains and weights from a scenario, or from a file that holds only them.

    Parameters
    ----------
    path : Path
        A scenario file, or a TOML file with ``[bounds]``, ``[gains]`` and, optionally,
        ``[weights]``, ``[switching]`` and ``law``.
    overrides : sequence of str
        As for `read_scenario`.

    Returns
    -------
    GainsFile
        Checked; where there are no weights, the paper's.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or lacks bounds or gains.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "gains.toml"
    ...     _ = path.write_text('[bounds]\nalpha = [0.5, 1.5]\n[gains]\nq1 = "13/15"\n')
    ...     str(read_gains_file(path).gains.q1)
    '13/15'
    """
    data = load_toml(Path(path))
    apply_overrides(data, overrides, Scenario)
    where = named_with(path, overrides)
    only_in_scenarios = set(Scenario.__struct_fields__) - set(GainsFile.__struct_fields__)
    if not only_in_scenarios & set(data):
        return converted(data, GainsFile, where)
    scenario = scenario_from_dict(data, where=where)
    return GainsFile(
        bounds=scenario.bounds,
        gains=scenario.gains,
        weights=scenario.weights or Weights(),
        switching=scenario.switching,
        law=scenario.law,
        title=scenario.title,
    )


def converted(data: Mapping[str, Any], struct: type[_Struct], where: str) -> _Struct:
    """Convert plain tables to a structure and check them, with a message for a user.

    Parameters
    ----------
    data : mapping
        Tables, lists, numbers and strings.
    struct : type
        A msgspec structure.
    where : str
        What a message calls the data.

    Returns
    -------
    object
        One of the structure.

    Raises
    ------
    InputError
        If a key or value is not the structure's.

    Examples
    --------
    >>> converted({"alpha": [0.5, 1.5]}, Bounds, "example").alpha_of(1)
    (0.5, 1.5)
    """
    try:
        return msgspec.convert(data, struct)
    except msgspec.ValidationError as error:
        raise InputError(f"{where}: {sentence(error, data, struct)}") from error


def named_with(path: Path, overrides: Sequence[str]) -> str:
    """Name a file and what was set beside it.

    Parameters
    ----------
    path : Path
        The file.
    overrides : sequence of str
        What was set.

    Returns
    -------
    str
        For a message.

    Examples
    --------
    >>> named_with(Path("a.toml"), ["run.duration=3"])
    'a.toml with --set run.duration=3'
    """
    settings = "".join(f" --set {plain(expression)}" for expression in overrides)
    return f"{path} with{settings}" if settings else str(path)
