"""A planted defect: a small change of one file of the package."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from multisrt.geometry.errors import InvalidInputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Mutant:
    """A textual change of the program that a user would call a defect.

    Attributes
    ----------
    name : str
        Its name, in words joined by hyphens.
    breaks : str
        What the program does wrong with it.
    file : str
        The file that changes, within the package, such as ``simulation/radio.py``.
    old, new : str
        The text that is replaced, which occurs once in the file, and what replaces it.
    """

    name: str
    breaks: str
    file: str
    old: str
    new: str

    @property
    def digest(self) -> str:
        """Digest of the change, in hexadecimal digits."""
        change = "\0".join((self.file, self.old, self.new))
        return hashlib.sha256(change.encode()).hexdigest()[:16]

    def changed(self, source: str) -> str:
        """Return the changed content of the file.

        Parameters
        ----------
        source : str
            The content of the file.

        Returns
        -------
        str
            The content with the defect.

        Raises
        ------
        InvalidInputError
            If the text that is replaced does not occur exactly once.
        """
        count = source.count(self.old)
        if count != 1:
            raise InvalidInputError(
                f"mutant {self.name}: its text occurs {count} times in {self.file}, not once; "
                "change the mutant in benchmarks/mutants to the present source"
            )
        return source.replace(self.old, self.new)

    def plant(self, package: Path) -> None:
        """Change the file in a copy of the package.

        Parameters
        ----------
        package : Path
            Folder of the copy.

        Raises
        ------
        InvalidInputError
            If the file is not there, or as `changed`.
        """
        path = package / self.file
        if not path.is_file():
            raise InvalidInputError(f"mutant {self.name}: there is no file {self.file}")
        path.write_text(self.changed(path.read_text()))
