"""Modules of users: the files behind them, and whether these have changed since their import."""

from __future__ import annotations

import ast
import importlib.util
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.library_files import folders_above

_Import = ModuleSpec | ModuleType | None
"""One import of a module: its spec, as every import and reload creates a new spec; a main program
has none and stands for itself. None: not imported yet."""

Place = tuple[str, Path]
"""The full name of a module, and its file."""

_sources: dict[Place, tuple[_Import, bytes | None]] = {}
"""The source that an import read; None if that is not known any more. Of a module that is not
imported yet, the source that its first import will probably read."""

_used: dict[str, tuple[_Import, dict[str, _Import]]] = {}
"""The imports of users' modules that an import of a module found, by its name."""


class SourceFile(NamedTuple):
    """A file of a user.

    Attributes
    ----------
    name : str
        Full name of its module.
    path : Path
        The file.
    content : bytes
        What it holds now.
    imports : tuple of str
        Full names of the users' modules that it imports.
    """

    name: str
    path: Path
    content: bytes
    imports: tuple[str, ...]


def files_behind(modules: Iterable[ModuleType]) -> Iterator[SourceFile]:
    """Yield the files of modules and of what they import, directly or not, by their text.

    Files of libraries and of multisrt do not count, but those of the library that a module is
    part of do.

    Parameters
    ----------
    modules : iterable of module
        The modules.

    Yields
    ------
    SourceFile
        Each module once.

    Raises
    ------
    InvalidInputError
        If a file cannot be read as Python.
    """
    waiting = {}
    for module in modules:
        path = path_of(module)
        if path is not None:
            waiting[module.__name__] = path, module.__package__ or ""
    roots, seen = [path.parent for path, _ in waiting.values()], set(waiting)
    while waiting:
        name, (path, package) = waiting.popitem()
        try:
            content = path.read_bytes()
            tree = ast.parse(content)
        except (OSError, SyntaxError, ValueError) as error:
            raise InvalidInputError(f"{path}: cannot be read as Python: {error}") from None
        imports: dict[str, None] = {}
        for its_package, imported, found in _imports(tree, package):
            if _is_own(found, roots):
                imports[imported] = None
                if imported not in seen:
                    seen.add(imported)
                    waiting[imported] = found, its_package
        yield SourceFile(name, path, content, tuple(imports))


def keep_track(module: ModuleType, content: bytes | None = None) -> set[Place]:
    """Note what the files behind a module hold, to notice later that they have changed.

    What was noted of the same import before stays.

    Parameters
    ----------
    module : module
        The module.
    content : bytes, optional
        The source that it was imported from; by default what its file holds.

    Returns
    -------
    set of Place
        The users' modules behind it, and itself.

    Raises
    ------
    InvalidInputError
        If a file cannot be read as Python.
    """
    path = path_of(module)
    if content is not None and path is not None:
        _sources[module.__name__, path] = _import_of(module), content
    places = set()
    for file in files_behind([module]):
        places.add((file.name, file.path))
        _note_source(file)
        now = _import_of(sys.modules.get(file.name))
        if now is None:
            continue
        noted, used = _used.get(file.name, (None, {}))
        if noted is not now:
            used = {}
            _used[file.name] = now, used
        for name in file.imports:
            found = _import_of(sys.modules.get(name))
            if found is not None:
                used.setdefault(name, found)
    return places


def outdated(module: ModuleType) -> str:
    """Return how a module is older than the files behind it, and keep track of it from now on.

    Parameters
    ----------
    module : module
        The module.

    Returns
    -------
    str
        What has changed since it was imported, as far as `keep_track` noted it or the compiled
        files tell that Python keeps; empty if nothing has.

    Raises
    ------
    InvalidInputError
        If a file cannot be read as Python.

    Examples
    --------
    >>> import json
    >>> outdated(json)
    ''
    """
    if not (what := _outdated(module)):
        keep_track(module)
        what = _outdated(module)
    return what


def require_current(module: ModuleType) -> None:
    """Check that a module is what its file and the users' files behind it hold.

    Parameters
    ----------
    module : module
        The module.

    Raises
    ------
    InvalidInputError
        If one of them has changed since this process imported it; the message says what to do.
    """
    if what := outdated(module):
        raise InvalidInputError(
            f"{what}: start again, or import it again (importlib.reload) and then what imports "
            "it, and give the strategy again"
        )


def forget_outdated(places: Iterable[Place]) -> None:
    """Forget imports of modules that are older than the files behind them.

    The next import of each reads its file, not what Python has kept compiled.

    Parameters
    ----------
    places : iterable of Place
        The modules; those that are not imported do not count.
    """
    known = [(name, sys.modules.get(name), path) for name, path in places]
    for name, module in [
        (name, module)
        for name, module, path in known
        if module is not None and path_of(module) == path and _outdated(module)
    ]:
        forget(name, module)


