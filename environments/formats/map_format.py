"""Formats of map files: name, suffixes, recognition and reader."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final, Protocol

from multisrt.environments.environment import Environment
from multisrt.environments.formats.files import require_file
from multisrt.geometry.errors import MapFormatError, reason_of

HEAD_BYTES: Final = 64 * 2**10
"""Number of bytes at the beginning of a file from which its format is recognised (64 KiB)."""


class Reader(Protocol):
    """Reader of one format. It rejects options that do not apply to the format."""

    def __call__(
        self,
        path: Path,
        *,
        resolution_m: float | None = None,
        threshold: float | None = None,
        name: str | None = None,
    ) -> Environment:
        """Return the world of a file, or raise a MapFormatError; see `read_environment`."""


@dataclass(frozen=True)
class Beginning:
    """The first bytes of a file.

    Attributes
    ----------
    raw : bytes
        At most `HEAD_BYTES` bytes.
    """

    raw: bytes

    @cached_property
    def text(self) -> str:
        """The bytes as UTF-8 without a byte order mark; empty if there is a zero byte."""
        if b"\0" in self.raw:
            return ""
        return self.raw.decode("utf-8-sig", errors="replace")

    @cached_property
    def first_line(self) -> str:
        """The first line that is not blank, without the space around it."""
        return next((line.strip() for line in self.text.splitlines() if line.strip()), "")


@dataclass(frozen=True, kw_only=True)
class MapFormat:
    """A format of map files.

    Attributes
    ----------
    name : str
        Its name in messages and tables, for instance ``"MovingAI grid"``.
    suffixes : tuple of str
        Usual suffixes of its files in lower case, with the dot.
    recognises : callable
        Takes the beginning of a file and returns whether it is of this format. At most one format
        recognises a file.
    read : Reader
        Its reader.
    repair : Reader or None
        Reader that also repairs rings that are open or cross, and leaves out starts that are not in
        free space; None if it repairs nothing.
    """

    name: str
    suffixes: tuple[str, ...]
    recognises: Callable[[Beginning], bool]
    read: Reader
    repair: Reader | None = None


def beginning_of(path: Path) -> Beginning:
    """Return the first bytes of a map file.

    Raises
    ------
    MapFormatError
        If there is no such file, it is empty, or it cannot be read.
    """
    require_file(path)
    try:
        with path.open("rb") as file:
            return Beginning(file.read(HEAD_BYTES))
    except OSError as error:
        raise MapFormatError(f"{path} cannot be read: {reason_of(error)}") from error
