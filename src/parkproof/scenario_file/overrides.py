"""Overrides of a scenario file from the command line: ``--set run.duration=10``."""

import tomllib
from collections.abc import Sequence
from typing import Any

from parkproof.errors import InputError
from parkproof.scenario_file.keys import (
    Place,
    dotted,
    item,
    known_keys,
    nearest_place,
    parse_place,
    types_at,
)
from parkproof.scenario_file.words import plain

_REPLACED: dict[Place, tuple[str, ...]] = {
    ("start", "state"): ("pose", "velocity"),
    ("start", "pose"): ("state",),
}
"""Keys that cannot stand beside one that is set."""


def apply_overrides(data: dict[str, Any], overrides: Sequence[str], root: type) -> None:
    """Write overrides into the contents of a file, in place.

    Parameters
    ----------
    data : dict
        What the file holds.
    overrides : sequence of str
        Expressions ``key=value`` with dotted keys and indices. The value is read as TOML, and as
        a plain string where it is not TOML. A start's state takes the place of its pose and
        velocity, and the other way round.
    root : type
        The structure that the file should have.

    Raises
    ------
    InputError
        If an expression has no "=", its key is unknown, or it goes into what the file does not
        hold as a table or a list.

    Examples
    --------
    >>> from parkproof.scenario import Scenario
    >>> data = {"gains": {"l": [2.0, 4.2, 21.0]}}
    >>> apply_overrides(data, ["gains.l[2]=25", "law=corrected"], Scenario)
    >>> data
    {'gains': {'l': [2.0, 4.2, 25]}, 'law': 'corrected'}
    """
    for expression in overrides:
        key, equals, text = expression.partition("=")
        place = parse_place(key.strip())
        if not equals or not place:
            raise InputError(
                f"--set {plain(expression)}: needs key=value, for example --set run.duration=35"
            )
        _check_known(place, key.strip(), root)
        for other in _REPLACED.get(place, ()):
            start = data.get("start")
            if isinstance(start, dict):
                start.pop(other, None)
        _put(data, place, _value(text.strip()), f"--set {plain(expression)}")


def _value(text: str) -> Any:
    """Read a TOML value, or take the text as it is."""
    try:
        read = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return read["value"] if len(read) == 1 else text


def _check_known(place: Place, key: str, root: type) -> None:
    """Raise if no scenario file can hold this place, and name the nearest that it can."""
    for end in range(1, len(place) + 1):
        if types_at(root, place[:end]):
            continue
        near = nearest_place(root, place[:end])
        if near is not None:
            remedy = f"did you mean {dotted((*near, *place[end:]))}?"
        elif known := known_keys(types_at(root, place[: end - 1])):
            remedy = f"known keys: {', '.join(known)}"
        else:
            remedy = f"set {dotted(place[: end - 1])} as a whole"
        lacking = "no such element" if isinstance(place[end - 1], int) else "unknown key"
        raise InputError(f"--set {key}: {lacking}; {remedy}")


def _put(data: dict[str, Any], place: Place, value: Any, where: str) -> None:
    """Set one place, making tables on the way."""
    holder: Any = data
    for depth, (key, following) in enumerate(zip(place, (*place[1:], None), strict=True)):
        fits = isinstance(holder, dict) if isinstance(key, str) else isinstance(holder, list)
        if not fits or (isinstance(key, int) and key >= len(holder)):
            whole = dotted(place[:depth])
            raise InputError(
                f"{where}: the file has no {dotted(place[: depth + 1])} to change; "
                f"set {whole} as a whole"
            )
        if following is None:
            holder[key] = value
        elif isinstance(following, str) and item(holder, key) is None:
            holder[key] = {}
        holder = item(holder, key)
