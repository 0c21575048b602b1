"""Cells of exported maps, compared with shapely."""

import itertools

import numpy as np
import pytest
import shapely

import multisrt as ms
from multisrt.analysis.scans import scanned_regions
from multisrt.events import Learned, NodeAdded, Sensed
from multisrt.exporting import ExportOptions
from multisrt.exporting.grids import (
    FREE_CELL,
    OCCUPIED_CELL,
    UNKNOWN_CELL,
    KnownMaps,
    frontier_of,
    grid_of,
    truth_of,
)

CLEAR_M = 1e-6
"""Cells whose values are decided by less than this are left out of comparisons."""


@pytest.fixture(scope="module")
def bidders() -> ms.Run:
    finder = ms.RangeFinderSpec(range_m=3.0, beams=180)
    robots = [ms.RobotSpec(range_finder=finder)] * 2
    return ms.explore("rooms", strategy="minpos", robots=robots, seed=1, max_time_s=12.0)


def expected_cells(grid, regions, walls):
    """Return cells by shapely, and where they are clear of rounding."""
    x = grid.x0 + (np.arange(grid.columns) + 0.5) * grid.cell_m
    y = grid.y0 + (np.arange(grid.rows) + 0.5) * grid.cell_m
    centres = shapely.points(*np.meshgrid(x, y))
    known, borders = shapely.union_all(regions), shapely.union_all([r.boundary for r in regions])
    shapely.prepare(known)
    cells = np.where(shapely.contains(known, centres), FREE_CELL, UNKNOWN_CELL)
    clear = shapely.distance(borders, centres) > CLEAR_M
    if walls:
        xs, ys = np.meshgrid(x, y)
        surely, perhaps = (
            touched(xs, ys, 0.5 * grid.cell_m + change_m, walls) for change_m in (-CLEAR_M, CLEAR_M)
        )
        cells[surely] = OCCUPIED_CELL
        clear = (clear | surely) & (surely == perhaps)
    return cells, clear


def touched(xs, ys, half_m, walls):
    """Return which boxes of a half-width around centres a wall passes through."""
    boxes = shapely.box(xs - half_m, ys - half_m, xs + half_m, ys + half_m)
    hit = np.zeros(boxes.size, np.bool_)
    found = shapely.STRtree(boxes.ravel()).query(np.array(walls), predicate="intersects")
    hit[found[1]] = True
    return hit.reshape(boxes.shape)


def obstacles_of(node):
    corners = [*node.boundary, node.boundary[0]]
    return [shapely.LineString(corners[i : i + 2]) for i, tag in enumerate(node.tags) if tag == "0"]


def known_nodes(recording, robot, until_s):
    nodes = {(node.robot, node.serial): node for node in recording.of(NodeAdded)}
    own = [node for node in nodes.values() if node.robot == robot and node.time_s <= until_s]
    learned = [
        nodes[name]
        for event in recording.of(Learned)
        if event.robot == robot and event.time_s <= until_s
        for name in event.nodes
    ]
    return own + learned


def check(cells, grid, regions, walls):
    expected, clear = expected_cells(grid, regions, walls)
    assert clear.mean() > 0.99
    assert np.array_equal(cells[clear], expected[clear])
    # Not trivially so.
    assert {FREE_CELL, UNKNOWN_CELL} <= set(np.unique(expected))


SLOW = [pytest.param(robot, marks=pytest.mark.slow) for robot in (0, 1, 3)]


