"""Every generator keeps its promises: one passable part, no cracks, the same world per seed."""

from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon, box

from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.environments.generators.bay import Bay, shared_widths
from multisrt.environments.generators.grid_walls import open_walls
from multisrt.environments.generators.maze import maze
from multisrt.environments.generators.parameters import call_text, number, whole
from multisrt.environments.generators.passable import passable, starts_near
from multisrt.environments.generators.rooms import rooms
from multisrt.geometry.errors import InvalidInputError

PASSAGES_M = {
    "garden": 1.4,
    "clutter": 1.0,
    "rooms": 1.2,
    "office": 1.0,
    "maze": 1.8,
    "hospital": 1.2,
    "open": 1.1,
}
"""Default width of the doors or passages of each generator."""

ROBOT_RADIUS_M = 0.25


def places(world: Environment, body_radius_m: float) -> int:
    """Number of places that such a body cannot drive between."""
    eroded = shapely.get_parts(world.free.buffer(-body_radius_m))
    return int((shapely.area(eroded) > 0.05).sum())


def crack_area(world: Environment, width_m: float) -> float:
    """Area of what no square of the given width fits into."""
    inset = width_m / 2
    opened = world.free.buffer(-inset, join_style="mitre").buffer(inset, join_style="mitre")
    return float(world.free.difference(opened.buffer(0.005)).area)


def assert_passable(world: Environment, passage_m: float) -> None:
    assert len(world.free.geoms) == 1
    assert places(world, ROBOT_RADIUS_M) == 1
    assert places(world, 0.45 * passage_m) == 1
    assert crack_area(world, 0.68) < 0.01
    assert all(world.clearance(x, y) > 0.3 for x, y in world.starts)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", PASSAGES_M)
def test_defaults_are_passable_everywhere(name: str, seed: int) -> None:
    world = environment(name, seed=seed)
    assert_passable(world, PASSAGES_M[name])
    assert world.starts
    assert 300.0 < world.area_m2 < 1100.0


@pytest.mark.parametrize("name", PASSAGES_M)
def test_equal_seeds_give_equal_worlds(name: str) -> None:
    one, other = environment(name, seed=3), environment(name, seed=3)
    assert one.digest == other.digest
    assert one.starts == other.starts


@pytest.mark.parametrize("name", [name for name in PASSAGES_M if name != "open"])
def test_other_seeds_give_other_worlds(name: str) -> None:
    digests = {environment(name, seed=seed).digest for seed in range(5)}
    assert len(digests) == 5


def test_columns_move_with_the_seed() -> None:
    worlds = [environment("open", columns=5, seed=seed) for seed in (0, 1)]
    assert worlds[0].digest != worlds[1].digest
    assert all(len(world.free.geoms[0].interiors) == 5 for world in worlds)


@given(size_m=st.floats(5, 30), share=st.floats(0, 1), seed=st.integers(0, 2**32))
def test_halls_are_passable_with_any_number_of_columns(
    size_m: float, share: float, seed: int
) -> None:
    most = 1 if size_m < 5.8 else int(size_m**2 / 16)
    world = environment("open", size_m=size_m, columns=round(share * most), seed=seed)
    assert_passable(world, PASSAGES_M["open"])


def test_a_small_hall_has_room_for_one_column() -> None:
    with pytest.raises(InvalidInputError, match=r"columns=2 .* from 0 to 1"):
        environment("open", size_m=5.79, columns=2)


