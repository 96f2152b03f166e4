"""What is wrong with a scenario file, in one line: the place, the rule, what to write instead."""

import re

import msgspec
from msgspec import inspect

from parkproof.errors import InputError
from parkproof.scenario_file.keys import (
    Place,
    dotted,
    item,
    known_keys,
    nearest,
    nearest_place,
    parse_place,
    types_at,
)
from parkproof.scenario_file.words import described, in_words, plain, shown

_UNKNOWN = re.compile(r"(?s)Object contains unknown field `(.*)`")
_MISSING = re.compile(r"Object missing required field `(.*)`")
_OWN_TABLE = re.compile(r"(\w+)\.(?=[A-Za-z_])")

_WRITE: dict[Place, str] = {
    ("law",): 'write law = "published", law = "corrected" or law = "homogeneous"',
    ("start",): (
        "add a [start] table with state = [x0, x1, x2, u0, u1] or pose = [x, y, theta]"
    ),
    ("bounds",): "add a [bounds] table with alpha, gamma and disturbance",
    ("gains",): "add a [gains] table with q1, l and k",
}  # fmt: skip


def place_name(place: Place, *, table: bool = False) -> str:
    """Name a place as a user of TOML finds it.

    Parameters
    ----------
    place : tuple
        Keys and indices.
    table : bool
        Whether a single key names a table.

    Returns
    -------
    str
        The table in brackets, then the key in it.

    Examples
    --------
    >>> place_name(("truth", "gamma", 0)), place_name(("run",), table=True)
    ('[truth] gamma[0]', '[run]')
    """
    if len(place) > 1:
        return f"[{place[0]}] {dotted(place[1:])}"
    return f"[{place[0]}]" if table else dotted(place)


def sentence(error: msgspec.ValidationError, data: object, root: type) -> str:
    """Translate a validation error into one line for a user.

    Parameters
    ----------
    error : msgspec.ValidationError
        What msgspec raised.
    data : object
        What the file holds.
    root : type
        The structure that it should have been.

    Returns
    -------
    str
        Place, rule and remedy.

    Examples
    --------
    >>> from parkproof.scenario import Scenario
    >>> data = {"law": "corected"}
    >>> try:
    ...     msgspec.convert(data, Scenario)
    ... except msgspec.ValidationError as error:
    ...     print(sentence(error, data, Scenario))
    law: expected "corrected", "homogeneous" or "published", got a string "corected"; did you mean
    "corrected"?
    """
    text, _, at = str(error).partition(" - at `$")
    place = parse_place(at.removesuffix("`")) or ()
    if isinstance(error.__cause__, InputError):
        return _with_table(place, str(error.__cause__), root)
    if unknown := _UNKNOWN.fullmatch(text):
        return unknown_key((*place, unknown[1]), data, root)
    if missing := _MISSING.fullmatch(text):
        return _missing(place, missing[1], data, root)
    value = data
    for key in place:
        value = item(value, key)
    name = f"{place_name(place)}: " if place else ""
    if text == "Number out of range":
        return f"{name}the number is too large; write a smaller one"
    return name + _wrong_type(place, value, root)


def _with_table(place: Place, rule: str, root: type) -> str:
    """Put the table before a structure's own sentence, unless it names its table already."""
    own = _OWN_TABLE.match(rule)
    if own is not None and own[1] in known_keys(types_at(root, ())):
        return f"[{own[1]}] {rule[own.end() :]}"
    if rule.startswith("[") or not place:
        return rule
    return place_name(place, table=True) + (": " if len(place) > 1 else " ") + rule


def unknown_key(place: Place, data: object, root: type) -> str:
    """Say that a key is unknown, and what may have been meant.

    Parameters
    ----------
    place : tuple
        The unknown place.
    data : object
        What the file holds.
    root : type
        The structure that it should have.

    Returns
    -------
    str
        One line.

    Examples
    --------
    >>> from parkproof.scenario import Scenario
    >>> unknown_key(("run", "duraton"), {}, Scenario)
    '[run] duraton: unknown key; did you mean "duration"?'
    """
    parent = place[:-1]
    key = plain(str(place[-1]))
    value = data
    for step in place:
        value = item(value, step)
    table = isinstance(value, dict) and not parent
    head = f"{place_name((*parent, key), table=table)}: unknown {'table' if table else 'key'}; "
    types = types_at(root, parent, data)
    known = f"known keys: {', '.join(known_keys(types))}"
    near = nearest_place(root, place, data)
    if near is None:
        return head + known
    if near[:-1] != parent:
        return head + f'did you mean "{near[-1]}" under [{near[0]}]?'
    is_table = not parent and bool(known_keys(types_at(root, near)))
    meant = f"did you mean {f'[{near[-1]}]' if is_table else shown(str(near[-1]))}?"
    # Which keys a signal has depends on its kind, so the nearest key alone may mislead.
    return head + (f"{meant} {known}" if len(parent) > 1 else meant)


def _missing(place: Place, key: str, data: object, root: type) -> str:
    """Say that a key is missing, and what to write."""
    name = f"{place_name(place)}: " if place else ""
    full = (*place, key)
    write = _WRITE.get(full) or f"it takes {in_words(types_at(root, full, data))}"
    return f"{name}{key} is missing; {write}"


def _wrong_type(place: Place, value: object, root: type) -> str:
    """Say what was expected and what was given."""
    types = types_at(root, place)
    line = f"expected {in_words(types)}, got {described(value)}"
    choices = [str(c) for t in types if isinstance(t, inspect.LiteralType) for c in t.values]
    near = nearest(value, choices) if isinstance(value, str) else None
    return line if near is None else f'{line}; did you mean "{near}"?'
