"""The model of a world: what it refuses, what it repairs, what it answers."""

import hashlib
import math
import struct

import numpy as np
import pytest
import shapely
from shapely import LineString, MultiPolygon, Polygon, box

from multisrt.environments.environment import Environment
from multisrt.geometry.errors import ClearanceError, InvalidInputError

HALL = box(0.0, 0.0, 10.0, 10.0)


def _with_odd_numbers(corners: list[tuple[float, float]]) -> Polygon:
    with np.errstate(invalid="ignore"):
        return Polygon(corners)


def test_free_space_of_a_hall_with_a_block() -> None:
    hall = Environment.from_outline("hall", HALL, [box(4, 4, 6, 6)], starts=[(1, 2)], origin="me")
    assert hall.name == "hall"
    assert hall.origin == "me"
    assert hall.starts == ((1.0, 2.0),)
    assert hall.area_m2 == 96.0
    assert hall.bounds == (0.0, 0.0, 10.0, 10.0)
    assert hall.edges.shape == (8, 4)


def test_free_space_is_on_the_left_of_every_edge() -> None:
    hall = Environment.from_outline("hall", HALL, [box(4, 4, 6, 6), box(8, 0, 10, 3)])
    for x0, y0, x1, y1 in hall.edges:
        length = math.hypot(x1 - x0, y1 - y0)
        left = np.array([-(y1 - y0), x1 - x0]) / length * 1e-6
        middle = np.array([x0 + x1, y0 + y1]) / 2
        assert hall.contains(*(middle + left))
        assert not hall.contains(*(middle - left))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 2e7])
def test_invalid_coordinates_are_reported_with_their_place(bad: float) -> None:
    outline = _with_odd_numbers([(0, 0), (5, 0), (5, bad), (0, 5)])
    with pytest.raises(InvalidInputError, match=r"'odd': vertex 2 is \(5, "):
        Environment("odd", outline)


def test_an_obstacle_that_is_not_finite_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="vertex 1"):
        Environment.from_outline("odd", HALL, [_with_odd_numbers([(1, 1), (math.nan, 1), (2, 2)])])


def test_a_self_crossing_outline_is_refused_with_the_place() -> None:
    bow_tie = Polygon([(0, 0), (4, 4), (4, 0), (0, 4)])
    with pytest.raises(InvalidInputError, match=r"'bow'.*Self-intersection\[2 2\]"):
        Environment("bow", bow_tie)
    with pytest.raises(InvalidInputError, match=r"Self-intersection"):
        Environment.from_outline("bow", HALL, [bow_tie])


@pytest.mark.parametrize("empty", [Polygon(), MultiPolygon(), box(0, 0, 10, 1e-4)])
def test_a_world_without_free_space_is_refused(empty: Polygon) -> None:
    with pytest.raises(InvalidInputError, match="free space is empty"):
        Environment("none", empty)


def test_an_obstacle_over_everything_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="free space is empty"):
        Environment.from_outline("none", HALL, [box(-1, -1, 11, 11)])


def test_lines_are_no_free_space() -> None:
    with pytest.raises(InvalidInputError, match="not LineString"):
        Environment("line", LineString([(0, 0), (1, 1)]))


@pytest.mark.parametrize("start", [(5.0, 5.0), (11.0, 1.0), (0.0, 5.0)])
def test_a_start_outside_free_space_is_refused(start: tuple[float, float]) -> None:
    with pytest.raises(InvalidInputError, match=r"suggested start .* is not in free space"):
        Environment.from_outline("hall", HALL, [box(4, 4, 6, 6)], starts=[start])


def test_overlapping_obstacles_count_once() -> None:
    hall = Environment.from_outline("hall", HALL, [box(2, 2, 5, 5), box(4, 4, 7, 7)])
    assert hall.area_m2 == pytest.approx(100.0 - (9 + 9 - 1), abs=1e-12)
    assert len(hall.edges) == 4 + 8


def test_touching_obstacles_leave_no_edge_between_them() -> None:
    hall = Environment.from_outline("hall", HALL, [box(2, 2, 4, 4), box(4, 2, 6, 4)])
    assert hall.area_m2 == 92.0
    assert not any(x0 == x1 == 4.0 for x0, _, x1, _ in hall.edges)
    assert hall.clearance(4.0, 3.0) == 0.0


