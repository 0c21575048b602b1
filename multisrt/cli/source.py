"""Strategies of one's own, and generators, as their files say, which are read and never imported.

For completion: code of others does not run, and kernels are not loaded, because a key is pressed.
What is computed when a file is imported is not found here: names and options that the file does not
spell out are left out.
"""

from __future__ import annotations

import ast
import os
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

MAX_STEPS = 20
"""Upper bound of steps from a name to what it stands for: imports may go in circles."""


class Option(NamedTuple):
    """An option of a strategy.

    Attributes
    ----------
    default : str
        Its default, as it is written; empty if it has none.
    words : tuple of str
        The words that it may be, as far as these are few.
    """

    default: str
    words: tuple[str, ...]


class OwnStrategy(NamedTuple):
    """A strategy in a file.

    Attributes
    ----------
    name : str
        Its name as a strategy; empty if the file computes it.
    options : dict of str to Option
        Its options, by name.
    """

    name: str
    options: dict[str, Option]


def strategies_in(place: str) -> dict[str, OwnStrategy]:
    """Return the strategies of a file or module, by the names that they have in it.

    Parameters
    ----------
    place : str
        Path of a Python file, or the name of a module.

    Returns
    -------
    dict of str to OwnStrategy
        As `multisrt.robots.loading.candidates_in` finds them: strategies, or the classes of
        explorers if there are none. Empty if there is no such file, or it is not Python.

    Examples
    --------
    >>> own = strategies_in("multisrt.robots.toolkit.templates.planner")["Mine"]
    >>> own.name, own.options["gain"], own.options["shape"].words
    ('mine', Option(default='1.0', words=()), ('ball', 'star', 'radial'))
    """
    path = _resolved(place) if place.endswith(".py") else _path_of(place, Path())
    source = None if path is None else _source(path)
    if source is None:
        return {}
    try:
        return _strategies_of(source)
    except RecursionError:  # a name that stands for itself
        return {}


def keywords_of(module: str, function: str) -> dict[str, Option]:
    """Return the parameters of a function that are given by name, in their order.

    Parameters
    ----------
    module, function : str
        The module, and the name of the function in it.

    Returns
    -------
    dict of str to Option
        Empty if there is no such function.

    Examples
    --------
    >>> keywords_of("multisrt.environments.generators.open", "open_hall")["columns"]
    Option(default='0', words=())
    """
    path = _path_of(module, Path())
    source = None if path is None else _source(path)
    node = None if source is None else source.defined.get(function)
    if source is None or not isinstance(node, ast.FunctionDef):
        return {}
    return {
        one.arg: Option(
            _written(default),
            () if one.annotation is None else tuple(_words(source, one.annotation)),
        )
        for one, default in zip(node.args.kwonlyargs, node.args.kw_defaults, strict=True)
    }


def _strategies_of(source: Source) -> dict[str, OwnStrategy]:
    public = {name: node for name, node in source.defined.items() if name[0] != "_"}
    found = {name: node for name, node in public.items() if _is_strategy(Named(source, node))}
    found = found or {
        name: node
        for name, node in public.items()
        if isinstance(node, ast.ClassDef) and _member(Named(source, node), "run") is not None
    }
    named = {name: Named(source, node) for name, node in found.items()}
    return {name: OwnStrategy(_name_of(own), _options_of(own)) for name, own in named.items()}


@dataclass(frozen=True)
class Source:
    """What a Python file defines and imports.

    Attributes
    ----------
    path : Path
        The file.
    defined : dict of str to node
        Its classes, its functions, and the values of its variables, by name.
    imported : dict of str to (str, str, int)
        Module, name in it (empty: the module itself) and level of what it imports.
    """

    path: Path
    defined: dict[str, ast.AST]
    imported: dict[str, tuple[str, str, int]]


class Named(NamedTuple):
    """What a name stands for, and the file that says so."""

    source: Source
    node: ast.AST


# Files and names ---------------------------------------------------------------------------


def _resolved(path: str | Path) -> Path:
    return Path(path).expanduser().resolve()


