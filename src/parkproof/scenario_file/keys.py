"""What a scenario file may hold at each place: its keys, their types, and near names."""

import difflib
import re
from collections.abc import Iterable

from msgspec import inspect

Place = tuple[str | int, ...]
Types = tuple[inspect.Type, ...]

_PART = re.compile(r"\.?([A-Za-z_][\w-]*)|\[(\d{1,9})\]")


def parse_place(text: str) -> Place | None:
    """Read a dotted key with indices.

    Parameters
    ----------
    text : str
        For example ``truth.gamma[0].mean``; a leading dot is passed over.

    Returns
    -------
    tuple or None
        Its keys and indices, or None if the text is no such key.

    Examples
    --------
    >>> parse_place("truth.gamma[0].mean")
    ('truth', 'gamma', 0, 'mean')
    """
    place: list[str | int] = []
    end = 0
    while end < len(text):
        part = _PART.match(text, end)
        if part is None:
            return None
        place.append(part[1] if part[1] is not None else int(part[2]))
        end = part.end()
    return tuple(place)


def dotted(place: Iterable[str | int]) -> str:
    """Write a place as a dotted key.

    Parameters
    ----------
    place : iterable of str and int
        Keys and indices.

    Returns
    -------
    str
        What `parse_place` reads.

    Examples
    --------
    >>> dotted(("truth", "gamma", 0, "mean"))
    'truth.gamma[0].mean'
    """
    parts = (f"[{key}]" if isinstance(key, int) else f".{key}" for key in place)
    return "".join(parts).removeprefix(".")


def alternatives(node: inspect.Type) -> Types:
    """Give the types that a value may have, without the None of optional keys.

    Parameters
    ----------
    node : msgspec.inspect.Type
        A type, perhaps a union.

    Returns
    -------
    tuple of msgspec.inspect.Type
        Its members.

    Examples
    --------
    >>> alternatives(inspect.type_info(float | None))
    (FloatType(gt=None, ge=None, lt=None, le=None, multiple_of=None),)
    """
    if isinstance(node, inspect.Metadata):
        return alternatives(node.type)
    if isinstance(node, inspect.UnionType):
        return tuple(found for inner in node.types for found in alternatives(inner))
    return () if isinstance(node, inspect.NoneType) else (node,)


def _below(node: inspect.Type, key: str | int) -> Types:
    """Give the types of one key or element of a value of the given type."""
    if isinstance(node, inspect.StructType):
        if key == node.tag_field:
            return (inspect.LiteralType((node.tag,)),)
        return tuple(t for f in node.fields if f.name == key for t in alternatives(f.type))
    if isinstance(node, inspect.TupleType) and isinstance(key, int):
        return tuple(t for item in node.item_types[key : key + 1] for t in alternatives(item))
    return ()


def _narrowed(types: Types, value: object) -> Types:
    """Keep only the table whose kind the value states, if it states one."""
    if isinstance(value, dict):
        stated = tuple(
            node
            for node in types
            if isinstance(node, inspect.StructType)
            and node.tag_field is not None
            and value.get(node.tag_field) == node.tag
        )
        return stated or types
    return types


def item(value: object, key: str | int) -> object:
    """Give what a file holds at a key or an index, or None.

    Parameters
    ----------
    value : object
        A table, a list, or anything else.
    key : str or int
        Key of a table or index of a list.

    Returns
    -------
    object
        The value there, or None if there is none.

    Examples
    --------
    >>> item({"l": [2.0, 4.2]}, "l"), item([1, 2], 5)
    ([2.0, 4.2], None)
    """
    if isinstance(value, dict):
        return value.get(key)
    if isinstance(value, list | tuple) and isinstance(key, int) and key < len(value):
        return value[key]
    return None


def types_at(root: type, place: Place, value: object = None) -> Types:
    """Give the types that may stand at a place.

    Parameters
    ----------
    root : type
        Structure of the whole file.
    place : tuple
        Keys and indices.
    value : object
        What the file holds; where a table states its kind, only that kind counts.

    Returns
    -------
    tuple of msgspec.inspect.Type
        Empty if the place is unknown.

    Examples
    --------
    >>> from parkproof.scenario import Scenario
    >>> types_at(Scenario, ("run", "duraton"))
    ()
    """
    types: Types = alternatives(inspect.type_info(root))
    for key in place:
        types = tuple(t for node in _narrowed(types, value) for t in _below(node, key))
        value = item(value, key)
    return _narrowed(types, value)


def known_keys(types: Types) -> list[str]:
    """List the keys of a table of one of the given types.

    Parameters
    ----------
    types : tuple of msgspec.inspect.Type
        As from `types_at`.

    Returns
    -------
    list of str
        In the order of the structures, a kind first.

    Examples
    --------
    >>> from parkproof.scenario import Scenario
    >>> known_keys(types_at(Scenario, ("robot",)))
    ['kind']
    """
    names: dict[str, None] = {}
    for node in types:
        if isinstance(node, inspect.StructType):
            if node.tag_field is not None:
                names[node.tag_field] = None
            names.update(dict.fromkeys(field.name for field in node.fields))
    return list(names)


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Find the known word most like a given one.

    Parameters
    ----------
    word : str
        What the user wrote.
    known : iterable of str
        What could have been meant.

    Returns
    -------
    str or None
        None if nothing is near.

    Examples
    --------
    >>> nearest("duraton", ["duration", "control_period"])
    'duration'
    """
    candidates = list(known)
    by_lower = {name.lower(): name for name in candidates}
    found = difflib.get_close_matches(word.lower(), by_lower, n=1)
    return by_lower[found[0]] if found else None


def nearest_place(root: type, place: Place, value: object = None) -> Place | None:
    """Find the known place that an unknown one may have meant.

    Parameters
    ----------
    root : type
        Structure of the whole file.
    place : tuple
        A place whose last key is unknown.
    value : object
        What the file holds.

    Returns
    -------
    tuple or None
        The place of a near key in the same table, else of the same key in a table of the file.

    Examples
    --------
    >>> from parkproof.scenario import Scenario
    >>> nearest_place(Scenario, ("duration",))
    ('run', 'duration')
    """
    parent, word = place[:-1], str(place[-1])
    near = nearest(word, known_keys(types_at(root, parent, value)))
    if near is not None:
        return (*parent, near)
    for table in known_keys(types_at(root, ())):
        if word in known_keys(types_at(root, (table,))):
            return (table, word)
    return None
