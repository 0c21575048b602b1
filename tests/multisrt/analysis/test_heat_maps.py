"""Rasters of visits and of times in isolation."""

import math
from itertools import pairwise

import numpy as np
import pytest
import shapely

import multisrt as ms
from multisrt.analysis.heat_maps import isolated_times, visits
from multisrt.analysis.scans import scanned_regions
from multisrt.events import Motion, Sensed
from multisrt.geometry.errors import InvalidInputError
from tests.multisrt.drawing.recordings import HALL, motion, node, recorded


@pytest.fixture(scope="module")
def run() -> ms.Run:
    return ms.explore(
        "apartment",
        strategy="closest",
        robots=2,
        seed=2,
        radio=ms.RadioSpec(range_m=5.0),
        max_time_s=60.0,
    )


def test_passes_are_counted_one_by_one():
    # To and fro along a line, and a second robot that crosses it.
    there, back, below, above = (4.0, 4.0), (10.0, 4.0), (7.0, 2.0), (7.0, 6.0)
    recording = recorded(
        [there, below],
        [
            node(0.0, 0, 0, there),
            motion(1.0, 0, there, back, there, back),
            motion(1.0, 1, below, above),
        ],
        HALL,
    )
    passes = visits(recording, "passes", cell_m=0.5)
    robots = visits(recording, "robots", cell_m=0.5)

    def at(found, x, y):
        return found.values[int((y - found.y0) / 0.5), int((x - found.x0) / 0.5)]

    # Cell centres at 0.25 from the line; the body reaches 0.25.
    assert at(passes, 6.1, 4.1) == 3.0
    assert at(passes, 7.1, 4.1) == 4.0
    assert at(passes, 7.1, 5.1) == 1.0
    assert at(passes, 10.1, 4.1) in (0.0, 1.0)
    assert at(passes, 9.6, 4.1) == 3.0
    assert at(passes, 6.1, 5.1) == 0.0
    assert at(robots, 7.1, 4.1) == 2.0
    assert at(robots, 6.1, 4.1) == 1.0
    assert passes.values.shape == (16, 40)


def test_passes_are_stretches_of_paths(run):
    found = visits(run.recording, "passes", cell_m=0.5)
    centres = found.centres()
    counts = np.zeros(len(centres))
    for robot in range(2):
        points = [run.recording.header.starts[robot][:2]]
        for event in run.recording.of(Motion):
            if event.robot == robot:
                points += [waypoint[1:3] for waypoint in event.waypoints]
        path = np.array(points)
        path = path[np.append(True, (np.diff(path, axis=0) != 0.0).any(axis=1))]
        parts = [
            a + (b - a) * np.linspace(0.0, 1.0, 2 + int(math.dist(a, b) / 0.002))[:, None]
            for a, b in pairwise(path)
        ]
        fine = np.concatenate(parts)
        for number, centre in enumerate(centres):
            near = np.hypot(*(fine - centre).T) <= 0.25
            counts[number] += np.count_nonzero(near[1:] & ~near[:-1]) + near[0]
    differ = np.count_nonzero(counts != found.values.ravel())
    assert counts.sum() > 50
    # Samples miss stretches that are shorter than their distance.
    assert differ <= 0.005 * np.count_nonzero(counts)


def test_sightings_are_scans_that_contain_the_centre(run):
    scans, viewers = (visits(run.recording, count, cell_m=1.0) for count in ("scans", "viewers"))
    centres = scans.centres()
    shown = [shapely.Polygon(c) for c in scanned_regions(run.recording, run.environment)]
    by_robot = np.zeros((2, len(centres)))
    for scan, region in zip(run.recording.of(Sensed), shown, strict=True):
        by_robot[scan.robot] += shapely.contains_xy(region, centres)
    np.testing.assert_array_equal(scans.values.ravel(), by_robot.sum(axis=0))
    np.testing.assert_array_equal(viewers.values.ravel(), (by_robot > 0.0).sum(axis=0))
    assert viewers.values.max() == 2.0


def test_isolated_times_add_up_and_lie_on_the_paths(run):
    found = isolated_times(run.recording, cell_m=0.5)
    total_s = sum(robot.total_s for robot in ms.isolation(run.recording))
    assert total_s > 5.0
    assert found.values.sum() == pytest.approx(total_s)
    driven = visits(run.recording, "passes", cell_m=0.5).values
    grown = np.pad(driven, 1)
    near = sum(
        grown[1 + r : grown.shape[0] - 1 + r, 1 + c : grown.shape[1] - 1 + c]
        for r in (-1, 0, 1)
        for c in (-1, 0, 1)
    )
    assert not (found.values[near == 0.0] > 0.0).any()


def test_cells_are_checked(run):
    for cell_m in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InvalidInputError, match="width of cells"):
            visits(run.recording, cell_m=cell_m)
    with pytest.raises(InvalidInputError, match="at most 4,000,000 are drawn"):
        visits(run.recording, cell_m=1e-4)
    with pytest.raises(InvalidInputError, match="count is passes"):
        visits(run.recording, "laps")  # type: ignore[arg-type]
