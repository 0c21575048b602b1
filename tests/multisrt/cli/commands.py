"""The type of commands that tests run, the maps they are run on, and what they write."""

from pathlib import Path
from typing import Protocol

MAPS = {
    "room": "POLYGON ((0 0, 6 0, 6 5, 0 5, 0 0))",
    "pillar": "POLYGON ((0 0, 9 0, 9 6, 0 6, 0 0), (3 2, 5 2, 5 4, 3 4, 3 2))",
    # Two rooms of 6 x 5 m, a door of 0.4 m between them in a wall of 0.2 m.
    "narrow": (
        "POLYGON ((0 0, 6 0, 6 2, 6.2 2, 6.2 0, 12.2 0, 12.2 5, 6.2 5, 6.2 2.4, 6 2.4, 6 5, 0 5,"
        " 0 0))"
    ),
}


class Call(Protocol):
    """A command that is run in this process."""

    def __call__(self, *words: str) -> tuple[int, str, str]:
        """Return exit code, standard output and standard error."""


def everything(folder: Path) -> dict[str, bytes | None]:
    """Return the contents of all files below a folder, by path; None for folders."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }
