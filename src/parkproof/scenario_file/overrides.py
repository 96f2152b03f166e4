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
        check_known(place, root, f"--set {key.strip()}")
        for other in _REPLACED.get(place, ()):
            start = data.get("start")
            if isinstance(start, dict):
                start.pop(other, None)
        put(data, place, _value(text.strip()), f"--set {plain(expression)}")


def _value(text: str) -> Any:
    """Read a TOML value, or take the text as it is."""
    try:
        read = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return read["value"] if len(read) == 1 else text


def check_known(place: Place, root: type, where: str) -> None:
    """Raise if no file can hold this place, and name the nearest that it can.

    Parameters
    ----------
    place : tuple
        Keys and indices.
    root : type
        The structure that the file should have.
    where : str
        What a message begins with.

    Raises
    ------
    InputError
        If the place is unknown.

    Examples
    --------
    >>> from parkproof.scenario import Scenario
    >>> check_known(("run", "duraton"), Scenario, "--set run.duraton")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: --set run.duraton: unknown key; did you mean run.duration?
    """
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
        raise InputError(f"{where}: {lacking}; {remedy}")


def put(data: dict[str, Any], place: Place, value: Any, where: str) -> None:
    """Set one place, making tables on the way.

    Parameters
    ----------
    data : dict
        What the file holds; changed in place.
    place : tuple
        Keys and indices.
    value : object
        What is to stand there.
    where : str
        What a message begins with.

    Raises
    ------
    InputError
        If there is no table or list that can hold the value.

    Examples
    --------
    >>> data = {"truth": {"alpha": [1.0, 1.0]}}
    >>> put(data, ("truth", "alpha", 1), 0.8, "example")
    >>> data
    {'truth': {'alpha': [1.0, 0.8]}}
    """
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
