"""Writing files that belong together: all or none, and over existing files only if allowed."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path

from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.recording import atomic_write


def require_new(paths: Iterable[Path], *, overwrite: bool) -> None:
    """Raise an `InvalidInputError` if a file exists and may not be replaced, or is a folder."""
    for path in paths:
        if path.is_dir():
            raise _is_folder(path)
        if not overwrite and os.path.lexists(path):
            raise InvalidInputError(
                f"{path} exists already; name another file, or replace it with overwrite=True"
            )


def write_files(files: Mapping[Path, bytes], *, overwrite: bool) -> None:
    """Write files, which get their names only when all have been written completely.

    Parameters
    ----------
    files : mapping of Path to bytes
        Their contents. The first gets its name last: it may name the others.
    overwrite : bool
        Whether files that exist are replaced.

    Raises
    ------
    InvalidInputError
        If a file exists and may not be replaced, or cannot be written.
    """
    require_new(files, overwrite=overwrite)
    with ExitStack() as stack:
        for path, content in files.items():
            stack.enter_context(atomic_write(path)).write(content)


def require_suffix(path: Path, known: Mapping[str, object], what: str) -> str:
    """Return the suffix of a path in lower case.

    Parameters
    ----------
    path : Path
        The path.
    known : mapping
        The known suffixes as keys; values that are strings describe them.
    what : str
        What is written, for the message.

    Raises
    ------
    InvalidInputError
        If it is not a known suffix, or the path is that of a folder.

    Examples
    --------
    >>> require_suffix(Path("hall.txt"), {".yaml": "a map", ".yml": "a map", ".dxf": "DXF"}, "maps")
    Traceback (most recent call last):
    multisrt.geometry.errors.InvalidInputError: hall.txt: '.txt' is no format of maps; maps are \
written as .yaml, .yml: a map; .dxf: DXF
    """
    if path.is_dir():
        raise _is_folder(path)
    suffix = path.suffix.lower()
    if suffix in known:
        return suffix
    said = f"{suffix!r} is no format of {what}" if suffix else "no suffix determines the format"
    hint = did_you_mean(suffix, known)
    raise InvalidInputError(f"{path}: {said}{hint}; {what} are written as {_listed(known)}")


def _listed(known: Mapping[str, object]) -> str:
    """Return suffixes with what describes them, which is said once for several of them."""
    suffixes: dict[str, list[str]] = {}
    for one, text in known.items():
        suffixes.setdefault(f": {text}" if isinstance(text, str) else "", []).append(one)
    joined = [", ".join(some) + text for text, some in suffixes.items()]
    return ("; " if len(joined) < len(known) else ", ").join(joined)


def _is_folder(path: Path) -> InvalidInputError:
    return InvalidInputError(f"cannot write {path}: it is a folder; name a file")
