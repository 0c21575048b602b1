import numpy as np
import pytest

from multisrt.geometry.bodies.collision import CollisionWorld
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.robots.explorer import Done, Sense
from multisrt.testing.hidden_truth import path_to_truth
from tests.multisrt.testing.explorers import HALL, WORLD, Base, check, explorer, refused


class Cheat(Base):
    def __init__(self, me, world):
        super().__init__(me)
        self.pocket = {"deep": [world]}


class Slotted:
    __slots__ = ("world",)

    def __init__(self, world):
        self.world = world


def as_local(self):
    peeked = [EdgeIndex(WORLD.edges, 1.0)]
    yield Sense()
    yield self.to(x=0.1 * len(peeked))


def by_import(self):
    yield Sense()
    from multisrt.environments.catalog import environment

    environment("open")


def by_module(self):
    import multisrt as ms

    yield Sense()
    ms.explore("open")


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda me: Cheat(me, WORLD), r"explorer\.pocket\['deep'\]\[0\] is a .*Environment"),
        (lambda me: Cheat(me, Slotted(WORLD)), r"pocket\['deep'\]\[0\]\.world is"),
        (lambda me: Cheat(me, lambda: WORLD.free), "global 'WORLD'"),
        (lambda me: Cheat(me, CollisionWorld(WORLD.free)), "CollisionWorld"),
        (lambda me: Cheat(me, EdgeIndex(HALL.edges, 1.0)), "EdgeIndex of the world"),
        (lambda me: Cheat(me, HALL.edges[:2]), "array of the world's edges"),
        (explorer(lambda self: iter([Sense()] * len(WORLD.starts))), "global 'WORLD' is"),
        (explorer(by_import), r"multisrt\.environments\.catalog"),
        (explorer(by_module), r"ms\.explore is multisrt\.run\.explore"),
    ],
)
def test_the_truth(make, match):
    defect = refused(make, match)
    assert "reaches the truth" in defect.what


def test_the_truth_in_a_closure_and_in_a_generator():
    def hide(world):
        return lambda: world

    refused(lambda me: Cheat(me, hide(WORLD)), "closure 'world'")

    class Peeking(Base):
        def run(self):
            index = self.look()
            yield Sense()
            del index
            yield Done(complete=True, reason="")

        def look(self):
            return next(iter(PEEK))

    PEEK[:] = [EdgeIndex(HALL.edges, 1.0)]
    refused(Peeking, r"local 'index'|global 'PEEK'")


PEEK: list[object] = []


def test_an_index_of_what_the_robot_has_seen_is_allowed():
    def act(self):
        scan = yield Sense()
        # Part of the hall: its visibility polygon, of which a corner is cut off by the range.
        edges = np.hstack([scan.boundary, np.roll(scan.boundary, -1, axis=0)])
        self.index = EdgeIndex(edges, 1.0)
        yield Sense()

    check(explorer(act), start=(1.0, 1.0))


def test_the_path_to_the_truth_is_a_shortest_one():
    thing = {"a": {"b": [WORLD]}, "c": WORLD}
    found = path_to_truth({"it": thing}, WORLD)
    assert found is not None
    assert found[0] == "it['c']"
    assert path_to_truth({"it": {"a": 1, "b": [np.zeros(3)]}}, WORLD) is None
