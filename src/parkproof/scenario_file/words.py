"""What a scenario file may hold and what it does hold, in the words of a user of TOML."""

import json
from collections.abc import Sequence

from msgspec import inspect

from parkproof.scenario_file.keys import Types, alternatives

SHOWN = 40
"""Longest text of a user's that a message repeats."""


def one_of(words: Sequence[str]) -> str:
    """Join alternatives as a sentence does.

    Parameters
    ----------
    words : sequence of str
        At least one.

    Returns
    -------
    str
        "a", "a or b", "a, b or c".

    Examples
    --------
    >>> one_of(["a", "b", "c"])
    'a, b or c'
    """
    *first, last = words
    return f"{', '.join(first)} or {last}" if first else last


def in_words(types: Types) -> str:
    """Say what may stand at a place.

    Parameters
    ----------
    types : tuple of msgspec.inspect.Type
        As from `types_at`, not empty.

    Returns
    -------
    str
        In the words of a user of TOML.

    Examples
    --------
    >>> from parkproof.scenario import Scenario
    >>> from parkproof.scenario_file.keys import types_at
    >>> in_words(types_at(Scenario, ("switching", "to_step2")))
    'a number or "settled"'
    """
    tags = {
        json.dumps(node.tag): node.tag_field
        for node in types
        if isinstance(node, inspect.StructType) and node.tag_field is not None
    }
    plain_types = types if not tags else tuple(t for t in types if not _is_tagged(t))
    words = list(dict.fromkeys(word for node in plain_types for word in _words(node)))
    if tags:
        words.append(f"a table with {next(iter(tags.values()))} = {one_of(list(tags))}")
    return one_of(words)


def _is_tagged(node: inspect.Type) -> bool:
    """Whether this is a table that states its kind."""
    return isinstance(node, inspect.StructType) and node.tag_field is not None


def _words(node: inspect.Type) -> list[str]:
    """Say what one type allows, alternatives apart."""
    if isinstance(node, inspect.LiteralType):
        return [json.dumps(value) for value in node.values]
    if isinstance(node, inspect.TupleType):
        items = {in_words(alternatives(inner)) for inner in node.item_types}
        each = items.pop() if len(items) == 1 else "a value"
        simple = {"a number": "numbers", "a string": "strings"}.get(each)
        return [
            f"a list of {len(node.item_types)}" + (f" {simple}" if simple else f", each {each}")
        ]
    if isinstance(node, inspect.StructType):
        return ["a table"]
    names = {
        inspect.FloatType: "a number",
        inspect.IntType: "a whole number",
        inspect.BoolType: "true or false",
        inspect.StrType: "a string",
    }
    return [names.get(type(node), "another type")]


def shown(text: str) -> str:
    """Quote a user's text on one line, shortened.

    Parameters
    ----------
    text : str
        Any text.

    Returns
    -------
    str
        In double quotes, control characters escaped.

    Examples
    --------
    >>> shown("a" * 50)[-8:]
    'aaaa..."'
    """
    short = text if len(text) <= SHOWN else text[:SHOWN] + "..."
    return json.dumps(short, ensure_ascii=False)


def plain(text: str) -> str:
    """Repeat a user's text on one line, shortened, without quotes around it.

    Parameters
    ----------
    text : str
        Any text.

    Returns
    -------
    str
        Control characters escaped.

    Examples
    --------
    >>> print(plain('law = "corrected"'))
    law = "corrected"
    """
    return shown(text)[1:-1].replace('\\"', '"')


def described(value: object) -> str:
    """Say what a user gave.

    Parameters
    ----------
    value : object
        A value as TOML has them.

    Returns
    -------
    str
        With its type.

    Examples
    --------
    >>> described("abc"), described([1, 2])
    ('a string "abc"', 'a list of 2')
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"the number {value}"
    if isinstance(value, str):
        return f"a string {shown(value)}"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}" if value else "an empty list"
    return "a table" if isinstance(value, dict) else "a date or time"
