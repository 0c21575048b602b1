"""The option `--without` of all commands that draw or export runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import click

LAYERS: Final = {
    "map": (
        *("areas", "outlines", "paths", "support", "bridges", "edges", "nodes", "goals"),
        *("isolation", "frontier", "given-up", "stops", "starts", "ends", "failures"),
        *("delivered", "base"),
    ),
    "animation": ("areas", "paths", "edges", "nodes", "goals", "base", "bodies", "caption"),
    "export": ("paths", "edges", "nodes", "bodies", "maps", "links", "decisions"),
}
"""Layers by what has them. The import of `multisrt.drawing.layers`, which describes them, would
delay the help; a test compares both."""


def without_option(picture: str, note: str = "") -> Callable[[Any], Any]:
    """Return the option that names layers to leave out.

    Parameters
    ----------
    picture : {"map", "animation", "export"}
        What has the layers.
    note : str, optional
        What else the help says.

    Returns
    -------
    callable
        Adds the option to a command.
    """
    names = LAYERS[picture]
    return click.option(
        "--without",
        multiple=True,
        type=click.Choice(names),
        metavar="LAYER",
        help=f"Leave a layer out; repeatable: {', '.join(names)}.{note}",
    )
