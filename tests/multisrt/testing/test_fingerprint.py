import numpy as np

from multisrt.planners.motion.trajectory import Waypoint
from multisrt.testing.fingerprint import attributes_of, fingerprint
from multisrt.testing.hidden_truth import path_to_truth
from tests.multisrt.testing.explorers import WORLD

TITLE = "a multisrt.environments.environment.Environment"


def test_fingerprints_tell_values_apart_and_not_objects():
    def value(x=1.0):
        return {"a": (1, np.array([x, 2.0])), "b": Waypoint(0.0, x, 2.0, 3.0), "c": {1, 2}}

    assert fingerprint(value()) == fingerprint(value())
    assert fingerprint(value()) != fingerprint(value(np.nextafter(1.0, 2.0)))
    assert fingerprint([1, [2]]) != fingerprint([[1], 2])
    assert fingerprint((1, 2)) != fingerprint([1, 2])
    assert fingerprint(np.zeros(2)) != fingerprint(np.zeros((2, 1)))
    endless: list[object] = []
    endless.append(endless)
    assert fingerprint(endless)


def test_an_object_whose_dict_is_no_mapping():
    class Strange:
        __slots__ = ("a",)

        def __getattr__(self, name):
            return (name, 1)

    assert not attributes_of(Strange())
    assert fingerprint(Strange()) == fingerprint(Strange())
    assert path_to_truth({"it": [Strange(), WORLD]}, WORLD) == ("it[1]", TITLE)