@cache
def _source(path: Path) -> Source | None:
    try:
        body = ast.parse(path.read_bytes()).body
    except (OSError, SyntaxError, ValueError, RecursionError):
        return None
    source = Source(path, {}, {})
    for node in body:
        # Under ``if TYPE_CHECKING`` there is what annotations name.
        for statement in node.body if isinstance(node, ast.If) else (node,):
            match statement:
                case ast.ClassDef(name=name) | ast.FunctionDef(name=name):
                    source.defined[name] = statement
                case ast.Assign(targets=[ast.Name(id=name)], value=value):
                    source.defined[name] = value
                case ast.AnnAssign(target=ast.Name(id=name), value=ast.expr() as value):
                    source.defined[name] = value
                case ast.ImportFrom(module=module, names=names, level=level):
                    for one in names:
                        own = module or "", one.name, level
                        source.imported[one.asname or one.name] = own
                case ast.Import(names=names):
                    for one in names:
                        if one.asname or "." not in one.name:
                            source.imported[one.asname or one.name] = one.name, "", 0
    return source


def _path_of(module: str, folder: Path, level: int = 0) -> Path | None:
    """Return the file of a module, which a file in a folder imports."""
    inner = module.replace(".", "/")
    # As when it is imported: no file beside it hides a library.
    roots = [*map(Path, sys.path), folder, Path()]
    if level:
        roots = [folder.joinpath(*[".."] * (level - 1))]
    for root in roots:
        for path in (root / f"{inner}.py", root / inner / "__init__.py"):
            if os.path.isfile(path):  # False where it may not be looked at, too
                return _resolved(path)
    return None


def _found(source: Source, node: ast.AST, steps: int = MAX_STEPS) -> Named | None:
    """Return what an expression names: a class, a function, or a value; None if not found."""
    if steps == 0:
        return None
    match node:
        case ast.Constant(value=str(text)):  # an annotation in quotes
            try:
                return _found(source, ast.parse(text, mode="eval").body, steps - 1)
            except (SyntaxError, ValueError):
                return None
        case ast.Name(id=name) if name in source.defined:
            return _found(source, source.defined[name], steps - 1)
        case ast.Name(id=name) if name in source.imported:
            return _imported(source, *source.imported[name], steps - 1)
        case ast.Name():
            return None
        case ast.Attribute(value=ast.Name(id=name), attr=attribute) if name in source.imported:
            module, inner, level = source.imported[name]
            whole = ".".join(filter(None, (module, inner)))
            return _imported(source, whole, attribute, level, steps - 1)
        case _:
            return Named(source, node)


def _imported(source: Source, module: str, name: str, level: int, steps: int) -> Named | None:
    path = _path_of(module, source.path.parent, level)
    there = None if path is None else _source(path)
    return None if there is None else _found(there, ast.Name(id=name), steps)


def _classes(named: Named) -> list[Named]:
    """Return a class and those that it derives from, as far as they are found."""
    found: dict[ast.AST, Named] = {}
    left = [named]
    while left:
        one = left.pop(0)
        if isinstance(one.node, ast.ClassDef) and one.node not in found:
            found[one.node] = one
            left += filter(None, (_found(one.source, base) for base in one.node.bases))
    return list(found.values())


def _member(named: Named, name: str) -> Named | None:
    """Return a function, class or value in a class or in those that it derives from."""
    for source, node in _classes(named):
        for statement in getattr(node, "body", ()):
            match statement:
                case ast.FunctionDef(name=own) | ast.ClassDef(name=own) if own == name:
                    return Named(source, statement)
                case ast.Assign(targets=[ast.Name(id=own)], value=value) if own == name:
                    return Named(source, value)
    return None


# Strategies and options --------------------------------------------------------------------


def _is_strategy(named: Named) -> bool:
    match named.node:
        case ast.FunctionDef(decorator_list=[decorator]):
            return _makes_strategies(named.source, decorator)
        case ast.Call(func=function):
            return _makes_strategies(named.source, function)
    return False


def _makes_strategies(source: Source, function: ast.AST) -> bool:
    """Whether a call gives a `Strategy`: its class, a method of that, or a function's result."""
    if isinstance(function, ast.Call):
        function = function.func
    if isinstance(function, ast.Attribute) and function.attr == "of":
        function = function.value
    made = _found(source, function)
    match made:
        case Named(node=ast.ClassDef(name="Strategy")):
            return True
        case Named(node=ast.FunctionDef(returns=ast.expr() as returned)):
            return "Strategy" in ast.unparse(returned)
    return False


def _name_of(named: Named) -> str:
    """Return the name of a strategy: that which is given, or that of a class or function.

    Empty if it is computed.
    """
    from multisrt.robots.strategy import kebab_case

    node = named.node
    call = node.decorator_list[0] if isinstance(node, ast.FunctionDef) else node
    if isinstance(call, ast.Call):
        if given := _given(call, "name"):
            return _text(named.source, given[0])
        match call.args[:1]:
            case [ast.Name(id=made) | ast.Attribute(attr=made)]:
                return kebab_case(made)
            case [first]:
                return _text(named.source, first)
    return kebab_case(getattr(node, "name", ""))


