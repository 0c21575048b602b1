"""Places in code of the user's, for messages."""

from __future__ import annotations

import linecache
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, ModuleType, TracebackType
from typing import Any

from multisrt.robots.defects import brief
from multisrt.robots.library_files import is_library_file, is_own_file

MAX_SOURCE_LENGTH = 60
"""Characters of a line of code in a message."""


def package_of(thing: Any) -> str:
    """Return the name of the package that defines a class or function."""
    return str(getattr(thing, "__module__", "") or "").partition(".")[0]


def modules_of(cls: Any) -> list[ModuleType]:
    """Return the loaded modules of the package of a class or function, if it is not this one."""
    package = package_of(cls)
    if package == "multisrt":
        return []
    prefix = f"{package}."
    return [
        module
        for name, module in list(sys.modules.items())
        if (name == package or name.startswith(prefix)) and isinstance(module, ModuleType)
    ]


def place_of_error(cls: Any, trace: TracebackType | None) -> str:
    """Return where in the code of an explorer an exception was raised, as text for a message.

    Parameters
    ----------
    cls : type or callable
        The class of the explorer, or the function that builds it.
    trace : traceback or None
        That of the exception.

    Returns
    -------
    str
        Such as ``mine.py:34, in choose: costs[goal]``; empty if there is no frame of its code.

    Examples
    --------
    >>> place_of_error(object, None)
    ''
    """
    frames = []
    while trace is not None:
        frames.append((trace.tb_frame.f_code, trace.tb_lineno))
        trace = trace.tb_next
    return place_among(cls, frames[::-1])


def place_of_yield(cls: Any, actions: object) -> str:
    """Return where in the code of an explorer its last action was yielded, as text for a message.

    Parameters
    ----------
    cls : type or callable
        The class of the explorer, or the function that builds it.
    actions : generator
        The explorer's actions, suspended at a yield.

    Returns
    -------
    str
        As that of `place_of_error`; empty if it is not in code of the user's.

    Examples
    --------
    >>> place_of_yield(object, iter(()))
    ''
    """
    frames = []
    while (frame := getattr(actions, "gi_frame", None)) is not None:
        frames.append((frame.f_code, frame.f_lineno))
        actions = getattr(actions, "gi_yieldfrom", None)
    return place_among(cls, frames[::-1])


def place_among(cls: Any, frames: Sequence[tuple[CodeType, int]]) -> str:
    """Return the innermost of some places that is in the code of an explorer, as text.

    Parameters
    ----------
    cls : type or callable
        The class of the explorer, or the function that builds it.
    frames : sequence of (code, int)
        Code that is executed, and its line, the innermost first.

    Returns
    -------
    str
        As that of `place_of_error`. It is the innermost place in the files of the explorer, else
        in those of no package: a rule's explorer is of this package, and calls the function of the
        user.
    """
    is_ours = package_of(cls) == "multisrt"
    own = {name for name in (getattr(m, "__file__", None) for m in modules_of(cls)) if name}
    runs = [base.__dict__.get("run") for base in getattr(cls, "__mro__", ())]
    for made in (cls, *runs):
        file = made.__code__.co_filename if hasattr(made, "__code__") else ""
        if is_ours or not is_own_file(file):
            own.add(file)
    of_user = [one for one in frames if not is_library_file(one[0].co_filename)]
    inner = [one for one in frames if one[0].co_filename in own]
    for code, line in (*of_user[:1], *inner[:1]) if is_ours else (*inner[:1], *of_user[:1]):
        source = linecache.getline(code.co_filename, line).strip()
        where = f"{file_of(code)}:{line}, in {code.co_name}"
        return f"{where}: {_cut(source)}" if source else where
    return ""


def place_suffix(place: str) -> str:
    """Return a place in code as the end of a phrase; empty if it is not known."""
    return f" ({place})" if place else ""


def file_of(code: CodeType) -> str:
    """Return the name of the file that some code is in, as text for a message."""
    name = Path(code.co_filename)
    return "the notebook" if "ipykernel" in str(name) else name.name


def _cut(source: str) -> str:
    return brief(source, MAX_SOURCE_LENGTH + 2)[1:-1] if len(source) > MAX_SOURCE_LENGTH else source
