"""Legs between places, of which only some are kept."""

import numpy as np
import pytest

from multisrt.informed import team
from multisrt.informed.roadmap import Tight


class Line:
    """Nodes on a line, one metre apart, in place of a roadmap."""

    def __init__(self):
        self.asked = 0

    def tight(self, a, b):
        self.asked += 1
        return Tight(float(b - a), 0.0, np.array([[a, 0.0], [b, 0.0]]))


@pytest.fixture
def line(monkeypatch):
    monkeypatch.setattr(team, "MAX_SLOTS", 10)
    return Line()


def test_legs_are_computed_once_for_many_nodes(line):
    table = team._Table(line)
    nodes = np.arange(8)
    for left_out in range(8):
        lengths, turning, angles = table.of(np.delete(nodes, left_out))
        assert (lengths == np.abs(np.subtract.outer(*[np.delete(nodes, left_out)] * 2))).all()
        assert not turning.any()
        assert not angles.any()
    assert line.asked == 8 * 7 / 2


@pytest.mark.parametrize("last", [13, 30])
def test_legs_of_too_many_nodes_are_forgotten(line, last):
    """A set of nodes that is larger than what is kept still has all its legs."""
    table = team._Table(line)
    table.of(np.arange(8))
    nodes = np.arange(6, last)
    lengths, _, _ = table.of(nodes)
    assert (lengths == np.abs(np.subtract.outer(nodes, nodes))).all()
    before = line.asked
    assert (table.of(nodes)[0] == lengths).all()
    assert line.asked == before
