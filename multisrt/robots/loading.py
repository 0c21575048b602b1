"""User-defined strategies by reference: ``file.py:Name``, ``package.module:Name`` or ``file.py``.

``file.py:Name=other`` gives the strategy of a class another name than that of the class.

A reference is followed only where a user gives it, on the command line or in Python: specs and
recordings hold the plain name of a strategy, and never lead to an import.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import os
import re
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.robots.registry import is_known, register, strategies
from multisrt.robots.strategy import Strategy, as_strategy
from multisrt.robots.user_modules import (
    Place,
    forget,
    forget_outdated,
    keep_track,
    outdated,
    require_current,
    users_modules,
)

if TYPE_CHECKING:
    from multisrt.robots.explorer import Explorer

HOW_TO_NAME = (
    "a reference is FILE.py, FILE.py:NAME, MODULE or MODULE:NAME; FILE.py:NAME=OTHER gives the "
    "strategy of a class another name"
)

_importing: ContextVar[str] = ContextVar("_importing", default="")
_registered: dict[str, Strategy] = {}
"""The strategies that were registered here, not by the module that has them."""

_brought: set[Place] = set()
"""The users' modules that were first imported for a file here."""


def is_reference(text: str) -> bool:
    """Whether a text is a reference to a user-defined strategy, and not a strategy's name.

    Parameters
    ----------
    text : str
        The text.

    Returns
    -------
    bool
        Whether it names a Python file, or a name in a file or module.

    Examples
    --------
    >>> [is_reference(text) for text in ("mine.py", "mine.py:Mine", "lab.mine:Mine", "minpos")]
    [True, True, True, False]
    """
    place, name, _ = split_reference(text)
    return _is_file(place) or bool(name and re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", place))


def split_reference(reference: str) -> tuple[str, str, str]:
    """Return the parts of a reference.

    Parameters
    ----------
    reference : str
        As `load_strategy` takes it.

    Returns
    -------
    place, name, own_name : str
        File or module, name in it, and name for the strategy; empty where not given.

    Examples
    --------
    >>> split_reference("mine.py:Mine=other"), split_reference("lab.mine")
    (('mine.py', 'Mine', 'other'), ('lab.mine', '', ''))
    """
    found = re.fullmatch(r"(?P<place>.*):(?P<name>[^\W\d]\w*)(=(?P<own>[\w-]+))?", reference)
    return (found["place"], found["name"], found["own"] or "") if found else (reference, "", "")


def load_strategy(reference: str) -> Strategy:
    """Import a user-defined strategy; it is not registered.

    Parameters
    ----------
    reference : str
        ``file.py:Name`` or ``package.module:Name``, where the name is that of a `Strategy`, of the
        class of an explorer, or of a function that builds one; without a name the file must
        have exactly one strategy or, if it has none, one class of an explorer. The strategy of a
        class gets another name by ``file.py:Name=other-name``.

    Returns
    -------
    Strategy
        The strategy.

    Raises
    ------
    InvalidInputError
        If there is no such file, module or name, or importing it fails; the message says where.

    Examples
    --------
    >>> load_strategy("multisrt.informed.registration:INFORMED").name
    'informed'
    >>> load_strategy("mine.py:Mine")
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: mine.py: there is no such file
    """
    place, name, own_name = split_reference(reference)
    module = import_place(place)
    candidates = candidates_in(module)
    if name:
        if name not in vars(module):
            raise InvalidInputError(
                f"{place} has no {name!r}{did_you_mean(name, candidates)}; it has: "
                f"{', '.join(candidates) or 'neither a Strategy nor the class of an explorer'}"
            )
        value = vars(module)[name]
        if own_name and isinstance(value, Strategy):
            raise InvalidInputError(
                f"{place}:{name} is a Strategy and has its own name, {value.name!r}; leave out "
                f"={own_name}"
            )
        return Strategy.of(value, name=own_name) if own_name else as_strategy(value)
    if not candidates:
        raise InvalidInputError(_no_candidate(place, module))
    if len(candidates) > 1:
        raise InvalidInputError(
            f"{place} has several strategies; name one: "
            f"{', '.join(f'{place}:{candidate}' for candidate in candidates)}"
        )
    return as_strategy(next(iter(candidates.values())))


def name_of(given: str | Strategy | Callable[..., Explorer]) -> str:
    """Return the name of a strategy, after registering it if it is not given by its name.

    Parameters
    ----------
    given : str, Strategy, class or function
        Its name, or a reference as `load_strategy` takes it; or what `Strategy.of` takes.

    Returns
    -------
    str
        The name. That it is known is not checked.

    Raises
    ------
    InvalidInputError
        If it cannot be imported, is something else, or has the name of a built-in strategy.

    Examples
    --------
    >>> name_of("minpos")
    'minpos'
    """
    if isinstance(given, str) and not is_reference(given):
        require_no_folder(given)
        return given
    own = load_strategy(given) if isinstance(given, str) else as_strategy(given)
    register(own, replace=True)
    return own.name


def import_reference(reference: str) -> tuple[Strategy, ...]:
    """Import what a user names, and register its strategies.

    Parameters
    ----------
    reference : str
        As `load_strategy` takes it, or the name of a module. Without a name, a module or file
        may register its strategies itself when it is imported; if it registers none, all that
        it has are registered.

    Returns
    -------
    tuple of Strategy
        The strategies that were registered here; empty if the module does that itself.

    Raises
    ------
    InvalidInputError
        If it cannot be imported, or a built-in strategy has the name of one of its strategies.

    Examples
    --------
    >>> import_reference("json")
    ()
    """
    place, name, _ = split_reference(reference)
    if name:
        found: tuple[Strategy, ...] = (load_strategy(reference),)
    else:
        module = import_place(place)
        if any(
            _is_from(module, each) and _registered.get(each.name) is not each
            for each in strategies()
        ):
            return ()
        found = tuple(as_strategy(each) for each in candidates_in(module).values())
    for strategy in found:
        register(strategy, replace=True)
        _registered[strategy.name] = strategy
    return found


def candidates_in(module: ModuleType) -> dict[str, Any]:
    """Return the strategies of a module, by name.

    Parameters
    ----------
    module : module
        The module.

    Returns
    -------
    dict of str to Strategy or type
        Its strategies; if it has none, the classes with a method `run` that are defined in it.

    Examples
    --------
    >>> from multisrt.informed import registration
    >>> list(candidates_in(registration))
    ['INFORMED']
    """
    named = {name: value for name, value in vars(module).items() if not name.startswith("_")}
    found: dict[str, Any] = {}
    for name, value in named.items():
        if isinstance(value, Strategy) and all(value is not other for other in found.values()):
            found[name] = value
    return found or {
        name: value
        for name, value in named.items()
        if inspect.isclass(value)
        and value.__module__ == module.__name__
        and inspect.isgeneratorfunction(getattr(value, "run", None))
    }


def import_place(place: str) -> ModuleType:
    """Import a module by its name, or a file under its stem.

    A file that has been imported already is imported again if it has changed since, or a file
    that it imports has; that one is imported again, too, if it was first imported for this file.
    The folder of the file is added to the end of the import path, so that it can import what is
    beside it. If its stem is that of another module, it is imported under a name of its own.

    Parameters
    ----------
    place : str
        Name of a module in the working directory or in a package that is installed, or the path
        of a file with the suffix ``.py``.

    Returns
    -------
    module
        The module.

    Raises
    ------
    InvalidInputError
        If it cannot be imported; the message says in which file and line. If a file that it
        imports has changed since others imported that.

    Examples
    --------
    >>> import_place("json").__name__
    'json'
    """
    if _is_file(place):
        return _import_file(place)
    _add_to_path(os.getcwd())
    if not re.fullmatch(r"[^\W\d]\w*(\.[^\W\d]\w*)*", place):
        raise InvalidInputError(f"{place!r} names no module; {HOW_TO_NAME}")
    with _told_errors(place, None):
        module = importlib.import_module(place)
    if getattr(module, "__file__", None) is None and hasattr(module, "__path__"):
        raise InvalidInputError(
            f"{place!r} is a folder without __init__.py; name the file, {place}/FILE.py, or a "
            f"module in it, {place}.MODULE"
        )
    return module


def require_no_folder(name: str) -> None:
    """Raise InvalidInputError if a folder is given in the place of a strategy.

    Parameters
    ----------
    name : str
        What is given as the name of a strategy.

    Raises
    ------
    InvalidInputError
        If there is a folder of that name, and no strategy.
    """
    folder = Path(name)
    if is_known(name) or not (name and folder.is_dir()):
        return
    files = sorted(folder.glob("*.py"))
    named = f", such as {files[0]}" if files else ""
    raise InvalidInputError(f"{name} is a folder; name the file of the strategy in it{named}")


def being_imported() -> str:
    """Return which module or file is being imported by this module; empty if none is.

    Examples
    --------
    >>> being_imported()
    ''
    """
    return _importing.get()


def _no_candidate(place: str, module: ModuleType) -> str:
    for name, value in vars(module).items():
        if (
            inspect.isclass(value)
            and value.__module__ == module.__name__
            and callable(getattr(value, "run", None))
        ):
            return (
                f"{place} has no strategy: {name}.run yields nothing, and is to be a generator: "
                "have it yield every action, as in scan = yield Sense(), and at last yield "
                f"Done(...); if it returns a generator that it has made, name {place}:{name}"
            )
    return f"{place} has no strategy: neither a Strategy nor a class with a method 'run'"


def _is_from(module: ModuleType, strategy: Strategy) -> bool:
    own = strategy.explorer.__module__
    return own == module.__name__ or own.startswith(f"{module.__name__}.")


def _import_file(place: str) -> ModuleType:
    path = Path(place).expanduser().resolve()
    try:
        content = path.read_bytes()
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        reason = "there is no such file" if missing else f"cannot be read ({error.strerror})"
        raise InvalidInputError(f"{place}: {reason}") from None
    _add_to_path(str(path.parent))
    name = _module_name(path)
    there = sys.modules.get(name)
    if there is not None and not outdated(there):
        return there
    forget_outdated(_brought)
    before = set(sys.modules)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        with _told_errors(place, path):
            # Not by the loader: its cache of compiled files goes by whole seconds.
            exec(compile(content, str(path), "exec", dont_inherit=True), vars(module))
    except BaseException:
        del sys.modules[name]
        for imported, _ in users_modules(set(sys.modules) - before, path.parent):
            forget(imported, sys.modules[imported])  # it may change before the next attempt
        raise
    behind = keep_track(module, content) | users_modules(set(sys.modules) - before, path.parent)
    _brought.update(each for each in behind if each[0] not in before | {name})
    require_current(module)
    return module


def _module_name(path: Path) -> str:
    """Return the stem of a file, or a longer name if another module has that."""
    stem = path.stem
    if stem.isidentifier() and stem != "__main__":
        there = sys.modules.get(stem)
        try:
            spec = importlib.util.find_spec(stem) if there is None else there.__spec__
        except (ImportError, ValueError):
            spec = None
        origin = getattr(there, "__file__", None) if spec is None else spec.origin
        if (there is None and spec is None) or (origin and Path(origin).resolve() == path):
            return stem
    own = hashlib.sha256(str(path).encode()).hexdigest()[:8]
    return f"{re.sub(r'[^0-9A-Za-z_]', '_', stem)}_{own}"


def _add_to_path(folder: str) -> None:
    # At the end: no file beside it shadows a library.
    if folder not in sys.path:
        sys.path.append(folder)


@contextmanager
def _told_errors(place: str, path: Path | None) -> Iterator[None]:
    """Turn whatever importing raises into an InvalidInputError of one line, with its place."""
    token = _importing.set(place)
    try:
        yield
    except ModuleNotFoundError as error:
        if path is None and error.name and f"{place}.".startswith(f"{error.name}."):
            beside = f"; did you mean {place}.py?" if Path(f"{place}.py").is_file() else ""
            raise InvalidInputError(
                f"there is no module {place!r} in the working directory or in a package that is "
                f"installed{beside}"
            ) from None
        raise _told(place, path, error) from None
    except (Exception, SystemExit) as error:  # code of others may raise anything
        raise _told(place, path, error) from None
    finally:
        _importing.reset(token)


def _told(place: str, path: Path | None, error: BaseException) -> InvalidInputError:
    what = " ".join(str(error).split())
    if isinstance(error, SyntaxError):
        where = f"{Path(error.filename or place).name}:{error.lineno}"
        return InvalidInputError(f"{place} is not Python: {error.msg} ({where})")
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename != __file__ and not frame.filename.startswith("<frozen importlib")
    ]
    own = [frame for frame in frames if path is None or frame.filename == str(path)]
    at = f" ({Path(own[-1].filename).name}:{own[-1].lineno})" if own else ""
    kind = "" if isinstance(error, InvalidInputError) else f"{type(error).__name__}: "
    return InvalidInputError(f"cannot import {place}: {kind}{what}{at}")


def _is_file(place: str) -> bool:
    return place.endswith(".py")
