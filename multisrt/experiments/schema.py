"""The JSON Schema of experiment files: for editors, and for saying what would have been right."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Mapping
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


# What would have been right ------------------------------------------------------------------


def explained(message: str, schema: Schema) -> str:
    """Say what is wrong with a file as a person would: where, what, and what would be right.

    Parameters
    ----------
    message : str
        What msgspec says.
    schema : dict
        The schema that the file does not keep to.
    """
    said, _, path = message.partition(" - at `")
    place = path.rstrip("`").removeprefix("$").lstrip(".")
    said = re.sub(r"`[^`]*`", lambda kinds: _in_toml(kinds[0]), said)
    unknown = re.fullmatch(r"Object contains unknown field `(.*)`", said)
    if unknown is not None:
        said = f"there is no field {unknown[1]!r}{_nearest(unknown[1], _fields(schema, place))}"
    elif said.startswith(("Invalid enum value", "Invalid value '")):
        said += f"; allowed: {', '.join(_allowed(schema, place))}"
    elif said.startswith("Object missing required field"):
        said = said.replace("Object missing required field", "missing field")
    return f"{place}: {said}" if place else said


def _in_toml(kinds: str) -> str:
    return kinds.replace("object", "table").replace("array", "list").replace(" | null", "")


def _nearest(word: str, known: list[str]) -> str:
    close = difflib.get_close_matches(word, known, n=1)
    return f" (did you mean {close[0]!r}?)" if close else f"; there are: {', '.join(known)}"


def _fields(schema: Schema, place: str) -> list[str]:
    return list(
        dict.fromkeys(name for node in _nodes(schema, place) for name in node.get("properties", {}))
    )


def _allowed(schema: Schema, place: str) -> list[str]:
    return [repr(value) for node in _nodes(schema, place) for value in node.get("enum", ())]


def _nodes(schema: Schema, place: str) -> list[Schema]:
    # All that the schema says of a place such as `radios[0].walls`.
    found = list(_alternatives(schema, schema))
    for step in re.findall(r"[^.\[\]]+", place):
        below = []
        for node in found:
            if step.isdigit() or step == "...":
                items = node.get("items", {})
                below += items if isinstance(items, list) else [items]
            else:
                below.append(node.get("properties", {}).get(step, {}))
        found = [one for node in below for one in _alternatives(node, schema)]
    return found


def _alternatives(node: Schema, schema: Schema) -> Iterator[Schema]:
    if "$ref" in node:
        yield from _alternatives(schema["definitions"][node["$ref"].rpartition("/")[2]], schema)
        return
    yield node
    for one in (*node.get("anyOf", ()), *node.get("allOf", ())):
        yield from _alternatives(one, schema)
