"""The JSON Schema of experiment files, in the dialect of editors."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import msgspec

from multisrt.experiments.spec import ExperimentSpec
from multisrt.spec import RadioSpec

DIALECT = "http://json-schema.org/draft-07/schema#"
"""The newest dialect of JSON Schema that Taplo, and with it Even Better TOML, understands."""

Schema = dict[str, Any]


def schema() -> Schema:
    """Return the JSON Schema of experiment files, for editors.

    Returns
    -------
    dict
        The schema, whose descriptions are those of the docstrings in `multisrt.experiments.spec`.
    """
    return for_editors(
        msgspec.json.schema(ExperimentSpec), bases={"RadioChoice": RadioSpec.__doc__ or ""}
    )


def for_editors(made: Schema, bases: Mapping[str, str]) -> Schema:
    """Turn a schema made by msgspec into one that editors of TOML understand.

    The root is written out, definitions have the name of draft 7, constraints beside a reference
    are kept, and each field has the description of its class's docstring.

    Parameters
    ----------
    made : dict
        A schema made by `msgspec.json.schema`.
    bases : mapping of str to str
        Docstrings of base classes, by the name of the class that inherits fields from them.

    Returns
    -------
    dict
        The schema in draft 7.
    """
    parts = {name: _described(part, bases.get(name, "")) for name, part in made["$defs"].items()}
    root = parts.pop(made["$ref"].rpartition("/")[2])
    return {"$schema": DIALECT, **_older(root), "definitions": _older(parts)}


def documented_attributes(docstring: str) -> dict[str, str]:
    """Return the descriptions in the "Attributes" section of a numpydoc docstring.

    Parameters
    ----------
    docstring : str
        The docstring of a class.

    Returns
    -------
    dict of str to str
        The description of each attribute, in one line; names that share an entry share it.

    Examples
    --------
    >>> docstring = '''A point.
    ...
    ...     Attributes
    ...     ----------
    ...     x, y : float
    ...         Coordinates (m).
    ... '''
    >>> documented_attributes(docstring)
    {'x': 'Coordinates (m).', 'y': 'Coordinates (m).'}
    """
    section = re.split(r"\n\s*Attributes\n\s*-+\n", docstring, maxsplit=1)[1:]
    if not section:
        return {}
    body = re.split(r"\n\s*\w+\n\s*-{3,}\n", section[0], maxsplit=1)[0]
    found: dict[str, str] = {}
    names: list[str] = []
    for line in body.splitlines():
        text = line.strip()
        if " : " in text and len(line) - len(line.lstrip()) <= 4:
            names = [name.strip() for name in text.partition(" : ")[0].split(",")]
            found |= dict.fromkeys(names, "")
        elif text:
            found |= {name: f"{found[name]} {text}".strip() for name in names}
    return found


def _described(part: Schema, base: str) -> Schema:
    docstring = part.get("description", "")
    described = documented_attributes(base) | documented_attributes(docstring)
    texts = {name: re.sub(r"\bNone\b", "left out", text) for name, text in described.items()}
    fields = {
        name: field | ({"description": texts[name]} if name in texts else {})
        for name, field in part.get("properties", {}).items()
    }
    return part | {"description": docstring.partition("\n")[0], "properties": fields}


def _older(part: Any) -> Any:
    """Return a part in draft 7, which ignores what stands beside a reference; TOML has no null."""
    if isinstance(part, (list, tuple)):
        return [_older(one) for one in part]
    if not isinstance(part, dict):
        return part
    made = {
        name: _older(one) for name, one in part.items() if not (name == "default" and one is None)
    }
    if isinstance(made.get("$ref"), str):
        made["$ref"] = made["$ref"].replace("#/$defs/", "#/definitions/")
        if len(made) > 1:
            made["allOf"] = [{"$ref": made.pop("$ref")}]
    if "prefixItems" in made:
        made |= {"items": made.pop("prefixItems"), "additionalItems": False}
    return made
