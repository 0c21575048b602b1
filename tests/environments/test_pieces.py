"""Separate areas of small worlds, drawn by hand."""

import shapely

from multisrt.environments.environment import Environment
from multisrt.environments.pieces import enclosing, is_minor, pieces

PAPER = shapely.box(0, 0, 20, 10)
BUILDING = shapely.box(1, 1, 19, 9)
ROOMS = shapely.union_all([shapely.box(2, 2, 9, 8), shapely.box(10, 2, 18, 8)])


def plan() -> Environment:
    """White paper around a building of two rooms."""
    return Environment.from_outline("plan", PAPER, [BUILDING - ROOMS])


def test_pieces_are_sorted_by_area():
    assert [piece.area for piece in pieces(plan())] == [56.0, 48.0, 42.0]
    assert pieces(plan())[2].bounds == (2.0, 2.0, 9.0, 8.0)


def test_pieces_are_those_of_component():
    world = plan()
    assert pieces(world)[1] is world.component(12.0, 5.0)


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


def test_all_but_the_largest_area_inside_is_minor():
    places = {"paper": (0.5, 0.5), "large room": (12.0, 5.0), "small room": (3.0, 5.0)}
    found = {name: is_minor(plan(), *place) for name, place in places.items()}
    assert found == {"paper": True, "large room": False, "small room": True}