VARIATIONS: dict[str, Any] = {
    "garden": (
        "path_m",
        {"size_m": st.floats(25, 60), "plots": st.integers(2, 4), "path_m": st.floats(0.9, 1.2)},
    ),
    "clutter": (
        "passage_m",
        {
            "size_m": st.floats(8, 30),
            "cover": st.floats(0.02, 0.05),
            "obstacle_m": st.floats(2.5, 4),
            "passage_m": st.floats(0.8, 1.2),
        },
    ),
    "rooms": (
        "door_m",
        {
            "size_m": st.floats(24, 60),
            "rooms_per_side": st.integers(1, 4),
            "door_m": st.floats(0.8, 3),
            "loops": st.floats(0, 1),
        },
    ),
    "office": (
        "door_m",
        {
            "width_m": st.floats(14, 60),
            "height_m": st.floats(11, 14),
            "corridor_m": st.floats(1.2, 2),
            "door_m": st.floats(0.8, 1.6),
            "connecting": st.floats(0, 1),
            "furnished": st.booleans(),
        },
    ),
    "hospital": (
        "door_m",
        {
            "wings": st.integers(1, 3),
            "wing_length_m": st.floats(16, 40),
            "door_m": st.floats(0.9, 1.6),
            "links": st.floats(0, 1),
        },
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIATIONS)
@settings(max_examples=12, deadline=None, derandomize=True)
@given(data=st.data(), seed=st.integers(0, 2**32))
def test_all_parameters_are_passable_everywhere(name: str, data: st.DataObject, seed: int) -> None:
    passage, strategies = VARIATIONS[name]
    parameters = {parameter: data.draw(values) for parameter, values in strategies.items()}
    world = environment(name, seed=seed, **parameters)
    assert_passable(world, parameters[passage])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("garden", {"size_m": 9.0}, r"size_m=9\.0 .* from 10 to 150"),
        ("garden", {"plots": 20}, "give fewer plots"),
        ("clutter", {"cover": 0.5}, r"cover=0\.5 .* from 0\.02 to 0\.25"),
        ("clutter", {"cover": 0.25, "obstacle_m": 1.0}, "give a smaller cover"),
        ("rooms", {"rooms_per_side": 12}, "give at most 8"),
        ("rooms", {"rooms_per_side": 2.5}, "whole number from 1 to 40"),
        ("office", {"height_m": 10.0, "corridor_m": 4.0}, "give a greater height_m"),
        ("office", {"door_m": 0.5}, r"from 0\.8 to 1\.6"),
        ("hospital", {"wings": 0}, "whole number from 1 to 12"),
        ("maze", {"cells": 30}, "give at most 24"),
        ("maze", {"loops": 1.5}, "number from 0 to 1"),
        ("maze", {"loops": float("nan")}, "loops=nan is out of range"),
        ("open", {"columns": 26}, "whole number from 0 to 25"),
        ("open", {"size_m": "wide"}, "size_m='wide' is out of range"),
        ("open", {"size_m": None}, "size_m=None is out of range"),
        ("open", {"columns": True}, "columns=True is out of range"),
    ],
)
def test_parameters_out_of_range_are_refused(
    name: str, parameters: dict[str, Any], message: str
) -> None:
    with pytest.raises(InvalidInputError, match=f"^{name}: .*{message}"):
        environment(name, **parameters)


@pytest.mark.parametrize("name", PASSAGES_M)
@pytest.mark.parametrize("seed", [-1, 1.5, "x", 2**63])
def test_seeds_are_natural_numbers(name: str, seed: Any) -> None:
    with pytest.raises(InvalidInputError, match=f"^{name}: seed=.*whole number from 0"):
        environment(name, seed=seed)


@pytest.mark.parametrize("cells", [5, 12])
def test_a_perfect_maze_has_no_loop(cells: int) -> None:
    assert len(maze(cells=cells, loops=0.0, seed=1).free.geoms[0].interiors) == 0


def test_a_maze_with_loops_has_islands() -> None:
    loops = [len(maze(loops=share, seed=1).free.geoms[0].interiors) for share in (0.0, 0.1, 0.4)]
    assert loops[0] < loops[1] < loops[2]


def test_a_maze_of_all_loops_is_a_hall() -> None:
    assert maze(size_m=20.0, cells=5, loops=1.0).area_m2 == pytest.approx(400.0)


def test_rooms_as_a_tree_have_a_door_less_than_rooms() -> None:
    plan = rooms(size_m=30.0, rooms_per_side=3, door_m=1.0, loops=0.0, seed=2)
    walls = 30.0**2 - 2 * 2 * 0.2 * 30.0 + 4 * 0.2**2
    assert plan.area_m2 == pytest.approx(walls + 8 * 1.0 * 0.2, abs=0.05)


def test_every_obstacle_in_clutter_can_be_walked_around() -> None:
    world = environment("clutter", passage_m=1.2, cover=0.08, seed=4)
    (free,) = world.free.geoms
    obstacles = [Polygon(ring) for ring in free.interiors]
    gaps = [
        one.distance(other)
        for index, one in enumerate(obstacles)
        for other in [Polygon(free.exterior).exterior, *obstacles[:index]]
    ]
    assert min(gaps) > 1.2 - 0.005


def test_the_garden_is_its_own_mirror_image() -> None:
    free = environment("garden", seed=5).free
    mirrored = shapely.transform(free, lambda points: points * [-1.0, 1.0] + [28.0, 0.0])
    assert free.symmetric_difference(mirrored).area < 0.5


