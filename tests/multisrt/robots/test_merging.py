"""Entries that robots send each other give one map, in any order, repeated, with losses."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.environments.catalog import environment
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.boundary import OBSTACLE, RANGE
from multisrt.geometry.regions.frontier_arcs import frontier_candidates, total_length
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.geometry.regions.shapes import Shape
from multisrt.robots.exploration_map import Closing, ClosingId, ExplorationMap, Node, NodeId
from multisrt.robots.knowledge import REASONS, key_of

REACH = 4.0
WIDTHS = (0.3, 0.6, 0.45)
RANGES = (4.0, 2.5, 3.3)
"""Widths and ranges of the three robots in metres."""

WORLDS = ("apartment", "cave", "office")
SHAPES: tuple[Shape, ...] = ("radial", "star", "ball")


def new_map(robot: int | None = None, min_arc_m: float = 0.3) -> ExplorationMap:
    width = min(WIDTHS) if robot is None else WIDTHS[robot]
    return ExplorationMap(reach_m=REACH, min_arc_m=min_arc_m, width_m=width, robot=robot)


def map_of(entries, robot: int | None = None, min_arc_m: float = 0.3) -> ExplorationMap:
    known = new_map(robot, min_arc_m)
    known.merge(entries)
    return known


def team_nodes(worlds, world: str, shape: Shape, count: int = 15) -> list[Node]:
    """Return nodes of three robots with different ranges; parents of robot 2's are the others'."""
    free = environment(world).free
    x, y = free.representative_point().coords[0]
    around = max(
        shapely.get_parts(free.intersection(shapely.box(x - 5, y - 5, x + 5, y + 5))),
        key=lambda part: part.area,
    )
    places = worlds.viewpoints(around, count, clearance=0.2, seed=3)
    # One robot looks from where another has looked before.
    places[-1] = places[0]
    index = worlds.index(free, REACH)
    nodes = []
    for k, at in enumerate(places.tolist()):
        robot, serial = k % 3, k // 3
        parent = NodeId(robot, serial - 1) if serial else None
        if robot == 2:
            parent = NodeId(serial % 2, serial // 2)
        scan = take_scan(index, Configuration(*at), 0.0, RANGES[0 if k == count - 1 else robot])
        nodes.append(
            Node(
                id=NodeId(robot, serial),
                configuration=Configuration(*at),
                region=local_safe_region(scan, shape),
                parent=parent,
                time_s=float(k),
            )
        )
    return nodes


def with_closings(nodes: list[Node]) -> list[Node | Closing]:
    """Return nodes, with closings of arcs that were open when only earlier nodes were known."""
    known, entries = new_map(), list[Node | Closing]()
    made = [0, 0, 0]
    for k, node in enumerate(nodes):
        known.add(node)
        entries.append(node)
        open_nodes = known.open_nodes()
        if k % 2 or not open_nodes:
            continue
        chosen = open_nodes[k % len(open_nodes)]
        arc = known.frontier_arcs(chosen)[0]
        robot = (k // 2) % 3
        half = arc[: max(1, len(arc) // 2)]
        entries.append(
            Closing(
                id=ClosingId(robot, made[robot]),
                node=chosen,
                arc=half,
                reason=REASONS[k // 2 % len(REASONS)],
                width_m=WIDTHS[robot],
            )
        )
        made[robot] += 1
    return entries


@pytest.fixture(scope="module")
def teams(worlds):
    return {
        (world, shape): with_closings(team_nodes(worlds, world, shape))
        for world, shape in zip(WORLDS, SHAPES, strict=True)
    } | {("apartment", "star"): with_closings(team_nodes(worlds, "apartment", "star"))}


TEAMS = st.sampled_from([*zip(WORLDS, SHAPES, strict=True), ("apartment", "star")])


def assert_same(known: ExplorationMap, expected: ExplorationMap) -> None:
    assert {n.id for n in known.nodes} == {n.id for n in expected.nodes}
    assert {c.id for c in known.closings} == {c.id for c in expected.closings}
    assert known.entries.have() == expected.entries.have()
    assert known.roots() == expected.roots()
    assert known.open_nodes() == expected.open_nodes()
    assert known.open_frontier_m() == pytest.approx(expected.open_frontier_m(), abs=1e-9)
    for node in expected.nodes:
        mine, theirs = known.frontier(node.id), expected.frontier(node.id)
        assert mine.shape == theirs.shape
        assert np.abs(mine - theirs).max(initial=0.0) <= 1e-9
        assert known.tree(node.id) == expected.tree(node.id)
    for root in expected.roots():
        assert known.open_nodes(root) == expected.open_nodes(root)
        lengths = known.open_frontier_m(root), expected.open_frontier_m(root)
        assert lengths[0] == pytest.approx(lengths[1], abs=1e-9)


def batches(random, entries):
    """Yield all entries in any order, some of them more than once, in batches."""
    stream = [*entries, *(random.choices(entries, k=len(entries) // 2) if entries else ())]
    random.shuffle(stream)
    while stream:
        size = random.randint(1, 6)
        yield stream[:size]
        stream = stream[size:]


@given(TEAMS, st.sampled_from([None, 0, 1, 2]), st.randoms(use_true_random=False))
@settings(max_examples=40)
def test_order_repetition_and_batches_make_no_difference(teams, team, robot, random):
    entries = teams[team]
    known = new_map(robot)
    new: list[NodeId] = []
    for batch in batches(random, entries):
        new += known.merge(batch)
        # Answers are cached in between, and must not be returned later.
        if random.random() < 0.3:
            known.open_frontier_m()
            known.is_complete()
            for root in known.roots():
                known.open_frontier_m(root)
    assert sorted(new) == sorted(e.id for e in entries if isinstance(e, Node))
    assert_same(known, map_of(entries, robot))


@given(TEAMS, st.data(), st.randoms(use_true_random=False))
@settings(max_examples=25)
def test_lost_entries_are_asked_for_again(teams, team, data, random):
    entries = teams[team]
    lost = data.draw(st.sets(st.sampled_from(range(len(entries)))))
    source, known = map_of(entries, 0), new_map(0)
    for batch in batches(random, [e for k, e in enumerate(entries) if k not in lost]):
        known.merge(batch)
    lacking = source.entries.missing_from(known.entries.have())
    assert {e.id for k, e in enumerate(entries) if k in lost} <= {e.id for e in lacking}
    known.merge(lacking)
    assert_same(known, source)
    assert source.entries.missing_from(known.entries.have()) == ()
    assert not source.entries.has_more_than(known.entries.have())


@given(TEAMS, st.data())
@settings(max_examples=25)
def test_robots_that_exchange_what_they_lack_know_the_same(teams, team, data):
    entries = teams[team]
    shares = st.lists(st.sampled_from(entries), max_size=len(entries))
    one, other = map_of(data.draw(shares), 0), map_of(data.draw(shares), 1)
    for each, else_ in ((one, other), (other, one)):
        assert each.entries.has_more_than(else_.entries.have()) == (
            len(each.entries.missing_from(else_.entries.have())) > 0
        )
    for_one, for_other = (
        other.entries.missing_from(one.entries.have()),
        one.entries.missing_from(other.entries.have()),
    )
    one.merge(for_one)
    other.merge(for_other)
    assert one.entries.have() == other.entries.have()
    assert {n.id for n in one.nodes} == {n.id for n in other.nodes}
    assert {c.id for c in one.closings} == {c.id for c in other.closings}


def box_node(robot: int, serial: int, corners, tag: int, parent: NodeId | None = None) -> Node:
    x0, y0, x1, y1 = corners
    region = LocalSafeRegion(
        x=(x0 + x1) / 2,
        y=(y0 + y1) / 2,
        range_m=REACH,
        boundary=np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], float),
        tags=np.full(4, tag, np.int8),
    )
    return Node(
        id=NodeId(robot, serial),
        configuration=Configuration(region.x, region.y),
        region=region,
        parent=parent,
        time_s=0.0,
    )


def plain_node(robot: int, serial: int, parent: NodeId | None = None) -> Node:
    return box_node(robot, serial, (0, 0, 1, 1), OBSTACLE, parent)


def plain_closing(robot: int, number: int) -> Closing:
    arc = np.array([[1.0, 0.0, 1.0, 1.0]])
    return Closing(
        id=ClosingId(robot, number),
        node=NodeId(0, 0),
        arc=arc,
        reason="seen from near",
        width_m=0.3,
    )


def test_counts_stop_at_the_first_gap():
    known = new_map()
    assert known.entries.have() == {}
    entries: list[Node | Closing] = [
        plain_node(4, 1),
        plain_node(4, 3),
        plain_closing(2, 0),
        plain_node(2, 0),
    ]
    assert known.merge(entries) == (NodeId(4, 1), NodeId(4, 3), NodeId(2, 0))
    assert known.merge(entries) == ()
    assert list(known.entries.have().items()) == [(2, (1, 1)), (4, (0, 0))]
    known.merge([plain_node(4, 0), plain_closing(4, 1)])
    assert known.entries.have() == {2: (1, 1), 4: (2, 0)}
    assert known.entries.counts() == ((2, 1, 1), (4, 2, 0))
    known.merge([plain_node(4, 2), plain_closing(4, 0)])
    assert known.entries.have() == {2: (1, 1), 4: (4, 2)}


def test_missing_entries_come_by_robot_kind_and_number():
    known = map_of(
        [
            plain_closing(3, 0),
            plain_node(3, 2),
            plain_node(3, 0),
            plain_closing(1, 5),
            plain_node(1, 1),
            plain_node(1, 0),
        ]
    )

    def lacking(theirs):
        return [entry.id for entry in known.entries.missing_from(theirs)]

    one, three = [NodeId(1, 0), NodeId(1, 1)], [NodeId(3, 0), NodeId(3, 2)]
    assert lacking({}) == [*one, ClosingId(1, 5), *three, ClosingId(3, 0)]
    assert lacking({1: (1, 0), 3: (1, 1), 8: (9, 9)}) == [one[1], ClosingId(1, 5), three[1]]
    assert lacking({1: (2, 6), 3: (3, 1)}) == []
    assert known.entries.has_more_than({1: (2, 5), 3: (3, 1)})
    assert not known.entries.has_more_than({1: (2, 6), 3: (3, 1)})


def test_entries_beyond_a_gap_are_told_by_key():
    known = map_of([plain_node(3, 0), plain_node(3, 2), plain_closing(3, 2), plain_closing(1, 5)])
    entries = known.entries
    assert entries.beyond() == ((1, 1, 5), (3, 0, 2), (3, 1, 2))
    assert {key_of(entry) for entry in entries.missing_from(entries.have())} == {*entries.beyond()}
    assert entries.missing_from(entries.have(), entries.beyond()) == ()
    assert not entries.has_more_than(entries.have(), entries.beyond())
    lacking = entries.missing_from(entries.have(), {(1, 1, 5), (3, 0, 2)})
    assert [entry.id for entry in lacking] == [ClosingId(3, 2)]
    assert entries.has_more_than(entries.have(), {(1, 1, 5), (3, 0, 2)})


@pytest.mark.parametrize("entry", [plain_node(0, -1), plain_closing(0, -1)])
def test_numbers_begin_at_zero(entry):
    with pytest.raises(InvalidInputError, match="numbered from 0, not -1"):
        new_map().merge([entry])


def test_trees_grow_together_when_the_missing_link_comes():
    # 0.0 <- 0.1 <- 1.5 <- 2.0 and 0.1 <- 2.1; 1.0 is a root of its own.
    nodes = [
        plain_node(2, 0, NodeId(1, 5)),
        plain_node(2, 1, NodeId(0, 1)),
        plain_node(1, 5, NodeId(0, 1)),
        plain_node(0, 0),
        plain_node(1, 0),
        plain_node(0, 1, NodeId(0, 0)),
    ]
    known = new_map()
    for node in nodes[:-1]:
        known.add(node)
    # Until then, what grows from a node without a parent is a tree.
    roots = [NodeId(0, 0), NodeId(1, 0), NodeId(1, 5), NodeId(2, 1)]
    assert [known.tree(n.id) for n in nodes[:-1]] == [roots[k] for k in (2, 3, 2, 0, 1)]
    assert known.roots() == roots
    known.add(nodes[-1])
    trees = [known.tree(n.id) for n in nodes]
    assert trees == [NodeId(1, 0) if n.id == (1, 0) else NodeId(0, 0) for n in nodes]
    assert known.roots() == roots[:2]


def test_a_far_node_joins_its_tree_with_the_missing_link():
    # Each is a square of 1 m, open all around, 100 m from the next.
    chain = [
        box_node(0, k, (100 * k, 0, 100 * k + 1, 1), RANGE, NodeId(0, k - 1) if k else None)
        for k in range(3)
    ]
    root, link, leaf = chain
    known = map_of([root, leaf])
    assert known.open_frontier_m() == 8.0
    assert known.open_frontier_m(root.id) == known.open_frontier_m(leaf.id) == 4.0
    assert known.open_nodes() == [root.id, leaf.id]
    known.add(link)
    assert known.open_frontier_m(root.id) == known.open_frontier_m() == 12.0
    assert known.open_nodes(root.id) == known.open_nodes() == [n.id for n in chain]


def test_open_frontier_is_asked_of_any_node_of_a_tree():
    known = map_of([plain_node(0, 0), plain_node(0, 1, NodeId(0, 0))])
    assert known.open_nodes(NodeId(0, 1)) == known.open_nodes(NodeId(0, 0))
    with pytest.raises(InvalidInputError, match="not known"):
        known.open_frontier_m(NodeId(5, 0))
    with pytest.raises(InvalidInputError, match="not known"):
        known.open_nodes(NodeId(5, 0))


def test_the_tree_of_a_node_that_is_not_known():
    with pytest.raises(InvalidInputError, match="not known"):
        new_map().tree(NodeId(0, 0))


@given(TEAMS, st.sampled_from([0.0, 0.3, 1.5]), st.randoms(use_true_random=False))
@settings(max_examples=15)
def test_open_frontier_of_trees_at_every_moment(teams, team, shortest, random):
    # After every entry, against sums over the nodes whose links lead to the root.
    entries = list(teams[team])
    random.shuffle(entries)
    known = new_map(0, shortest)
    for entry in entries:
        known.merge([entry])
        fresh = map_of([*known.nodes, *known.closings], 0, shortest)
        for root in known.roots():
            members = [n.id for n in known.nodes if followed(known, n.id) == root]
            lengths = {n: total_length(fresh.frontier(n)) for n in members}
            assert known.open_nodes(root) == sorted(n for n in members if lengths[n])
            assert known.open_frontier_m(root) == pytest.approx(math.fsum(lengths.values()))
        for node in known.nodes:
            assert known.tree(node.id) == followed(known, node.id)


def followed(known: ExplorationMap, node_id: NodeId) -> NodeId:
    while (parent := known[node_id].parent) is not None and parent in known:
        node_id = parent
    return node_id


def lines(segments) -> shapely.MultiLineString:
    return shapely.MultiLineString(list(np.reshape(segments, (-1, 2, 2))))


@given(TEAMS, st.randoms(use_true_random=False), st.integers(1, 15))
@settings(max_examples=20)
def test_a_frontier_lies_in_no_known_region(teams, team, random, count):
    # Points a little outside of every frontier arc are in no region at all.
    nodes = [e for e in teams[team] if isinstance(e, Node)]
    random.shuffle(nodes)
    known = map_of(nodes[:count], min_arc_m=0.0)
    regions = [n.region.polygon().buffer(-1e-4) for n in nodes[:count]]
    for node in nodes[:count]:
        arcs = known.frontier(node.id)
        along = arcs[:, 2:] - arcs[:, :2]
        lengths = np.hypot(*along.T)
        arcs, along = arcs[lengths > 0.01], along[lengths > 0.01]
        outward = np.column_stack([along[:, 1], -along[:, 0]])
        outward /= np.hypot(*outward.T)[:, None]
        for share in (0.1, 0.37, 0.5, 0.9):
            for eps in (0.0, 1e-5):
                x, y = (arcs[:, :2] + share * along + eps * outward).T
                assert not any(shapely.contains_xy(region, x, y).any() for region in regions)
        inside = arcs[:, :2] + 0.5 * along - 1e-5 * outward
        assert shapely.contains_xy(node.region.polygon(), *inside.T).all()


@pytest.mark.slow
@given(TEAMS, st.randoms(use_true_random=False), st.integers(1, 15))
@settings(max_examples=20)
def test_all_frontier_is_the_border_of_the_union_and_counts_once(teams, team, random, count):
    nodes = [e for e in teams[team] if isinstance(e, Node)]
    random.shuffle(nodes)
    nodes = nodes[:count]
    known = map_of(nodes, min_arc_m=0.0)
    candidates = np.vstack([frontier_candidates(n.region.boundary, n.region.tags) for n in nodes])
    border = shapely.union_all([n.region.polygon() for n in nodes]).boundary
    expected = border.intersection(lines(candidates).buffer(1e-6))
    found = lines(np.vstack([known.frontier(n.id) for n in nodes]))
    assert found.difference(border.buffer(1e-5)).length < 1e-3
    # What is left out is shorter than a millimetre each.
    missing = expected.difference(found.buffer(1e-4))
    assert max((part.length for part in shapely.get_parts(missing)), default=0.0) < 2e-3
    assert known.open_frontier_m() == pytest.approx(expected.length, abs=2e-2)


@pytest.mark.slow
@given(
    st.lists(
        st.tuples(st.integers(0, 5), st.integers(0, 5), st.integers(1, 4), st.integers(1, 4)),
        min_size=1,
        max_size=9,
    ),
    st.randoms(use_true_random=False),
)
@settings(max_examples=150)
def test_boxes_that_share_borders_have_the_border_of_their_union(boxes, random):
    # On a grid of half metres nearly all borders coincide with others, on one side or on two.
    nodes = [
        box_node(k % 2, k // 2, (x / 2, y / 2, (x + w) / 2, (y + h) / 2), RANGE)
        for k, (x, y, w, h) in enumerate(boxes)
    ]
    shuffled = random.sample(nodes, len(nodes))
    known = map_of(shuffled, min_arc_m=0.0)
    border = shapely.union_all([n.region.polygon() for n in nodes]).boundary
    assert known.open_frontier_m() == pytest.approx(border.length, abs=1e-3)
    found = lines(np.vstack([known.frontier(n.id) for n in nodes]))
    assert border.difference(found.buffer(1e-5)).length < 1e-3
    assert_same(known, map_of(nodes, min_arc_m=0.0))


def test_two_scans_at_one_place_share_their_frontier(worlds):
    nodes = team_nodes(worlds, "apartment", "radial")
    assert nodes[-1].configuration == nodes[0].configuration
    twice = map_of([nodes[0], nodes[-1]])
    assert nodes[0].id < nodes[-1].id
    assert twice.open_nodes() == [nodes[0].id]
    assert twice.open_frontier_m() == map_of([nodes[0]]).open_frontier_m()
