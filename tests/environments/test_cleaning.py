import json
import math
from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis.extra.numpy import arrays
from shapely import Polygon, box

from multisrt.environments.cleaning import (
    ZERO_M,
    Cleaning,
    CleaningOptions,
    cleaned,
    closed_ring,
    flushed,
    repaired,
    united,
    without_denormals,
)
from multisrt.environments.environment import Environment
from multisrt.environments.fixing import fixed
from multisrt.environments.formats import read_environment
from multisrt.environments.formats.files import grid_polygons, straightened
from multisrt.geometry.errors import InvalidInputError, MapFormatError

HALL = box(0, 0, 10, 6)
BOW = [(0, 0), (4, 4), (4, 0), (0, 4)]


def geojson(path, *polygons, kind="free"):
    features = [
        {
            "type": "Feature",
            "properties": {"kind": kind},
            "geometry": {"type": "Polygon", "coordinates": [[list(p) for p in polygon]]},
        }
        for polygon in polygons
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def test_nothing_changed_is_false_and_silent():
    assert not Cleaning()
    assert str(Cleaning()) == ""
    assert Environment("hall", HALL).cleaning == Cleaning()


def test_notes_come_first_and_are_joined():
    both = Cleaning(notes=("a note",), closed_rings=1) + Cleaning(notes=("another",))
    assert str(both) == "a note; another; 1 open ring closed"


def test_cleanings_add_up():
    one = Cleaning(closed_rings=1, dropped_m2=0.5)
    two = Cleaning(closed_rings=2, displacement_m=0.25)
    assert one + two == Cleaning(closed_rings=3, dropped_m2=0.5, displacement_m=0.25)
    assert one + Cleaning() == one


def test_an_environment_counts_the_slivers_it_drops():
    slivers = [box(2, 1, 2.0005, 3), box(5, 5, 5.2, 5.0008)]
    apart = shapely.union_all([HALL - shapely.union_all(slivers), box(20, 0, 20.0001, 5)])
    world = Environment("slivers", apart)
    assert world.cleaning.dropped_obstacles == 2
    assert world.cleaning.dropped_parts == 1
    lost = sum(sliver.area for sliver in slivers) + 0.0005
    assert world.cleaning.dropped_m2 == pytest.approx(lost)
    assert world.digest == Environment("slivers", HALL).digest


def test_the_cleaning_is_not_part_of_the_digest():
    told = Environment("hall", HALL, cleaning=Cleaning(closed_rings=3))
    assert told.cleaning.closed_rings == 3
    assert told == Environment("hall", HALL)


def test_an_open_ring_is_closed_once():
    ring, cleaning = closed_ring(BOW)
    assert ring == [*BOW, BOW[0]]
    assert cleaning.closed_rings == 1
    assert closed_ring(ring) == (ring, Cleaning())


def test_a_bow_tie_becomes_two_triangles():
    tie, cleaning = repaired(Polygon(BOW))
    assert tie.area == 8.0
    assert len(shapely.get_parts(tie)) == 2
    assert cleaning == Cleaning(repaired_polygons=1)


def test_a_loop_is_filled_and_its_area_told():
    # A ring that runs twice around the square from (2, 2) to (4, 4).
    loop = [(0, 0), (4, 0), (4, 4), (2, 4), (2, 2), (4.5, 2), (4.5, 5), (0, 5)]
    filled, cleaning = repaired(Polygon(loop))
    drawn = shapely.make_valid(Polygon(loop), method="linework")
    drawn = shapely.union_all([part for part in shapely.get_parts(drawn) if part.area])
    assert filled.is_valid
    assert cleaning.repaired_m2 == pytest.approx(filled.symmetric_difference(drawn).area)
    assert cleaning.repaired_m2 > 0


@pytest.mark.parametrize(
    ("hole", "changed"),
    [
        ([(8, 2), (10, 2), (10, 4), (8, 4)], 0.0),  # reaches the outer edge
        ([(8, 2), (11, 2), (11, 4), (8, 4)], 2.0),  # and beyond
        ([(0, 0), (10, 0), (10, 1), (0, 1)], 0.0),
    ],
)
def test_a_hole_at_the_edge_changes_no_area(hole, changed):
    polygon = Polygon(HALL.exterior, [hole])
    assert not polygon.is_valid
    free, cleaning = repaired(polygon)
    assert free.area == HALL.area - HALL.intersection(Polygon(hole)).area
    assert cleaning.repaired_m2 == pytest.approx(changed)


def test_a_valid_polygon_is_not_touched():
    assert repaired(HALL) == (HALL, Cleaning())


@given(arrays(float, (5, 2), elements=st.floats(-1e7, 1e7)))
def test_only_the_smallest_coordinates_become_zero(points):
    clear = flushed(points)
    changed = clear != points
    assert (clear[changed] == 0.0).all()
    assert (np.abs(points[changed]) < ZERO_M).all()
    assert ((clear == 0.0) | (np.abs(clear) >= ZERO_M)).all()


def test_denormal_coordinates_of_worlds_are_zero():
    room = Polygon([(5e-324, 0), (4, -1e-310), (4, 3), (0, 3)])
    assert without_denormals(HALL) is HALL
    expected = Environment("room", Polygon([(0, 0), (4, 0), (4, 3), (0, 3)]))
    assert Environment("room", room).digest == expected.digest
    assert repaired(room) == (without_denormals(room), Cleaning())


def test_overlaps_are_united_and_contacts_are_not_counted():
    rooms = [box(0, 0, 3, 2), box(2, 0, 5, 2), box(5, 0, 6, 2), box(9, 9, 10, 10)]
    space, cleaning = united(rooms)
    assert space.area == 13.0
    assert cleaning == Cleaning(united_polygons=2, united_m2=2.0)


@given(st.lists(st.tuples(*[st.integers(0, 9)] * 2, *[st.integers(1, 5)] * 2), min_size=1))
@settings(max_examples=60, deadline=None)
def test_overlap_is_the_sum_of_areas_minus_the_union(sides):
    boxes = [box(x, y, x + w, y + h) for x, y, w, h in sides]
    space, cleaning = united(boxes)
    assert cleaning.united_m2 == pytest.approx(sum(b.area for b in boxes) - space.area)
    overlapping = [
        any(k != j and boxes[k].intersection(boxes[j]).area > 0 for j in range(len(boxes)))
        for k in range(len(boxes))
    ]
    assert cleaning.united_polygons == sum(overlapping)


def test_narrow_gaps_are_closed_and_wide_ones_stay():
    walls = [box(3, 0, 3.5, 2), box(3, 2.2, 3.5, 6), box(6, 0, 6.5, 3), box(6, 3.5, 6.5, 6)]
    free = HALL - shapely.union_all(walls)
    space, cleaning = cleaned(free, CleaningOptions(gap_m=0.4))
    assert len(space.geoms) == 2
    assert cleaning.closed_gaps == 1
    # The door, but for the segments of discs of 0.2 m that rest on its corners, 0.2 m apart.
    segment = 0.2**2 / 2 * (math.pi / 3 - math.sin(math.pi / 3))
    assert cleaning.closed_m2 == pytest.approx(0.5 * 0.2 - 2 * segment, abs=1e-4)
    assert cleaning.closed_m2 == pytest.approx(free.area - space.area)
    assert cleaned(free, CleaningOptions(gap_m=0.2))[1].closed_gaps == 0
    assert cleaned(free, CleaningOptions(gap_m=0.6))[1].closed_gaps == 2


@pytest.mark.parametrize("wall_m", [0.02, 0.1, 0.2, 1.0])
@pytest.mark.parametrize("gap_m", [0.41, 0.5, 1.5])
def test_doors_are_closed_whatever_the_thickness_of_their_wall(wall_m, gap_m):
    wall = box(4, 0, 4 + wall_m, 1.8) | box(4, 2.2, 4 + wall_m, 4)
    space, cleaning = cleaned(box(0, 0, 9, 4) - wall, CleaningOptions(gap_m=gap_m))
    assert len(space.geoms) == 2
    assert cleaning.closed_gaps == 1
    assert 0.0 < cleaning.closed_m2 < 0.4 * wall_m + 0.1
    assert space.buffer(1e-5).contains(box(0, 0, 9, 4) - box(3.6, 1.7, 4.4 + wall_m, 2.3) - wall)


def test_corners_and_dead_ends_are_no_gaps():
    dead_end = HALL | box(10, 2, 12, 2.2)
    space, cleaning = cleaned(dead_end, CleaningOptions(gap_m=0.4))
    assert cleaning.closed_gaps == 0
    assert space.area == pytest.approx(dead_end.area)


def test_specks_are_dropped_by_their_extent():
    holes = [box(1, 1, 1.04, 1.03), box(3, 1, 3.3, 1.02)]
    free = shapely.union_all([HALL - shapely.union_all(holes), box(20, 0, 20.04, 0.04)])
    space, cleaning = cleaned(free, CleaningOptions(speck_m=0.05))
    assert (cleaning.dropped_parts, cleaning.dropped_obstacles) == (1, 1)
    assert cleaning.dropped_m2 == pytest.approx(0.04 * 0.03 + 0.04**2)
    assert len(space.geoms[0].interiors) == 1


@pytest.mark.parametrize("cells", [1, 2, 3, 6, 7])
@pytest.mark.parametrize("cell_m", [0.05, 0.1, 0.3])
def test_specks_of_exactly_the_size_are_dropped(cells, cell_m):
    # Sides of cells are differences of multiples, some of which are a little too large.
    specks = [
        box(k * cell_m, 1.0, (k + cells) * cell_m, 1.0 + cell_m) for k in range(1, 60, 2 * cells)
    ]
    hall = box(0, 0, 200 * cell_m, 6) - shapely.union_all(specks)
    kept, _ = cleaned(hall, CleaningOptions(speck_m=cells * cell_m))
    assert len(kept.geoms[0].interiors) == 0
    larger, _ = cleaned(hall, CleaningOptions(speck_m=cells * cell_m - 1e-3))
    assert len(larger.geoms[0].interiors) == len(specks)


def test_vertices_on_straight_lines_go_and_corners_stay():
    ring = [(0, 0), (2, 0), (5, 0), (5, 5), (5, 5), (0, 5), (0, 2.5)]
    space, cleaning = cleaned(Polygon(ring), CleaningOptions())
    assert space.equals(box(0, 0, 5, 5))
    assert shapely.get_num_coordinates(space) == 5
    assert cleaning == Cleaning(removed_vertices=3)


@given(st.integers(0, 10_000), st.sampled_from([0.01, 0.1, 0.5]))
@settings(max_examples=40, deadline=None)
def test_walls_move_by_at_most_the_tolerance(seed, tolerance):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 60))
    radius = 5 + rng.normal(0, 0.2, 60)
    free = Polygon(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]))
    if not free.is_valid:
        return
    space, cleaning = cleaned(free, CleaningOptions(tolerance_m=tolerance))
    assert space.is_valid
    moved = shapely.hausdorff_distance(free.boundary, space.boundary, densify=0.02)
    assert moved <= cleaning.displacement_m + 2e-3
    assert cleaning.displacement_m <= tolerance + 2e-6
    removed = shapely.get_num_coordinates(free) - shapely.get_num_coordinates(space)
    assert cleaning.removed_vertices == removed


