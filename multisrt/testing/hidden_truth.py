"""The search for the truth in what an explorer holds and in what its code names.

An explorer may know its scans, its messages and itself. This search goes through all objects that
can be reached from it, and names the path to the first one that belongs to the world or to the
simulation.
"""

from __future__ import annotations

import builtins
import dis
import gc
import sys
import types
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import simpy
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.experiments.provenance import parts_behind
from multisrt.geometry.bodies.collision import CollisionWorld
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.robots.defects import brief

MAX_KEY_LENGTH = 40
"""Letters of the key of a table that a path shows."""

_PLAIN = (int, float, complex, str, bytes, type(None), types.ModuleType, types.CodeType)


def way_to_truth(roots: Mapping[str, object], world: Environment) -> tuple[str, str] | None:
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
    (way, what) or None
        A shortest path, such as ``explorer.planner._worlds[0]``, and what was found there; None
        if there is nothing.
    """
    seen: dict[int, object] = {}
    waiting = deque(roots.items())
    while waiting:
        way, thing = waiting.popleft()
        if id(thing) in seen or isinstance(thing, _PLAIN):
            continue
        seen[id(thing)] = thing
        if (what := _truth_in(thing, world)) is not None:
            return way, what
        if not isinstance(thing, type):
            waiting.extend((way + step, child) for step, child in _within(thing))
    return None


def named_by_code(cls: type) -> dict[str, object]:
    """Return what the code of an explorer's class names: globals, class attributes, imports.

    The code of functions and classes of the same package is read, too.

    Returns
    -------
    dict of str to object
        The named objects by their names for messages: all data, and modules, classes and functions
        that belong to the truth. Empty for classes of this package, which import rules cover.
    """
    found: dict[str, object] = {}
    if _package(cls) == "multisrt":
        return found
    waiting: deque[Any] = deque([cls])
    read: set[int] = set()
    while waiting:
        thing = waiting.popleft()
        if id(thing) in read:
            continue
        read.add(id(thing))
        for name, value in _named_in(thing):
            function = _function_of(value)
            if _is_of_truth(value):
                found.setdefault(name, value)
            elif function is not None or isinstance(value, type):
                if _package(function or value) == _package(cls):
                    waiting.append(function or value)
            elif not isinstance(value, types.ModuleType | types.BuiltinFunctionType):
                found.setdefault(name, value)
    return found


def truth_named_by_code(cls: type) -> tuple[str, str] | None:
    """Return the first module of the truth, or thing defined in one, that a class's code names.

    Returns
    -------
    (name, what) or None
        Its name in the code, and what it is; None if there is nothing.
    """
    for name, value in named_by_code(cls).items():
        if _is_of_truth(value):
            return name, _title(value)
    return None


def _truth_in(thing: object, world: Environment) -> str | None:
    # A description of a thing that is the truth.
    if isinstance(thing, np.ndarray):
        return "an array of the world's edges" if np.may_share_memory(thing, world.edges) else None
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
    return f"a {_title(type(thing))}" if _is_of_truth(type(thing)) else None


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
    if isinstance(thing, dict):
        for key, value in list(thing.items()):
            yield f"[{brief(key, MAX_KEY_LENGTH)}]", value
            yield " -> key", key
    elif isinstance(thing, list | tuple | deque):
        yield from ((f"[{k}]", value) for k, value in enumerate(thing))
    elif isinstance(thing, np.ndarray):
        yield ".base", thing.base
    else:
        yield from ((f".{name}", value) for name, value in _attributes(thing))
    # What else it refers to: items of sets, cells, parts of compiled objects.
    for value in gc.get_referents(thing):
        if not isinstance(value, type):
            yield f" -> held by the {type(thing).__name__}", value


def _within_function(function: types.FunctionType) -> Iterator[tuple[str, object]]:
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    for name, cell in cells:
        yield f" -> closure {name!r}", _contents(cell)
    yield from _defaults(function, " -> default of ")
    if _package(function) != "multisrt":
        for name, value in _named_in_code(function.__code__, function.__globals__):
            if _function_of(value) is None and not isinstance(value, type):
                yield f" -> {name}", value


def _attributes(thing: object) -> Iterator[tuple[str, object]]:
    yield from list(getattr(thing, "__dict__", {}).items())
    for cls in type(thing).__mro__:
        slots = cls.__dict__.get("__slots__", ())
        for name in (slots,) if isinstance(slots, str) else slots:
            member = cls.__dict__.get(name)
            if isinstance(member, types.MemberDescriptorType):
                try:
                    yield name, member.__get__(thing)
                except AttributeError:
                    continue  # an empty slot


def _named_in(thing: Any) -> Iterator[tuple[str, object]]:
    # The attributes of a class, or what the code of a function names.
    if isinstance(thing, type):
        for base in thing.__mro__:
            if _package(base) == _package(thing):
                for name, value in base.__dict__.items():
                    if not name.startswith("__") or _function_of(value) is not None:
                        yield f"{base.__name__}.{name}", value
        return
    yield from _defaults(thing, "default of ")
    for cell in thing.__closure__ or ():
        inner = _contents(cell)
        if _function_of(inner) is not None or isinstance(inner, type):
            yield "closure", inner
    waiting = [thing.__code__]
    while waiting:
        code = waiting.pop()
        waiting += [part for part in code.co_consts if isinstance(part, types.CodeType)]
        yield from _named_in_code(code, thing.__globals__)


def _named_in_code(
    code: types.CodeType, known: Mapping[str, object]
) -> Iterator[tuple[str, object]]:
    # Names, and attributes of named modules, such as `ms.environment` of a module `ms`.
    name: str = ""
    current: object = None
    local: dict[str, object] = {}
    for instruction in dis.get_instructions(code):
        operation, argument = instruction.opname, instruction.argval
        if operation in ("LOAD_GLOBAL", "LOAD_NAME"):
            name, current = argument, known.get(argument, getattr(builtins, argument, None))
            yield f"global {name!r}", current
        elif operation == "IMPORT_NAME":
            name, current = argument, sys.modules.get(argument)
            if current is None and _is_truth_module(argument):
                current = types.ModuleType(argument)
            yield f"import of {name}", current
        elif operation == "IMPORT_FROM" and isinstance(current, types.ModuleType):
            yield f"import of {name}.{argument}", getattr(current, argument, None)
        elif operation in ("LOAD_ATTR", "LOAD_METHOD") and isinstance(current, types.ModuleType):
            name, current = f"{name}.{argument}", getattr(current, argument, None)
            yield name, current
        elif operation in ("STORE_FAST", "STORE_DEREF"):
            local[argument], current = current, None
        elif operation in ("LOAD_FAST", "LOAD_DEREF"):
            name, current = argument, local.get(argument)
        else:
            current = None


def _is_of_truth(value: object) -> bool:
    # Whether it is a module of the truth, or defined in one.
    if isinstance(value, types.ModuleType):
        return _is_truth_module(value.__name__)
    if isinstance(value, type | types.FunctionType):
        return _is_truth_module(value.__module__)
    return False


def _is_truth_module(name: str | None) -> bool:
    # What the robots of this package do without is of the truth, or has to do with it.
    package, _, inner = (name or "").partition(".")
    part = inner.partition(".")[0]
    return package == "multisrt" and part not in ("", "testing", *parts_behind("robots"))


def _function_of(value: object) -> types.FunctionType | None:
    for inner in (value, getattr(value, "__func__", None), getattr(value, "fget", None)):
        if isinstance(inner, types.FunctionType):
            return inner
    return None


def _defaults(function: types.FunctionType, of: str) -> Iterable[tuple[str, object]]:
    values = [*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()]
    return [(f"{of}{function.__name__}()", value) for value in values]


def _contents(cell: types.CellType) -> object:
    try:
        return cell.cell_contents
    except ValueError:
        return None  # an empty cell


def _package(thing: Any) -> str:
    return str(getattr(thing, "__module__", "") or "").partition(".")[0]


def _title(value: Any) -> str:
    if isinstance(value, types.ModuleType):
        return f"the module {value.__name__}"
    return f"{value.__module__}.{value.__qualname__}"
