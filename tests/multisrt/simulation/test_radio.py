import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.environments.environment import Environment
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.line_of_sight import line_of_sight
from multisrt.simulation.radio import Radio
from multisrt.spec import RadioSpec

HALL = shapely.box(0, 0, 20, 10)


def radio(world=HALL, seed=0, cell=2.0, **spec):
    edges = Environment("world", world).edges
    return Radio(RadioSpec(**spec), EdgeIndex(edges, cell), np.random.default_rng(seed))


def everybody(positions):
    return [True] * len(positions)


def test_an_unlimited_radio_reaches_all_that_work():
    at = [(1, 1), (19, 9), (5, 5), (7, 2)]
    for walls in ("pass", "block"):
        assert radio(walls=walls).reached(2, at, everybody(at)) == [0, 1, 3]
        assert radio(walls=walls).reached(2, at, [True, False, True, True]) == [0, 3]
    assert radio().reached(0, at, [False, True, True, True]) == []
    assert radio().reached(0, at[:1], [True]) == []


def test_only_an_unlimited_radio_needs_no_positions():
    assert radio().reaches_everywhere
    assert radio(loss=0.5).reaches_everywhere
    assert not radio(walls="block").reaches_everywhere
    assert not radio(range_m=100.0).reaches_everywhere
    assert radio().reached(2, [], [True, False, True, True]) == [0, 3]


def test_the_range_is_a_disc_with_its_border():
    at = [(1, 1), (4, 5), (1, 6.001)]
    assert radio(range_m=5.0).reached(0, at, everybody(at)) == [1, 2]  # 2 by a relay at 1
    assert radio(range_m=5.0, multi_hop=False).reached(0, at, everybody(at)) == [1]
    assert radio(range_m=4.999).reached(0, at, everybody(at)) == []
    assert radio(range_m=0.0).reached(0, at, everybody(at)) == []


def test_relays_go_on_until_one_is_silent():
    chain = [(x, 5) for x in (1, 4, 7, 10, 13)]
    reach = radio(range_m=3.5).reached
    assert reach(0, chain, everybody(chain)) == [1, 2, 3, 4]
    assert reach(0, chain, [True, True, False, True, True]) == [1]
    assert reach(4, chain, [True, True, False, True, True]) == [3]
    assert radio(range_m=3.5, multi_hop=False).reached(2, chain, everybody(chain)) == [1, 3]


def test_walls_block_and_relays_go_round_them():
    world = HALL - shapely.box(9.9, 2, 10.1, 10)  # open at the bottom
    at = [(5, 8), (15, 8), (10, 1)]
    assert radio(world, walls="block").reached(0, at, everybody(at)) == [1, 2]
    assert radio(world, walls="block").reached(0, at[:2], [True, True]) == []
    assert radio(world, walls="block", multi_hop=False).reached(0, at, everybody(at)) == [2]
    assert radio(world, walls="pass").reached(0, at[:2], [True, True]) == [1]
    # The path over (10, 1) has two links of 8.6 m.
    assert radio(world, walls="block", range_m=8.0).reached(0, at, everybody(at)) == []


def test_links_are_the_robots_reached_without_relays():
    world = HALL - shapely.box(9.9, 2, 10.1, 10)
    at = [(5, 8), (15, 8), (10, 1), (6, 8)]
    working = [True, True, True, False]
    links = radio(world, walls="block").links(at, working)
    assert links.tolist() == [
        [False, False, True, False],
        [False, False, True, False],
        [True, True, False, False],
        [False, False, False, False],
    ]


@pytest.mark.parametrize(
    ("walls", "distance", "hears"),
    [
        (0, 9.99, True),
        (0, 10.01, False),
        # 6 dB with exponent 2 halve the range: 20 log10(1 / 2) = -6.02.
        (1, 5.00, True),
        (1, 5.02, False),
        (2, 2.51, True),
        (2, 2.52, False),
    ],
)
def test_walls_weaken(walls, distance, hears):
    solid = [shapely.box(2.1 + 0.2 * k, 0.5, 2.2 + 0.2 * k, 9.5) for k in range(walls)]
    world = HALL - shapely.union_all(solid)
    at = [(2, 5), (2 + distance, 5)]
    spec = {"range_m": 10.0, "walls": "weaken", "wall_loss_db": 6.0}
    assert radio(world, **spec).reached(0, at, [True, True]) == ([1] if hears else [])
    assert radio(world, **spec).reached(1, at, [True, True]) == ([0] if hears else [])


def test_a_steeper_loss_makes_walls_matter_less():
    world = HALL - shapely.box(3, 0.5, 3.2, 9.5)
    at = [(2, 5), (9, 5)]
    for exponent, hears in ((2.0, []), (4.0, [1])):  # 10 m shrink to 5.0 and 7.1 m
        heard = radio(
            world, range_m=10.0, walls="weaken", wall_loss_db=6.0, path_loss_exponent=exponent
        ).reached(0, at, [True, True])
        assert heard == hears


def test_touching_and_grazing_walls_is_no_passage():
    # A block from 4 to 6, with robots on the lines of its sides and at its corners, and a second
    # one on the other side of the line y = 6.
    world = HALL - shapely.box(4, 4, 6, 6) - shapely.box(8, 6, 10, 8)
    pairs = [((1, 6), (15, 6)), ((1, 4), (15, 4)), ((2, 2), (2, 8)), ((3, 9), (9, 3))]
    for pair in pairs:
        assert radio(world, walls="block").reached(0, pair, [True, True]) == [1]
        weak = radio(world, range_m=math.dist(*pair), walls="weaken", wall_loss_db=1.0)
        assert weak.reached(0, pair, [True, True]) == [1]
    through = ((2, 7), (7, 4.2))
    assert radio(world, walls="block").reached(0, through, [True, True]) == []
    # From corner to corner, along a diagonal of the block.
    assert radio(world, walls="block").reached(0, ((3, 3), (7, 7)), [True, True]) == []


