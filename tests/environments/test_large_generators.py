"""Caverns, warehouses, cities, forests and dungeons: passable by other means than their own."""

import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

import multisrt as ms
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.environments.generators.difficulty import RANGES
from multisrt.geometry.errors import InvalidInputError

PASSAGES_M = {"cavern": 1.2, "warehouse": 1.2, "city": 1.6, "forest": 1.2, "dungeon": 1.4}
"""Default passage of each of them."""

MIN_SIZES_M = {"cavern": 12, "warehouse": 16, "city": 26, "forest": 8, "dungeon": 32}

PIXEL_M = 0.05


def rooms_of_body(world: Environment, radius_m: float) -> int:
    """Number of places with room for a disc that it cannot drive between."""
    eroded = shapely.get_parts(world.free.buffer(-radius_m))
    return int((shapely.area(eroded) > 0.02).sum())


def beyond_reach(world: Environment, radius_m: float) -> float:
    """Share of the world's cells that have room for a disc and that it does not reach."""
    x0, y0, x1, y1 = world.bounds
    x = np.arange(x0 + PIXEL_M / 2, x1, PIXEL_M)
    y = np.arange(y0 + PIXEL_M / 2, y1, PIXEL_M)
    free = shapely.contains_xy(world.free, *np.meshgrid(x, y))
    away = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1] * PIXEL_M
    # A pixel more, by which distances between centres of pixels may be wrong.
    labels, _ = ndimage.label(away >= radius_m - PIXEL_M, np.ones((3, 3)))
    sizes = np.bincount(labels.ravel())[1:]
    return 1.0 - float(sizes.max() / sizes.sum())


def walls_per_area(world: Environment) -> float:
    """Length of walls per area of free space, in 1/m."""
    return float(world.free.length / world.area_m2)


