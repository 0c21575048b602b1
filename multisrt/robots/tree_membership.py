"""Which tree each node belongs to, also while some of the nodes between are not known."""

from __future__ import annotations

from bisect import insort

from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.knowledge import NodeId


class TreeMembership:
    """The tree that each node belongs to, by parent links.

    A node whose parent is not known is the root of what grows from it. When the parent becomes
    known, its tree joins that of the parent.

    Examples
    --------
    >>> trees, (a, b, c) = TreeMembership(), (NodeId(0, serial) for serial in range(3))
    >>> trees.add(a, None)
    {NodeId(robot=0, serial=0): None}
    >>> trees.add(c, parent=b)
    {NodeId(robot=0, serial=2): None}
    >>> trees.add(b, parent=a)
    {NodeId(robot=0, serial=1): None, NodeId(robot=0, serial=2): NodeId(robot=0, serial=2)}
    >>> trees.roots, trees.root(c)
    ([NodeId(robot=0, serial=0)], NodeId(robot=0, serial=0))
    """

    __slots__ = ("_cut_off", "_members", "_root_of", "roots")

    def __init__(self) -> None:
        self.roots: list[NodeId] = []
        self._root_of: dict[NodeId, NodeId] = {}
        # Of trees whose root has a parent that is not known: their roots by that parent, and
        # their nodes by root.
        self._cut_off: dict[NodeId, list[NodeId]] = {}
        self._members: dict[NodeId, list[NodeId]] = {}

    def root(self, node_id: NodeId) -> NodeId:
        """Return the root of a node's tree.

        Raises
        ------
        InvalidInputError
            If the node is not known.
        """
        root = self._root_of.get(node_id)
        if root is None:
            raise InvalidInputError(f"node {tuple(node_id)} is not known, nor is its tree")
        return root

    def add(self, node_id: NodeId, parent: NodeId | None) -> dict[NodeId, NodeId | None]:
        """Add a new node.

        Returns
        -------
        dict of NodeId to NodeId or None
            The former root of all nodes that have a new one; None for the node itself, which
            comes first.
        """
        root, moved = node_id, [node_id]
        if parent is None:
            insort(self.roots, root)
        elif parent in self._root_of:
            root = self._root_of[parent]
        else:
            insort(self.roots, root)
            self._cut_off.setdefault(parent, []).append(root)
            self._members[root] = []
        for head in self._cut_off.pop(node_id, []):
            self.roots.remove(head)
            moved += self._members.pop(head)
        former = {each: self._root_of.get(each) for each in moved}
        self._root_of.update(dict.fromkeys(moved, root))
        if root in self._members:
            self._members[root] += moved
        return former