@pytest.mark.parametrize("robot", [*SLOW, 2])
def test_maps_hold_what_a_robot_made_and_learned(team, messages, robot):
    grid = grid_of(team.recording, team.environment, ExportOptions())
    shown = messages[f"/robot_{robot}/map"]
    for time, message in (shown[0], shown[len(shown) // 2], shown[-1]):
        info = message.info
        assert (info.width, info.height) == (grid.columns, grid.rows)
        assert info.resolution == np.float32(grid.cell_m)
        assert (info.origin.position.x, info.origin.position.y) == (grid.x0, grid.y0)
        cells = np.array(message.data).reshape(grid.rows, grid.columns)
        nodes = known_nodes(team.recording, robot, time * 1e-9)
        if not nodes:  # it has not started
            assert (cells == UNKNOWN_CELL).all()
            continue
        regions = [shapely.Polygon(node.boundary) for node in nodes]
        check(cells, grid, regions, [wall for node in nodes for wall in obstacles_of(node)])
        area_m2 = shapely.union_all(regions).area
        walls = np.count_nonzero(cells == OCCUPIED_CELL) * grid.cell_m**2
        free = np.count_nonzero(cells == FREE_CELL) * grid.cell_m**2
        assert free < area_m2 + 0.5 < free + walls + 1.0


def test_a_map_is_sent_when_it_has_changed(team, messages):
    for robot in range(4):
        shown = messages[f"/robot_{robot}/map"]
        data = [bytes(np.array(message.data, np.int8)) for _, message in shown]
        assert all(one != two for one, two in itertools.pairwise(data))
        end = round(team.recording.footer.time_s * 1e9)
        assert all(time % 3_000_000_000 == 0 or time == end for time, _ in shown)


def test_frontier_markers_are_free_cells_beside_unknown_ones(messages):
    for (time, grid), (marked, markers) in zip(
        messages["/robot_2/map"], messages["/robot_2/frontier"], strict=True
    ):
        assert time == marked
        cells = np.array(grid.data).reshape(grid.info.height, grid.info.width)
        cell = grid.info.resolution
        found = set()
        for point in markers.markers[0].points:
            column = (point.x - grid.info.origin.position.x) / cell - 0.5
            row = (point.y - grid.info.origin.position.y) / cell - 0.5
            assert abs(column - round(column)) < 1e-3
            found.add((round(row), round(column)))
        padded = np.pad(cells, 1, constant_values=OCCUPIED_CELL)
        expected = {
            (row, column)
            for row, column in np.argwhere(cells == FREE_CELL).tolist()
            if UNKNOWN_CELL
            in (
                padded[row, column + 1],
                padded[row + 2, column + 1],
                padded[row + 1, column],
                padded[row + 1, column + 2],
            )
        }
        assert found == expected


def test_the_truth_is_the_world(team, messages):
    ((time, message),) = messages["/truth/map"]
    grid = grid_of(team.recording, team.environment, ExportOptions())
    cells = np.array(message.data).reshape(grid.rows, grid.columns)
    assert time == 0
    assert set(np.unique(cells)) == {FREE_CELL, OCCUPIED_CELL}
    walls = [shapely.LineString(edge.reshape(2, 2)) for edge in team.environment.edges]
    expected, clear = expected_cells(grid, [team.environment.free], walls)
    expected[expected == UNKNOWN_CELL] = OCCUPIED_CELL
    assert np.array_equal(cells[clear], expected[clear])


def test_the_truth_has_holes_and_islands_in_them():
    outline, hole = shapely.box(0, 0, 9, 9).exterior, shapely.box(2, 2, 7, 7).exterior
    ring, island = shapely.Polygon(outline, [hole]), shapely.box(4, 4, 5, 5)
    world = ms.Environment("ring", shapely.MultiPolygon([ring, island]))
    recording = ms.explore(world, start=(1.0, 1.0), max_time_s=1.0).recording
    grid = grid_of(recording, world, ExportOptions(cell_m=0.1))
    cells = truth_of(world, grid)

    def at(x, y):
        return cells[int((y - grid.y0) / 0.1), int((x - grid.x0) / 0.1)]

    assert [at(1, 1), at(3, 3), at(4.5, 4.5), at(8, 5)] == [0, 100, 0, 0]
    assert (cells == FREE_CELL).sum() * 0.01 == pytest.approx(57.0, rel=0.06)


@pytest.mark.slow
def test_maps_of_bidders_hold_their_scans(bidders):
    recording = bidders.recording
    grid = grid_of(recording, bidders.environment, ExportOptions(cell_m=0.2))
    maps = KnownMaps(recording, bidders.environment, grid)
    for event in recording.events:
        maps.add(event)
    for robot, cells in maps.changed():
        nodes = known_nodes(recording, robot, 1e9)
        regions = [shapely.Polygon(node.boundary) for node in nodes]
        check(cells, grid, regions, [wall for node in nodes for wall in obstacles_of(node)])
    assert not list(maps.changed())


@pytest.mark.slow
def test_robots_that_note_no_nodes_know_their_scans(bidders):
    whole = bidders.recording
    recording = ms.Recording(
        header=whole.header, events=tuple(whole.of(Sensed)), footer=whole.footer
    )
    grid = grid_of(recording, bidders.environment, ExportOptions(cell_m=0.2))
    maps = KnownMaps(recording, bidders.environment, grid)
    for event in recording.events:
        maps.add(event)
    scanned = scanned_regions(recording, bidders.environment)
    robots = [scan.robot for scan in recording.events]
    for robot, cells in maps.changed():
        own = [shapely.Polygon(r) for r, who in zip(scanned, robots, strict=True) if who == robot]
        known = cells != UNKNOWN_CELL
        expected, clear = expected_cells(grid, own, [])
        assert own
        assert np.array_equal(known[clear], (expected == FREE_CELL)[clear] | (cells[clear] == 100))
        assert (cells == OCCUPIED_CELL).sum() > 20


def test_cells_grow_with_the_world():
    side = 250.0
    world = ms.Environment("field", shapely.MultiPolygon([shapely.box(0, 0, side, side)]))
    recording = ms.explore(world, start=(1.0, 1.0), max_time_s=1.0).recording
    assert grid_of(recording, world, ExportOptions()).cell_m == 0.4
    assert grid_of(recording, world, ExportOptions(cell_m=0.1)).cell_m == 0.1
    with pytest.raises(ms.InvalidInputError, match=r"choose cells wider than 0\.002 m"):
        grid_of(recording, world, ExportOptions(cell_m=0.002))


def test_frontier_at_the_border_of_the_grid():
    cells = np.zeros((3, 3), np.int8)
    assert not frontier_of(cells).any()
    cells[1, 1] = UNKNOWN_CELL
    assert frontier_of(cells).sum() == 4