@pytest.mark.parametrize("name", ["speck_m", "gap_m", "tolerance_m"])
@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
def test_lengths_of_options_are_finite_and_positive(name, value):
    with pytest.raises(InvalidInputError, match=name):
        CleaningOptions(**{name: value})


def test_a_start_in_a_closed_gap_is_left_out():
    walls = [box(3, 0, 3.5, 2), box(3, 2.2, 3.5, 6)]
    world = Environment("gap", HALL - shapely.union_all(walls), starts=[(3.2, 2.1), (1, 1)])
    copy = fixed(world, CleaningOptions(gap_m=0.4))
    assert copy.starts == ((1.0, 1.0),)
    assert copy.cleaning.removed_starts == 1
    assert "1 suggested start removed" in str(copy.cleaning)


def test_vector_files_are_refused_with_the_remedy_and_repaired(tmp_path):
    closed = " ".join(f"{x} {y}," for x, y in BOW) + " 0 0"
    wkt = tmp_path / "bow.wkt"
    wkt.write_text(f"POLYGON (({closed}))")
    imr = tmp_path / "bow.txt"
    imr.write_text("[BORDER]\n" + "\n".join(f"{x} {y}" for x, y in BOW))
    crossing = geojson(tmp_path / "bow.geojson", [*BOW, BOW[0]])
    for path in (wkt, imr, crossing):
        with pytest.raises(MapFormatError, match="multisrt environments check FILE --fix"):
            read_environment(path)
        world = read_environment(path, repair=True)
        assert world.area_m2 == 8.0
        assert world.cleaning == Cleaning(repaired_polygons=1)


