"""Which files are libraries': of Python, of installed packages and of multisrt."""

from __future__ import annotations

import sysconfig
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]

_FOLDERS = tuple(
    dict.fromkeys(
        Path(sysconfig.get_path(kind)).resolve()
        for kind in ("stdlib", "platstdlib", "purelib", "platlib")
    )
)


def folders_above(file: str | Path) -> list[Path]:
    """Return the folders of libraries that a file is in; none if it is a user's.

    Parameters
    ----------
    file : str or Path
        The file; empty for what has none.

    Examples
    --------
    >>> import json
    >>> bool(folders_above(json.__file__)), folders_above("mine.py"), folders_above("")
    (True, [], [])
    """
    path = Path(file).resolve()
    return [folder for folder in _FOLDERS if file and path.is_relative_to(folder)]


def is_library_file(file: str) -> bool:
    """Whether the code in a file is a library's, multisrt's, or of no file at all.

    Parameters
    ----------
    file : str
        The file, as code objects name it: ``<string>`` and its like are no files.

    Examples
    --------
    >>> is_library_file(__file__), is_library_file("<string>"), is_library_file("mine.py")
    (True, True, False)
    """
    return file.startswith("<") or is_own_file(file) or bool(folders_above(file))


def is_own_file(file: str) -> bool:
    """Whether a file is part of multisrt."""
    return Path(file).resolve().is_relative_to(_PACKAGE)
