import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from shapely.geometry.base import BaseGeometry

from multisrt.geometry.bodies.clearance import disc_clearance, path_clearance, rings_of
from multisrt.geometry.bodies.fitting import pose_is_inside
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.bodies.free_travel import free_travel_polygon
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.room import Room
from multisrt.planners.motion.trajectory import Trajectory, Waypoint, leg_points

BOX = Footprint.box(0.6, 0.4)
DISC = Footprint.disc(0.25)
ELL = Footprint.polygon(
    [(-0.3, -0.3), (0.5, -0.3), (0.5, 0.0), (0.1, 0.0), (0.1, 0.4), (-0.3, 0.4)]
)

# A hall of 4 x 4 m with a pillar of 1 x 1 m in its middle.
HALL = shapely.box(0, 0, 4, 4).difference(shapely.box(1.5, 1.5, 2.5, 2.5))


def size(footprint: Footprint):
    return footprint.radius_m if footprint.is_disc else footprint.planning_vertices


def test_rings_of_a_region_are_closed_and_separated():
    rings = rings_of(HALL)
    assert np.isnan(rings[[0, 6, 12]]).all()
    assert len(rings) == 13
    outer, hole = shapely.LinearRing(rings[1:6]), shapely.LinearRing(rings[7:12])
    assert outer.is_ccw
    assert not hole.is_ccw
    assert len(rings_of(shapely.union(HALL, shapely.box(5, 5, 6, 6)))) == 19


def test_room_in_a_region_with_a_hole():
    rings = rings_of(HALL)
    corners = BOX.vertices
    assert disc_clearance(rings, 1.0, 2.0) == 0.5
    assert pose_is_inside(rings, corners, 1.0, 2.0, 0.0)
    assert not pose_is_inside(rings, corners, 1.3, 2.0, 0.0)
    assert not pose_is_inside(rings, corners, 2.0, 2.0, 0.0)
    assert not pose_is_inside(rings, corners, 5.0, 2.0, 0.0)
    # A body that is larger than the pillar and covers it.
    assert not Room(rings, 2.0 * corners).holds(Configuration(2.0, 2.0, 0.0))
    assert not Room(rings, 4.0 * corners).holds(Configuration(2.0, 2.0, 0.0))
    assert Room(rings_of(HALL.envelope), 4.0 * corners).holds(Configuration(2.0, 2.0, 0.0))
    assert free_travel_polygon(rings, corners, 0.5, 2.0, 0.0, 1.0, 0.0, 9.0) == pytest.approx(0.7)
    assert free_travel_polygon(rings, corners, 0.5, 1.0, 0.0, 1.0, 0.0, 9.0) == pytest.approx(3.2)


coordinate = st.floats(-3.0, 3.0)
triangles = st.tuples(*[coordinate] * 6).map(lambda c: shapely.Polygon(np.reshape(c, (3, 2))))
turns = st.one_of(st.just(0.0), st.floats(0.01, 3.1), st.floats(-3.1, -0.01))


@given(triangles, coordinate, coordinate, coordinate, coordinate, turns)
def test_path_clearance_of_a_triangle(triangle, x, y, dx, dy, turn):
    assume(triangle.area > 1e-3 and math.hypot(dx, dy) > 1e-3)
    moved = shapely.LineString(leg_points((0.0, x, y, 0.0), (0.0, x + dx, y + dy, turn), 2e-3))
    clearance = path_clearance(rings_of(triangle), x, y, dx, dy, turn)
    assert clearance == pytest.approx(moved.distance(triangle.exterior), abs=1e-3)
    # An open ring gives the same result.
    ring = np.asarray(triangle.exterior.coords)[:-1].copy()
    assert path_clearance(ring, x, y, dx, dy, turn) == pytest.approx(clearance, abs=1e-12)


