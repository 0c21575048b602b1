"""Provenance of results: versions, machine, and a digest of the program."""

from __future__ import annotations

import ast
import hashlib
import platform
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path

import msgspec


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
    """

    versions: dict[str, str]
    program: str
    machine: str
    system: str


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


@cache
def program_digest() -> str:
    """Return a digest of the code that decides a run's outcome.

    That is the code of `multisrt.simulation` and of every part of this package that it imports,
    directly or not. Docstrings, blank lines and lines of comment do not count.
    """
    digest = hashlib.sha256()
    for name, code in sorted(_program().items()):
        digest.update(f"{name}\n{code}\n".encode())
    return digest.hexdigest()[:16]


def parts_of_the_program() -> list[str]:
    """Return the folders and modules, directly in this package, that decide a run's outcome."""
    return sorted({name.split("/")[0] for name in _program()})


@cache
def _program() -> dict[str, str]:
    # An imported file stands for its whole folder: some files are loaded by name, from a table.
    top = Path(__file__).parents[1]
    code: dict[str, str] = {}
    parts, waiting = {"simulation"}, ["simulation"]
    while waiting:
        part = waiting.pop()
        # rglob does not descend into a symbolic link.
        folder = (top / part).resolve()
        for path in folder.rglob("*.py") if folder.is_dir() else [top / f"{part}.py"]:
            inner = path.relative_to(folder).as_posix() if folder.is_dir() else ""
            code[f"{part}/{inner}"], imported = _read(path)
            waiting.extend(imported - parts)
            parts |= imported
    return code


def _read(path: Path) -> tuple[str, set[str]]:
    """Return the code of a file without docstrings and comments, and the parts it imports."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    imported: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Import():
                imported.update(alias.name for alias in node.names)
            case ast.ImportFrom():
                imported.update(f"{node.module}.{alias.name}" for alias in node.names)
            case ast.Expr(value=ast.Constant(value=str()), lineno=first, end_lineno=last):
                lines[first - 1 : last] = [""] * (last - first + 1 if last else 1)
    code = "\n".join(line for line in lines if line.strip() and not line.lstrip().startswith("#"))
    ours = (name.split(".") for name in imported)
    return code, {name[1] for name in ours if name[0] == "multisrt" and len(name) > 1}
