"""Tables on the terminal."""

from __future__ import annotations

import sys
from typing import Any

WIDTH = 100
"""Columns, where no terminal says how many it has."""


def table(*columns: str) -> Any:
    """Begin a table; a column that begins with > is set to the right."""
    from rich import box
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        right = column.startswith(">")
        made.add_column(column.lstrip(">"), justify="right" if right else "left")
    return made


def show(made: Any) -> None:
    """Print a table."""
    from rich.console import Console

    width = None if sys.stdout.isatty() else WIDTH
    Console(width=width, highlight=False).print(made)
