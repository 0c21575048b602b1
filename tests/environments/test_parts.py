"""Separate areas of small worlds, drawn by hand."""

import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.environments.parts import enclosing, inside, is_poor_start, parts_of, surrounding

PAPER = shapely.box(0, 0, 20, 10)
BUILDING = shapely.box(1, 1, 19, 9)
ROOMS = shapely.union_all([shapely.box(2, 2, 9, 8), shapely.box(10, 2, 18, 8)])


def plan() -> Environment:
    """White paper around a building of two rooms."""
    return Environment.from_outline("plan", PAPER, [BUILDING - ROOMS])


def test_pieces_are_sorted_by_area():
    assert [part.area for part in parts_of(plan())] == [56.0, 48.0, 42.0]
    assert parts_of(plan())[2].bounds == (2.0, 2.0, 9.0, 8.0)


def test_pieces_are_those_of_component():
    world = plan()
    assert parts_of(world)[1] is world.component(12.0, 5.0)


def test_the_paper_around_a_building_is_found():
    world = plan()
    found = enclosing(world)
    assert found is not None
    assert found.area is world.component(0.5, 0.5)
    assert [area.area for area in found.inside] == [48.0, 42.0]


def test_rooms_side_by_side_enclose_nothing():
    assert enclosing(Environment("rooms", ROOMS)) is None


def test_a_hall_around_a_pillar_encloses_nothing():
    assert enclosing(Environment.from_outline("hall", PAPER, [BUILDING])) is None


def test_a_hall_around_a_closed_closet_is_no_paper():
    closet = shapely.box(5, 4, 8, 7) - shapely.box(5.5, 4.5, 7.5, 6.5)
    assert enclosing(Environment.from_outline("hall", PAPER, [closet])) is None


def test_a_courtyard_that_touches_no_border_is_no_paper():
    # A ring of free space inside a building, around another building, with a room beside it.
    ring = shapely.box(2, 2, 12, 8) - shapely.box(3, 3, 11, 7)
    inner, beside = shapely.box(4, 4, 10, 6), shapely.box(0, 0, 20, 1)
    above = shapely.box(0, 9, 20, 10)
    sides = shapely.union_all([shapely.box(0, 2, 1, 8), shapely.box(19, 2, 20, 8)])
    world = Environment("court", shapely.union_all([ring, inner, beside, above, sides]))
    assert enclosing(world) is None


def flat_on(page: BaseGeometry) -> Environment:
    """A flat of 13 x 12 m with walls of 0.3 m, of two rooms, on a page."""
    flat = shapely.box(2, 2, 15, 14)
    rooms = [shapely.box(2.3, 2.3, 10, 13.7), shapely.box(10.2, 2.3, 14.7, 13.7)]
    return Environment.from_outline("flat", page, [flat - shapely.union_all(rooms)])


def test_a_small_flat_on_a_large_page_is_surrounded_but_not_chosen():
    world = flat_on(shapely.box(0, 0, 36, 30))
    assert enclosing(world) is None
    found = surrounding(world)
    assert found is not None
    assert found.area is world.component(0.5, 0.5)
    assert [round(room.area, 2) for room in found.inside] == [87.78, 51.3]
    assert inside(world) == parts_of(world)


def test_a_page_that_is_cut_along_most_of_its_border_surrounds():
    page = shapely.box(0, 0, 36, 30) - shapely.box(30, 29, 35, 30)
    assert surrounding(flat_on(page)) is not None
    page = shapely.box(0, 0, 36, 30) - shapely.box(5, 29, 35, 30)
    assert surrounding(flat_on(page)) is None


def test_what_no_robot_fits_into_is_not_surrounded():
    # The inside of a hollow wall, of more than 4 m2, and a closet of 4 m2.
    strip = shapely.box(2, 2, 20, 2.3)
    wall = strip.buffer(0.05, join_style="mitre") - strip
    closet = shapely.box(5, 5, 7.2, 7.2) - shapely.box(5.1, 5.1, 7.1, 7.1)
    world = Environment.from_outline("hall", shapely.box(0, 0, 30, 30), [wall, closet])
    assert surrounding(world) is None
    larger = shapely.box(15, 5, 17.2, 7.2) - shapely.box(15.1, 5.1, 17.1, 7.1)
    world = Environment.from_outline("hall", shapely.box(0, 0, 30, 30), [closet, larger])
    found = surrounding(world)
    assert found is not None
    assert len(found.inside) == 2


def test_inside_is_all_but_the_paper():
    assert [part.area for part in inside(plan())] == [48.0, 42.0]
    rooms = Environment("rooms", ROOMS)
    assert inside(rooms) == parts_of(rooms)


def test_all_but_the_largest_area_inside_is_poor_start():
    places = {"paper": (0.5, 0.5), "large room": (12.0, 5.0), "small room": (3.0, 5.0)}
    found = {name: is_poor_start(plan(), *place) for name, place in places.items()}
    assert found == {"paper": True, "large room": False, "small room": True}


def test_the_page_around_a_small_flat_is_a_poor_start():
    world = flat_on(shapely.box(0, 0, 36, 30))
    places = {"page": (20.0, 20.0), "large room": (5.0, 5.0), "small room": (12.0, 5.0)}
    found = {name: is_poor_start(world, *place) for name, place in places.items()}
    assert found == {"page": True, "large room": True, "small room": True}
