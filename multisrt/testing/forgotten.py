"""What is forgotten in the code of an explorer: `yield`, `yield from`, `return`."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterator
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple, get_args

from multisrt.robots.code_places import package_of
from multisrt.robots.defects import Flaw
from multisrt.robots.explorer import Action


class _Method(NamedTuple):
    # A method of the user, its syntax, and what its file's lines are counted from.
    function: Any
    tree: ast.FunctionDef
    place: str
    line: int


def forgotten_yield(cls: type) -> Flaw | None:
    """Return the first statement of an explorer that makes a generator or an action and drops it.

    Parameters
    ----------
    cls : type
        The class of the explorer.

    Returns
    -------
    Flaw or None
        Such as a line ``self.look_around()``, which does nothing: none of what is in that
        procedure is done unless its actions are yielded. None if there is no such line, or the
        code cannot be read.
    """
    for method in _methods(cls):
        for node in ast.walk(method.tree):
            if not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)):
                continue
            called = ast.unparse(node.value.func)
            made = _named(cls, method.function, node.value.func)
            where = f"{method.place}:{method.line + node.lineno}, in {method.tree.name}"
            if inspect.isgeneratorfunction(made):
                return Flaw(
                    f"it calls {called}(), which yields actions, and lets go of them ({where}): "
                    "nothing of it is done",
                    f"write yield from {ast.unparse(node.value)}",
                )
            if made in get_args(Action):
                return Flaw(
                    f"it makes a {called} and does not yield it ({where}): nothing comes of it",
                    f"write yield {ast.unparse(node.value)}",
                )
    return None


def forgotten_return(cls: type) -> str:
    """Return which method `choose` returns nothing in any case, as text; empty if there is none.

    Parameters
    ----------
    cls : type
        The class of the explorer.

    Returns
    -------
    str
        Such as ``choose (mine.py:20) returns nothing``.
    """
    for method in _methods(cls):
        if method.tree.name == "choose" and not any(
            isinstance(node, ast.Return | ast.Yield | ast.YieldFrom | ast.Raise)
            for node in ast.walk(method.tree)
        ):
            return f"choose ({method.place}:{method.line + method.tree.lineno}) returns nothing"
    return ""


def writes_run(cls: type) -> bool:
    """Whether a class has a method `run` of its own, and does not take it from this package."""
    own = [base for base in cls.__mro__ if base is cls or package_of(base) != "multisrt"]
    return any("run" in vars(base) for base in own)


def _methods(cls: type) -> Iterator[_Method]:
    for base in cls.__mro__:
        if package_of(base) in ("multisrt", "builtins"):
            continue
        for function in vars(base).values():
            if not isinstance(function, FunctionType):
                continue
            if inspect.getattr_static(cls, function.__name__, None) is not function:
                continue  # it is overridden
            try:
                lines, first = inspect.getsourcelines(function)
                tree = ast.parse(textwrap.dedent("".join(lines))).body[0]
            except (OSError, TypeError, SyntaxError, IndexError):  # made without a file
                continue
            if isinstance(tree, ast.FunctionDef):
                place = Path(function.__code__.co_filename).name
                yield _Method(function, tree, place, first - 1)


def _named(cls: type, function: FunctionType, name: ast.expr) -> object:
    # The method or global that is called.
    match name:
        case ast.Attribute(ast.Name("self"), attribute):
            return inspect.getattr_static(cls, attribute, None)
        case ast.Name(of_module):
            return function.__globals__.get(of_module)
    return None
