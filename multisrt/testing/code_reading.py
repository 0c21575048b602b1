"""Names that the code of an explorer's class uses, and where; the code is read, not run."""

from __future__ import annotations

import builtins
import dis
import functools
import sys
import types
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from importlib.util import resolve_name
from itertools import pairwise
from typing import Any, NamedTuple

from multisrt.experiments.provenance import parts_behind
from multisrt.robots.code_places import package_of
from multisrt.robots.library_files import folders_above

OwnCode = type | types.FunctionType
"""What is read of an explorer: its class, or the function that it asks where to go."""

BY_TEXT = object()
"""Stands for whatever a module holds, where code looks it up by a text."""

_LOOKS_UP = (getattr, vars)
_OPEN_TO_ALL = ("multisrt", "builtins", "gc", "inspect", "sys")
"""Packages whose modules lead to the truth by a text, whatever takes them as an argument."""

_NO_LOADS = ("CACHE", "PRECALL", "NOP", "EXTENDED_ARG", "RESUME", "PUSH_NULL")
_EQUIVALENT = {
    "LOAD_NAME": "LOAD_GLOBAL",
    "LOAD_DEREF": "LOAD_FAST",
    "LOAD_FAST_CHECK": "LOAD_FAST",
    "LOAD_FAST_AND_CLEAR": "LOAD_FAST",
    "LOAD_METHOD": "LOAD_ATTR",
    "STORE_DEREF": "STORE_FAST",
    "STORE_GLOBAL": "POP_TOP",
    "STORE_NAME": "POP_TOP",
    "SET_ADD": "BUILD_SET",
}
"""Instructions that are read as others."""

_PAIRS = {
    "LOAD_FAST_LOAD_FAST": ("LOAD_FAST", "LOAD_FAST"),
    "STORE_FAST_LOAD_FAST": ("STORE_FAST", "LOAD_FAST"),
    "STORE_FAST_STORE_FAST": ("STORE_FAST", "STORE_FAST"),
}
"""Instructions that Python 3.13 and later have for two."""

_BUILDERS = ("__init__", "__new__", "__post_init__")


class Named(NamedTuple):
    """A thing that code names.

    Attributes
    ----------
    name : str
        The name for messages, such as ``global 'WORLD'`` or ``time.time``.
    value : object
        The thing; `BY_TEXT` for a name that is looked up in a module by a text.
    code : code or None
        The code that names it; None for an attribute of the class and a default.
    line : int or None
        Line of its file.
    is_called : bool
        Whether it is a method that is called.
    """

    name: str
    value: object
    code: types.CodeType | None = None
    line: int | None = None
    is_called: bool = False


class _Step(NamedTuple):
    # An instruction, as `_EQUIVALENT` and `_PAIRS` have it.
    operation: str
    argument: Any
    line: int | None
    is_called: bool = False


class _Loaded(NamedTuple):
    # A value on the stack: what names it, what it is if that is known, and a constant.
    name: str = ""
    value: object = None
    constant: Any = None


def own_code_of(explorer: object) -> OwnCode:
    """Return the code of an explorer that is its author's.

    Parameters
    ----------
    explorer : Explorer
        The explorer. One of this package may ask a function of its author's: a policy, a rule of
        assignment. It names that function in its attribute `asks`.

    Returns
    -------
    type or function
        Its class, if that is none of this package; else the function that it asks, or the class
        of the object that it asks; else its class.
    """
    cls = type(explorer)
    asked: Any = getattr(explorer, "asks", None)
    if package_of(cls) != "multisrt" or asked is None:
        return cls
    while isinstance(asked, functools.partial) or (
        hasattr(asked, "__wrapped__") and not isinstance(asked, types.FunctionType)
    ):
        asked = asked.func if isinstance(asked, functools.partial) else asked.__wrapped__
    if isinstance(asked, types.MethodType):
        asked = asked.__self__
    own = asked if isinstance(asked, OwnCode) else type(asked)
    return cls if package_of(own) == "multisrt" or _is_installed(own) else own


def names_in_reach(cls: OwnCode, *, as_it_runs: bool = False) -> Iterator[Named]:
    """Yield what the code of a class names, and that of what it names in the same package.

    Parameters
    ----------
    cls : type or function
        The code of an explorer, see `own_code_of`. Classes of this package name nothing: import
        rules cover them.
    as_it_runs : bool
        Whether to leave out what builds an object of the class: `__init__`, and methods that
        nothing else names.

    Yields
    ------
    Named
        Globals, class attributes, defaults, imports and attributes of modules.
    """
    if package_of(cls) == "multisrt":
        return
    waiting: deque[Any] = deque([cls])
    read: set[int] = set()
    if as_it_runs and isinstance(cls, type):
        waiting = deque(_running_parts(cls))
        read = {id(base) for base in cls.__mro__}
    while waiting:
        thing = waiting.popleft()
        if id(thing) in read:
            continue
        read.add(id(thing))
        for named in _named_in(thing):
            yield named
            inner = function_of(named.value) or named.value
            if (
                isinstance(inner, type | types.FunctionType)
                and package_of(inner) == package_of(cls)
                and not is_of_truth(named.value)
            ):
                waiting.append(inner)