def stones(seed):
    rng = np.random.default_rng(seed)
    blocks = [
        shapely.box(x, y, x + w, y + h)
        for x, y, w, h in zip(
            *np.round(rng.uniform(0.5, 18, (1, 12)), 1),
            *np.round(rng.uniform(0.5, 8.5, (1, 12)), 1),
            *np.round(rng.uniform(0.1, 2, (2, 12)), 1),
            strict=True,
        )
    ]
    return HALL - shapely.union_all(blocks)


def places_in(world, count, rng):
    places: list[tuple[float, float]] = []
    while len(places) < count:
        x, y = rng.uniform((0, 0), (20, 10))
        if shapely.contains_xy(world, x, y):
            places.append((x, y))
    return places


@pytest.mark.slow
@given(st.integers(0, 10**6))
def test_walls_are_counted_as_shapely_counts_them(seed):
    world, rng = stones(seed), np.random.default_rng(seed)
    at = places_in(world, 6, rng)
    solid = shapely.box(-1, -1, 21, 11) - world
    # A spec whose range behind k walls is 30 / 2 ** k metres.
    loss = 20 * math.log10(2)
    weak = radio(world, range_m=30.0, walls="weaken", wall_loss_db=loss, cell=1.3)
    blocked = radio(world, walls="block", cell=1.3)
    sight = EdgeIndex(Environment("world", world).edges, 1.0)
    links, views = weak.links(at, everybody(at)), blocked.links(at, everybody(at))
    for i in range(6):
        for j in range(6):
            if i == j:
                continue
            inside = shapely.LineString([at[i], at[j]]) & solid
            walls = sum(part.length > 1e-7 for part in shapely.get_parts(inside))
            assert links[i, j] == (math.dist(at[i], at[j]) <= 30.0 / 2**walls)
            assert views[i, j] == (walls == 0) == line_of_sight(sight, *at[i], *at[j])


@given(st.integers(0, 10**6), st.floats(0.5, 8.0), st.sampled_from(["pass", "block", "weaken"]))
def test_relays_reach_the_connected_component(seed, range_m, walls):
    world, rng = stones(seed), np.random.default_rng(seed)
    at = places_in(world, 12, rng)
    working = (rng.random(12) < 0.8).tolist()
    one = radio(world, range_m=range_m, walls=walls)
    links = one.links(at, working)
    assert (links == links.T).all()
    assert not links.diagonal().any()
    assert not links[~np.array(working)].any()
    connected = np.linalg.matrix_power(links.astype(int) + np.eye(12, dtype=int), 12) > 0
    near = radio(world, range_m=range_m, walls=walls, multi_hop=False)
    for sender in range(12):
        others = [r for r in range(12) if r != sender]
        assert one.reached(sender, at, working) == [r for r in others if connected[sender, r]]
        assert near.reached(sender, at, working) == [r for r in others if links[sender, r]]


def test_a_message_takes_its_time():
    at = [(1, 1), (2, 1), (3, 1)]
    assert radio(latency_s=0.3).deliveries(1, None, at, everybody(at)) == ([(0, 0.3), (2, 0.3)], [])
    assert radio(latency_s=0.3).deliveries(1, 2, at, everybody(at)) == ([(2, 0.3)], [])
    assert radio(range_m=1.5, multi_hop=False).deliveries(0, 2, at, everybody(at)) == ([], [])
    assert radio().deliveries(1, 1, at, everybody(at)) == ([], [])


def test_nothing_is_drawn_where_nothing_is_random():
    at = [(1, 1), (2, 1), (3, 1)]
    rng = np.random.default_rng(3)
    quiet = Radio(RadioSpec(latency_s=1.0), EdgeIndex(Environment("w", HALL).edges, 2.0), rng)
    quiet.deliveries(0, None, at, everybody(at))
    assert rng.random() == np.random.default_rng(3).random()


def test_losses_and_jitter_are_as_the_spec_says():
    at = [(1 + 0.1 * k, 1) for k in range(101)]
    noisy = radio(loss=0.3, latency_s=0.5, jitter_s=0.2, seed=5)
    delays, losses = [], 0
    for _ in range(200):
        delivered, lost = noisy.deliveries(0, None, at, everybody(at))
        assert sorted([receiver for receiver, _ in delivered] + lost) == list(range(1, 101))
        assert lost == sorted(lost)
        delays += [delay for _, delay in delivered]
        losses += len(lost)
    assert losses / 20_000 == pytest.approx(0.3, abs=0.015)
    assert 0.5 <= min(delays) < 0.501
    assert 0.699 < max(delays) < 0.7
    assert np.mean(delays) == pytest.approx(0.6, abs=0.005)
    assert np.std(delays) == pytest.approx(0.2 / math.sqrt(12), abs=0.003)


def test_the_same_seed_gives_the_same_losses():
    at = [(1 + 0.1 * k, 1) for k in range(40)]

    def said(seed):
        noisy = radio(loss=0.5, jitter_s=0.1, seed=seed)
        return [noisy.deliveries(k, None, at, everybody(at)) for k in range(5)]

    assert said(7) == said(7)
    assert said(7) != said(8)


def test_the_data_sheet_names_the_longest_time():
    sheet = radio(latency_s=0.5, jitter_s=0.25, loss=0.1, multi_hop=False).datasheet()
    assert (sheet.range_m, sheet.latency_s, sheet.loss) == (math.inf, 0.75, 0.1)
    assert not sheet.multi_hop
    assert radio(range_m=8.0).datasheet().range_m == 8.0
