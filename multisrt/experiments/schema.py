"""The JSON Schema of experiment files, as editors understand it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

DIALECT = "http://json-schema.org/draft-07/schema#"
"""What editors of TOML understand (Taplo, and with it Even Better TOML): nothing newer."""

Schema = dict[str, Any]


def for_editors(made: Schema, bases: Mapping[str, str]) -> Schema:
    """Turn a schema as msgspec makes it into one that editors of TOML understand.

    The root is written out, definitions stand under their old name, what stands beside a
    reference is not lost, and each field is described as its class's docstring describes it.

    Parameters
    ----------
    made : dict
        What msgspec makes.
    bases : mapping of str to str
        For a class that has fields of another, that one's docstring.
    """
    parts = {name: _described(part, bases.get(name, "")) for name, part in made["$defs"].items()}
    root = parts.pop(made["$ref"].rpartition("/")[2])
    return {"$schema": DIALECT, **_older(root), "definitions": _older(parts)}


def _described(part: Schema, base: str) -> Schema:
    said = part.get("description", "")
    told = _attributes(base) | _attributes(said)
    fields = {
        name: field | ({"description": told[name]} if name in told else {})
        for name, field in part.get("properties", {}).items()
    }
    return part | {"description": said.partition("\n")[0], "properties": fields}


def _attributes(docstring: str) -> dict[str, str]:
    # Names and descriptions of a numpydoc section of attributes.
    _, _, section = docstring.partition("Attributes\n")
    found: dict[str, str] = {}
    names: list[str] = []
    for line in section.splitlines()[1:]:
        text = line.strip()
        if text and len(line) - len(line.lstrip()) < 8 and " : " in text:
            names = [name.strip() for name in text.partition(" : ")[0].split(",")]
        elif text:
            for name in names:
                found[name] = f"{found.get(name, '')} {text}".strip()
    return {name: re.sub(r"\bNone\b", "left out", text) for name, text in found.items()}


def _older(part: Any) -> Any:
    # Draft 7 looks at nothing beside a reference, and TOML knows no null.
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
