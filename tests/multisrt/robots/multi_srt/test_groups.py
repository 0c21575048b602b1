"""Groups of robots as equivalence classes: against scipy's components, and by hand."""

import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from multisrt.environments.catalog import environment
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.robots.multi_srt.groups import are_coupled, group_of

coordinates = st.tuples(st.floats(0.0, 30.0), st.floats(0.0, 30.0))


@st.composite
def teams(draw, most=8):
    """Paths of robots that stand, plan a motion or move, whether they move, and their ranges."""
    count = draw(st.integers(1, most))
    return [
        (
            draw(st.lists(coordinates, min_size=1, max_size=4)),
            {"moving": draw(st.booleans()), "range_m": draw(st.floats(0.5, 6.0))},
        )
        for _ in range(count)
    ]


def meet(a, b) -> bool:
    """Whether two robots are pre-engaged, from the definition."""
    places = []
    for robot in (a, b):
        path = np.array([(x, y) for _, x, y, _ in robot.path])
        places.append(path if robot.phase == "moving" else path[:1])
    reach = a.range_m + b.range_m
    if np.hypot(*(places[0][-1] - places[1][-1])) < reach:
        return True
    near_a = np.hypot(*(places[0] - places[1][-1]).T).min() < b.range_m
    near_b = np.hypot(*(places[1] - places[0][-1]).T).min() < a.range_m
    return (a.phase == "moving" and near_a) or (b.phase == "moving" and near_b)


def components(members, coupled) -> dict[int, tuple[int, ...]]:
    """The connected component of every member, by scipy."""
    numbers = sorted(members)
    pairs = np.array(
        [[i != j and bool(coupled(members[i], members[j])) for j in numbers] for i in numbers]
    )
    _, labels = connected_components(csr_array(pairs), directed=False)
    return {
        i: tuple(j for j, other in zip(numbers, labels, strict=True) if other == label)
        for i, label in zip(numbers, labels, strict=True)
    }


def check_groups(members, coupled, oracle, order):
    """Check the laws of groups under a symmetric relation."""
    for a, b in itertools.permutations(members.values(), 2):
        assert coupled(a, b) == coupled(b, a)
    groups = {number: group_of(number, members, coupled) for number in members}
    for number, group in groups.items():
        assert number in group
        assert list(group) == sorted(set(group))
        assert all(groups[other] == group for other in group)
    assert sorted(itertools.chain(*set(groups.values()))) == sorted(members)
    for i, j in itertools.combinations(members, 2):
        if coupled(members[i], members[j]):
            assert groups[i] == groups[j]
    assert groups == components(members, oracle)
    shuffled = {number: members[number] for number in order}
    assert {number: group_of(number, shuffled, coupled) for number in members} == groups


@given(teams(), st.data())
def test_pre_engaged_groups_are_equivalence_classes(robot_state, drawn, data):
    team = {number: robot_state(number, path, **how) for number, (path, how) in enumerate(drawn)}
    check_groups(team, are_coupled, meet, data.draw(st.permutations(sorted(team))))


@st.composite
def regions(draw, most=7):
    count = draw(st.integers(1, most))
    made = {}
    for number in range(count):
        x, y = draw(coordinates)
        radii = draw(st.lists(st.floats(0.3, 5.0), min_size=3, max_size=9))
        angles = np.linspace(0.0, 2.0 * math.pi, len(radii), endpoint=False)
        boundary = np.column_stack([x + radii * np.cos(angles), y + radii * np.sin(angles)])
        tags = np.zeros(len(radii), np.int8)
        made[number] = LocalSafeRegion(x=x, y=y, range_m=5.0, boundary=boundary, tags=tags)
    return made


@pytest.mark.slow
@given(regions(), st.data())
def test_engaged_groups_are_equivalence_classes(made, data):
    def touch(a, b):
        return not shapely.relate_pattern(a.polygon(), b.polygon(), "FF*FF****")

    order = data.draw(st.permutations(sorted(made)))
    check_groups(made, LocalSafeRegion.overlaps, touch, order)


WORLD = environment("clutter", seed=4)
INDEX = EdgeIndex(WORLD.edges, 1.5)


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.sampled_from(["ball", "star", "radial"]))
def test_groups_of_scanned_regions_are_equivalence_classes(seed, shape):
    rng = np.random.default_rng(seed)
    places = rng.uniform(WORLD.free.bounds[:2], WORLD.free.bounds[2:], (60, 2)).tolist()
    free = [p for p in places if shapely.contains_xy(WORLD.free, *p) and WORLD.clearance(*p) > 0.3]
    made = {
        number: local_safe_region(take_scan(INDEX, Configuration(x, y, 0.0), 0.0, 4.0), shape)
        for number, (x, y) in enumerate(free[:8])
    }

    def share_area(a, b):
        return shapely.distance(a.polygon(), b.polygon()) == 0.0

    check_groups(made, LocalSafeRegion.overlaps, share_area, rng.permutation(len(made)).tolist())


# By hand -------------------------------------------------------------------------------------


def test_targets_nearer_than_both_ranges_couple(robot_state):
    a, far, near = robot_state(0, [(0, 0)]), robot_state(1, [(8, 0)]), robot_state(2, [(7.99, 0)])
    assert not are_coupled(a, far)
    assert are_coupled(a, near)
    assert are_coupled(a, robot_state(3, [(8, 0)], range_m=4.1))
    assert not are_coupled(
        robot_state(0, [(0, 0)], range_m=1.0), robot_state(1, [(4, 0)], range_m=2.0)
    )


def test_the_target_of_a_standing_robot_is_its_place(robot_state):
    other = robot_state(1, [(20, 0)])
    assert not are_coupled(robot_state(0, [(0, 0), (15, 0)]), other)
    assert are_coupled(robot_state(0, [(0, 0), (15, 0)], moving=True), other)
    assert not are_coupled(robot_state(0, [(20, 9), (0, 0)], moving=True), other)


def test_a_path_that_passes_near_couples(robot_state):
    # A long way round: it passes 3 m from the other, which sees 4 m, and ends 20 m from it.
    detour = [(-20, 0), (0, 3), (20, 0)]
    other = robot_state(1, [(0, 0)])
    assert are_coupled(robot_state(0, detour, moving=True), other)
    assert not are_coupled(robot_state(0, detour), other)
    assert not are_coupled(robot_state(0, [(-20, 0), (0, 4), (20, 0)], moving=True), other)


def test_a_chain_is_one_group(robot_state):
    chain = {k: robot_state(k, [(7.0 * k, 0.0)]) for k in range(5)}
    assert not are_coupled(chain[0], chain[2])
    assert group_of(3, chain, are_coupled) == (0, 1, 2, 3, 4)
    del chain[2]
    assert group_of(0, chain, are_coupled) == (0, 1)
    assert group_of(4, chain, are_coupled) == (3, 4)