def test_a_box_passes_a_corner_that_it_just_fits():
    # Round the pillar's corner (2.5, 2.5) on a quarter circle of 1 m about (2, 2): the inner side
    # of the box is 0.8 m from (2, 2), and the corner 0.707 m; its outer corners come to within
    # hypot(1.2, 0.3) = 1.237 m of it.
    moved = Trajectory((Waypoint(0, 3.0, 2.0, math.pi / 2), Waypoint(1, 2.0, 3.0, math.pi)))
    rings = rings_of(HALL)
    assert Room(rings, BOX.vertices).lets_pass(moved.waypoints)
    assert Room(rings, BOX.vertices).lets_pass(moved.reversed().waypoints)
    wide = Footprint.box(0.6, 0.6)
    assert not Room(rings, wide.vertices).lets_pass(moved.waypoints)
    assert Room(rings, 0.2928).lets_pass(moved.waypoints)
    assert not Room(rings, 0.2930).lets_pass(moved.waypoints)
    close = shapely.box(0, 0, 3.23, 4).difference(shapely.box(1.5, 1.5, 2.5, 2.5))
    assert not Room(rings_of(close), BOX.vertices).lets_pass(moved.waypoints)


def test_bounds_of_a_room():
    assert Room(rings_of(HALL), 0.1).bounds == (0.0, 0.0, 4.0, 4.0)


def width(room: Room | None) -> float:
    """Return the extent along y of a room's outline."""
    assert room is not None
    assert isinstance(room.outline, np.ndarray)
    return float(np.ptp(room.outline[:, 1]))


def test_room_keeps_as_much_margin_as_places_allow():
    corridor = rings_of(shapely.box(0, 0, 4, 0.41))
    body = PlanningBody(BOX, 0.02)
    wide = body.room(rings_of(HALL), Configuration(1.0, 1.0, 0.0))
    narrow = body.room(corridor, Configuration(1.0, 0.205, 0.0))
    assert width(wide) == pytest.approx(0.44)
    assert width(narrow) == pytest.approx(0.408)
    assert body.room(corridor, Configuration(1.0, 0.1, 0.0)) is None
    # The margin that all of the places have room for.
    both = body.room(corridor, Configuration(1.0, 0.205, 0.0), Configuration(3.0, 0.2045, 0.0))
    assert width(both) == pytest.approx(0.408)
    assert body.room(corridor, Configuration(1.0, 0.205, 0.0), Configuration(3.9, 0.205)) is None
    disc = PlanningBody(DISC, 0.02)
    round_ = disc.room(rings_of(HALL), Configuration(1.0, 1.0))
    assert round_ is not None
    assert round_.outline == pytest.approx(0.27)
    assert disc.room(rings_of(HALL), Configuration(0.2, 1.0)) is None
    assert disc.room(rings_of(HALL), Configuration(2.0, 2.0)) is None


boxes = st.tuples(coordinate, coordinate, st.floats(0.2, 1.0), st.floats(0.2, 1.0)).map(
    lambda b: shapely.box(b[0], b[1], b[0] + b[2], b[1] + b[3])
)
regions = st.lists(boxes, max_size=4).map(
    lambda holes: shapely.box(-2, -2, 2, 2).difference(shapely.union_all(holes))
)
places = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))


@pytest.mark.slow
@settings(max_examples=60)
@example(
    shapely.box(-2, -2, 2, 2).difference(shapely.box(0, 0, 0.2, 0.2)),
    BOX,
    (0.0, 0.0),
    (0.0, 1.0),
    1.0,
    0.0,
)
@given(regions, st.sampled_from([BOX, DISC, ELL]), places, places, st.floats(-3.1, 3.1), turns)
def test_lets_pass_agrees_with_placed_footprints(region, footprint, start, end, heading, turn):
    assume(math.dist(start, end) > 0.01)
    (x0, y0), (x1, y1) = start, end
    moved = Trajectory((Waypoint(0.0, x0, y0, heading), Waypoint(1.0, x1, y1, heading + turn)))
    passes = Room(rings_of(region), size(footprint)).lets_pass(moved.waypoints)
    line = shapely.LineString(moved.points(0.01))
    poses = [Configuration(*moved.at(time)) for time in np.linspace(0.0, 1.0, 100)]
    area: BaseGeometry
    if footprint.is_disc:
        area = line.buffer(footprint.radius_m, quad_segs=32)
    else:
        shape = Footprint.polygon(footprint.planning_vertices)
        area = shapely.union_all([shape.placed(pose) for pose in poses])
    # Between two poses the body moves by a few centimetres, which cuts off less than 1e-3.
    deep = region.buffer(2e-3, join_style="mitre")
    if passes:
        assert deep.contains(area)
    elif region.buffer(-2e-3, join_style="mitre").contains(area):
        # Without contact at the sampled poses, it can only have grazed between them.
        assert not region.buffer(-0.02, join_style="mitre").contains(area)