def function_of(value: object) -> types.FunctionType | None:
    """Return the function of a function, method or property; None for anything else."""
    for inner in (value, getattr(value, "__func__", None), getattr(value, "fget", None)):
        if isinstance(inner, types.FunctionType):
            return inner
    return None


def is_of_truth(value: object) -> bool:
    """Whether a thing is a module that knows the world or simulates it, or defined in one."""
    if isinstance(value, types.ModuleType):
        return _is_truth_module(value.__name__)
    if isinstance(value, type | types.FunctionType):
        return _is_truth_module(value.__module__)
    return False


def names_in_code(code: types.CodeType, known: Mapping[str, object]) -> Iterator[Named]:
    """Yield names of some code, and attributes of modules, such as `ms.environment`.

    Parameters
    ----------
    code : code
        The code of a function.
    known : mapping
        Its globals.

    Yields
    ------
    Named
        What it names.
    """
    reader = _Reader(known)
    for step in _steps_of(code):
        for name, value in reader.read(step):
            yield Named(name, value, code, step.line, step.is_called)


class _Reader:
    """Follows values from loads to stores, instruction by instruction.

    What any other instruction does to the stack does not matter: it uses up all that is loaded.
    """

    def __init__(self, known: Mapping[str, object]) -> None:
        self._known = known
        self._local: dict[str, object] = {}
        self._stack: list[_Loaded] = []

    def read(self, step: _Step) -> Iterator[tuple[str, object]]:
        """Yield what an instruction names, as name and value."""
        argument = step.argument
        match step.operation:
            case "LOAD_GLOBAL":
                value = self._known.get(argument, getattr(builtins, argument, None))
                self._stack.append(_Loaded(argument, value))
                yield f"global {argument!r}", value
            case "LOAD_FAST":
                self._stack.append(_Loaded(argument, self._local.get(argument)))
            case "LOAD_CONST":
                self._stack.append(_Loaded(constant=argument))
                # An attribute by its name, such as those that `operator.attrgetter` takes.
                parts = argument.split(".") if isinstance(argument, str) else [""]
                if all(map(str.isidentifier, parts)):
                    yield f".{argument}", None
            case "LOAD_ATTR":
                self._stack.append(_attribute(self._pop(), argument))
                yield self._stack[-1][:2]
            case "IMPORT_NAME":
                yield self._import(argument)
            case "IMPORT_FROM":
                source = self._stack[-1] if self._stack else _Loaded()
                name = f"{source.name}.{argument}"
                value = getattr(source.value, argument, sys.modules.get(name))
                self._stack.append(_Loaded(name, value))
                yield f"import of {name}", value
            case "STORE_FAST":
                self._local[argument] = self._pop().value
            case "POP_TOP":
                self._pop()
            case "COPY" if argument <= len(self._stack):
                self._stack.append(self._stack[-argument])
            case "SWAP" if argument <= len(self._stack):
                stack = self._stack
                stack[-1], stack[-argument] = stack[-argument], stack[-1]
            case operation:
                if operation == "BUILD_SET":
                    yield "a set", set
                yield from self._looked_up()
                self._stack.clear()

    def _pop(self) -> _Loaded:
        return self._stack.pop() if self._stack else _Loaded()

    def _import(self, argument: str) -> tuple[str, object]:
        # `import a.b` leaves `a` on the stack; only `from a.b import c` leaves `a.b`.
        names, level = self._pop().constant, self._pop().constant
        name = argument
        if level:
            with suppress(ImportError):
                name = resolve_name("." * level + argument, str(self._known.get("__package__")))
        module = _module(name)
        bound = name if names else name.partition(".")[0]
        self._stack.append(_Loaded(bound, module if names else _module(bound)))
        return f"import of {name}", module

    def _looked_up(self) -> Iterator[tuple[str, object]]:
        # Modules that are given to a function that may take names as text, such as `getattr`.
        for before, (name, value, _) in pairwise([_Loaded(), *self._stack]):
            if not isinstance(value, types.ModuleType):
                continue
            if any(before.value is each for each in _LOOKS_UP):
                yield f"{before.name}({name})", BY_TEXT
            elif value.__name__.partition(".")[0] in _OPEN_TO_ALL:
                yield f"{name} as an argument", BY_TEXT


