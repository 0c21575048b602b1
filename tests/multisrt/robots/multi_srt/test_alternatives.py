"""Motions that a master finds for other robots, whose bodies may differ from its own."""

import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.sweep import Sweep
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.alternatives import KnownAlternatives

GAP_M = 0.05


@pytest.mark.parametrize(("radius_m", "node"), [(0.15, 2), (0.35, 2), (0.45, None)])
def test_a_robot_is_sent_aside_only_along_edges_on_which_its_body_fits(
    robot_in, robot_state, prospect, line, radius_m, node
):
    # Two rooms, 0.8 m high at the nodes 0 and 1 and 0.8 m wide beyond. The path of robot 2
    # sweeps all of the first, so that robot 1 has to go to the second room.
    robot = robot_in(
        ((0.0, 0.0), (-1.0, -0.4, 3.5, 0.4)),
        ((2.5, 0.0), (-1.0, -0.4, 3.5, 0.4)),
        ((2.5, 3.0), (2.1, -0.4, 2.9, 3.8)),
        footprint=Footprint.disc(0.15),
    )
    robot.team.roster.take(
        robot_state(1, ((2.5, 0.0),), node=NodeId(0, 1), footprint=f"disc:{radius_m}"), sender=1
    )
    swept = Sweep(Footprint.disc(0.3), line((-0.7, 0.0), (3.2, 0.0)))
    prospects = {1: prospect(1, (2.5, 0.0)), 2: prospect(2, (-0.7, 0.0), (3.2, 0.0))}
    aside = KnownAlternatives(robot).motions_aside(1, swept, GAP_M, prospects)
    nodes = [(end.serial, motion.end[:2]) for _, motion, end in aside if end is not None]
    assert nodes == ([] if node is None else [(node, (2.5, 3.0))])


def test_a_disc_refuses_an_edge_of_another_roadmap(robot_in):
    rooms = ((0.0, 0.0), (-1.0, -0.3, 3.0, 0.3)), ((2.0, 0.0), (-1.0, -0.3, 3.0, 0.3))
    for radius_m, knows in ((0.2, True), (0.4, False)):
        robot = robot_in(*rooms, footprint=Footprint.disc(radius_m))
        assert robot.roadmap.knows_hop(NodeId(0, 0), NodeId(0, 1)) == knows
