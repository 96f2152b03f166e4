"""The JSON schema of scenario files, made from the structures and their docstrings.

Editors that know JSON schemas complete and check scenario files with it.
"""

import inspect as python_inspect
import json
from typing import Any

import msgspec
from msgspec import inspect

from parkproof.scenario import Scenario

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def scenario_schema() -> dict[str, Any]:
    """Give the JSON schema of a scenario file.

    Returns
    -------
    dict
        A schema of draft 2020-12 with the structures' docstrings as descriptions. It knows keys
        and types; rules that join several values are checked when the file is read.

    Examples
    --------
    >>> schema = scenario_schema()
    >>> schema["required"], sorted(schema["$defs"])[:2]
    (['law', 'start'], ['Adversary', 'Bounds'])
    """
    (reference,), definitions = msgspec.json.schema_components(
        (_with_default_factories(Scenario),), ref_template="#/$defs/{name}"
    )
    definitions = _without_null(definitions)
    for struct in _structs(inspect.type_info(Scenario), {}).values():
        _describe(definitions[struct.__name__], struct)
    root = definitions.pop(reference["$ref"].rpartition("/")[2])
    root["title"] = "Parkproof scenario"
    return {"$schema": DIALECT, **root, "$defs": definitions}


def schema_text() -> str:
    """Give the schema as the text of ``docs/scenario.schema.json``.

    Returns
    -------
    str
        Indented JSON.

    Examples
    --------
    >>> schema_text().startswith('{')
    True
    """
    return json.dumps(scenario_schema(), indent=2, ensure_ascii=False) + "\n"


def _with_default_factories(struct: type[msgspec.Struct]) -> type[msgspec.Struct]:
    """Copy a structure with default tables made anew, as msgspec cannot print exponents in them."""
    fields: list[Any] = []
    for field in msgspec.structs.fields(struct):
        if isinstance(field.default, msgspec.Struct):
            factory = msgspec.field(default_factory=type(field.default))
            fields.append((field.name, field.type, factory))
        elif field.required:
            fields.append((field.name, field.type))
        else:
            fields.append((field.name, field.type, field.default))
    return msgspec.defstruct(struct.__name__, fields, kw_only=True, forbid_unknown_fields=True)


def _structs(node: inspect.Type, found: dict[str, type]) -> dict[str, type]:
    """Collect the structures below a type by name."""
    if isinstance(node, inspect.StructType):
        found[node.cls.__name__] = node.cls
        below = [field.type for field in node.fields]
    elif isinstance(node, inspect.TupleType):
        below = list(node.item_types)
    elif isinstance(node, inspect.UnionType):
        below = list(node.types)
    else:
        below = []
    for inner in below:
        _structs(inner, found)
    return found


def _describe(definition: dict[str, Any], struct: type) -> None:
    """Put a structure's docstring into its definition and those of its keys."""
    doc = python_inspect.getdoc(struct) or ""
    definition["description"] = " ".join(doc.partition("\n\n")[0].split())
    descriptions = _parameters(doc)
    for name, key in definition["properties"].items():
        if name in descriptions and "$ref" not in key:
            key["description"] = descriptions[name]


def _parameters(doc: str) -> dict[str, str]:
    """Read the descriptions under "Parameters" of a NumPy docstring."""
    _, _, rest = doc.partition("Parameters\n----------\n")
    section = rest.partition("\n\n")[0]
    texts: dict[str, list[str]] = {}
    names: list[str] = []
    for line in section.splitlines():
        if line.startswith(" "):
            for name in names:
                texts[name].append(line.strip().replace("``", '"'))
        else:
            names = line.partition(" : ")[0].split(", ")
            texts.update({name: [] for name in names})
    return {name: " ".join(lines) for name, lines in texts.items()}


def _without_null(node: Any) -> Any:
    """Take the null of optional keys out of a schema: TOML has none, the key is left out."""
    if isinstance(node, list):
        return [_without_null(inner) for inner in node if inner != {"type": "null"}]
    if not isinstance(node, dict):
        return node
    kept = {
        key: _without_null(inner)
        for key, inner in node.items()
        if not (key == "default" and inner is None)
    }
    if len(kept.get("anyOf", ())) == 1:
        (only,) = kept.pop("anyOf")
        kept |= only
    return kept
