"""What to change where the code of an explorer raises an exception."""

from __future__ import annotations

import inspect
import linecache
import re
from types import TracebackType
from typing import Any, get_args

import msgspec

from multisrt.geometry.errors import did_you_mean, shortened
from multisrt.robots.code_places import package_of, place_of_error, place_suffix
from multisrt.robots.defects import ExplorerDefect, Flaw, one_line
from multisrt.robots.explorer import Action, Sense

ACTIONS = {kind.__name__: kind for kind in get_args(Action)}
"""The actions by name."""

MAX_SAID = 400
"""Upper bound of what is cited of an exception, in characters."""

_ARGUMENTS = re.compile("Extra positional arguments|Unexpected keyword argument|Missing required")


def error_flaw(cls: Any, error: BaseException, usual: str) -> Flaw:
    """Return the flaw of an explorer that raised an exception, with the line of its code.

    Parameters
    ----------
    cls : type or callable
        The class of the explorer, or the function that builds it.
    error : exception
        What it raised.
    usual : str
        What to change if the exception does not tell more.

    Returns
    -------
    Flaw
        The exception with its place, and what to change.
    """
    if isinstance(error, ExplorerDefect):  # what a rule of assignment does
        return Flaw(f"{error.where}: {error.what}", error.remedy)
    text = _text(error)
    said = f": {shortened(one_line(text), MAX_SAID)}" if text else ""
    place = place_of_error(cls, error.__traceback__)
    meant = ""
    if isinstance(error, AttributeError) and error.name and error.obj is not None:
        meant = did_you_mean(error.name, dir(error.obj))
    remedy = _not_yielded(error, text) or _not_begun(error) or _arguments(error, text) or usual
    if remedy == usual and place:
        remedy = f"correct that line: {usual}"
    return Flaw(f"it raised {type(error).__name__}{said}{meant}{place_suffix(place)}", remedy)


def _text(error: BaseException) -> str:
    try:
        return str(error)
    except Exception:  # of the code of what the user raised
        return ""


def _not_yielded(error: BaseException, text: str) -> str:
    # An action that is used as if it were its outcome.
    found = re.search(r"'(\w+)' object|non-iterable (\w+) object", text)
    name = (found[1] or found[2]) if found is not None else ""
    if name not in ACTIONS or not isinstance(error, AttributeError | TypeError):
        return ""
    outcome = "scan" if ACTIONS[name] is Sense else "outcome"
    return (
        f"a {name} is an action, and what comes of it is sent back when it is yielded: write "
        f"{outcome} = yield {name}({'...' if ACTIONS[name].__struct_fields__ else ''})"
    )


def _not_begun(error: BaseException) -> str:
    # An attribute that a class of this package sets, whose __init__ was not called.
    cls = type(getattr(error, "obj", None))
    if not isinstance(error, AttributeError) or package_of(cls) == "multisrt":
        return ""
    for base in cls.__mro__:
        made = base.__dict__.get("__init__")
        if made is None:
            continue
        if package_of(base) == "multisrt":
            return ""
        ours = [other for other in cls.__mro__ if package_of(other) == "multisrt"]
        code = getattr(made, "__code__", None)
        is_called = code is not None and {"super", "__init__"} & set(code.co_names)
        if not ours or is_called or not any("__init__" in vars(other) for other in ours):
            return ""
        return f"begin {base.__name__}.__init__ with super().__init__(me, options)"
    return ""


def _arguments(error: BaseException, text: str) -> str:
    # How the structures are built that the innermost line names.
    if not (isinstance(error, TypeError) and _ARGUMENTS.match(text)):
        return ""
    trace: TracebackType | None = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None:
        return ""
    frame = trace.tb_frame
    line = linecache.getline(frame.f_code.co_filename, trace.tb_lineno)
    kinds = [frame.f_globals.get(name) for name in re.findall(r"\b(\w+)\(", line)]
    heads = [
        f"{kind.__name__}({_fields(kind)})"
        for kind in kinds
        if isinstance(kind, type) and issubclass(kind, msgspec.Struct)
    ]
    return f"write {' or '.join(heads)}" if heads else ""


def _fields(kind: type[msgspec.Struct]) -> str:
    return ", ".join(
        f"{one.name}=..." if one.kind is one.KEYWORD_ONLY else one.name
        for one in inspect.signature(kind).parameters.values()
    )
