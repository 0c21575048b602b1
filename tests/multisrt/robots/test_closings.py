"""Closings of arcs: what they take off the frontier, and for whom they hold."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.frontier_arcs import total_length
from multisrt.robots.exploration_map import Closing, ClosingId, NodeId

WIDTH = 0.5


def closing(number: int, arc: ArrayLike, serial: int = 0, **fields: Any) -> Closing:
    """Robot 1 closes an arc of a node of robot 0."""
    given: dict[str, Any] = {"reason": "seen from near", "width_m": WIDTH} | fields
    return Closing(
        id=ClosingId(1, number), node=NodeId(0, serial), arc=np.asarray(arc, float), **given
    )


@pytest.mark.slow
def test_closing_an_arc(map_of, rectangle_node):
    known = map_of([rectangle_node(0, 0, 0, 2, 2, "right left")])
    arcs = known.frontier_arcs(NodeId(0, 0))
    assert [total_length(arc) for arc in arcs] == [2.0, 2.0]
    first, second = closing(0, arcs[0]), closing(1, arcs[1])
    assert known.close(first)
    assert np.array_equal(known.frontier(NodeId(0, 0)), arcs[1])
    assert not known.is_complete()
    assert not known.close(first)
    assert known.close(second)
    assert known.is_complete()
    assert known.open_nodes() == []
    assert known.open_frontier_m() == 0.0
    assert known.closings == (first, second)


def test_closing_a_part_of_an_opening_leaves_the_rest_too_narrow(map_of, rectangle_node):
    parts = [rectangle_node(k, 0.0, 0.3 * k, 2.0, 0.3 * k + 0.3, "right") for k in range(2)]
    known = map_of(parts)
    assert known.has_frontier(NodeId(0, 1))
    known.close(closing(0, known.frontier(NodeId(0, 0))))
    assert not known.has_frontier(NodeId(0, 1))
    assert known.is_complete()


@pytest.mark.parametrize("turned", [False, True])
def test_an_arc_closes_only_the_parts_that_lie_along_it(map_of, rectangle_node, turned):
    # The node's side runs from (2, 0) to (2, 4); the arc from 1 to 2.5, and beyond other sides.
    arc = np.array([[2.0, 1.0, 2.0, 2.0], [2.0, 2.0, 2.0, 2.5], [3.0, 0.0, 3.0, 4.0]])
    if turned:
        arc = arc[:, [2, 3, 0, 1]]
    known = map_of([rectangle_node(0, 0, 0, 2, 4, "right above")])
    known.close(closing(0, arc))
    expected = [[2, 0, 2, 1], [2, 2.5, 2, 4], [2, 4, 0, 4]]
    assert known.frontier(NodeId(0, 0)) == pytest.approx(np.array(expected, float), abs=1e-9)
    known.close(closing(1, [[2.0, 2.4, 2.0, 9.0], [0.0, 4.00001, 2.0, 4.00001]]))
    assert known.open_frontier_m() == pytest.approx(3.0)


def test_an_arc_across_the_frontier_closes_nothing(map_of, rectangle_node):
    known = map_of([rectangle_node(0, 0, 0, 2, 2, "right")])
    known.close(closing(0, [[1.0, 1.0, 3.0, 1.0], [1.5, 0.5, 2.5, 1.5], [2.0, -1.0, 2.0, 0.0]]))
    assert np.array_equal(known.frontier(NodeId(0, 0)), [[2, 0, 2, 2]])


def test_an_arc_can_be_closed_before_its_node_is_known(new_map, rectangle_node):
    known = new_map()
    assert known.close(closing(0, [[2, 0, 2, 1]]))
    assert known.is_complete()
    known.add(rectangle_node(0, 0, 0, 2, 2, "right"))
    assert known.frontier(NodeId(0, 0)) == pytest.approx(np.array([[2.0, 1.0, 2.0, 2.0]]))


@pytest.mark.parametrize(
    ("reason", "width_m", "robot", "own_width_m", "closed"),
    [
        ("seen from near", 9.0, 0, 0.1, True),
        ("too narrow", 0.5, 0, 0.5, True),
        ("too narrow", 0.5, 0, 0.6, True),
        ("too narrow", 0.5, 0, 0.4, False),
        ("too narrow", 0.5, None, 0.4, False),
        ("not reachable", 0.5, 0, 0.5, False),
        ("not reachable", 0.5, 1, 0.5, True),
        ("not reachable", 0.5, None, 0.5, True),
    ],
)
def test_the_reason_of_a_closing_decides_for_whom_it_holds(
    map_of, rectangle_node, reason, width_m, robot, own_width_m, closed
):
    known = map_of([rectangle_node(0, 0, 0, 2, 2, "right")], width_m=own_width_m, robot=robot)
    known.close(closing(0, [[2, 0, 2, 2]], reason=reason, width_m=width_m))
    assert known.is_complete() == closed
    assert len(known.closings) == 1


def test_the_own_width_defaults_to_the_shortest_arc(map_of, rectangle_node):
    known = map_of([rectangle_node(0, 0, 0, 2, 2, "right")])
    known.close(closing(0, [[2, 0, 2, 2]], reason="too narrow", width_m=WIDTH))
    assert known.is_complete()


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"reason": "too far"}, "not 'too far'"),
        # A body is no fact of the world: what it bars is no entry of a map.
        ({"reason": "blocked by a robot"}, "not 'blocked by a robot'"),
        ({"arc": [2, 0, 2, 2]}, r"shape \(4,\)"),
    ],
)
def test_an_invalid_closing_is_refused(fields, message):
    given: dict[str, Any] = {"number": 0, "arc": [[2, 0, 2, 2]]} | fields
    with pytest.raises(InvalidInputError, match=message):
        closing(**given)


def test_the_arc_of_a_closing_is_its_own():
    arc = np.array([[2.0, 0.0, 2.0, 2.0]])
    made = closing(0, arc)
    arc[0, 0] = 7.0
    assert made.arc[0, 0] == 2.0
    with pytest.raises(ValueError, match="read-only"):
        made.arc[0, 0] = 7.0
