"""Digests of arbitrary values, to notice when one is changed."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np
import shapely
from numpy.random import Generator as RandomGenerator
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.robots.messages import Message


def fingerprint(value: object) -> bytes:
    """Return a digest of a value: equal values have equal digests, whatever objects hold them.

    Random generators are left out, as drawing from one changes it.
    """
    return _digest(value, {})


def attributes_of(value: object) -> Mapping[str, object]:
    """Return what an object holds in its `__dict__`; empty where that is no mapping."""
    held = getattr(value, "__dict__", None)
    return dict(held) if isinstance(held, Mapping) else {}


def _digest(value: Any, known: dict[int, bytes]) -> bytes:
    # An object that occurs again, also within itself, stands for its digest so far.
    kind = type(value)
    digest = hashlib.sha256(f"<{kind.__module__}.{kind.__qualname__}>".encode())
    if value is None or isinstance(value, bool | int | float | complex | str | bytes | np.generic):
        digest.update(repr(value).encode())
        return digest.digest()
    if id(value) in known:
        return known[id(value)]
    known[id(value)] = digest.digest()
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        digest.update(f"{value.dtype}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    elif isinstance(value, BaseGeometry):
        digest.update(shapely.to_wkb(value))
    elif isinstance(value, Footprint):
        digest.update(str(value).encode())
    elif isinstance(value, set | frozenset):
        digest.update(b"".join(sorted(_digest(item, known) for item in value)))
    elif (data := _written(value)) is not None:
        digest.update(data)
    elif not isinstance(value, RandomGenerator | type):
        for part in _parts(value):
            digest.update(_digest(part, known))
    known[id(value)] = digest.digest()
    return known[id(value)]


def _written(value: Any) -> bytes | None:
    # Messages are many and may hold whole maps: most are data that msgspec writes at once.
    if not isinstance(value, Message):
        return None
    try:
        return _ENCODER.encode(value)
    except (TypeError, ValueError, OverflowError, RecursionError):
        return None


def _array(value: Any) -> tuple[object, ...]:
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        return str(value.dtype), value.shape, np.ascontiguousarray(value).tobytes()
    if isinstance(value, np.generic):
        return str(value.dtype), repr(value)
    raise TypeError


_ENCODER = msgspec.msgpack.Encoder(enc_hook=_array, order="deterministic")


def _parts(value: Any) -> list[Any]:
    # What a value consists of, in order, with the number of parts.
    if isinstance(value, tuple | list):
        return [len(value), *value]
    if isinstance(value, np.ndarray):
        return [value.shape, *value.ravel().tolist()]
    if isinstance(value, dict):
        return [len(value), *(part for item in value.items() for part in item)]
    if isinstance(value, msgspec.Struct):
        return [getattr(value, name) for name in value.__struct_fields__]
    if dataclasses.is_dataclass(value):
        return [getattr(value, field.name) for field in dataclasses.fields(value)]
    return [part for item in attributes_of(value).items() for part in item]