def test_open_rings_are_closed_when_asked(tmp_path):
    wkt = tmp_path / "open.wkt"
    wkt.write_text("MULTIPOLYGON (((0 0, 4 0, 4 3), (2 1, 3 1, 3 1.5, 2 1)), ((9 9, 10 9, 10 10)))")
    ring = [(0, 0), (4, 0), (4, 3)]
    for path, count, area in ((wkt, 2, 6.25), (geojson(tmp_path / "open.json", ring), 1, 6.0)):
        with pytest.raises(MapFormatError, match="multisrt environments check FILE --fix"):
            read_environment(path)
        world = read_environment(path, repair=True)
        assert world.cleaning == Cleaning(closed_rings=count)
        assert world.area_m2 == area


def test_overlapping_rooms_of_a_file_are_told(tmp_path):
    rooms = [[(x, 0), (x + 3, 0), (x + 3, 2), (x, 2), (x, 0)] for x in (0, 2)]
    world = read_environment(geojson(tmp_path / "rooms.geojson", *rooms))
    assert world.cleaning == Cleaning(united_polygons=2, united_m2=2.0)
    assert str(world.cleaning) == "2 overlapping polygons united (2 m2)"


def test_grids_tell_how_far_walls_may_move(tmp_path):
    path = tmp_path / "grid.map"
    path.write_text("type octile\nheight 3\nwidth 3\nmap\n@@.\n@..\n...\n")
    world = read_environment(path, resolution_m=0.5)
    assert world.cleaning.straightened_m == pytest.approx(0.5 * math.hypot(0.5, 0.45))
    assert str(world.cleaning) == "walls straightened within 0.336 m"
    # A format without rings has nothing to repair.
    assert read_environment(path, resolution_m=0.5, repair=True) == world


@pytest.mark.parametrize("rows", ["...|...", ".@.|.@.", "...|.@.|..."])
def test_grids_without_slanted_walls_are_not_straightened(tmp_path, rows):
    path = tmp_path / "grid.map"
    lines = rows.split("|")
    path.write_text("\n".join(["type octile", f"height {len(lines)}", "width 3", "map", *lines]))
    world = read_environment(path, resolution_m=0.3)
    assert not world.cleaning
    assert world.area_m2 == pytest.approx(0.09 * rows.count("."))
    turned = shapely.affinity.rotate(world.free, 30)
    assert straightened(turned, 0.3).straightened_m > 0


@settings(max_examples=200, deadline=None)
@given(free=arrays(bool, (6, 7)))
def test_walls_are_told_as_straightened_iff_they_moved(free):
    if not free.any():
        return
    cells = [shapely.box(x, y, x + 1, y + 1) for y, x in zip(*np.nonzero(free[::-1]), strict=True)]
    polygons = grid_polygons(Path("map.png"), free, 1.0)
    stayed = polygons.symmetric_difference(shapely.union_all(cells)).area == 0.0
    assert bool(straightened(polygons, 1.0)) is not stayed