def _text(source: Source, node: ast.AST) -> str:
    """Return the text that an expression spells out, or that of the variable that it names."""
    value = source.defined.get(node.id) if isinstance(node, ast.Name) else node
    return value.value if isinstance(value, ast.Constant) and isinstance(value.value, str) else ""


def _options_of(named: Named) -> dict[str, Option]:
    structure = _structure(named)
    found: dict[str, Option] = {}
    for source, node in reversed(list(_classes(structure)) if structure is not None else []):
        for field in getattr(node, "body", ()):
            match field:
                case ast.AnnAssign(target=ast.Name(id=name), annotation=kind, value=value):
                    if not ast.unparse(kind).startswith(("ClassVar", "typing.ClassVar")):
                        found[name] = Option(_written(value), tuple(_words(source, kind)))
    return found


def _structure(named: Named) -> Named | None:
    """Return the structure of options of what makes explorers, or of a strategy."""
    source, node = named
    match node:
        case ast.ClassDef():
            return _structure_of_class(named)
        case ast.FunctionDef(decorator_list=[decorator]) if _is_strategy(named):
            return _structure_of_call(source, decorator)
        case ast.FunctionDef():
            return _annotated(source, node, 1)
        case ast.Call():
            return _structure_of_call(source, node)
    return None


def _structure_of_class(named: Named) -> Named | None:
    # As `Strategy.of` finds it.
    made_by = _member(named, "__init__")
    if made_by is not None:
        structure = _annotated(*made_by, 2)
        if structure is not None and isinstance(structure.node, ast.ClassDef):
            return structure
    inner = _member(named, "Options")
    return None if inner is None else _found(*inner)


def _structure_of_call(source: Source, node: ast.AST) -> Named | None:
    function = node.func if isinstance(node, ast.Call) else node
    if isinstance(node, ast.Call) and (given := _given(node, "options")):
        return _found(source, given[0])
    match function:
        case ast.Attribute(attr="of"):
            of = [*node.args[:1], *_given(node, "explorer")] if isinstance(node, ast.Call) else []
            made = _found(source, of[0]) if of else None
            return None if made is None else _structure(made)
    # By default that of the function that is called, or of the strategy that it makes.
    called = _found(source, function)
    if called is None or not isinstance(called.node, ast.FunctionDef):
        return None
    arguments = called.node.args
    for argument, default in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True):
        if argument.arg == "options" and default is not None:
            return _found(called.source, default)
    for inner in ast.walk(called.node):
        if isinstance(inner, ast.Call) and _given(inner, "options"):
            return _structure_of_call(called.source, inner)
    return None


def _given(call: ast.Call, name: str) -> list[ast.expr]:
    """Return what a call gives for a keyword: one value or none."""
    return [keyword.value for keyword in call.keywords if keyword.arg == name]


def _annotated(source: Source, node: ast.AST, number: int) -> Named | None:
    """Return what the annotation of a parameter of a function names, by its number from 0.

    None if it is no function, or has no such parameter.
    """
    if not isinstance(node, ast.FunctionDef):
        return None
    parameters = [*node.args.posonlyargs, *node.args.args]
    if number >= len(parameters) or (annotation := parameters[number].annotation) is None:
        return None
    return _found(source, annotation)


def _written(value: ast.expr | None) -> str:
    from multisrt.validation_errors import written

    if value is None:
        return ""
    return written(value.value) if isinstance(value, ast.Constant) else ast.unparse(value)


def _words(source: Source, kind: ast.AST) -> list[str]:
    """Return the words that an annotation allows; see `validation_errors.allowed_words`."""
    match kind:
        case ast.Constant(value=None):
            return ["none"]
        case ast.Name(id="bool"):
            return ["true", "false"]
        case ast.BinOp(left=left, op=ast.BitOr(), right=right):
            return _words(source, left) + _words(source, right)
        case ast.Subscript(value=ast.Name(id="Literal"), slice=inner):
            ones = inner.elts if isinstance(inner, ast.Tuple) else [inner]
            return [str(one.value) for one in ones if isinstance(one, ast.Constant)]
        case ast.Name() | ast.Constant(value=str()):
            alias = _found(source, kind)
            is_kind = alias is not None and isinstance(alias.node, ast.Subscript | ast.BinOp)
            return _words(*alias) if alias is not None and is_kind else []
    return []
