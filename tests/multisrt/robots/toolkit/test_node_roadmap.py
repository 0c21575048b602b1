import math

import numpy as np
import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.knowledge import Node, NodeId
from multisrt.robots.toolkit import NodeRoadmap

# A room with a wall across it that leaves a door at its upper end.
ROOM = [(0, 0), (7, 0), (7, 5), (0, 5)]
WALL = [(3.4, 0), (3.4, 3.5), (3.6, 3.5), (3.6, 0.0)]
PLACES = [(1.5, 1.5), (2.5, 4.25), (4.5, 4.25), (5.5, 1.5)]


@pytest.fixture
def add(scans):
    world = scans(ROOM, WALL)

    def add_to(known, serial, robot=0):
        scan = world(*PLACES[serial])
        node = Node(
            id=NodeId(robot, serial),
            configuration=scan.configuration,
            region=local_safe_region(scan, "radial"),
            parent=None,
            time_s=0.0,
        )
        known.add(node)
        return node

    return add_to


@pytest.fixture
def known(add):
    made = ExplorationMap(reach_m=4.0, min_arc_m=0.5)
    for serial in range(4):
        add(made, serial, robot=serial % 2)
    return made


def test_paths_lead_round_walls_by_way_of_nodes(known):
    roadmap = NodeRoadmap(known, Footprint.disc(0.25), reach_m=4.0)
    path = roadmap.path((1.0, 0.5), (6.0, 0.5))
    assert path is not None
    assert path.tolist() == [[1.0, 0.5], *map(list, PLACES), [6.0, 0.5]]
    length_m = float(np.hypot(*np.diff(path, axis=0).T).sum())
    assert roadmap.costs((1.0, 0.5), (6.0, 0.5)).tolist() == pytest.approx([length_m])


def test_it_grows_with_the_map(add):
    known = ExplorationMap(reach_m=4.0, min_arc_m=0.5)
    roadmap = NodeRoadmap(known, Footprint.disc(0.25), reach_m=4.0)
    for serial in range(4):
        assert math.isinf(roadmap.costs(PLACES[0], PLACES[3])[0]) == (serial < 3)
        node = add(known, serial)
        assert node.id in roadmap.graph.tree({node.id: 0.0})[0]
    assert math.isfinite(roadmap.costs(PLACES[0], PLACES[3])[0])


def test_wide_bodies_do_not_fit_through_the_door(known):
    wide = NodeRoadmap(known, Footprint.disc(0.8), reach_m=4.0)
    assert wide.path(PLACES[1], PLACES[2]) is None


def test_paths_that_are_barred_are_not_taken(known):
    roadmap = NodeRoadmap(known, Footprint.disc(0.25), reach_m=4.0)
    assert roadmap.path(PLACES[0], PLACES[3], lambda a, b: {a.serial, b.serial} != {1, 2}) is None


def test_nodes_that_lead_to_a_place_come_nearest_first(known):
    roadmap = NodeRoadmap(known, Footprint.disc(0.25), reach_m=4.0)
    assert [node.id.serial for node in roadmap.visible_from((2.0, 4.0))] == [1, 2, 0]


def test_a_path_has_one_place_at_each_end(known):
    roadmap = NodeRoadmap(known, Footprint.disc(0.25), reach_m=4.0)
    with pytest.raises(InvalidInputError, match="give one"):
        roadmap.path(PLACES, PLACES[0])
    assert roadmap.costs(PLACES[0], []).tolist() == []