class TestPassable:
    def test_square_rooms_stay_square(self) -> None:
        assert passable(box(0, 0, 4, 3), 1.0).equals(box(0, 0, 4, 3))

    def test_cracks_are_closed(self) -> None:
        crack = box(0, 0, 4, 4).difference(box(0.5, 1, 4, 4))
        assert passable(crack, 1.0).equals(box(0, 0, 4, 1))

    def test_rooms_without_a_door_become_solid(self) -> None:
        cut = shapely.union_all([box(0, 0, 4, 4), box(4.2, 0, 6, 4)])
        assert passable(cut, 1.0).equals(box(0, 0, 4, 4))

    def test_rooms_behind_a_door_too_narrow_become_solid(self) -> None:
        plan = shapely.union_all([box(0, 0, 6, 6), box(6, 2, 6.2, 2.8), box(6.2, 0, 9, 4)])
        assert passable(plan, 0.8).area == pytest.approx(plan.area, abs=1e-6)
        assert passable(plan, 1.0).area < 36.2
        assert passable(plan, 1.0).covers(box(0.01, 0.01, 5.99, 5.99))

    def test_equal_rooms_that_are_not_connected_become_one(self) -> None:
        plan = shapely.union_all([box(0, 0, 4, 4), box(4, 1, 4.2, 1.8), box(4.2, 0, 8.2, 4)])
        assert 16.0 <= passable(plan, 1.0).area < 16.2

    def test_starts_are_moved_to_where_there_is_room(self) -> None:
        free = box(0, 0, 4, 3)
        assert starts_near(free, [(0, 0), (2, 1), (-1, -1)], 0.5) == ((0.5, 0.5), (2.0, 1.0))

    def test_starts_in_narrow_space_keep_what_clearance_there_is(self) -> None:
        ((x, y),) = starts_near(box(0, 0, 4, 1), [(2, 0)], 0.6)
        assert x == pytest.approx(2.0, abs=0.1)
        assert 0.35 < y < 0.65


class TestBay:
    def test_places_drawings_in_the_world(self) -> None:
        left_of_corridor = Bay(
            x=10.0, y=5.0, along=(0.0, 1.0), inward=(-1.0, 0.0), width_m=4.0, depth_m=3.0
        )
        assert left_of_corridor.floor().equals(box(7, 5, 10, 9))
        assert left_of_corridor.place(box(0, 2, 1, 3)).equals(box(7, 5, 8, 6))
        assert left_of_corridor.mirrored().floor().equals(box(7, 5, 10, 9))
        assert left_of_corridor.mirrored().place(box(0, 2, 1, 3)).equals(box(7, 8, 8, 9))
        assert left_of_corridor.doorway(1.0, 1.0, 0.2).equals(box(10, 5.5, 10.2, 6.5))

    def test_rooms_and_walls_fill_the_row(self) -> None:
        row = Bay(x=0.0, y=0.0, along=(1.0, 0.0), inward=(0.0, 1.0), width_m=10.0, depth_m=3.0)
        widths = shared_widths(row.width_m, np.array([1.0, 2.0, 1.0]), 0.2)
        assert widths == pytest.approx([2.4, 4.8, 2.4])
        first, second, third = row.split(widths, 0.2)
        assert (first.x, second.x, third.x) == pytest.approx((0.0, 2.6, 7.6))
        assert third.x + third.width_m == pytest.approx(10.0)


class TestOpenWalls:
    @given(columns=st.integers(1, 7), rows=st.integers(1, 7), seed=st.integers(0, 99))
    @settings(max_examples=30, deadline=None)
    def test_a_tree_reaches_every_cell_once(self, columns: int, rows: int, seed: int) -> None:
        tree = open_walls(columns, rows, 0.0, np.random.default_rng(seed))
        assert len(tree) == columns * rows - 1
        reached = {(0, 0)}
        for _ in tree:
            reached |= {cell for wall in tree if reached & set(wall) for cell in wall}
        assert len(reached) == columns * rows

    def test_all_loops_open_every_wall(self) -> None:
        opened = open_walls(4, 3, 1.0, np.random.default_rng(0))
        assert len(opened) == len(set(opened)) == 3 * 3 + 4 * 2
        assert all(
            sorted((right - left, upper - lower)) == [0, 1]
            for (left, lower), (right, upper) in opened
        )


def test_calls_are_written_so_that_they_can_be_repeated() -> None:
    assert call_text("garden", size_m=40.0, seed=3) == "garden(size_m=40, seed=3)"
    assert call_text("maze", loops=0.1) == "maze(loops=0.1)"


def test_numbers_of_numpy_are_numbers() -> None:
    size = number("open", "size_m", np.float64(7.0), 5.0, 200.0)
    columns = whole("open", "columns", np.int64(3), 0, 5)  # type: ignore[arg-type]
    assert (type(size), size) == (float, 7.0)
    assert (type(columns), columns) == (int, 3)


def test_a_buffer_of_geos_that_touches_itself_is_mended() -> None:
    # Of this office a campaign found that it could not be drawn.
    office = environment("office", width_m=22.8, height_m=22.7, corridor_m=2.29, seed=3502)
    assert office.free.is_valid
    assert len(office.free.geoms) == 1
    assert len(shapely.get_parts(office.free.buffer(-0.45))) == 1
