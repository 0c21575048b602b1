"""Messages as bytes and back, for radios that are not simulated.

The bytes are MessagePack that names the classes of what it holds. They are data: decoding builds
only messages, and structures that the annotations of messages name, of modules that have been
imported already.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import typing
from collections.abc import Iterator
from functools import cache
from typing import Any, Final

import msgspec
import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import builtin
from multisrt.robots.defects import brief
from multisrt.robots.messages import Message

ARRAY, STRUCTURE, TABLE, LIST = 1, 2, 3, 4
"""Codes of MessagePack extensions: arrays of numpy, structures, dictionaries and lists."""

MAX_BYTES: Final = 100_000_000
"""Size of the largest message that is decoded."""


def encode(message: Message) -> bytes:
    """Return a message as bytes.

    Parameters
    ----------
    message : Message
        The message.

    Returns
    -------
    bytes
        Equal messages of one class have equal bytes.

    Raises
    ------
    InvalidInputError
        If it holds anything but numbers, text, bytes, tuples, lists, dictionaries, structures,
        immutable dataclasses and arrays of numbers.

    Examples
    --------
    >>> class Hello(Message, frozen=True, kw_only=True):
    ...     kind = "hello"
    ...     place: tuple[float, float]
    >>> decode(encode(Hello(sender=0, place=(2.0, 1.5)))).place
    (2.0, 1.5)
    """
    if not isinstance(message, Message):
        raise InvalidInputError(f"expected a Message, not {type(message).__name__}")
    try:
        return msgspec.msgpack.encode(_tree(message))
    except (OverflowError, RecursionError, TypeError) as error:
        raise InvalidInputError(f"{message.kind} message: {error}") from None


def decode(data: bytes) -> Message:
    """Return the message that bytes hold.

    Parameters
    ----------
    data : bytes
        What `encode` has returned, here or in another process with the same classes of messages.

    Returns
    -------
    Message
        An equal message; its arrays are read-only.

    Raises
    ------
    InvalidInputError
        If the bytes hold no message, or one of a class that this process does not know, or fields
        of other types than its class declares.
    """
    if not isinstance(data, bytes | bytearray | memoryview):
        raise InvalidInputError(f"a message is decoded from bytes, not from {brief(data)}")
    if len(data) > MAX_BYTES:
        raise InvalidInputError(f"a message of {len(data)} bytes; at most {MAX_BYTES} are decoded")
    try:
        message = _value(msgspec.msgpack.decode(data, ext_hook=_extension))
    except (
        *(msgspec.MsgspecError, ValueError, TypeError, AttributeError),
        *(LookupError, ArithmeticError, RecursionError, MemoryError),
    ) as error:
        if isinstance(error, InvalidInputError):
            raise
        raise InvalidInputError(f"these {len(data)} bytes hold no message: {error}") from None
    if not isinstance(message, Message):
        raise InvalidInputError(f"these {len(data)} bytes hold no message")
    return message


def _tree(value: Any) -> Any:
    # What MessagePack can write; tuples are its arrays.
    if value is None or isinstance(value, bool | int | float | str | bytes):
        return value
    if isinstance(value, np.ndarray) and value.ndim:
        if value.dtype.kind not in "biuf":
            raise TypeError(f"an array of {value.dtype} cannot be sent; numbers can")
        rows = np.ascontiguousarray(value)
        return _ext(ARRAY, [rows.dtype.str, list(rows.shape), rows.tobytes()])
    fields = _fields(value)
    if fields is not None:
        return _ext(STRUCTURE, [_name(type(value)), {k: _tree(v) for k, v in fields.items()}])
    match value:
        case tuple():
            return [_tree(part) for part in value]
        case list():
            return _ext(LIST, [_tree(part) for part in value])
        case dict():
            return _ext(TABLE, [[_tree(k), _tree(v)] for k, v in value.items()])
    try:
        return builtin(value)
    except TypeError:
        raise TypeError(f"a value of type {type(value).__name__} cannot be sent") from None


def _ext(code: int, content: Any) -> msgspec.msgpack.Ext:
    return msgspec.msgpack.Ext(code, msgspec.msgpack.encode(content))


def _fields(value: Any) -> dict[str, Any] | None:
    # The fields of a structure; None for what is none.
    if isinstance(value, msgspec.Struct):
        return {name: getattr(value, name) for name in value.__struct_fields__}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = dataclasses.fields(value)
        return {field.name: getattr(value, field.name) for field in fields if field.init}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return dict(value._asdict())
    return None


def _extension(code: int, data: memoryview) -> Any:
    content = msgspec.msgpack.decode(data, ext_hook=_extension)
    if code == ARRAY:
        kind, shape, values = content
        dtype = np.dtype(kind)
        if dtype.kind not in "biuf" or len(values) != dtype.itemsize * math.prod(shape):
            raise ValueError("an array whose size is not that of its numbers")
        return np.frombuffer(values, dtype).reshape(shape)
    if code == STRUCTURE:
        name, fields = content
        return _structure(_class(name), {key: _value(value) for key, value in fields.items()})
    if code == TABLE:
        return {_value(key): _value(value) for key, value in content}
    if code == LIST:
        return _Fixed(map(_value, content))
    raise ValueError(f"an extension of the code {code}")


def _structure(cls: type, fields: dict[str, Any]) -> Any:
    if issubclass(cls, msgspec.Struct) and (more := fields.keys() - set(cls.__struct_fields__)):
        raise ValueError(f"a {cls.__name__} has no field {min(more)!r}")
    if issubclass(cls, msgspec.Struct) and _is_checkable(cls):
        return msgspec.convert(fields, cls)
    if issubclass(cls, Message):
        msgspec.convert(fields, Message)
    return cls(**fields)


@cache
def _is_checkable(cls: type[msgspec.Struct]) -> bool:
    # Whether msgspec can check all fields: it knows no unions of several dataclasses.
    try:
        msgspec.convert({}, cls)
    except (NameError, TypeError):
        return False
    except msgspec.ValidationError:
        pass
    return True


class _Fixed(list[Any]):
    """A list that was sent as a list, not as a tuple."""


def _value(value: Any) -> Any:
    if isinstance(value, _Fixed):
        return list(value)
    return tuple(map(_value, value)) if isinstance(value, list) else value


# Classes by their names ---------------------------------------------------------------------

_known: dict[str, type] = {}


def _name(cls: type) -> str:
    return f"{cls.__module__}.{cls.__qualname__}"


def _class(name: str) -> type:
    if name not in _known:
        _known.update((_name(cls), cls) for cls in _sendable())
    if name not in _known:
        raise InvalidInputError(
            f"a message holds a {name}, which no class of messages here names: import the module "
            "that defines it, and name it in an annotation"
        )
    return _known[name]


def _sendable() -> Iterator[type]:
    # The classes of messages, and all structures that their annotations name.
    waiting: list[Any] = [Message]
    seen: set[Any] = set()
    while waiting:
        hint = waiting.pop()
        try:
            if hint in seen:
                continue
            seen.add(hint)
        except TypeError:  # a hint that cannot be hashed names no class
            continue
        waiting += typing.get_args(hint)
        if not isinstance(hint, type):
            continue
        if issubclass(hint, Message):
            waiting += hint.__subclasses__()
        is_tuple = issubclass(hint, tuple) and hasattr(hint, "_fields")
        if is_tuple or issubclass(hint, msgspec.Struct) or dataclasses.is_dataclass(hint):
            yield hint
            waiting += _hints(hint)


def _hints(cls: type) -> list[Any]:
    scope = vars(sys.modules[cls.__module__]) if cls.__module__ in sys.modules else {}
    try:
        return list(typing.get_type_hints(cls, scope).values())
    except (NameError, TypeError):  # an annotation that only a type checker can read
        return []