def _attribute(of: _Loaded, name: str) -> _Loaded:
    if not isinstance(of.value, types.ModuleType | type):
        return _Loaded(f".{name}")
    is_table = name == "__dict__" and isinstance(of.value, types.ModuleType)
    return _Loaded(f"{of.name}.{name}", BY_TEXT if is_table else getattr(of.value, name, None))


def _module(name: str) -> types.ModuleType | None:
    # A module as far as it is imported; one that knows the truth counts before that, too.
    module = sys.modules.get(name)
    return types.ModuleType(name) if module is None and _is_truth_module(name) else module


def _steps_of(code: types.CodeType) -> Iterator[_Step]:
    # The instructions of some code, as far as they load and store.
    line: int | None = code.co_firstlineno
    for each in dis.get_instructions(code):
        if sys.version_info >= (3, 13):
            line = each.line_number or line
        else:
            line = each.starts_line or line
        name = each.opname
        # Python 3.11 has an instruction for methods, later versions a flag.
        is_called = name == "LOAD_METHOD" or (name.endswith("_ATTR") and "NULL" in each.argrepr)
        if name in _PAIRS:  # two loads or stores in one instruction
            for operation, argument in zip(_PAIRS[name], each.argval, strict=True):
                yield _Step(operation, argument, line)
        elif name == "LOAD_SUPER_ATTR":  # a call of super, and an attribute of the result
            yield _Step("CALL", None, line)
            yield _Step("LOAD_ATTR", each.argval, line, is_called)
        elif name not in _NO_LOADS:
            argument = each.arg if name in ("COPY", "SWAP") else each.argval
            yield _Step(_EQUIVALENT.get(name, name), argument, line, is_called)


def contents(cell: types.CellType) -> object:
    """Return what a cell of a closure holds; None if it is empty."""
    try:
        return cell.cell_contents
    except ValueError:
        return None


def defaults(function: types.FunctionType, of: str) -> Iterable[tuple[str, object]]:
    """Return the defaults of a function's parameters, by a name for messages."""
    values = [*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()]
    return [(f"{of}{function.__name__}()", value) for value in values]


def _named_in(thing: Any) -> Iterator[Named]:
    # The attributes of a class, or what the code of a function names.
    if isinstance(thing, type):
        for base in thing.__mro__:
            if package_of(base) == package_of(thing):
                for name, value in base.__dict__.items():
                    if not name.startswith("__") or function_of(value) is not None:
                        yield Named(f"{base.__name__}.{name}", value)
        return
    for name, value in defaults(thing, "default of "):
        yield Named(name, value)
    for cell in thing.__closure__ or ():
        inner = contents(cell)
        if function_of(inner) is not None or isinstance(inner, type):
            yield Named("closure", inner)
    waiting = [thing.__code__]
    while waiting:
        code = waiting.pop()
        waiting += [part for part in code.co_consts if isinstance(part, types.CodeType)]
        yield from names_in_code(code, thing.__globals__)


def _running_parts(cls: type) -> list[types.FunctionType]:
    # The functions of a class without those that build its objects.
    methods = {
        name: function
        for base in reversed(cls.__mro__)
        if package_of(base) == package_of(cls)
        for name, value in base.__dict__.items()
        if (function := function_of(value)) is not None
    }
    named = {name: _attributes_in(function.__code__) - {name} for name, function in methods.items()}
    elsewhere = {each for name in named if name not in _BUILDERS for each in named[name]}
    building = {each for name in named if name in _BUILDERS for each in named[name]} - elsewhere
    return [
        function
        for name, function in methods.items()
        if name not in _BUILDERS and (name not in building or name == "run")
    ]


def _attributes_in(code: types.CodeType) -> set[str]:
    parts = [part for part in code.co_consts if isinstance(part, types.CodeType)]
    return {*code.co_names, *(name for part in parts for name in _attributes_in(part))}


def _is_installed(thing: OwnCode) -> bool:
    # Whether it is of an installed library, such as a model that is a policy.
    file = getattr(sys.modules.get(thing.__module__), "__file__", None) or ""
    return not isinstance(thing, types.FunctionType) and bool(folders_above(file))


def _is_truth_module(name: str | None) -> bool:
    # What the robots of this package do without is of the truth, or has to do with it.
    package, _, inner = (name or "").partition(".")
    part = inner.partition(".")[0]
    return package == "multisrt" and part not in ("", "testing", *parts_behind("robots"))
