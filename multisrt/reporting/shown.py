"""Tables and figures that show themselves at the prompt and in notebooks."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

from multisrt.extras.notebook import picture_html
from multisrt.geometry.errors import InvalidInputError
from multisrt.reporting.layout import Table
from multisrt.terminal import terminal_width

if TYPE_CHECKING:
    from multisrt.reporting.style import Picture


class ShownTable(Table):
    """A table that prints itself on a terminal, as wide as that is, and in a notebook."""

    def __repr__(self) -> str:
        return self.text(terminal_width())

    def __str__(self) -> str:
        return repr(self)

    def _repr_html_(self) -> str:
        return self.notebook_html()


def shown(table: Table) -> ShownTable:
    """Return a table that prints itself."""
    return ShownTable(**{field.name: getattr(table, field.name) for field in fields(Table)})


class Drawings(tuple["Picture", ...]):
    """Figures that show themselves in a notebook and can be saved as files."""

    __slots__ = ()

    def save(self, folder: str | Path) -> list[Path]:
        """Write each figure as SVG and as PDF.

        Parameters
        ----------
        folder : str or Path
            Folder for the files; it is created if necessary.

        Returns
        -------
        list of Path
            The files written.

        Raises
        ------
        InvalidInputError
            If the folder cannot be written to.
        """
        written = []
        try:
            Path(folder).mkdir(parents=True, exist_ok=True)
            for picture in self:
                for suffix, data in ((".svg", picture.svg), (".pdf", picture.pdf)):
                    path = Path(folder) / f"{picture.name}{suffix}"
                    path.write_bytes(data)
                    written.append(path)
        except OSError as error:
            raise InvalidInputError(
                f"cannot write to {folder}: {error.strerror or error}"
            ) from None
        return written

    def __repr__(self) -> str:
        return "\n".join(picture.alt for picture in self)

    def _repr_html_(self) -> str:
        return "\n".join(picture_html(picture.svg, picture.alt) for picture in self)