def test_an_obstacle_through_the_outline_shapes_it() -> None:
    hall = Environment.from_outline("hall", HALL, [box(9, 4, 12, 6)])
    assert hall.area_m2 == 98.0
    assert len(hall.edges) == 8


def test_slivers_are_dropped() -> None:
    apart = MultiPolygon([HALL, box(20, 0, 20.0005, 50)])
    world = Environment("slivers", apart)
    assert len(world.free.geoms) == 1
    assert world.bounds == (0.0, 0.0, 10.0, 10.0)
    thin = Environment.from_outline("slivers", HALL, [box(3, 3, 3.0005, 8), box(6, 6, 6.002, 8)])
    assert len(thin.edges) == 8


def test_a_component_is_found_by_a_point_in_it() -> None:
    world = Environment.from_outline("two", HALL, [box(6, 0, 7, 10)])
    assert world.component(1.0, 1.0).area == 60.0
    assert world.component(9.0, 1.0).area == 30.0
    with pytest.raises(ClearanceError, match="'two'") as caught:
        world.component(6.5, 5.0)
    assert caught.value.clearance_m == 0.0


def test_clearance_is_the_distance_to_the_nearest_wall() -> None:
    hall = Environment.from_outline("hall", HALL, [box(4, 4, 6, 6)])
    assert hall.clearance(3.0, 5.0) == 1.0
    assert hall.clearance(0.5, 5.0) == 0.5
    assert hall.clearance(3.0, 3.0) == pytest.approx(math.sqrt(2.0))
    assert hall.clearance(5.0, 5.0) == 0.0
    assert hall.clearance(4.0, 5.0) == 0.0
    assert hall.clearance(-1.0, 5.0) == 0.0


def test_equal_worlds_drawn_differently_have_equal_digests() -> None:
    one = Environment.from_outline("hall", HALL, [box(4, 4, 6, 6), box(1, 1, 2, 2)])
    turned = Polygon([(10, 10), (10, 0), (0, 0), (0, 10)])
    other = Environment.from_outline("hall", turned, [box(1, 1, 2, 2), box(4, 4, 6, 6)])
    assert one.digest == other.digest
    assert one == other
    assert hash(one) == hash(other)


def test_a_moved_wall_changes_the_digest() -> None:
    one = Environment.from_outline("hall", HALL, [box(4, 4, 6, 6)])
    other = Environment.from_outline("hall", HALL, [box(4, 4, 6, 6 + 1e-9)])
    assert one.digest != other.digest
    assert one != other


def test_the_digest_is_that_of_known_coordinates() -> None:
    corners = [0, 0, 10, 0, 10, 10, 0, 10, 0, 0]
    wkb = struct.pack("<BII", 1, 6, 1) + struct.pack("<BIII10d", 1, 3, 1, 5, *corners)
    assert Environment("hall", HALL).digest == hashlib.sha256(wkb).hexdigest()


def test_names_tell_equal_shapes_apart() -> None:
    assert Environment("one", HALL) != Environment("other", HALL)
    assert Environment("one", HALL) != "one"


def test_a_world_cannot_be_changed() -> None:
    starts = [(1.0, 1.0)]
    hall = Environment("hall", HALL, starts=starts)
    for name in ("name", "free", "starts", "origin", "area_m2", "bounds"):
        with pytest.raises(AttributeError):
            setattr(hall, name, None)
    with pytest.raises(ValueError, match="read-only"):
        hall.edges[0, 0] = 5.0
    starts.append((2.0, 2.0))
    assert hall.starts == ((1.0, 1.0),)


def test_drawings_with_heights_are_read_as_flat() -> None:
    raised = shapely.force_3d(HALL, 2.5)
    assert Environment("hall", raised).edges.shape == (4, 4)


def test_repr_shows_name_size_and_edges() -> None:
    assert repr(Environment("hall", HALL)) == "Environment('hall', 10 x 10 m, 100 m2 free, 4 edges)"
