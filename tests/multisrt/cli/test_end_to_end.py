"""Whole runs, with a check of their motions independent of the simulation's."""

import math
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely

import multisrt as ms
from multisrt.environments.catalog import names
from multisrt.environments.environment import Environment
from multisrt.events import Motion, NodeAdded
from multisrt.finished_run import Run
from multisrt.spec import DriveSpec

TURN_STEP_RAD = math.radians(1.0)

L_SHAPE = "polygon:-0.15,-0.15 0.35,-0.15 0.35,0.1 0.1,0.1 0.1,0.35 -0.15,0.35"
TRIANGLE = "polygon:-0.2,-0.25 0.4,0 -0.2,0.25"

Pose = tuple[float, float, float]
Corners = list[tuple[float, float]]

BODIES: dict[str, Corners | None] = {
    "disc:0.25": None,
    "box:0.5x0.3": [(-0.25, -0.15), (0.25, -0.15), (0.25, 0.15), (-0.25, 0.15)],
    L_SHAPE: [(-0.15, -0.15), (0.35, -0.15), (0.35, 0.1), (0.1, 0.1), (0.1, 0.35), (-0.15, 0.35)],
    TRIANGLE: [(-0.2, -0.25), (0.4, 0), (-0.2, 0.25)],
}
"""Footprints as text, and their corners; a disc has a radius of 0.25 m."""

SMALL: dict[str, dict[str, Any]] = {
    "rooms": {"size_m": 20.0, "rooms_per_side": 3},
    "office": {"width_m": 24.0, "height_m": 16.0},
}
"""Parameters of smaller versions of large environments."""


@cache
def world(name: str) -> Environment:
    return ms.environment(name, **SMALL.get(name, {}))


def deepest_overlap(run: Run) -> float:
    """Return the largest penetration of obstacles by the body (m), by shapely alone."""
    corners = BODIES[run.spec.robots[0].footprint]
    free = run.environment.free
    obstacles = shapely.box(*free.bounds).buffer(2.0, join_style="mitre").difference(free)
    solids = shapely.get_parts(obstacles)
    motions = [event for event in run.recording.events if isinstance(event, Motion)]
    legs: list[tuple[Pose, Pose]] = [(run.recording.starts[0], run.recording.starts[0])]
    legs += [(a[1:], b[1:]) for motion in motions for a, b in pairwise(motion.waypoints)]
    covered = np.concatenate([covered_by_leg(corners, a, b) for a, b in legs])
    which, solid = shapely.STRtree(solids).query(covered, predicate="intersects")
    overlap = shapely.intersection(covered[which], solids[solid])
    # Twice the area over the perimeter approximates the depth of a sliver.
    depth = 2.0 * shapely.area(overlap) / np.maximum(shapely.length(overlap), 1e-9)
    return float(depth.max(initial=0.0))


def covered_by_leg(corners: Corners | None, a: Pose, b: Pose) -> np.ndarray:
    """Return the area swept by a body on a leg, as polygons from inside."""
    if corners is None:
        path = shapely.Point(a[:2]) if a[:2] == b[:2] else shapely.LineString([a[:2], b[:2]])
        # Chords of 256 a circle lie within 0.25 m (1 - cos(pi / 256)) = 0.02 mm of it.
        return np.array([path.buffer(0.25, quad_segs=64)])
    if a[2] == b[2]:
        # A triangle of the body sweeps the convex hull of its two positions.
        triangles = shapely.constrained_delaunay_triangles(shapely.Polygon(corners))
        parts = [shapely.get_coordinates(part)[:3] for part in shapely.get_parts(triangles)]
        swept = [np.vstack([placed(part, a), placed(part, b)]) for part in parts]
        return np.array([shapely.MultiPoint(points).convex_hull for points in swept])
    steps = 2 + math.ceil(abs(b[2] - a[2]) / TURN_STEP_RAD)
    poses = np.linspace(a, b, steps).tolist()
    return np.array([shapely.Polygon(placed(np.array(corners), tuple(pose))) for pose in poses])


def placed(corners: np.ndarray, pose: Pose) -> np.ndarray:
    """Return the corners of a body at a pose."""
    x, y, heading = pose
    c, s = math.cos(heading), math.sin(heading)
    return corners @ np.array([[c, s], [-s, c]]) + (x, y)


