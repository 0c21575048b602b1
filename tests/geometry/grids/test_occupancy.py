"""Occupancy: every cell right, no way through walls, groups as if labelled from nothing."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from shapely import affinity, box

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids import raster as raster_module
from multisrt.geometry.grids.occupancy import FREE, OCCUPIED, UNKNOWN, Occupancy
from multisrt.geometry.grids.occupancy.change_log import MAX_CHANGES
from multisrt.geometry.regions.boundary import GAP, OBSTACLE, RANGE
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import take_scan

R = 4.0
EIGHT = np.ones((3, 3), int)


def seen_from(index, places, *, beams=None, shape="radial", range_m=R):
    return [
        local_safe_region(take_scan(index, Configuration(x, y), 0.0, range_m, beams), shape)
        for x, y in np.asarray(places).tolist()
    ]


def regions_of(worlds, name, count, *, seed=61, clearance=0.2, **options):
    free = worlds.WORLDS[name]()
    places = worlds.viewpoints(free, count, clearance=clearance, seed=seed)
    return seen_from(worlds.index(free), places, **options)


def hand_made(corners, tags):
    boundary = np.array(corners, float)
    x, y = boundary.mean(axis=0)
    return LocalSafeRegion(x=x, y=y, range_m=R, boundary=boundary, tags=np.array(tags, np.int8))


def rectangle(x0, y0, x1, y1, tag=GAP):
    return hand_made([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], [tag] * 4)


def surfaces(regions):
    pieces = [
        np.stack([r.boundary, np.roll(r.boundary, -1, axis=0)], axis=1)[r.tags == OBSTACLE]
        for r in regions
    ]
    return shapely.linestrings(np.concatenate(pieces))


def centres(occupancy):
    rows, columns = np.indices(occupancy.cells.shape)
    cells = np.column_stack([rows.ravel(), columns.ravel()])
    return occupancy.centres_of(in_lattice(occupancy, cells))


def in_lattice(raster, index):
    return index + np.array([raster.row, raster.column])


def frontier(occupancy):
    known = np.pad(occupancy.cells, 1) != UNKNOWN
    inside = known[:-2, 1:-1] & known[2:, 1:-1] & known[1:-1, :-2] & known[1:-1, 2:]
    return (occupancy.cells == FREE) & ~inside


def groups_from_nothing(occupancy):
    labels, count = ndimage.label(frontier(occupancy), EIGHT)
    cells = [np.argwhere(labels == k + 1) for k in range(count)]
    return sorted((in_lattice(occupancy, c).tolist() for c in cells), key=lambda c: c[0])


def target_from_nothing(occupancy, cells):
    passable = [tuple(c) for c in cells if occupancy.passable[*occupancy_index(occupancy, c)]]
    # In whole numbers, so that ties are ties.
    total = np.sum(cells, axis=0)
    return min(
        passable,
        key=lambda c: (sum(int(d) ** 2 for d in len(cells) * np.array(c) - total), c),
        default=None,
    )


def occupancy_index(occupancy, cell):
    return cell[0] - occupancy.row, cell[1] - occupancy.column


def assert_groups_are_right(occupancy):
    groups = occupancy.frontier_groups(0.0)
    assert [g.cells.tolist() for g in groups] == groups_from_nothing(occupancy)
    for group in groups:
        assert group.target == target_from_nothing(occupancy, group.cells.tolist())


def knowledge(occupancy):
    """All that is known, whatever the window: known cells, and groups with their targets."""
    known = np.argwhere(occupancy.cells != UNKNOWN)
    named = in_lattice(occupancy, known)
    return (
        named.tolist(),
        occupancy.cells[*known.T].tolist(),
        occupancy.passable[*known.T].tolist(),
        [(g.cells.tolist(), g.target, g.size_m) for g in occupancy.frontier_groups(0.0)],
    )


CASES = [
    ("office", {}),
    ("office", {"beams": 360}),
    ("clutter", {}),
    ("clutter", {"beams": 180}),
    ("crates", {"shape": "star"}),
]


@pytest.mark.parametrize(("name", "options"), CASES)
def test_cells_are_what_the_regions_show(worlds, name, options):
    regions = regions_of(worlds, name, 7, **options)
    occupancy = Occupancy(0.1, 0.23)
    new = sum(occupancy.add(region) for region in regions)
    assert new == np.count_nonzero(occupancy.cells)
    points = centres(occupancy)

    inside = np.zeros(len(points), bool)
    for region in regions:
        polygon = region.polygon()
        shapely.prepare(polygon)
        inside |= shapely.contains_xy(polygon, points)
    walls = shapely.STRtree(surfaces(regions))
    squares = shapely.box(*(points - 0.05).T, *(points + 0.05).T)
    touched = np.zeros(len(points), bool)
    touched[walls.query(squares, predicate="intersects")[0]] = True
    surely = np.zeros(len(points), bool)
    smaller = shapely.box(*(points - 0.05 + 1e-9).T, *(points + 0.05 - 1e-9).T)
    surely[walls.query(smaller, predicate="intersects")[0]] = True

    cells = occupancy.cells.ravel()
    assert (cells[surely] == OCCUPIED).all()
    assert touched[cells == OCCUPIED].all()
    assert (cells[~touched] == np.where(inside, FREE, UNKNOWN)[~touched]).all()

    (which, _), distance = walls.query_nearest(
        shapely.points(points), return_distance=True, all_matches=False
    )
    nearest = np.empty(len(points))
    nearest[which] = distance
    clear = np.abs(nearest - 0.23) > 1e-9
    expected = (cells == FREE) & (nearest >= 0.23)
    assert np.array_equal(occupancy.passable.ravel()[clear], expected[clear])
    assert expected.any()


@pytest.mark.parametrize(("name", "options"), CASES)
def test_groups_equal_those_labelled_from_nothing(worlds, name, options):
    occupancy = Occupancy(0.1, 0.2)
    for k, region in enumerate(regions_of(worlds, name, 24, **options)):
        occupancy.add(region)
        # Now after every region, now after several.
        if k % 7 < 4:
            assert_groups_are_right(occupancy)


@pytest.mark.parametrize(("name", "options"), CASES)
def test_order_and_repetition_do_not_matter(worlds, name, options):
    regions = regions_of(worlds, name, 16, seed=62, **options)
    expected = None
    for seed in range(4):
        order = np.random.default_rng(seed).permutation(16).tolist()
        # One begins with a window for all, the others grow theirs.
        occupancy = Occupancy(0.1, 0.2, None if seed else (-3.0, -3.0, 25.0, 25.0))
        for k in order + order[:5]:
            occupancy.add(regions[k])
            if seed % 2:
                occupancy.frontier_groups()
        expected = expected or knowledge(occupancy)
        assert knowledge(occupancy) == expected


def star(draw):
    n = draw(st.integers(3, 9))
    x, y = draw(st.floats(-6, 6)), draw(st.floats(-6, 6))
    radii = draw(st.lists(st.floats(0.05, 4), min_size=n, max_size=n))
    tags = draw(st.lists(st.sampled_from([OBSTACLE, RANGE, GAP]), min_size=n, max_size=n))
    angles = 0.1 + np.arange(n) * (2 * np.pi / n)
    boundary = np.array([x, y]) + np.array(radii)[:, None] * np.column_stack(
        [np.cos(angles), np.sin(angles)]
    )
    if draw(st.booleans()):
        boundary = np.round(boundary)
    return hand_made(boundary, tags)


@settings(max_examples=40)
@given(st.lists(st.composite(star)(), min_size=1, max_size=7), st.sampled_from([0.25, 0.4, 1.0]))
def test_whatever_the_regions_groups_are_right_and_order_is_nothing(regions, cell):
    forward, backward = Occupancy(cell, 0.5), Occupancy(cell, 0.5)
    for region in regions:
        before = np.count_nonzero(forward.cells)
        assert forward.add(region) == np.count_nonzero(forward.cells) - before
        assert_groups_are_right(forward)
    for region in regions[::-1]:
        backward.add(region)
    assert knowledge(forward) == knowledge(backward)
    revision = forward.revision
    assert [forward.add(region) for region in regions] == [0] * len(regions)
    assert forward.revision == revision


def test_groups_are_right_after_more_changes_than_are_kept_apart():
    regions = [rectangle(k % 13, k // 13, k % 13 + 0.7, k // 13 + 0.7) for k in range(150)]
    occupancy = Occupancy(0.1, 0.2)
    for region in regions:
        occupancy.add(region)
    assert_groups_are_right(occupancy)


def test_groups_far_from_a_change_stay_the_same_objects():
    occupancy = Occupancy(0.1, 0.2)
    occupancy.add(rectangle(0, 0, 2, 2))
    occupancy.add(rectangle(10, 0, 12, 2))
    first, _ = occupancy.frontier_groups()
    occupancy.add(rectangle(11, 1, 13, 3))
    occupancy.add(rectangle(-30, -30, -29, -29))
    assert first in occupancy.frontier_groups()
    assert len(occupancy.frontier_groups()) == 3


@pytest.mark.parametrize("angle", [0.0, 17.0, 45.0, 88.0])
@pytest.mark.parametrize("size", [(3.0, 2.0), (2.43, 4.71)])
def test_a_closed_room_has_no_frontier(worlds, angle, size):
    room = affinity.rotate(box(0, 0, *size), angle)
    index = worlds.index(room, 8.0)
    places = worlds.viewpoints(room, 3, clearance=0.25)
    for place in places:
        occupancy = Occupancy(0.1, 0.2)
        occupancy.add(*seen_from(index, [place], range_m=8.0))
        assert occupancy.frontier_groups(0.0) == []
        assert np.count_nonzero(occupancy.cells == FREE) * 0.01 > 0.8 * room.area
    # Not so if the range is too short to see all of it.
    occupancy.add(*seen_from(index, [places[0]], range_m=1.0))
    short = Occupancy(0.1, 0.2)
    short.add(*seen_from(index, [places[0]], range_m=1.0))
    assert short.frontier_groups()
    assert occupancy.frontier_groups(0.0) == []


@pytest.mark.parametrize("name", ["rooms", "office", "clutter", "crates"])
@pytest.mark.parametrize("beams", [None, 360])
def test_who_visits_every_target_once_has_seen_all(worlds, name, beams):
    free = worlds.WORLDS[name]()
    index = worlds.index(free)
    occupancy = Occupancy(0.1, 0.2)
    place = worlds.viewpoints(free, 1, clearance=0.3)[0]
    for _ in range(150):
        occupancy.add(*seen_from(index, [place], beams=beams))
        targets = [g.target for g in occupancy.frontier_groups() if g.target]
        if not targets:
            break
        # From a target all that made it one is seen.
        assert occupancy.cell_of(*place) not in targets
        place = occupancy.centre_of(*targets[0])
    assert targets == []
    # No passable place is left that is next to unknown ones, but for slivers.
    assert np.count_nonzero(frontier(occupancy) & occupancy.passable) < 20
    standing = free.buffer(-0.35)
    shapely.prepare(standing)
    places = centres(occupancy)[shapely.contains_xy(standing, centres(occupancy))]
    found = [occupancy.passable[occupancy_index(occupancy, occupancy.cell_of(*p))] for p in places]
    assert np.mean(found) > 0.97


@given(
    st.tuples(st.floats(-9, 9), st.floats(-9, 9)),
    st.tuples(st.floats(-9, 9), st.floats(-9, 9)),
    st.booleans(),
)
def test_the_cells_of_a_wall_hang_together_over_their_sides(a, b, on_lattice):
    cell = 0.5
    if on_lattice:
        a, b = ((np.round(p) - raster_module.OFFSET) * cell for p in (a, b))
    cells = []
    for corners in ((a, b), (b, a)):
        occupancy = Occupancy(cell, 0.5, (-12.0, -12.0, 12.0, 12.0))
        occupancy.add(hand_made([*corners, corners[1]], [OBSTACLE, GAP, GAP]))
        cells.append(occupancy.cells)
    assert np.array_equal(*cells)
    wall = cells[0] == OCCUPIED
    assert ndimage.label(wall)[1] == 1
    for end in (a, b):
        row, column = occupancy.cell_of(*end)
        assert wall[occupancy.indices_of([(row, column)])].all()


def test_occupied_wins_in_either_order_and_is_never_passable():
    free, wall = rectangle(0, 0, 4, 4), hand_made([(1, 2), (3, 2), (2, 2.5)], [OBSTACLE, GAP, GAP])
    for regions in ((free, wall), (wall, free)):
        occupancy = Occupancy(0.1, 0.05)
        for region in regions:
            occupancy.add(region)
        at = occupancy.indices_of([occupancy.cell_of(2.0, 2.0)])
        assert occupancy.cells[at] == OCCUPIED
        assert not occupancy.passable[at].any()
    # A free cell that turns out to be occupied is a change, but not a new cell.
    occupancy = Occupancy(0.1, 0.05)
    occupancy.add(free)
    assert occupancy.add(wall) == 0
    assert occupancy.revision == 2


def test_changes_are_reported_where_they_are(worlds):
    regions = regions_of(worlds, "office", MAX_CHANGES + 30, seed=63)
    occupancy = Occupancy(0.1, 0.2, (-3.0, -3.0, 25.0, 25.0))
    assert occupancy.changed_since(0) is None
    states = {0: (occupancy.cells.copy(), occupancy.passable.copy())}
    tight = 0
    for region in regions:
        occupancy.add(region)
        states[occupancy.revision] = occupancy.cells.copy(), occupancy.passable.copy()
        assert len(states) == occupancy.revision + 1
        for revision in range(0, occupancy.revision, 5):
            window = occupancy.changed_since(revision)
            differ = (states[revision][0] != occupancy.cells) | (
                states[revision][1] != occupancy.passable
            )
            rows, columns = np.nonzero(differ)
            rows, columns = rows + occupancy.row, columns + occupancy.column
            least = (rows.min(), rows.max() + 1, columns.min(), columns.max() + 1)
            assert window[0] <= least[0] <= least[1] <= window[1]
            assert window[2] <= least[2] <= least[3] <= window[3]
            tight += window == least
        assert occupancy.changed_since(occupancy.revision) is None
    assert tight > 200


def test_a_window_of_changes_survives_growing():
    occupancy = Occupancy(0.5, 0.5)
    occupancy.add(rectangle(0, 0, 2, 2))
    window = occupancy.changed_since(0)
    occupancy.add(rectangle(-40, -40, -39, -39))
    assert occupancy.changed_since(0) == (
        occupancy.changed_since(1)[0],
        window[1],
        occupancy.changed_since(1)[2],
        window[3],
    )


def test_the_oldest_changes_are_not_forgotten():
    occupancy = Occupancy(0.5, 0.5)
    occupancy.add(rectangle(-40, -40, -38, -38))
    first = occupancy.changed_since(0)
    for k in range(MAX_CHANGES + 9):
        occupancy.add(rectangle(k, 0, k + 2, 2))
    assert occupancy.revision == MAX_CHANGES + 10
    assert occupancy.changed_since(0)[::2] == first[::2]
    assert occupancy.changed_since(occupancy.revision - MAX_CHANGES)[0] > first[1]


def test_blocked_discs_are_restored_exactly(worlds):
    occupancy = Occupancy(0.1, 0.2)
    for region in regions_of(worlds, "office", 12):
        occupancy.add(region)
    before, groups = occupancy.passable.copy(), knowledge(occupancy)[3]
    points = centres(occupancy)
    outer = np.array([[5.0, 5.0, 1.0], [5.5, 5.0, 1.0], [-90.0, 0.0, 3.0], [0.0, 0.0, 0.0]])
    inner = np.array([[5.2, 5.4, 1.2], [14.0, 3.0, 25.0]])

    def without(discs):
        away = np.hypot(*(points[:, None] - discs[:, :2]).T) > discs[:, 2:]
        return before & away.all(axis=0).reshape(before.shape)

    revision = occupancy.revision
    with occupancy.blocked(outer):
        assert np.array_equal(occupancy.passable, without(outer))
        with occupancy.blocked(inner):
            assert np.array_equal(occupancy.passable, without(np.vstack([outer, inner])))
        assert np.array_equal(occupancy.passable, without(outer))
        assert knowledge(occupancy)[3] == groups
        with pytest.raises(InvalidInputError, match="while discs are blocked"):
            occupancy.add(rectangle(0, 0, 1, 1))
    assert np.array_equal(occupancy.passable, before)
    with occupancy.blocked(np.empty((0, 3))):
        assert np.array_equal(occupancy.passable, before)
    with pytest.raises(ZeroDivisionError), occupancy.blocked(outer):
        raise ZeroDivisionError
    assert np.array_equal(occupancy.passable, before)
    assert occupancy.revision == revision
    assert occupancy.add(rectangle(-5, -5, -4, -4)) > 0


def test_targets_are_found_afresh_while_discs_are_blocked():
    occupancy, other = Occupancy(0.1, 0.2), Occupancy(0.1, 0.2)
    for each in (occupancy, other):
        each.add(rectangle(0, 0, 3, 3))
    with occupancy.blocked([(1.5, 1.5, 9.0)]):
        assert not occupancy.passable.any()
        assert occupancy.frontier_groups()[0].target is not None
    assert knowledge(occupancy) == knowledge(other)


def test_small_groups_are_dropped_and_openings_have_their_width():
    def openings(angle):
        # A room with an opening of 1 m in the middle of one side, turned.
        corners = np.array([(0, 0), (4, 0), (4, 3), (2.5, 3), (1.5, 3), (0, 3)], float)
        turn = np.radians(angle)
        turned = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        tags = [OBSTACLE] * 3 + [GAP] + [OBSTACLE] * 2
        occupancy = Occupancy(0.05, 0.2)
        occupancy.add(hand_made(turned, tags))
        return occupancy

    for angle in (0.0, 30.0, 45.0, 71.0):
        occupancy = openings(angle)
        (group,) = occupancy.frontier_groups()
        assert group.size_m == pytest.approx(1.0, abs=0.16)
        x, y = occupancy.centre_of(*group.target)
        turn = np.radians(angle)
        middle = np.array(
            [2 * np.cos(turn) - 3 * np.sin(turn), 2 * np.sin(turn) + 3 * np.cos(turn)]
        )
        assert np.hypot(*(middle - (x, y))) < 0.15
        assert occupancy.frontier_groups(1.2) == []
        assert not group.cells.flags.writeable
    # Too narrow to pass: kept if that is asked for, but there is no place to stand.
    narrow = Occupancy(0.05, 0.6)
    narrow.add(
        hand_made(
            [(0, 0), (4, 0), (4, 3), (2.5, 3), (1.5, 3), (0, 3)], [OBSTACLE] * 3 + [GAP] + [0, 0]
        )
    )
    assert narrow.frontier_groups() == []
    (group,) = narrow.frontier_groups(0.0)
    assert group.target is None


def test_a_group_exactly_as_wide_as_the_body_is_kept():
    # Cells (3, 5) to (3, 8): four of 0.1 m for a body of 0.4 m.
    shift = raster_module.OFFSET * 0.1
    for count in (3, 4):
        occupancy = Occupancy(0.1, 0.2)
        occupancy.add(rectangle(0.5 - shift, 0.3 - shift, 0.5 + 0.1 * count - shift, 0.4 - shift))
        cells = [g.cells.tolist() for g in occupancy.frontier_groups()]
        assert cells == ([[[3, 5], [3, 6], [3, 7], [3, 8]]] if count == 4 else [])
    # Its centroid lies between (3, 6) and (3, 7): the first counts.
    assert occupancy.frontier_groups()[0].target == (3, 6)


def test_cells_and_centres():
    occupancy = Occupancy(0.3, 0.2)
    for x, y in ((0.0, 0.0), (-3.71, 8.2), (5e5, 4.5e6)):
        cell = occupancy.cell_of(x, y)
        centre = occupancy.centre_of(*cell)
        assert np.abs(np.subtract(centre, (x, y))).max() <= 0.15 + 1e-9
        assert occupancy.centres_of([cell]).tolist() == [list(centre)]
    occupancy.add(rectangle(-3, 2, -1, 7))
    row, column = occupancy.cell_of(-2.0, 5.0)
    at = occupancy.indices_of([(row, column)])
    assert occupancy.cells[at] == FREE
    assert occupancy.x0 + (at[1][0] + 0.5) * 0.3 == pytest.approx(
        occupancy.centre_of(row, column)[0]
    )
    assert occupancy.y0 + (at[0][0] + 0.5) * 0.3 == pytest.approx(
        occupancy.centre_of(row, column)[1]
    )
    with pytest.raises(InvalidInputError, match=r"cell \(500, 0\) is not in the window"):
        occupancy.indices_of([(row, column), (500, 0)])


def test_free_cells_are_those_of_a_raster_of_the_same_cells(worlds):
    occupancy, raster = Occupancy(0.1, 0.2), raster_module.Raster(0.1)
    for region in regions_of(worlds, "crates", 12):
        occupancy.add(region)
        raster.paint(region.boundary)
    painted = in_lattice(raster, np.argwhere(raster.cells))
    assert (occupancy.cells[occupancy.indices_of(painted)] != UNKNOWN).all()
    free = in_lattice(occupancy, np.argwhere(occupancy.cells == FREE))
    assert {*map(tuple, free.tolist())} <= {*map(tuple, painted.tolist())}


def test_refuses_what_cannot_be():
    for cell in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InvalidInputError, match="positive width"):
            Occupancy(cell, 1.0)
    for radius in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InvalidInputError, match="positive radius"):
            Occupancy(0.1, radius)
    with pytest.raises(InvalidInputError, match=r"choose at most 0\.4 m"):
        Occupancy(0.41, 0.2)
    assert Occupancy(0.4, 0.2).cell_m == 0.4
    occupancy = Occupancy(0.1, 0.2)
    with pytest.raises(InvalidInputError, match="finite"), occupancy.blocked([(0.0, np.nan, 1.0)]):
        pass


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e19, -1e300])
@pytest.mark.parametrize("corner", range(4))
@pytest.mark.parametrize("axis", range(2))
def test_refuses_regions_that_are_not_finite(bad, corner, axis):
    corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    occupancy = Occupancy(0.1, 0.25)
    occupancy.add(hand_made(corners, [OBSTACLE] * 4))
    before = knowledge(occupancy)
    corners[corner][axis] = bad
    with pytest.raises(InvalidInputError, match="finite numbers of metres"):
        occupancy.add(hand_made(corners, [OBSTACLE] * 4))
    assert knowledge(occupancy) == before


def test_refuses_to_grow_without_end():
    occupancy = Occupancy(0.01, 0.2)
    occupancy.add(rectangle(0, 0, 1, 1))
    before = knowledge(occupancy)
    with pytest.raises(InvalidInputError, match=r"choose cells wider than 0\.01 m"):
        occupancy.add(rectangle(900, 900, 901, 901))
    assert knowledge(occupancy) == before


def hall_seen(worlds, cell_m=0.1):
    occupancy = Occupancy(cell_m, 0.25)
    for region in regions_of(worlds, "office", 5, clearance=0.3, seed=8):
        occupancy.add(region)
    return occupancy


def places_around(occupancy, count, seed):
    rng = np.random.default_rng(seed)
    rows, columns = occupancy.cells.shape
    low = np.array([occupancy.x0, occupancy.y0])
    size = np.array([columns, rows]) * occupancy.cell_m
    return (low - 1.0 + rng.random((count, 2)) * (size + 2.0)).tolist()


def test_cells_of_names_places_as_cell_of_does(worlds):
    occupancy = hall_seen(worlds)
    places = places_around(occupancy, 200, seed=1)
    assert [*map(tuple, occupancy.cells_of(places).tolist())] == [
        occupancy.cell_of(x, y) for x, y in places
    ]
    assert occupancy.cells_of(np.empty((0, 2))).shape == (0, 2)
    centred = occupancy.centres_of(occupancy.cells_of(places))
    assert np.abs(centred - places).max() <= 0.05 + 1e-9


def test_a_window_of_the_lattice_is_the_same_cells_after_growth():
    occupancy = Occupancy(0.1, 0.2)
    occupancy.add(rectangle(0, 0, 1, 2))
    window = occupancy.changed_since(0)
    r0, r1, c0, c1 = occupancy.window_of(window)
    before = occupancy.cells[r0:r1, c0:c1].copy()
    assert (before == FREE).any()
    occupancy.add(rectangle(-6, -5, -5, -4))
    assert occupancy.window_of(window) != (r0, r1, c0, c1)
    r0, r1, c0, c1 = occupancy.window_of(window)
    assert (occupancy.cells[r0:r1, c0:c1] == before).all()


def test_known_are_cells_that_are_not_unknown(worlds):
    occupancy = hall_seen(worlds)
    cells = np.argwhere(np.ones(occupancy.cells.shape, bool))
    for (row, column), (x, y) in [*zip(cells.tolist(), centres(occupancy).tolist(), strict=True)][
        ::7
    ]:
        assert occupancy.is_known(x, y) == (occupancy.cells[row, column] != UNKNOWN)
    assert not occupancy.is_known(1e3, 0.0)
    assert not occupancy.is_known(0.0, -1e3)
    assert not Occupancy(0.1, 0.2).is_known(0.0, 0.0)


@pytest.mark.parametrize("within", [0, 1, 3, 8])
def test_the_passable_cell_near_by_is_the_nearest(worlds, within):
    occupancy = hall_seen(worlds)
    passable = in_lattice(occupancy, np.argwhere(occupancy.passable))
    found_any = found_none = 0
    for x, y in places_around(occupancy, 150, seed=2 + within):
        near = passable[np.abs(passable - occupancy.cell_of(x, y)).max(axis=1) <= within]
        found = occupancy.passable_near(x, y, within)
        if not len(near):
            assert found is None
            found_none += 1
            continue
        found_any += 1
        assert found in map(tuple, near.tolist())
        gaps = np.hypot(*(occupancy.centres_of(near) - (x, y)).T)
        gap = np.hypot(*(np.array(occupancy.centre_of(*found)) - (x, y)))
        assert gap == pytest.approx(gaps.min())
    assert found_any
    assert found_none


def test_of_equally_near_cells_the_first_row_by_row_is_taken():
    occupancy = Occupancy(0.1, 0.15)
    occupancy.add(rectangle(0, 0, 2, 2))
    x, y = occupancy.centre_of(*occupancy.cell_of(1.0, 1.0))
    row, column = occupancy.cell_of(x, y)
    with occupancy.blocked([(x, y, 0.01)]):
        assert occupancy.passable_near(x, y, 0) is None
        assert occupancy.passable_near(x, y, 2) == (row - 1, column)
    assert occupancy.passable_near(x, y, 2) == (row, column)


def test_passable_centres_are_those_in_the_square(worlds):
    occupancy = hall_seen(worlds)
    passable = in_lattice(occupancy, np.argwhere(occupancy.passable))
    some = 0
    for (x, y), half in zip(
        places_around(occupancy, 40, seed=9), [0.0, 0.5, 2.0, 50.0] * 10, strict=True
    ):
        reach = round(half / occupancy.cell_m)
        around = passable[np.abs(passable - occupancy.cell_of(x, y)).max(axis=1) <= reach]
        given = occupancy.passable_centres(x, y, half)
        assert given.tolist() == occupancy.centres_of(around).tolist()
        some += 0 < len(given) < len(passable)
    assert some >= 3
    assert len(occupancy.passable_centres(1e3, 1e3, 1.0)) == 0


@pytest.mark.parametrize("radius", [0.04, 0.25, 1.0])
def test_a_frontier_near_by_is_one_of_a_cells_centre(worlds, radius):
    occupancy = hall_seen(worlds)
    open_at = occupancy.centres_of(in_lattice(occupancy, np.argwhere(frontier(occupancy))))
    answers = []
    for x, y in [*places_around(occupancy, 150, seed=3), *(open_at[::9] + 0.02).tolist()]:
        gap = np.hypot(*(open_at - (x, y)).T).min()
        if abs(gap - radius) > 1e-9:
            answers.append(occupancy.has_frontier_near(x, y, radius))
            assert answers[-1] == (gap < radius)
    assert {*answers} == {True, False}


def test_the_diagonal_is_that_of_the_window():
    occupancy = Occupancy(0.1, 0.2)
    assert occupancy.diagonal_m == 0.0
    occupancy.add(rectangle(0, 0, 3, 4))
    rows, columns = occupancy.cells.shape
    assert occupancy.diagonal_m == pytest.approx(0.1 * (rows**2 + columns**2) ** 0.5)
    assert occupancy.diagonal_m >= 5.0
