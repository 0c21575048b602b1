"""A copy of the package outside of the repository, in which one defect at a time is planted.

The copy stays in one folder, and files that do not change keep their times: so Python's bytecode
and numba's compiled kernels, which are found by path and time, are used again for all defects.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import multisrt
from benchmarks.mutants.mutant import Mutant

PACKAGE: Final = "multisrt"

NOT_COPIED: Final = "__pycache__"


class ProgramCopy:
    """A copy of the package.

    Parameters
    ----------
    folder : Path
        Where it is, with its compiled kernels; it is made if need be.

    Attributes
    ----------
    path : Path
        The folder to be put on the import path.
    package : Path
        The package in it.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder.resolve() / "program"
        self.package = self.path / PACKAGE
        self._kernels = folder.resolve() / "kernels"

    def prepare(self, mutant: Mutant | None) -> None:
        """Make it equal to the package in use, and plant a defect.

        Parameters
        ----------
        mutant : Mutant or None
            The defect; None: none.

        Raises
        ------
        InvalidInputError
            If the text of the mutant is not in the package.
        """
        source = Path(str(multisrt.__file__)).parent
        wanted = dict(_files_in(source))
        for name, path in _files_in(self.package):
            if name not in wanted:
                path.unlink()
        for name, path in wanted.items():
            there = self.package / name
            if not _is_equal(path, there):
                there.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(path, there)
        if mutant is not None:
            mutant.plant(self.package)

    def environment(self) -> dict[str, str]:
        """Return the environment of a process that uses the copy, and its compiled kernels."""
        return os.environ | {
            "PYTHONPATH": str(self.path),
            "NUMBA_CACHE_DIR": str(self._kernels),
            "PYTHONDONTWRITEBYTECODE": "",
        }


def _files_in(package: Path) -> Iterator[tuple[str, Path]]:
    """Yield the files of a package by their names in it; parts of it may be links to folders."""
    for folder, folders, files in os.walk(package, followlinks=True):
        folders[:] = [name for name in folders if name != NOT_COPIED]
        for file in files:
            path = Path(folder, file)
            yield path.relative_to(package).as_posix(), path


def _is_equal(path: Path, other: Path) -> bool:
    if not other.is_file():
        return False
    here, there = path.stat(), other.stat()
    return (here.st_size, here.st_mtime_ns) == (there.st_size, there.st_mtime_ns)