def check(run: Run, least_coverage: float) -> None:
    metrics = run.metrics
    assert run.outcome == "complete", run.reason
    assert metrics.collisions == 0
    assert metrics.coverage is not None
    assert metrics.coverage >= least_coverage
    assert metrics.min_clearance_m >= 0.0
    assert deepest_overlap(run) <= 1e-6
    # Nobody knows a map complete of which less was covered than a success takes.
    assert (metrics.known_complete_s is not None) == metrics.reached(0.95)
    if metrics.known_complete_s is not None:
        assert metrics.known_complete_s <= metrics.makespan_s
    assert metrics.lower_bound_s is not None
    assert metrics.makespan_s >= metrics.lower_bound_s
    home: Pose = run.recording.starts[0]
    place = home
    for event in run.recording.events:
        if isinstance(event, Motion):
            # Every motion begins where the one before it ended.
            assert event.waypoints[0][1:3] == pytest.approx(place[:2], abs=1e-9)
            place = event.waypoints[-1][1:]
        elif isinstance(event, NodeAdded):
            assert event.configuration[:2] == pytest.approx(place[:2], abs=1e-9)
    assert place[:2] == pytest.approx(home[:2], abs=1e-9)


MAPS = ("museum", "apartment", "workshop", "library", "clinic", "cave")


def test_all_bundled_maps_are_tested():
    assert set(MAPS) == {entry.name for entry in ms.catalog() if entry.kind == "map"}
    assert set(MAPS) < set(names())


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(("strategy", "share"), [("srt-radial", 0.99), ("srt-star", 0.95)])
@pytest.mark.parametrize("name", MAPS)
def test_bundled_maps_are_explored(name, strategy, share, seed):
    check(ms.explore(world(name), strategy=strategy, seed=seed), share)


@pytest.mark.slow
@pytest.mark.parametrize("drive", ["holonomic", "differential"])
@pytest.mark.parametrize("footprint", [text for text in BODIES if text != "disc:0.25"])
@pytest.mark.parametrize(
    ("name", "strategy"),
    [("rooms", "srt-star"), ("office", "srt-radial"), ("apartment", "srt-radial")],
)
def test_other_bodies_explore(name, strategy, footprint, drive):
    run = ms.explore(
        world(name), strategy=strategy, footprint=footprint, drive=DriveSpec(kind=drive), seed=2
    )
    # Relative to the area that a disc inscribed in the body can see, which is larger.
    check(run, 0.93)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rooms", "office", "apartment"])
def test_a_laser_explores(name):
    run = ms.explore(world(name), strategy="srt-radial", beams=720, seed=3)
    check(run, 0.97)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 5])
@pytest.mark.parametrize("name", ["garden", "clutter"])
def test_a_laser_of_few_beams_among_sharp_corners(name, seed):
    check(ms.explore(world(name), strategy="srt-radial", beams=360, seed=seed), 0.95)


@pytest.mark.slow
def test_a_box_with_a_laser_and_star_regions_explores():
    run = ms.explore(
        world("apartment"), strategy="srt-star", beams=720, footprint="box:0.5x0.3", seed=4
    )
    check(run, 0.93)


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        {"backtrack": "nearest_open"},
        {"frontier_bias": False},
        {"gaps_count": False},
        {"alpha": 1.0, "margin_m": 0.0025},
        {"max_draws": 1, "cones": 8},
    ],
)
def test_options_of_strategies(options):
    strategy = "srt-star" if "cones" in options else "srt-radial"
    run = ms.explore(world("apartment"), strategy=strategy, options=options, seed=5)
    check(run, 0.90)


def test_without_later_stages_it_stops_but_never_collides():
    run = ms.explore(
        world("office"), options={"approach": False, "complete": False}, seed=1, max_time_s=1e6
    )
    assert run.outcome == "stalled"
    assert "frontier left open" in run.reason
    assert run.metrics.frontier_left_m > 0.0
    assert run.metrics.coverage < 0.9
    assert deepest_overlap(run) <= 1e-6


def test_the_independent_check_detects_contact():
    # A motion through a wall 0.1 m thick makes the check fail.
    run = ms.explore(Environment("closet", shapely.box(0, 0, 3, 3)), start=(1.0, 1.5))
    assert deepest_overlap(run) == 0.0
    walled = shapely.box(0, 0, 3, 3).difference(shapely.box(1.4, 0, 1.5, 3))
    through = Motion(time_s=0.0, robot=0, waypoints=((0, 1.0, 1.5, 0.0), (1, 2.0, 1.5, 0.0)))
    recording = type(run.recording)(
        header=run.recording.header, events=(through,), footer=run.recording.footer
    )
    assert deepest_overlap(Run(recording, Environment("walled", walled))) > 0.05
