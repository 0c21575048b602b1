"""The layers of the picture of a run that can be left out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from multisrt.geometry.errors import InvalidInputError, did_you_mean

LAYERS: Final[dict[str, str]] = {
    "areas": "the area that each robot saw first",
    "outlines": "outlines of the regions that robots saw",
    "paths": "paths of the robots; with trees only those off the tree",
    "support": "paths in support of other robots",
    "bridges": "paths between nodes that no edge joins",
    "edges": "edges of the trees",
    "nodes": "nodes of the trees",
    "goals": "goals of robots that bid for frontiers",
    "isolation": "marks of paths that were driven in isolation",
    "frontier": "frontier that was left open",
    "given-up": "frontier that was given up",
    "stops": "protective stops",
    "starts": "starts, with the numbers of robots",
    "ends": "last positions of robots",
    "failures": "deaths and collisions",
}
"""Names and contents of the layers that can be left out."""


def left_out(without: Iterable[str]) -> frozenset[str]:
    """Return the layers to leave out.

    Parameters
    ----------
    without : iterable of str
        Names of layers; a single name may be given as it is.

    Raises
    ------
    InvalidInputError
        If there is no such layer.

    Examples
    --------
    >>> sorted(left_out(["outlines", "nodes"]))
    ['nodes', 'outlines']
    """
    names = frozenset([without] if isinstance(without, str) else without)
    for name in sorted(map(str, names)):
        if name not in LAYERS:
            hint = did_you_mean(name, LAYERS) or f"; the layers are {', '.join(LAYERS)}"
            raise InvalidInputError(f"there is no layer {name!r}{hint}")
    return names
