"""Writing a scenario out: as plain tables, and as TOML."""

import json
from collections.abc import Collection
from typing import Any

import msgspec

from parkproof.scenario import Scenario


def resolved(scenario: Scenario) -> dict[str, Any]:
    """Give a scenario as plain tables, with every default filled in: what repeats a run.

    Parameters
    ----------
    scenario : Scenario
        Any.

    Returns
    -------
    dict
        Dicts, lists, numbers, strings and booleans only; an exponent is a ratio such as "9/11".
        `scenario_from_dict` makes an equal scenario of it.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> resolved(Scenario(law="corrected", start=Start(pose=(0.0, 0.0, 0.0))))["gains"]["q1"]
    '9/11'
    """
    builtins: dict[str, Any] = _without_none(msgspec.to_builtins(scenario, enc_hook=str))
    return builtins


def to_toml(scenario: Scenario) -> str:
    """Write a scenario as a file that `read_scenario` reads, with every default filled in.

    Parameters
    ----------
    scenario : Scenario
        Any.

    Returns
    -------
    str
        TOML.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> print(to_toml(Scenario(law="corrected", start=Start(pose=(-2.0, 0.3, 0.1)))))
    title = ""
    law = "corrected"
    <BLANKLINE>
    [bounds]
    alpha = [[1.0, 1.0], [1.0, 1.0]]
    ...
    """
    return toml_of(scenario)


def toml_of(struct: msgspec.Struct, *, leave_out: Collection[str] = ()) -> str:
    """Write any structure of tables as TOML, with every default filled in.

    Parameters
    ----------
    struct : msgspec.Struct
        Its fields are values or structures of values.
    leave_out : collection of str
        Fields that are not written.

    Returns
    -------
    str
        TOML.

    Examples
    --------
    >>> from parkproof.scenario import RunSettings
    >>> print(toml_of(RunSettings(duration=3.0)).splitlines()[0])
    duration = 3.0
    """
    plain: dict[str, Any] = _without_none(msgspec.to_builtins(struct, enc_hook=str))
    data = {key: value for key, value in plain.items() if key not in leave_out}
    tables = {key: value for key, value in data.items() if isinstance(value, dict)}
    blocks = [[f"{key} = {_toml(value)}" for key, value in data.items() if key not in tables]]
    for name, table in tables.items():
        if table:
            keys = (f"{key} = {_toml(value)}" for key, value in table.items())
            blocks.append([f"[{name}]", *keys])
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def _toml(value: object) -> str:
    """Write one value; keys are names of fields and need no quotes."""
    if isinstance(value, dict):
        pairs = ", ".join(f"{key} = {_toml(inner)}" for key, inner in value.items())
        return f"{{ {pairs} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(_toml(inner) for inner in value)}]"
    if isinstance(value, str):
        # A TOML basic string is a JSON string, but for DEL, which TOML wants escaped.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _without_none(value: Any) -> Any:
    """Leave out optional keys that were not given: TOML has no null."""
    if isinstance(value, dict):
        return {key: _without_none(inner) for key, inner in value.items() if inner is not None}
    if isinstance(value, list | tuple):
        return [_without_none(inner) for inner in value]
    return value
