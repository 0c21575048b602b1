"""Folders for compiled kernels, such that none is ever older than the kernels that it calls.

numba compares a cached kernel with the file that defines it, and with no other. Here the kernels
of every file have a folder named after a digest of that file and of all files of this package
that it imports, directly or not. A change in any of them leads to another folder.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numba
import platformdirs

PACKAGE = __name__.partition(".")[0]

_IMPORT = re.compile(
    rf"^(?:from|import) +({PACKAGE}[\w.]*)(?: +import +(?:\(([^)]*)\)|(.*)))?", re.MULTILINE
)
_LOCK = threading.Lock()


@contextmanager
def cache_for(module: str) -> Iterator[bool]:
    """Direct numba's cache to the folder of a module while a ``with`` block is executed.

    Parameters
    ----------
    module : str
        Name of the module that declares kernels in the block; its imports have been executed.

    Yields
    ------
    bool
        Whether the kernels can be cached, that is, whether there is a writable folder.
    """
    with _LOCK:
        before = numba.config.CACHE_DIR
        folder = _folder(module, before)
        if folder is None:
            yield False
            return
        numba.config.CACHE_DIR = str(folder)
        try:
            yield True
        finally:
            numba.config.CACHE_DIR = before


def imported_files(module: str) -> dict[str, Path]:
    """Return a module and all modules of this package that it imports, directly or not.

    Parameters
    ----------
    module : str
        Name of a module that is loaded. Imports within functions do not count.

    Returns
    -------
    dict of str to Path
        File of each module, sorted by the modules' names.

    Examples
    --------
    >>> list(imported_files("multisrt.geometry.configuration"))
    ['multisrt.geometry.configuration']
    """
    found: dict[str, Path] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        file = getattr(sys.modules.get(name), "__file__", None)
        if name not in found and file is not None:
            found[name] = Path(file)
            waiting.extend(_imports(found[name]))
    return dict(sorted(found.items()))


def _imports(file: Path) -> Iterator[str]:
    for name, many, one in _IMPORT.findall(_source(file).decode()):
        yield name
        # A name imported from a package may be a module.
        yield from (f"{name}.{part}" for part in re.findall(r"\w+", many or one))


@cache
def _source(file: Path) -> bytes:
    return file.read_bytes()


@cache
def _folder(module: str, chosen_by_user: str) -> Path | None:
    digest = hashlib.sha256()
    for name, file in imported_files(module).items():
        digest.update(f"{name} {hashlib.sha256(_source(file)).hexdigest()}\n".encode())
    stem = module.rpartition(".")[2]
    name = f"{stem}-{digest.hexdigest()[:16]}"
    in_tree = Path(str(sys.modules[module].__file__)).parent / "__pycache__"
    users = platformdirs.user_cache_path("multisrt")
    bases = (Path(chosen_by_user),) if chosen_by_user else (in_tree, users)
    for base in bases:
        try:
            (base / name).mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(base / name, os.W_OK):
            if base == in_tree:
                _remove_others(base, stem, name)
            return base / name
    warnings.warn(
        "kernels are recompiled in every process, which takes a minute: none of "
        f"{', '.join(map(str, bases))} can be written to; set NUMBA_CACHE_DIR to a folder "
        "that can",
        stacklevel=2,
    )
    return None


def _remove_others(base: Path, stem: str, name: str) -> None:
    # The folders beside the sources of other versions of this file are out of date.
    for folder in base.glob(f"{stem}-????????????????"):
        if folder.name != name:
            shutil.rmtree(folder, ignore_errors=True)