@pytest.mark.parametrize("difficulty", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("name", PASSAGES_M)
def test_a_body_of_most_of_the_passage_reaches_everything(name: str, difficulty: float) -> None:
    for seed in range(3):
        world = environment(name, difficulty=difficulty, seed=seed)
        assert len(world.free.geoms) == 1
        assert rooms_of_body(world, 0.45 * PASSAGES_M[name]) == 1
        assert rooms_of_body(world, 0.25) == 1
        assert world.starts
        assert all(world.clearance(x, y) > 0.45 for x, y in world.starts)


@pytest.mark.slow
@pytest.mark.parametrize("name", PASSAGES_M)
def test_a_flood_of_a_raster_reaches_everything(name: str) -> None:
    for seed in range(2):
        world = environment(name, difficulty=0.9, seed=seed)
        assert beyond_reach(world, 0.45 * PASSAGES_M[name]) == 0.0


def test_the_flood_finds_what_is_cut_off() -> None:
    two = shapely.union_all([shapely.box(0, 0, 4, 4), shapely.box(4, 1, 6, 1.6)])
    plan = Environment("plan", two.union(shapely.box(6, 0, 8, 4)))
    assert beyond_reach(plan, 0.25) == 0.0
    assert beyond_reach(plan, 0.5) == pytest.approx(1 / 4, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", PASSAGES_M)
@settings(max_examples=15, deadline=None, derandomize=True)
@given(
    larger=st.floats(1.0, 2.0),
    difficulty=st.floats(0.0, 1.0),
    passage_m=st.floats(0.8, 1.8),
    seed=st.integers(0, 2**32),
)
def test_all_parameters_are_passable(
    name: str, larger: float, difficulty: float, passage_m: float, seed: int
) -> None:
    world = environment(
        name,
        size_m=larger * MIN_SIZES_M[name],
        difficulty=difficulty,
        passage_m=passage_m,
        seed=seed,
    )
    x0, y0, x1, y1 = world.bounds
    assert max(x1 - x0, y1 - y0) <= larger * MIN_SIZES_M[name] + 1.5e-3
    assert len(world.free.geoms) == 1
    assert rooms_of_body(world, 0.45 * passage_m) == 1
    assert all(world.clearance(x, y) >= 0.38 * passage_m for x, y in world.starts)


SMALLEST: list[tuple[str, dict[str, float]]] = [
    ("cavern", {"size_m": 48.0, "passage_m": 6.0}),
    ("cavern", {"size_m": 10.0, "passage_m": 0.8}),
    ("warehouse", {"size_m": 14.0, "passage_m": 2.0}),
    ("city", {"size_m": 28.0, "passage_m": 4.0}),
    ("city", {"size_m": 24.0, "passage_m": 0.8}),
    ("forest", {"size_m": 9.2, "passage_m": 4.0}),
    ("dungeon", {"size_m": 89.2, "passage_m": 6.0}),
]


@pytest.mark.parametrize(("name", "parameters"), SMALLEST)
def test_the_smallest_worlds_are_passable(name: str, parameters: dict[str, float]) -> None:
    for seed in range(4):
        for difficulty in (0.0, 1.0):
            world = environment(name, seed=seed, difficulty=difficulty, **parameters)
            assert len(world.free.geoms) == 1
            assert rooms_of_body(world, 0.45 * parameters["passage_m"]) == 1
            assert world.area_m2 > 0.15 * parameters["size_m"] ** 2


@pytest.mark.parametrize("name", PASSAGES_M)
def test_coordinates_are_whole_millimetres(name: str) -> None:
    world = environment(name, seed=1)
    points = shapely.get_coordinates(world.free)
    assert np.array_equal(points, np.round(points, 3))
    assert all((x, y) == (round(x, 3), round(y, 3)) for x, y in world.starts)


def test_another_process_draws_the_same_worlds() -> None:
    code = (
        "from multisrt.environments.catalog import environment\n"
        f"for name in {list(PASSAGES_M)}:\n"
        "    world = environment(name, seed=3)\n"
        "    print(world.digest, world.starts)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    own = [environment(name, seed=3) for name in PASSAGES_M]
    assert done.stdout.splitlines() == [f"{world.digest} {world.starts}" for world in own]


@pytest.mark.parametrize("name", PASSAGES_M)
def test_seeds_make_the_difference(name: str) -> None:
    assert environment(name, seed=2) == environment(name, seed=2)
    assert len({environment(name, seed=seed).digest for seed in range(5)}) == 5


HARDER: dict[str, dict[str, float]] = {
    **{name: {} for name in RANGES},
    "warehouse": {},
    "forest": {},
    # Few blocks or chambers differ too much from one another.
    "city": {"size_m": 200.0},
    "cavern": {"size_m": 70.0},
    "dungeon": {"size_m": 80.0},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", HARDER)
def test_walls_per_area_grow_with_difficulty(name: str) -> None:
    for seed in range(4):
        found = [
            walls_per_area(environment(name, seed=seed, difficulty=share, **HARDER[name]))
            for share in (0.0, 0.25, 0.5, 0.75, 1.0)
        ]
        assert found == sorted(found)
        assert found[-1] > 1.02 * found[0]


def test_difficulty_stands_for_parameters_that_may_be_given_too() -> None:
    assert environment("maze", difficulty=0.5) == environment("maze", loops=0.3)
    assert environment("maze", difficulty=1.0) == environment("maze")
    assert environment("maze", difficulty=0.5, loops=0.1) == environment("maze", loops=0.1)
    with pytest.raises(InvalidInputError, match=r"^maze: difficulty=2 .* from 0 to 1"):
        environment("maze", difficulty=2)
    with pytest.raises(InvalidInputError, match="open has no parameter 'difficulty'"):
        environment("open", difficulty=0.5)


def test_the_bundled_cave_stays_and_points_to_the_generator() -> None:
    assert environment("cave").origin.endswith("cave.geojson")
    with pytest.raises(InvalidInputError, match=r"'cave' is fixed.*the generator 'cavern'"):
        environment("cave", seed=1)


def test_a_harder_warehouse_has_more_dead_ends() -> None:
    # An aisle that is closed at one end makes two corners of shelves that point inwards.
    counts = [_notches(environment("warehouse", size_m=60, difficulty=d)) for d in (0.0, 0.5, 1.0)]
    assert counts[0] == 0
    assert counts[0] < counts[1] < counts[2]


def test_a_harder_dungeon_has_fewer_loops() -> None:
    worlds = [environment("dungeon", size_m=80, difficulty=d, seed=4) for d in (0.0, 0.5, 1.0)]
    loops = [len(world.free.geoms[0].interiors) for world in worlds]
    assert loops[0] > loops[1] > loops[2]


def _notches(world: Environment) -> int:
    (free,) = world.free.geoms
    hulls = [shapely.Polygon(ring) for ring in free.interiors]
    return sum(len(hull.exterior.coords) - 1 > 4 for hull in hulls)


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("cavern", {"size_m": 5}, r"size_m=5 .* from 10 to 1000"),
        ("warehouse", {"difficulty": 1.1}, r"difficulty=1\.1 .* from 0 to 1"),
        ("city", {"passage_m": float("nan")}, "passage_m=nan is out of range"),
        ("forest", {"size_m": 1001.0}, r"size_m=1001\.0 .* from 6 to 1000"),
        ("dungeon", {"size_m": "wide"}, "size_m='wide' is out of range"),
        (
            "dungeon",
            {"size_m": 20, "passage_m": 4},
            "size_m=20 .* give a size_m of at least 61.2 m",
        ),
        ("cavern", {"size_m": 20, "passage_m": 6}, "size_m=20 .* give a size_m of at least 48 m"),
        ("forest", {"size_m": 9, "passage_m": 4}, r"size_m=9 .* of at least 9\.2 m"),
        ("city", {"size_m": 25, "passage_m": 4, "difficulty": 0}, "size_m=25 .* of at least 28 m"),
        ("cavern", {"seed": -1}, "seed=-1 is out of range"),
    ],
)
def test_parameters_out_of_range_are_refused(
    name: str, parameters: dict[str, Any], message: str
) -> None:
    with pytest.raises(InvalidInputError, match=f"^{name}: {message}") as caught:
        environment(name, **parameters)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize("name", PASSAGES_M)
def test_a_kilometre_takes_seconds(name: str) -> None:
    began = time.process_time()
    world = environment(name, size_m=1000)
    assert time.process_time() - began < 10.0
    assert 500.0 < max(world.bounds) <= 1000.0
    assert len(world.edges) < 500_000


@pytest.mark.slow
@pytest.mark.parametrize("name", PASSAGES_M)
def test_two_robots_explore_all_of_it(name: str) -> None:
    where = ms.CatalogEnvironment(
        name=name, parameters={"size_m": float(MIN_SIZES_M[name])}, seed=2
    )
    run = ms.explore(ms.RunSpec(environment=where, robots=(ms.RobotSpec(),) * 2, seed=1))
    assert run.outcome == "complete"
    assert run.metrics.coverage > 0.99
    assert run.metrics.collisions == 0