def forget(name: str, module: ModuleType) -> None:
    """Forget an import of a module: the next one reads its file.

    Parameters
    ----------
    name : str
        Its full name.
    module : module
        What it is imported as.
    """
    del sys.modules[name]
    above, _, last = name.rpartition(".")
    if above in sys.modules:
        vars(sys.modules[above]).pop(last, None)
    cached = getattr(module.__spec__, "cached", None)
    if cached:
        with suppress(OSError):  # it goes by whole seconds: a quick change is not noticed
            Path(cached).unlink(missing_ok=True)
    importlib.invalidate_caches()


def users_modules(names: Iterable[str], root: Path) -> set[Place]:
    """Return which imported modules are users'.

    Parameters
    ----------
    names : iterable of str
        Full names of imported modules.
    root : Path
        Folder of the module that imports them.

    Returns
    -------
    set of Place
        Those of files that are neither libraries' nor of multisrt.
    """
    files = {name: path_of(sys.modules[name]) for name in names if not is_ours(name)}
    return {(name, path) for name, path in files.items() if path and _is_own(path, [root])}


def _outdated(module: ModuleType) -> str:
    waiting, seen = [module], {module.__name__}
    while waiting:
        one = waiting.pop()
        if _has_changed(one):
            return f"{_file_name(one)} has changed since it was imported here"
        noted, used = _used.get(one.__name__, (None, {}))
        for name, found in used.items() if noted is _import_of(one) else ():
            now = sys.modules.get(name)
            if now is None or _import_of(now) is not found:
                return f"{name} was imported again since {_file_name(one)} imported it"
            if name not in seen:
                seen.add(name)
                waiting.append(now)
    return ""


def _note_source(file: SourceFile) -> None:
    module, key = sys.modules.get(file.name), (file.name, file.path)
    now = _import_of(module)
    noted, content = _sources.get(key, (None, file.content))
    if module is None:
        _sources[key] = None, file.content
    elif noted is not now:
        # First seen now: of what was not imported before, the file may have changed meanwhile.
        is_late = noted is None and content != file.content
        stale = is_late or _differs_from_compiled(module, file.path)
        _sources[key] = now, None if stale else file.content


def _has_changed(module: ModuleType) -> bool:
    path = path_of(module)
    if path is None:
        return False
    noted, content = _sources.get((module.__name__, path), (None, None))
    if noted is not None and noted is _import_of(module):
        return path.read_bytes() != content
    return _differs_from_compiled(module, path)


def _differs_from_compiled(module: ModuleType, path: Path) -> bool:
    cached = Path(getattr(module.__spec__, "cached", None) or "")
    header = cached.read_bytes()[:16] if cached.is_file() else b""
    if len(header) < 16 or header[4:8] != bytes(4):
        return False
    # Python's own check: modification time and size of the source, modulo 2 ** 32.
    now = path.stat()
    kept = [int.from_bytes(header[begin : begin + 4], "little") for begin in (8, 12)]
    return kept != [int(now.st_mtime) % 2**32, now.st_size % 2**32]


def _import_of(module: ModuleType | None) -> _Import:
    return None if module is None else module.__spec__ or module


def _file_name(module: ModuleType) -> str:
    return Path(module.__file__ or "").name


def path_of(module: ModuleType) -> Path | None:
    """Return the Python file of an imported module; None if it has none."""
    file = vars(module).get("__file__") if isinstance(module, ModuleType) else None
    path = Path(file) if isinstance(file, str) else Path()
    return path.resolve() if path.suffix == ".py" and path.is_file() else None


def is_ours(name: str) -> bool:
    """Whether a module, by its full name, is of this package."""
    return name.partition(".")[0] == "multisrt"


def _imports(tree: ast.Module, package: str) -> Iterator[tuple[str, str, Path]]:
    """Yield what a module in a package imports: the package it is in, full name and file."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                above = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*above, *filter(None, [base])])
            names = [base, *(f"{base}.{alias.name}" for alias in node.names)]
        else:
            continue
        for name in names:
            parts = name.split(".")
            for length in range(1, len(parts) + 1):
                full = ".".join(parts[:length])
                if (path := _file_of(full)) is not None:
                    is_package = path.name == "__init__.py"
                    yield (full if is_package else full.rpartition(".")[0]), full, path


def _file_of(name: str) -> Path | None:
    """Return the Python file of a module by its full name, without importing it."""
    top, *rest = name.split(".")
    if top == "" or is_ours(top):
        return None
    try:
        spec = sys.modules[top].__spec__ if top in sys.modules else importlib.util.find_spec(top)
    except (ImportError, ValueError):
        return None
    if spec is None:
        return None
    if not rest:
        path = Path(spec.origin) if spec.origin and spec.origin.endswith(".py") else None
        return path.resolve() if path is not None and path.exists() else None
    for folder in spec.submodule_search_locations or ():
        base = Path(folder).joinpath(*rest)
        for path in (base.with_suffix(".py"), base / "__init__.py"):
            if path.exists():
                return path.resolve()
    return None


def _is_own(path: Path, roots: list[Path]) -> bool:
    """Whether a file is no library's, or of the package that defines the strategy."""
    beside = [root for root in roots if path.is_relative_to(root)]
    return all(
        any(root != library and root.is_relative_to(library) for root in beside)
        for library in folders_above(path)
    )
