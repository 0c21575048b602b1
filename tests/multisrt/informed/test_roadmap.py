"""Paths through known worlds against shortest paths of an independent search."""

import itertools
import math

import numpy as np
import pytest
import shapely
from scipy.sparse.csgraph import dijkstra
from shapely import LineString, Polygon, box

from multisrt.environments.catalog import environment
from multisrt.geometry.configuration import Configuration
from multisrt.informed.roadmap import Roadmap, edges_of

PILLARS = Polygon(box(0, 0, 10, 8).exterior, [box(2, 2, 4, 6).exterior, box(6, 1, 8, 5.5).exterior])


def united(*parts):
    """The union of polygons that overlap."""
    whole = shapely.union_all(parts)
    assert isinstance(whole, Polygon)
    return whole


def path(roadmap, a, b):
    """The path between two nodes, one of which is known to lead to the other."""
    tight = roadmap.tight(a, b)
    assert tight is not None
    return tight


def shortest(room, a, b):
    """The shortest path of a point in a polygon, by its visibility graph."""
    points = [a, b, *np.unique(shapely.get_coordinates(room), axis=0).tolist()]
    wide = room.buffer(1e-6)
    graph = np.zeros((len(points), len(points)))
    for p, q in itertools.combinations(range(len(points)), 2):
        if wide.covers(LineString((points[p], points[q]))):
            graph[p, q] = graph[q, p] = math.dist(points[p], points[q])
    return float(dijkstra(graph, indices=np.array([0]))[0, 1])


def test_paths_are_nearly_shortest_and_keep_clear():
    starts = (Configuration(1.0, 4.0, 0.0),)
    roadmap = Roadmap(PILLARS, 0.25, starts)
    room = PILLARS.buffer(-0.263, quad_segs=4)
    rng = np.random.default_rng(0)
    for node in rng.integers(1, len(roadmap.places), 40).tolist():
        tight = path(roadmap, 0, node)
        best = shortest(room, tuple(roadmap.places[0]), tuple(roadmap.places[node]))
        assert best - 0.02 <= tight.length_m <= 1.03 * best + 0.02
        line = LineString(tight.corners)
        assert line.length == pytest.approx(tight.length_m)
        assert line.distance(PILLARS.boundary) > 0.25
        back = path(roadmap, node, 0)
        assert back.corners[::-1] == pytest.approx(tight.corners)


def test_nodes_and_edges_have_room_everywhere():
    # Curved walls and 16 robots: some nodes once lay outside of the room for ways, and saw through
    # walls.
    museum = environment("museum")
    free = museum.component(*museum.starts[0])
    roadmap = Roadmap(free, 0.25, (Configuration(*museum.starts[0], 0.0),))
    pairs = np.array(roadmap._graph.nonzero()).T
    edges = shapely.linestrings(roadmap.places[pairs])
    assert float(shapely.distance(edges, free.boundary).min()) > 0.25
    assert bool(shapely.contains_xy(free, roadmap.places).all())


def test_turning_counts_lines_not_headings():
    roadmap = Roadmap(PILLARS, 0.25, (Configuration(1.0, 4.0, 0.0), Configuration(5.0, 4.0, 0.0)))
    tight = path(roadmap, 0, 1)
    lines = np.diff(tight.corners, axis=0)
    angles = np.arctan2(lines[:, 1], lines[:, 0])
    turns = [abs(math.remainder(b - a, math.pi)) for a, b in itertools.pairwise(angles.tolist())]
    assert tight.turning_rad == pytest.approx(sum(turns))


def test_a_door_that_the_lattice_misses_is_passed():
    # A door that leaves 6 cm beside the body, between two rooms.
    rooms = united(box(0, 0, 4, 4), box(4.3, 0, 8.3, 4), box(3.9, 1.77, 4.4, 2.33))
    roadmap = Roadmap(rooms, 0.25, (Configuration(1.0, 3.0, 0.0), Configuration(7.0, 3.0, 0.0)))
    assert path(roadmap, 0, 1).length_m < 7.5


def test_bodies_that_stand_are_kept_clear_of():
    start, goal = Configuration(1.0, 1.0, 0.0), Configuration(9.0, 1.0, 0.0)
    hall = box(0, 0, 10, 3)
    roadmap = Roadmap(hall, 0.25, (start, goal), [(5.0, 1.0, 0.3)])
    line = LineString(path(roadmap, 0, 1).corners)
    assert line.distance(shapely.Point(5.0, 1.0)) > 0.55


def test_what_a_disc_cannot_reach_has_no_path():
    rooms = united(box(0, 0, 4, 4), box(4.3, 0, 8.3, 4), box(3.9, 1.9, 4.4, 2.1))
    start, other = Configuration(1.0, 3.0, 0.0), Configuration(7.0, 3.0, 0.0)
    assert Roadmap(rooms, 0.25, (start, other)).tight(0, 1) is None


def test_a_start_nearer_to_a_wall_than_nodes_leads_off():
    roadmap = Roadmap(PILLARS, 0.25, (Configuration(0.251, 4.0, 0.0), Configuration(9.0, 7.0, 0.0)))
    tight = path(roadmap, 0, 1)
    assert LineString(tight.corners).distance(PILLARS.boundary) >= 0.25


def test_edges_have_the_area_on_their_left():
    edges = edges_of(PILLARS)
    twice = (edges[:, 0] * edges[:, 3] - edges[:, 2] * edges[:, 1]).sum()
    assert twice == pytest.approx(2.0 * PILLARS.area)
