"""Provenance of results: versions, machine, and a digest of the program."""

from __future__ import annotations

import ast
import hashlib
import platform
import re
import sys
from collections.abc import Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path

import msgspec

_IMPORTS = re.compile(rb"^[ \t]*(?:from|import) multisrt\.(\w+)", re.MULTILINE)
"""Imports of parts of this package. To parse all files would cost a short check a quarter more."""


class Provenance(msgspec.Struct, frozen=True, kw_only=True):
    """Versions and machine that made results.

    Attributes
    ----------
    versions : dict of str to str
        Versions of Python and of the packages that results depend on.
    program : str
        Digest of the source; see `program_digest`.
    machine, system : str
        Processor architecture and operating system.
    strategies : dict of str to str
        Digests of the source of the strategies that are not built in, by name.
    """

    versions: dict[str, str]
    program: str
    machine: str
    system: str
    strategies: dict[str, str] = {}


@cache
def provenance() -> Provenance:
    """Return the provenance of results made by this process.

    Returns
    -------
    Provenance
        Versions, program and machine.
    """
    packages = ("multisrt", "numpy", "scipy", "shapely", "numba", "ompl", "python-fcl", "simpy")
    return Provenance(
        versions={"python": platform.python_version()} | {p: version(p) for p in packages},
        program=program_digest(),
        machine=platform.machine(),
        system=f"{platform.system()} ({sys.platform})",
    )


def differences(one: Provenance, other: Provenance) -> str:
    """Return how two provenances differ, in words.

    Parameters
    ----------
    one, other : Provenance
        What made results.

    Returns
    -------
    str
        Versions, processor, system or source that differ; empty if results compare.
    """
    found = [
        f"{name} {one.versions.get(name, 'none')} and {other.versions.get(name, 'none')}"
        for name in dict.fromkeys((*one.versions, *other.versions))
        if one.versions.get(name) != other.versions.get(name)
    ]
    found += [
        f"{what} {a} and {b}"
        for what, a, b in (
            ("processor", one.machine, other.machine),
            ("system", one.system, other.system),
        )
        if a != b
    ]
    if not found and one.program != other.program:
        found = [f"another source of multisrt, {one.program} and {other.program}"]
    return ", ".join(found)


def changed_strategies(one: Provenance, other: Provenance) -> list[str]:
    """Return the user-defined strategies that two provenances have in different versions.

    Parameters
    ----------
    one, other : Provenance
        What made results.

    Returns
    -------
    list of str
        Names; a strategy that one of them lacks is not among them.
    """
    return [
        name
        for name, digest in one.strategies.items()
        if other.strategies.get(name, digest) != digest
    ]


@cache
def program_digest(*also: str) -> str:
    """Return a digest of what decides a run's outcome: code, and the bundled maps.

    Parameters
    ----------
    *also : str
        Other parts of this package that count, without what they import.

    Returns
    -------
    str
        Sixteen hexadecimal digits.

    Notes
    -----
    That is everything in `multisrt.simulation` and in every part of this package that it imports,
    directly or not, and `multisrt.informed`, which it loads by name. Docstrings, blank lines,
    lines of comment and the messages of raised errors do not count.
    """
    digest = hashlib.sha256()
    # What `informed` imports besides is `analysis`, by which all runs are measured.
    files = _files_behind("simulation") | _files_in("informed")
    for part in also:
        files |= _files_in(part)
    for name, source in sorted(files.items()):
        content = code_of(source) if name.endswith((".py", "/")) else source
        digest.update(f"{name} {len(content)}\n".encode())
        digest.update(content)
    return digest.hexdigest()[:16]


@cache
def parts_behind(part: str) -> frozenset[str]:
    """Return a part of this package with all parts that it imports, directly or not.

    Parameters
    ----------
    part : str
        Name of a folder or module directly in this package.

    Returns
    -------
    frozenset of str
        Names of folders and modules directly in this package.
    """
    return frozenset(name.split("/")[0] for name in _files_behind(part))


def _files_behind(part: str) -> dict[str, bytes]:
    # An imported file stands for its whole folder: some files are loaded by name, from a table.
    found: dict[str, bytes] = {}
    parts, waiting = {part}, [part]
    while waiting:
        for name, source in _files_in(waiting.pop()).items():
            found[name] = source
            imported = {each.decode() for each in _IMPORTS.findall(source)}
            waiting.extend(imported - parts)
            parts |= imported
    return found


def _files_in(part: str) -> dict[str, bytes]:
    """Return the content of each file of a part by its name; that of a module ends with a slash."""
    top = Path(__file__).parents[1]
    # rglob does not descend into a symbolic link.
    folder = (top / part).resolve()
    if not folder.is_dir():
        return {f"{part}/": (top / f"{part}.py").read_bytes()}
    return {
        f"{part}/{path.relative_to(folder).as_posix()}": path.read_bytes()
        for path in _files_of(folder)
    }


def _files_of(folder: Path) -> Iterator[Path]:
    for path in folder.rglob("[!.]*"):
        if path.is_file() and "__pycache__" not in path.parts:
            yield path


def code_of(source: bytes) -> bytes:
    """Return what counts of the source of a module.

    Parameters
    ----------
    source : bytes
        The content of a Python file, in UTF-8.

    Returns
    -------
    bytes
        The source without docstrings, blank lines, comments and messages of raised errors.
    """
    text = source.decode("utf-8")
    lines = text.splitlines()
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Expr(value=ast.Constant(value=str()), lineno=first, end_lineno=last):
                lines[first - 1 : last] = [""] * ((last or first) - first + 1)
            case ast.Raise(exc=ast.Call(func=error), end_lineno=last):
                first = error.end_lineno or error.lineno
                lines[first - 1] = lines[first - 1][: error.end_col_offset]
                lines[first:last] = [""] * ((last or first) - first)
    code = "\n".join(line for line in lines if line.strip() and not line.lstrip().startswith("#"))
    return code.encode()
