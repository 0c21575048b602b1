"""Tables on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

MAX_WIDTH = 10_000
"""Width for which a table is laid out to see how wide it wants to be."""


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
    _console().print(made)


def show_blocks(headings: Sequence[str], rows: Sequence[Sequence[str]], labels: int = 1) -> None:
    """Print a table in blocks of as many columns as fit, each with the labels.

    Parameters
    ----------
    headings : sequence of str
        Headings as for `table`.
    rows : sequence of sequence of str
        The cells.
    labels : int, optional
        Number of leading columns that every block begins with.
    """
    console = _console()
    unlimited = console.options.update(max_width=MAX_WIDTH)
    block: list[int] = []
    for column in range(labels, len(headings)):
        wider = [*block, column]
        made = _block(headings, rows, labels, wider)
        if block and console.measure(made, options=unlimited).maximum > console.width:
            console.print(_block(headings, rows, labels, block))
            wider = [column]
        block = wider
    console.print(_block(headings, rows, labels, block))


def _block(
    headings: Sequence[str], rows: Sequence[Sequence[str]], labels: int, columns: Sequence[int]
) -> Any:
    shown = [*range(labels), *columns]
    made = table(*(headings[i] for i in shown))
    for row in rows:
        made.add_row(*(row[i] for i in shown))
    return made


def _console() -> Any:
    from rich.console import Console

    from multisrt.terminal import terminal_width

    return Console(width=terminal_width(), highlight=False)
