"""The search for the truth in what an explorer holds and in what its code names.

An explorer may know its scans, its messages and itself. This search goes through all objects that
can be reached from it, and names the path to the first one that belongs to the world or to the
simulation.
"""

from __future__ import annotations

import gc
import types
from collections import deque
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import simpy
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.collision import CollisionWorld
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.robots.code_places import package_of
from multisrt.robots.defects import brief
from multisrt.testing.code_reading import (
    OwnCode,
    contents,
    defaults,
    function_of,
    is_of_truth,
    names_in_code,
    names_in_reach,
)
from multisrt.testing.fingerprint import attributes_of

MAX_KEY_LENGTH = 40
"""Letters of the key of a table that a path shows."""

_ATOMS = frozenset((int, float, bool, str, bytes, type(None)))
_PLAIN = (int, float, complex, str, bytes, type(None), types.ModuleType, types.CodeType)


def path_to_truth(roots: Mapping[str, object], world: Environment) -> tuple[str, str] | None:
    """Search all objects that can be reached from some objects for the truth.

    Attributes, slots, items, closures, defaults and the local variables of generators are
    followed; modules and classes are not, as `named_by_code` covers those.

    Parameters
    ----------
    roots : mapping of str to object
        Where to begin, by name.
    world : Environment
        The truth, to recognise arrays that share its memory.

    Returns
    -------
    (path, what) or None
        A shortest path, such as ``explorer.planner._worlds[0]``, and what was found there; None
        if there is nothing.
    """
    seen: dict[int, object] = {}
    waiting = deque(roots.items())
    while waiting:
        path, thing = waiting.popleft()
        if id(thing) in seen or isinstance(thing, _PLAIN):
            continue
        seen[id(thing)] = thing
        if (what := _truth_in(thing, world)) is not None:
            return path, what
        if not isinstance(thing, type):
            waiting.extend(
                (path + step, child)
                for step, child in _within(thing)
                if type(child) not in _ATOMS and id(child) not in seen
            )
    return None


def named_by_code(cls: OwnCode) -> dict[str, object]:
    """Return what the code of an explorer's class names: globals, class attributes, imports.

    The code of functions and classes of the same package is read, too.

    Returns
    -------
    dict of str to object
        The named objects by their names for messages: all data, and modules, classes and functions
        that belong to the truth. Empty for classes of this package, which import rules cover.
    """
    found: dict[str, object] = {}
    for name, value, *_ in names_in_reach(cls):
        if name.startswith("."):
            continue
        is_plain = isinstance(value, type | types.ModuleType | types.BuiltinFunctionType)
        if is_of_truth(value) or not (is_plain or function_of(value) is not None):
            found.setdefault(name, value)
    return found


def truth_named_by_code(cls: OwnCode) -> tuple[str, str] | None:
    """Return the first module of the truth, or thing defined in one, that a class's code names.

    Returns
    -------
    (name, what) or None
        Its name in the code, and what it is; None if there is nothing.
    """
    for name, value in named_by_code(cls).items():
        if is_of_truth(value):
            return name, _title(value)
    return None


def _truth_in(thing: object, world: Environment) -> str | None:
    # A description of a thing that is the truth.
    if isinstance(thing, np.ndarray):
        # The checker builds its own worlds: those of the user have equal arrays.
        same = np.may_share_memory(thing, world.edges) or np.array_equal(thing, world.edges)
        return "an array of the world's edges" if same else None
    if isinstance(thing, EdgeIndex):
        # An index of what the robot itself has seen is allowed.
        same = np.array_equal(thing.edges, world.edges)
        return "the EdgeIndex of the world" if same else None
    if isinstance(thing, CollisionWorld | simpy.Environment):
        return f"a {type(thing).__module__}.{type(thing).__name__}"
    if isinstance(thing, BaseGeometry):
        return "the world's free space" if thing is world.free else None
    if isinstance(thing, type | types.FunctionType):
        return None
    return f"a {_title(type(thing))}" if is_of_truth(type(thing)) else None


def _within(thing: object) -> Iterator[tuple[str, object]]:
    # What a thing holds, by the step that leads there.
    if isinstance(thing, types.FunctionType):
        yield from _within_function(thing)
        return
    if isinstance(thing, types.MethodType):
        yield " -> self", thing.__self__
        yield "", thing.__func__
        return
    if isinstance(thing, types.GeneratorType):
        if thing.gi_frame is not None:
            for name, value in thing.gi_frame.f_locals.items():
                yield f" -> local {name!r}", value
        yield " -> yield from", thing.gi_yieldfrom
        return
    if isinstance(thing, dict | list | tuple | deque):
        yield from _items(thing)
        if type(thing) in (dict, list, tuple, deque):
            return
    elif isinstance(thing, np.ndarray):
        yield ".base", thing.base
    else:
        yield from ((f".{name}", value) for name, value in _attributes(thing))
    # What else it refers to: items of sets, cells, parts of compiled objects.
    for value in gc.get_referents(thing):
        if not isinstance(value, type):
            yield f" -> held by the {type(thing).__name__}", value


def _items(thing: Any) -> Iterator[tuple[str, object]]:
    if type(thing) in (tuple, dict) and not gc.is_tracked(thing):
        return  # It holds numbers and text alone, as the garbage collector has found.
    if isinstance(thing, dict):
        for key, value in list(thing.items()):
            yield f"[{brief(key, MAX_KEY_LENGTH)}]", value
            yield " -> key", key
        return
    for k, value in enumerate(thing):
        if type(value) not in _ATOMS:
            yield f"[{k}]", value


def _within_function(function: types.FunctionType) -> Iterator[tuple[str, object]]:
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    for name, cell in cells:
        yield f" -> closure {name!r}", contents(cell)
    yield from defaults(function, " -> default of ")
    if package_of(function) != "multisrt":
        for name, value, *_ in names_in_code(function.__code__, function.__globals__):
            if function_of(value) is None and not isinstance(value, type):
                yield f" -> {name}", value


def _attributes(thing: object) -> Iterator[tuple[str, object]]:
    yield from attributes_of(thing).items()
    for cls in type(thing).__mro__:
        slots = cls.__dict__.get("__slots__", ())
        for name in (slots,) if isinstance(slots, str) else slots:
            member = cls.__dict__.get(name)
            if isinstance(member, types.MemberDescriptorType):
                try:
                    yield name, member.__get__(thing)
                except AttributeError:
                    continue  # an empty slot


def _title(value: Any) -> str:
    if isinstance(value, types.ModuleType):
        return f"the module {value.__name__}"
    return f"{value.__module__}.{value.__qualname__}"
