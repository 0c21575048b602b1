"""The layers of pictures of runs that can be left out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, Literal

from multisrt.geometry.errors import InvalidInputError, did_you_mean

Picture = Literal["map", "animation", "export"]
"""What has layers: the map of a run, an animation, and a file of `multisrt.exporting`."""

LAYERS: Final[dict[str, str]] = {
    "areas": "the area that each robot saw first",
    "outlines": "outlines of the regions that robots saw",
    "paths": "paths of the robots; on maps with trees only those off the tree",
    "support": "paths in support of other robots",
    "bridges": "paths between nodes that no edge joins",
    "edges": "edges of the trees",
    "nodes": "nodes of the trees",
    "goals": "goals of robots",
    "isolation": "marks of paths that were driven in isolation",
    "frontier": "frontier that is still open",
    "given-up": "frontier that was given up",
    "stops": "protective stops",
    "starts": "starts, with the numbers of robots",
    "ends": "last positions of robots",
    "failures": "deaths and collisions",
    "delivered": "the border of what the base station knows",
    "base": "the base station",
    "bodies": "bodies of the robots, with their headings and numbers",
    "caption": "the title, the time, and what each robot is doing",
    "maps": "the map of each robot, and its frontier",
    "links": "radio links between robots in contact",
    "decisions": "decisions and unplanned events, in words",
}
"""Names and contents of all layers that can be left out."""

PICTURES: Final[dict[Picture, tuple[str, ...]]] = {
    "map": (
        *("areas", "outlines", "paths", "support", "bridges", "edges", "nodes", "goals"),
        *("isolation", "frontier", "given-up", "stops", "starts", "ends", "failures"),
        *("delivered", "base"),
    ),
    "animation": ("areas", "paths", "edges", "nodes", "goals", "base", "bodies", "caption"),
    "export": ("paths", "edges", "nodes", "bodies", "maps", "links", "decisions"),
}
"""Layers of each kind of picture, of `LAYERS`."""

_NAMES: Final[dict[Picture, str]] = {
    "map": "a map of a run",
    "animation": "an animation",
    "export": "an export",
}


def left_out(without: Iterable[str], picture: Picture = "map") -> frozenset[str]:
    """Return the layers to leave out of a picture.

    Parameters
    ----------
    without : iterable of str
        Names of layers; a single name may be given as it is.
    picture : {"map", "animation", "export"}, optional
        The kind of picture.

    Returns
    -------
    frozenset of str
        The names.

    Raises
    ------
    InvalidInputError
        If there is no such layer, or the picture has none of that name.

    Examples
    --------
    >>> sorted(left_out(["outlines", "nodes"]))
    ['nodes', 'outlines']
    """
    names = frozenset([without] if isinstance(without, str) else without)
    own = PICTURES[picture]
    for name in sorted(map(str, names)):
        if name not in own:
            hint = "" if name in LAYERS else did_you_mean(name, own)
            hint = hint or f"; its layers are {', '.join(own)}"
            raise InvalidInputError(f"{_NAMES[picture]} has no layer {name!r}{hint}")
    return names
