"""Tables on the terminal."""

from __future__ import annotations

import sys
from typing import Any

WIDTH = 100
"""Columns of output that does not go to a terminal."""


def table(*columns: str) -> Any:
    """Return an empty table.

    Parameters
    ----------
    *columns : str
        Headings; a column whose heading starts with ``>`` is aligned to the right.

    Returns
    -------
    rich.table.Table
    """
    from rich import box
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        right = column.startswith(">")
        made.add_column(column.lstrip(">"), justify="right" if right else "left")
    return made


def show(made: Any) -> None:
    """Print a table, as wide as the terminal.

    Parameters
    ----------
    made : rich.table.Table
        The table.
    """
    from rich.console import Console

    width = None if sys.stdout.isatty() else WIDTH
    Console(width=width, highlight=False).print(made)
