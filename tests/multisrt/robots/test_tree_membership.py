"""Trees of nodes: whatever the order in which nodes become known, the trees are the same."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.knowledge import NodeId
from multisrt.robots.tree_membership import TreeMembership

A, B, C, D = (NodeId(0, serial) for serial in range(4))


def test_a_tree_joins_that_of_the_missing_parent():
    trees = TreeMembership()
    assert trees.add(A, None) == {A: None}
    assert trees.add(C, B) == {C: None}
    assert trees.add(D, C) == {D: None}
    assert trees.roots == [A, C]
    assert trees.add(B, A) == {B: None, C: C, D: C}
    assert trees.roots == [A]
    assert [trees.root(each) for each in (A, B, C, D)] == [A] * 4


def test_a_tree_that_joins_one_without_a_parent_moves_with_it():
    trees = TreeMembership()
    trees.add(D, C)
    trees.add(C, B)
    assert trees.root(D) == C
    trees.add(B, A)
    assert trees.root(D) == B
    trees.add(A, None)
    assert trees.root(D) == A


def test_the_root_of_an_unknown_node_is_an_error():
    with pytest.raises(InvalidInputError, match=r"node \(0, 1\) is not known"):
        TreeMembership().root(B)


@given(st.lists(st.integers(-1, 8), min_size=1, max_size=12), st.randoms(use_true_random=False))
def test_roots_are_those_at_the_end_of_parent_links(links, random):
    # Node k + 1 hangs under a node before it, or is a root.
    parents: dict[NodeId, NodeId | None] = {NodeId(0, 0): None}
    for k, link in enumerate(links):
        parents[NodeId(0, k + 1)] = None if link < 0 else NodeId(0, link % (k + 1))
    trees, known = TreeMembership(), set()
    for node_id in random.sample(sorted(parents), len(parents)):
        trees.add(node_id, parents[node_id])
        known.add(node_id)
        for each in known:
            root = each
            while parents[root] in known:
                root = parents[root]
            assert trees.root(each) == root
        assert trees.roots == sorted(each for each in known if parents[each] not in known)
