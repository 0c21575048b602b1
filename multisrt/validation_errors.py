"""Messages of validation errors: where in a file or an option, what, and what is allowed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import msgspec

from multisrt.geometry.errors import did_you_mean, shortened, shown

Schema = dict[str, Any]

MAX_EXPLAINED = 600
"""Upper bound of the length of a message, in characters."""

UNREADABLE = (msgspec.MsgspecError, ValueError, RecursionError)
"""What decoders raise, of msgspec and those of Python that it calls."""


def explained(error: Exception, wanted: Any) -> str:
    """Return a validation error of msgspec as a message for people.

    Parameters
    ----------
    error : Exception
        The error that msgspec raised.
    wanted : type
        The type to which it converted.

    Returns
    -------
    str
        The place, what is wrong there, and what is allowed.

    Examples
    --------
    >>> import msgspec
    >>> class Size(msgspec.Struct, forbid_unknown_fields=True):
    ...     width_m: float
    >>> try:
    ...     msgspec.json.decode(b'{"widht_m": 1.0}', type=Size)
    ... except msgspec.ValidationError as error:
    ...     print(explained(error, Size))
    there is no field 'widht_m' (did you mean 'width_m'?)
    """
    schema = msgspec.json.schema(wanted)
    said, _, path = str(error).partition(" - at `")
    place = path.rstrip("`").removeprefix("$").lstrip(".")
    unknown = re.fullmatch(r"Object contains unknown field `(.*)`", said)
    if unknown is not None:
        known = _fields(schema, place)
        hint = did_you_mean(unknown[1], known) or f"; there are: {', '.join(known)}"
        said = f"there is no field {shown(unknown[1])}{hint}"
    elif said.startswith(("Invalid enum value", "Invalid value '")):
        said = re.sub("^Invalid (enum )?value", "unknown value", said)
        said += f"; allowed: {', '.join(_allowed(schema, place))}"
    elif "matching regex" in said:
        said = "expected text on one line, without control characters"
    elif said.startswith("Object missing required field"):
        said = said.replace("Object missing required field", "missing field")
    else:
        said = re.sub(r"`([^`]*)`", lambda kinds: _in_words(kinds[1]), said)
    return shortened(f"{place}: {said}" if place else said, MAX_EXPLAINED)


def allowed_words(kind: Any) -> list[str]:
    """Return the words that a value may be, as they are written in options.

    Parameters
    ----------
    kind : type
        The type of the value, as msgspec takes it.

    Returns
    -------
    list of str
        The words; empty for a type that has other values, and these without numbers.

    Examples
    --------
    >>> from typing import Literal
    >>> allowed_words(bool), allowed_words(float | None), allowed_words(Literal["ball", "star"])
    (['true', 'false'], ['none'], ['ball', 'star'])
    """
    info = msgspec.inspect.type_info(kind)
    found: list[str] = []
    for one in info.types if isinstance(info, msgspec.inspect.UnionType) else (info,):
        if isinstance(one, msgspec.inspect.BoolType):
            found += ["true", "false"]
        elif isinstance(one, msgspec.inspect.LiteralType):
            found += map(str, one.values)
        elif isinstance(one, msgspec.inspect.NoneType):
            found.append("none")
    return found


def written(value: object) -> str:
    """Return a value of an option as it is written: ``true``, ``none``, ``0.5``.

    Examples
    --------
    >>> written(True), written(None), written(0.5)
    ('true', 'none', '0.5')
    """
    return str(value).lower() if value is None or isinstance(value, bool) else str(value)


def _in_words(kinds: str) -> str:
    words = (_WORDS.get(kind, kind) for kind in kinds.split(" | ") if kind != "null")
    return " or ".join(words)


_WORDS = {
    "object": "a table",
    "array": "a list",
    "str": "text",
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
}
"""Kinds of values, as msgspec and as people call them."""


def _fields(schema: Schema, place: str) -> list[str]:
    return list(
        dict.fromkeys(name for node in _nodes(schema, place) for name in node.get("properties", {}))
    )


def _allowed(schema: Schema, place: str) -> list[str]:
    return [repr(value) for node in _nodes(schema, place) for value in node.get("enum", ())]


def _nodes(schema: Schema, place: str) -> list[Schema]:
    # The parts of the schema that describe a place such as `radios[0].walls`.
    found = list(_alternatives(schema, schema))
    for step in re.findall(r"[^.\[\]]+", place):
        below: list[Schema] = []
        for node in found:
            if step.isdigit() or step == "...":
                below += node.get("prefixItems") or [node.get("items") or {}]
            else:
                below.append(node.get("properties", {}).get(step, {}))
        found = [one for node in below for one in _alternatives(node, schema)]
    return found


def _alternatives(node: Schema, schema: Schema) -> Iterator[Schema]:
    if "$ref" in node:
        yield from _alternatives(schema["$defs"][node["$ref"].rpartition("/")[2]], schema)
        return
    yield node
    for one in node.get("anyOf", ()):
        yield from _alternatives(one, schema)
