"""The exploration trees of robots as GraphML and GeoJSON."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, NamedTuple
from xml.sax.saxutils import escape, quoteattr

from multisrt.events import NodeAdded, NodeName
from multisrt.exporting.polygon_text import collection_bytes, printable
from multisrt.exporting.sampling import nanoseconds
from multisrt.exporting.selection import require_robot, require_time
from multisrt.exporting.written import require_suffix, write_files
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording

ATTRIBUTES: Final = {
    "x": "double",
    "y": "double",
    "heading": "double",
    "time": "double",
    "robot": "int",
    "kind": "string",
}
"""Attributes of nodes with their types in GraphML: metres, radians, seconds, the robot that made
the node, and its stage (see `multisrt.events.NodeAdded`)."""


class ExplorationTree(NamedTuple):
    """Nodes that robots made, in order of time, and the edges between them.

    Attributes
    ----------
    world : str
        Name of the world.
    nodes : list of NodeAdded
        The nodes. Those of robots that bid for frontiers are the places of their scans, without
        edges.
    edges : list of (parent, child)
        Names of nodes in the list. A node has no edge if the robot that made its parent is left
        out.
    """

    world: str
    nodes: list[NodeAdded]
    edges: list[tuple[NodeName, NodeName]]


def is_joined(node: NodeAdded) -> bool:
    """Return whether a node is joined to its parent; scans of frontier bidders form no tree."""
    return node.parent is not None and node.stage != "scan"


def exploration_tree(
    recording: Recording, *, robot: int | None = None, time_s: float | None = None
) -> ExplorationTree:
    """Return the exploration tree of a robot, or of all.

    Parameters
    ----------
    recording : Recording
        The run.
    robot : int, optional
        The robot that made the nodes, from 0; by default all robots.
    time_s : float, optional
        Time in seconds up to which nodes are included; by default the end of the run.

    Raises
    ------
    InvalidInputError
        If there is no such robot, or no node by that time.

    Examples
    --------
    >>> import multisrt as ms
    >>> tree = exploration_tree(ms.explore("open", seed=1).recording, robot=0)
    >>> len(tree.nodes) - len(tree.edges), tree.nodes[0].stage
    (1, 'root')
    """
    tree = tree_by(recording, robot, time_s)
    if not tree.nodes:
        who = "no robot made a node" if robot is None else f"robot {robot} made no node"
        when = "" if time_s is None else f" by {time_s:g} s"
        raise InvalidInputError(f"{who}{when}: there is no tree to write")
    return tree


def tree_by(recording: Recording, robot: int | None, time_s: float | None) -> ExplorationTree:
    """Return the exploration tree of a robot, or of all, which may be empty.

    Parameters are those of `exploration_tree`.

    Raises
    ------
    InvalidInputError
        If there is no such robot, or the run has no such time.
    """
    require_robot(recording, robot)
    end_s = require_time(recording, time_s)
    nodes = [
        node
        for node in recording.of(NodeAdded)
        if nanoseconds(node.time_s) <= nanoseconds(end_s) and robot in (None, node.robot)
    ]
    names = {(node.robot, node.serial) for node in nodes}
    edges = [
        (node.parent, (node.robot, node.serial))
        for node in nodes
        if is_joined(node) and node.parent is not None and node.parent in names
    ]
    return ExplorationTree(recording.header.world, nodes, edges)


def save_trees(
    recording: Recording,
    path: str | Path,
    *,
    robot: int | None = None,
    time_s: float | None = None,
    overwrite: bool = False,
) -> None:
    """Write the exploration trees of a run.

    Parameters
    ----------
    recording : Recording
        The run.
    path : str or Path
        The file, whose suffix determines the format: ``.graphml``, or ``.geojson`` or ``.json`` for
        GeoJSON. It is written completely or not at all.
    robot, time_s
        As for `exploration_tree`.
    overwrite : bool, optional
        Whether an existing file is replaced.

    Raises
    ------
    InvalidInputError
        If the suffix is another one, there is no such robot or no node, the file exists and may
        not be replaced, or it cannot be written.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> save_trees(run.recording, "trees.graphml")
    >>> save_trees(run.recording, "tree-1.geojson", robot=1)
    """
    path = Path(path)
    encoded = TREE_FORMATS[require_suffix(path, TREE_FORMATS, "trees")]
    tree = exploration_tree(recording, robot=robot, time_s=time_s)
    write_files({path: encoded(tree)}, overwrite=overwrite)


def graphml_bytes(tree: ExplorationTree) -> bytes:
    """Return an exploration tree as GraphML, with directed edges from parents to children.

    Node 5 of robot 0 is called ``r0n5``. Nodes have the `ATTRIBUTES`.

    Parameters
    ----------
    tree : ExplorationTree
        The tree.

    Notes
    -----
    Source: Brandes et al., GraphML Progress Report, 2002, and its primer.
    """
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<graphml xmlns="http://graphml.graphdrawing.org/xmlns">',
        *(
            f'<key id="{name}" for="node" attr.name="{name}" attr.type="{kind}"/>'
            for name, kind in ATTRIBUTES.items()
        ),
        f'<graph id={quoteattr(printable(tree.world))} edgedefault="directed">',
    ]
    for node in tree.nodes:
        data = "".join(
            f'<data key="{name}">{escape(str(value))}</data>'
            for name, value in _attributes(node).items()
        )
        lines.append(f'<node id="{_node_id((node.robot, node.serial))}">{data}</node>')
    for parent, child in tree.edges:
        lines.append(f'<edge source="{_node_id(parent)}" target="{_node_id(child)}"/>')
    return ("\n".join([*lines, "</graph>", "</graphml>"]) + "\n").encode()


def tree_geojson_bytes(tree: ExplorationTree) -> bytes:
    """Return an exploration tree as GeoJSON in metres: nodes as points, edges as lines.

    Nodes have the `ATTRIBUTES` and their `name`; edges have `kind` ``edge``, the `robot` and
    `time` of the child, and the names of parent and child as `source` and `target`.

    Parameters
    ----------
    tree : ExplorationTree
        The tree.
    """
    features: list[tuple[dict[str, Any], dict[str, Any]]] = []
    by_name = {(node.robot, node.serial): node for node in tree.nodes}
    for name, node in by_name.items():
        geometry = {"type": "Point", "coordinates": list(node.configuration[:2])}
        features.append(({"name": _node_id(name), **_attributes(node)}, geometry))
    for parent, child in tree.edges:
        ends = [list(by_name[name].configuration[:2]) for name in (parent, child)]
        properties = {
            "kind": "edge",
            "source": _node_id(parent),
            "target": _node_id(child),
            "robot": child[0],
            "time": by_name[child].time_s,
        }
        features.append((properties, {"type": "LineString", "coordinates": ends}))
    return collection_bytes(tree.world, features)


TREE_FORMATS: Final[dict[str, Callable[[ExplorationTree], bytes]]] = {
    ".graphml": graphml_bytes,
    ".geojson": tree_geojson_bytes,
    ".json": tree_geojson_bytes,
}
"""Writers of trees by suffix."""


def _attributes(node: NodeAdded) -> dict[str, float | int | str]:
    x, y, heading = node.configuration
    values = (x, y, heading, node.time_s, node.robot, node.stage)
    return dict(zip(ATTRIBUTES, values, strict=True))


def _node_id(name: NodeName) -> str:
    return f"r{name[0]}n{name[1]}"
