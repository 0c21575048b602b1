"""The area that robots saw, as it grows."""

import itertools
from dataclasses import replace

import pytest
import shapely
from msgspec import structs
from shapely.geometry.base import BaseGeometry

from multisrt.drawing.animation.growth import pieces
from multisrt.drawing.animation.pace import Pace
from multisrt.drawing.areas import seen_first
from multisrt.environments.environment import Environment
from multisrt.events import NodeAdded

PACE = Pace.of(40.0, duration_s=4.0, speed=None, fps=10.0)
TOLERANCE_M = 0.02


def area(rings) -> float:
    return shapely.Polygon(rings[0], rings[1:]).area


def test_new_area_appears_with_its_node(told):
    found = list(pieces(told, told.environment(), PACE, TOLERANCE_M))
    assert [(piece.picture, piece.robot) for piece in found] == [(0, 0), (0, 2), (12, 1), (20, 0)]
    # Squares of 4 x 4 m; pieces are wider by the tolerance on each side.
    assert [area(piece.rings) for piece in found] == pytest.approx(
        [4.04**2, 4.04**2, 4.04**2, 4.04**2], abs=0.01
    )


def test_what_others_saw_before_is_left_out(told):
    # Robot 1 sees the square of robot 0, from x = 1 to 5, and one metre beyond.
    late = next(event for event in told.of(NodeAdded) if event.robot == 1)
    corners = ((1.0, 1.0), (6.0, 1.0), (6.0, 5.0), (1.0, 5.0))
    changed = structs.replace(late, boundary=corners)
    events = tuple(changed if event is late else event for event in told.events)
    recording = replace(told, events=events)
    found = list(pieces(recording, recording.environment(), PACE, TOLERANCE_M))
    [own] = [piece for piece in found if piece.robot == 1]
    assert shapely.Polygon(own.rings[0]).bounds == pytest.approx((5.0, 1.0, 6.0, 5.0), abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["trees", "bidding"])
def test_pieces_make_up_the_areas_that_robots_saw_first(request, name):
    recording = request.getfixturevalue(name)
    pace = Pace.of(recording.footer.time_s, duration_s=6.0, speed=None, fps=5.0)
    found = list(pieces(recording, recording.environment(), pace, TOLERANCE_M))
    assert len(found) > 5
    assert all(a.picture <= b.picture for a, b in itertools.pairwise(found))
    nodes = recording.of(NodeAdded)
    regions = [shapely.Polygon(recording.region(node)) for node in nodes]
    true = seen_first(regions, [node.robot for node in nodes], 0.001)
    for robot, rings in true.items():
        # Even-odd, as it is drawn.
        drawn = shapely.union_all(
            [_even_odd(piece.rings) for piece in found if piece.robot == robot]
        )
        missing = _even_odd(rings).difference(drawn.buffer(TOLERANCE_M))
        assert missing.buffer(-2 * TOLERANCE_M).area < 0.02
        if name == "trees":  # in the order of nodes within a picture
            beyond = drawn.difference(_even_odd(rings).buffer(3 * TOLERANCE_M))
            assert beyond.buffer(-2 * TOLERANCE_M).area < 0.02 * drawn.area


def test_without_nodes_scans_are_shown(told):
    scans = replace(told, events=tuple(e for e in told.events if not isinstance(e, NodeAdded)))
    hall: Environment = scans.environment()
    [only] = pieces(scans, hall, PACE, TOLERANCE_M)
    assert (only.picture, only.robot) == (0, 0)
    # A quarter of the range of 4 m is cut by the walls: the hall begins 3 m away on two sides.
    assert 30.0 < area(only.rings) < 50.0


def _even_odd(rings) -> BaseGeometry:
    shape: BaseGeometry = shapely.Polygon()
    for ring in rings:
        shape = shape.symmetric_difference(shapely.make_valid(shapely.Polygon(ring)))
    return shape
