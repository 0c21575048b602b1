"""How much frontier is open in each tree: sums that are corrected where something has changed."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from multisrt.robots.knowledge import NodeId
from multisrt.robots.local_frontiers import LocalFrontiers
from multisrt.robots.node_regions import NodeRegions
from multisrt.robots.tree_membership import TreeMembership


class OpenFrontiers:
    """The nodes with a local frontier, by tree, with its length.

    Changes are noted, and worked off when something is asked: only nodes near those that changed
    are looked at again, for arcs count with those of other nodes that they are joined to.

    Parameters
    ----------
    regions : NodeRegions
        The nodes.
    frontiers : LocalFrontiers
        Their local frontiers.
    trees : TreeMembership
        Their trees.
    """

    __slots__ = (
        "_changed",
        "_frontiers",
        "_lengths_m",
        "_regions",
        "_sums_m",
        "_trees",
        "_witness",
    )

    def __init__(
        self, regions: NodeRegions, frontiers: LocalFrontiers, trees: TreeMembership
    ) -> None:
        self._regions = regions
        self._frontiers = frontiers
        self._trees = trees
        self._changed: dict[int, None] = {}
        self._lengths_m: dict[NodeId, dict[NodeId, float]] = {}
        self._sums_m: dict[NodeId, float] = {}
        self._witness = 0

    def note_changed(self, numbers: Iterable[int]) -> None:
        """Note that the arcs of nodes have changed."""
        for number in numbers:
            self._changed[number] = None

    def note_moved(self, former: dict[NodeId, NodeId | None]) -> None:
        """Note that nodes have a new root; the former one of each is given."""
        for node_id, root in former.items():
            if root is not None:
                self._set(root, node_id, 0.0)
            self._changed[self._regions.numbers[node_id]] = None

    def is_empty(self) -> bool:
        """Whether no node has a local frontier."""
        if not len(self._regions):
            return True
        # One arc that is long enough on its own suffices; the longest one mostly stays so.
        if not self._frontiers.is_wide(self._witness):
            self._witness = int(self._frontiers.longest_m.argmax())
        if self._frontiers.is_wide(self._witness):
            return False
        self._update()
        return not any(self._lengths_m.values())

    def nodes(self, tree: NodeId | None) -> list[NodeId]:
        """Return the nodes with a local frontier in the tree of a node, or all; sorted."""
        if tree is not None:
            return sorted(self._in_tree(tree))
        self._update()
        return sorted(node_id for nodes in self._lengths_m.values() for node_id in nodes)

    def length_m(self, tree: NodeId | None) -> float:
        """Return the total length of frontier in the tree of a node, or of all, in metres."""
        if tree is None:
            self._update()
            return math.fsum(m for nodes in self._lengths_m.values() for m in nodes.values())
        nodes, root = self._in_tree(tree), self._trees.root(tree)
        known = self._sums_m.get(root)
        if known is None:
            known = self._sums_m[root] = math.fsum(nodes.values())
        return known

    def _in_tree(self, node_id: NodeId) -> dict[NodeId, float]:
        root = self._trees.root(node_id)
        self._update()
        return self._lengths_m.get(root, {})

    def _update(self) -> None:
        if not self._changed:
            return
        changed = np.array([*self._changed])
        near = self._regions.places.around(changed, 2.0 * self._regions.reach_m)
        has_arcs = self._frontiers.longest_m[near] >= 0.0
        for number, may_be_open in zip(near.tolist(), has_arcs.tolist(), strict=True):
            if may_be_open or number in self._changed:
                node_id = self._regions.ids[number]
                self._set(self._trees.root(node_id), node_id, self._frontiers.length_m(number))
        self._changed.clear()

    def _set(self, root: NodeId, node_id: NodeId, length_m: float) -> None:
        nodes = self._lengths_m.setdefault(root, {})
        if nodes.get(node_id, 0.0) == length_m:
            return
        self._sums_m.pop(root, None)
        if length_m:
            nodes[node_id] = length_m
        else:
            del nodes[node_id]
