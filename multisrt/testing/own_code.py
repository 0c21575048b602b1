"""Places in the code of an explorer, for messages, and names in it that explain a defect."""

from __future__ import annotations

import datetime
import gc
import inspect
import io
import os
import random
import secrets
import sys
import time
import types
import uuid
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from types import FrameType
from typing import Any

import numpy as np

from multisrt.robots.code_places import file_of, place_among
from multisrt.testing import watchdog
from multisrt.testing.code_reading import BY_TEXT, Named, OwnCode, function_of, names_in_reach
from multisrt.testing.surroundings import CLOCKS

MAX_NAMES = 3
"""How many places a message names at most."""

_CHANCE = (
    np.random.default_rng,
    np.random.RandomState,
    random.Random,
    random.SystemRandom,
    os.urandom,
    uuid.uuid1,
    uuid.uuid4,
)
_CLOCKS = (
    datetime.datetime,
    datetime.date.today,
    *(getattr(time, name) for name in CLOCKS),
    *(getattr(time, f"{name}_ns") for name in CLOCKS),
)
_ORDER = (set, frozenset, id, hash)

_HIDING = (
    eval,
    exec,
    globals,
    __import__,
    gc.get_objects,
    gc.get_referrers,
    gc.get_referents,
    sys._getframe,
    sys._current_frames,
    sys.modules,
    inspect.currentframe,
    inspect.stack,
    inspect.trace,
    inspect.getmembers,
    BY_TEXT,
)
_HIDING_MODULES = ("importlib", "ctypes")
_FRAMES = (
    "f_back",
    "f_locals",
    "f_globals",
    "f_builtins",
    "tb_frame",
    "gi_frame",
    "__globals__",
    "__subclasses__",
)
_OUTSIDE = (
    open,
    io.FileIO,
    os.open,
    os.popen,
    os.system,
    os.listdir,
    os.scandir,
    os.walk,
    np.load,
    np.loadtxt,
    np.genfromtxt,
    np.fromfile,
    np.memmap,
)
_OUTSIDE_MODULES = (
    "pathlib",
    "glob",
    "mmap",
    "subprocess",
    "multiprocessing",
    "socket",
    "sqlite3",
    "urllib",
)


_FILE_METHODS = ("open", "read_bytes", "read_text", "write_bytes", "write_text")
"""Methods of paths and archives by which files are read and written."""


def place_of_frame(cls: Any, frame: FrameType | None) -> str:
    """Return where in the code of an explorer it computes, as text for a message.

    Parameters
    ----------
    cls : type or callable
        The class of the explorer, or the function that builds it.
    frame : frame or None
        The innermost frame.

    Returns
    -------
    str
        Such as ``mine.py:34, in choose: costs[goal]``; empty if there is no frame of its code.
    """
    frames = []
    while frame is not None and frame.f_code.co_filename != watchdog.__file__:
        frames.append((frame.f_code, frame.f_lineno))
        frame = frame.f_back
    return place_among(cls, frames)


def chance_in(cls: OwnCode) -> str:
    """Return where a class uses random numbers that are not its robot's, as text; may be empty."""
    generators = (random.Random, np.random.RandomState)
    return _places(
        named
        for named in names_in_reach(cls)
        if isinstance(getattr(named.value, "__self__", None), generators)
        or _is_any(named.value, _CHANCE)
        or getattr(named.value, "__module__", None) == secrets.__name__
    )


def clocks_in(cls: OwnCode) -> str:
    """Return where a class names a clock, as text; may be empty."""
    return _places(
        named
        for named in names_in_reach(cls)
        if _is_any(named.value, _CLOCKS)
        or getattr(named.value, "__self__", None) in (datetime.datetime, datetime.date)
    )


def order_in(cls: OwnCode) -> str:
    """Return where a class names what depends on where objects lie in memory; may be empty."""
    return _places(named for named in names_in_reach(cls) if _is_any(named.value, _ORDER))


@lru_cache(maxsize=8)
def back_door(cls: OwnCode) -> str:
    """Return the first name in a class's code that leads round the contract to the truth.

    Parameters
    ----------
    cls : type or function
        The code of an explorer, see `own_code_of`.

    Returns
    -------
    str
        The name and its place, such as ``gc.get_objects (mine.py:12)``; empty if there is none.
    """
    for named in names_in_reach(cls):
        if (
            _is_any(named.value, _HIDING)
            or _is_of(named, _HIDING_MODULES)
            or not set(_FRAMES).isdisjoint(named.name.split("."))
        ):
            return _at(named)
    return ""


@lru_cache(maxsize=8)
def outside_in(cls: OwnCode) -> str:
    """Return the first name by which code reads files or starts programs while it runs.

    Parameters
    ----------
    cls : type or function
        The code of an explorer, see `own_code_of`. What builds its objects is left out.

    Returns
    -------
    str
        The name and its place, such as ``open (mine.py:12)``; empty if there is none.
    """
    for named in names_in_reach(cls, as_it_runs=True):
        if _is_any(named.value, _OUTSIDE) or _is_of(named, _OUTSIDE_MODULES) or _opens(named, cls):
            return _at(named)
    return ""


def _places(names: Iterator[Named]) -> str:
    found = list(dict.fromkeys(_at(named) for named in names))
    return ", ".join(found[:MAX_NAMES])


def _at(named: Named) -> str:
    name = named.name.removeprefix("global ").strip("'")
    return name if named.code is None else f"{name} ({file_of(named.code)}:{named.line})"


def _methods_in_reach(cls: OwnCode) -> set[str]:
    # The names of the methods of the classes that the code of a class names, and its own.
    names = [named.name for named in names_in_reach(cls) if function_of(named.value) is not None]
    return {name.rpartition(".")[2] for name in names}


def _opens(named: Named, cls: OwnCode) -> bool:
    # Whether it is a call such as path.open(), of an object that is not known.
    method = named.name.removeprefix(".")
    return (
        named.is_called
        and named.name != method
        and method in _FILE_METHODS
        and method not in _methods_in_reach(cls)
    )


def _is_any(value: object, others: Iterable[Any]) -> bool:
    return any(value is other or _is_same_method(value, other) for other in others)


def _is_same_method(value: object, other: object) -> bool:
    # Each access to a method makes a new object.
    owner = getattr(value, "__self__", None)
    return (
        isinstance(owner, type)
        and owner is getattr(other, "__self__", None)
        and getattr(value, "__name__", None) == getattr(other, "__name__", "")
    )


def _is_of(named: Named, modules: Sequence[str]) -> bool:
    # Whether a thing is one of some modules, or of one; some may not be loaded yet.
    home = named.name.removeprefix("import of ") if named.name.startswith("import of ") else ""
    if isinstance(named.value, types.ModuleType):
        home = named.value.__name__
    elif isinstance(named.value, type | types.FunctionType | types.BuiltinFunctionType):
        home = named.value.__module__ or ""
    return home.partition(".")[0] in modules
