"""The source of user-defined strategies, as far as results depend on it."""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import ModuleType

from multisrt.experiments.modules import home_modules, own_strategies
from multisrt.experiments.provenance import Provenance, code_of, provenance
from multisrt.experiments.spec import ExperimentSpec
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.loading import is_outdated
from multisrt.robots.strategy import Strategy

_LIBRARIES = tuple(
    Path(sysconfig.get_path(kind)).resolve()
    for kind in ("stdlib", "platstdlib", "purelib", "platlib")
)


def provenance_with(own: Iterable[Strategy]) -> Provenance:
    """Return the provenance of results that this process makes with user-defined strategies.

    Parameters
    ----------
    own : iterable of Strategy
        The strategies.

    Returns
    -------
    Provenance
        Versions, machine, program, and the digests of the strategies' source.
    """
    base = provenance()
    return Provenance(
        versions=base.versions,
        program=base.program,
        machine=base.machine,
        system=base.system,
        strategies={strategy.name: source_digest(strategy) for strategy in own},
    )


def source_digest(own: Strategy) -> str:
    """Return a digest of the source of a strategy.

    That is the code of the file that defines it and of what it imports, directly or not, from
    files that are neither libraries nor part of this package. Docstrings, blank lines, comments
    and the messages of raised errors do not count, nor where the files are.

    Parameters
    ----------
    own : Strategy
        The strategy.

    Returns
    -------
    str
        Equal for equal source; empty if there is no file, as for a notebook's cell.

    Raises
    ------
    InvalidInputError
        If a file cannot be read, or has changed since this process imported it.
    """
    files = sorted(_code_behind(own))
    if not files:
        return ""
    digest = hashlib.sha256()
    for code in files:
        digest.update(f"{len(code)}\n".encode())
        digest.update(code)
    return digest.hexdigest()[:16]


def require_files(spec: ExperimentSpec) -> None:
    """Check that changes of user-defined strategies can be noticed when results are kept.

    Parameters
    ----------
    spec : ExperimentSpec
        The experiment.

    Raises
    ------
    InvalidInputError
        If a strategy is defined in a notebook's cell or at the prompt.
    """
    for own in own_strategies(spec):
        if not source_digest(own):
            raise InvalidInputError(
                f"the strategy {own.name!r} is in no file, and results in a store could be of "
                "several versions of it; write it to a file and import it from there (in a "
                "notebook: %%writefile mine.py), or keep results in memory alone: leave out store"
            )


def _code_behind(own: Strategy) -> Iterator[bytes]:
    begin = {}
    for module in home_modules(own):
        _require_current(module)
        file = getattr(module, "__file__", None)
        if file is not None and file.endswith(".py") and Path(file).exists():
            begin[Path(file).resolve()] = module.__package__ or ""
    roots = [path.parent for path in begin]
    waiting, seen = list(begin.items()), set(begin)
    while waiting:
        path, package = waiting.pop()
        try:
            code, tree = code_of(path.read_bytes())
        except (OSError, SyntaxError, UnicodeDecodeError) as error:
            raise InvalidInputError(f"{path}: cannot be read as Python: {error}") from None
        yield code
        for its_package, imported in _imports(tree, package):
            found = _file_of(imported)
            if found is not None and found not in seen and _is_own(found, roots):
                _require_current(sys.modules.get(imported))
                seen.add(found)
                waiting.append((found, its_package))


def _require_current(module: ModuleType | None) -> None:
    if module is not None and is_outdated(module):
        raise InvalidInputError(
            f"{Path(module.__file__ or '').name} has changed since it was imported here: start "
            f"again, or import it again (importlib.reload) and pass its strategy again"
        )


def _imports(tree: ast.Module, package: str) -> Iterator[tuple[str, str]]:
    """Yield the full names that a module in a package imports, each with the package it is in."""
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
                path = _file_of(full)
                is_package = path is not None and path.name == "__init__.py"
                yield (full if is_package else full.rpartition(".")[0]), full


def _file_of(name: str) -> Path | None:
    """Return the Python file of a module by its full name, without importing it."""
    top, *rest = name.split(".")
    if top in ("", "multisrt"):
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
    """Whether a file is not a library's, or of the package that defines the strategy."""
    libraries = [library for library in _LIBRARIES if path.is_relative_to(library)]
    beside = [root for root in roots if path.is_relative_to(root)]
    return all(
        any(root != library and root.is_relative_to(library) for root in beside)
        for library in libraries
    )
