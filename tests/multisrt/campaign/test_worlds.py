"""The worlds of a campaign."""

from collections import Counter

import pytest
import shapely

from multisrt.campaign.worlds import MAX_AREA_M2, ODD, world, world_of
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import CatalogEnvironment, InlineEnvironment

SAMPLE = 120


@pytest.fixture(scope="module")
def worlds():
    """Worlds of a campaign that can be built."""
    found = []
    for number in range(SAMPLE):
        try:
            spec = world(5, number)
            found.append((spec, world_of(spec)))
        except InvalidInputError:
            continue
    return found


def test_most_worlds_can_be_built_and_are_small(worlds):
    assert len(worlds) > 0.85 * SAMPLE
    drawn = [built.area_m2 for spec, built in worlds if _is_drawn(spec)]
    assert max(drawn) <= MAX_AREA_M2
    assert sorted(drawn)[len(drawn) // 2] < 300.0


def _is_drawn(spec) -> bool:
    return isinstance(spec, InlineEnvironment) or bool(spec.parameters)


def test_worlds_are_of_all_kinds(worlds):
    kinds = Counter(
        "generated" if isinstance(spec, CatalogEnvironment) and spec.parameters else spec.name
        for spec, _ in worlds
    )
    assert kinds["generated"] > 0.3 * SAMPLE
    assert kinds["passages"] > 5
    assert len(ODD.keys() & kinds.keys()) > 3
    assert sum(name.startswith("turned-") for name in kinds) > 2


def test_some_turned_worlds_are_slanted(worlds):
    for spec, built in worlds:
        if spec.name.startswith("turned-"):
            steps = shapely.get_coordinates(built.free)
            assert len(steps) > 4
            box = shapely.box(*built.bounds)
            assert built.free.area < box.area


def test_equal_worlds_are_built_once():
    spec = CatalogEnvironment(name="open", parameters={"size_m": 6.0})
    assert world_of(spec) is world_of(CatalogEnvironment(name="open", parameters={"size_m": 6.0}))


@pytest.mark.parametrize("number", range(3))
def test_a_world_depends_on_seed_and_number_alone(number):
    assert world(2, number) == world(2, number)
    assert world(2, number) != world(3, number)
