"""Places from which frontier arcs are seen."""

import numpy as np

from multisrt.planners.motion.kinematics import Car
from multisrt.planners.viewing import MAX_ASKED
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.roadmap import SrtRoadmap
from multisrt.robots.multi_srt.views import MAX_VAIN_PLANS


def test_a_car_that_finds_no_path_soon_tries_curves_only(robot_in, monkeypatch):
    width = 1.2
    corridor = ((0.0, 0.0), (-1.0, -width / 2, 7.0, width / 2))
    robot = robot_in(corridor, kinematics=Car(turning_radius_m=2.0, reverse=False))
    asked = []
    leads = SrtRoadmap.leads

    def asked_for(self, node, known, x, y, checks):
        may_plan = not checks.are_used_up
        found = leads(self, node, known, x, y, checks)
        asked.append((found, may_plan and checks.are_used_up))
        return found

    monkeypatch.setattr(SrtRoadmap, "leads", asked_for)
    # The corridor's right end is open: a car sees it from everywhere, and cannot turn round there.
    arc = np.array([[7.0, -width / 2, 7.0, width / 2]])
    windows = len(robot.views._windows())
    assert robot.views.viewing_place(NodeId(0, 0), arc) == "not reachable"
    assert MAX_ASKED < len(asked) <= windows * MAX_ASKED
    assert not any(found for found, _ in asked)
    assert MAX_VAIN_PLANS <= sum(in_vain for _, in_vain in asked) <= windows * MAX_VAIN_PLANS
