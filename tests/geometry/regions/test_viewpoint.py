"""Viewpoints and ranges that views, lasers and lines of sight refuse."""

from functools import partial

import numpy as np
import pytest
import shapely
from shapely import Point, box

from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.laser import laser_ranges
from multisrt.geometry.regions.line_of_sight import line_of_sight
from multisrt.geometry.regions.visibility import visibility_polygon


@pytest.mark.parametrize(
    ("x", "y", "clearance"),
    [
        (0.0, 0.0, 0.0),  # on a vertex of the outline
        (5.0, 0.0, 0.0),  # on an edge of the outline
        (4.0, 4.0, 0.0),  # on a vertex of the pillar
        (5.0, 4.0, 0.0),  # on an edge of the pillar
        (4.5, 4.0 + 1e-10, -1e-10),
        (4.5, 4.0 - 1e-10, 1e-10),
        (4.2, 4.9, -0.2),  # in the pillar
        (5.0, 5.0, -1.0),
        (-0.3, 5.0, -0.3),  # behind the outline
        (-0.3, -0.4, -0.5),  # behind its corner
        (-3.0, 5.0, -3.0),
    ],
)
@pytest.mark.parametrize("sense", [visibility_polygon, partial(laser_ranges, beams=90)])
def test_an_error_reports_too_little_clearance(worlds, x, y, clearance, sense):
    index = worlds.index(worlds.pillar())
    with pytest.raises(ClearanceError) as refused:
        sense(index, x, y, 4.0)
    assert refused.value.clearance_m == pytest.approx(clearance, abs=1e-14)
    assert f"clearance {clearance:.3g} m" in str(refused.value).replace("-0 m", "0 m")


@pytest.mark.parametrize(("x", "y"), [(50.0, 50.0), (-50.0, 50.0), (150.0, 50.0), (50.0, -7.0)])
def test_inside_an_obstacle_with_no_surface_in_range(worlds, x, y):
    free = box(0, 0, 100, 100).difference(box(20, 20, 80, 80))
    index = EdgeIndex(worlds.edges(free), 1.3)
    with pytest.raises(ClearanceError) as refused:
        visibility_polygon(index, x, y, 4.0)
    # How deep is not known beyond the range.
    assert refused.value.clearance_m == -4.0
    with pytest.raises(ClearanceError):
        laser_ranges(index, x, y, 4.0, 8)
    visibility_polygon(index, 10.0, 50.0, 4.0)


def test_sides_are_right_everywhere(worlds):
    free = worlds.clutter(8.0, 60)
    index = worlds.index(free, 1.0)
    rng = np.random.default_rng(5)
    sides = {True: 0, False: 0}
    for x, y in rng.uniform(-1.0, 9.0, (1500, 2)).tolist():
        inside = bool(shapely.contains_xy(free, x, y))
        sides[inside] += 1
        distance = free.boundary.distance(Point(x, y))
        if inside:
            laser_ranges(index, x, y, 1.0, 3)
        else:
            with pytest.raises(ClearanceError) as refused:
                laser_ranges(index, x, y, 1.0, 3)
            assert refused.value.clearance_m == pytest.approx(-min(distance, 1.0), abs=1e-12)
    assert min(sides.values()) > 300


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_refuses_viewpoints_that_are_not_finite(worlds, bad):
    index = worlds.index(worlds.hall())
    for x, y in ((bad, 5.0), (5.0, bad)):
        with pytest.raises(InvalidInputError, match="finite"):
            visibility_polygon(index, x, y, 4.0)
        with pytest.raises(InvalidInputError, match="finite"):
            laser_ranges(index, x, y, 4.0, 90)
        with pytest.raises(InvalidInputError, match="finite"):
            line_of_sight(index, 1.0, 1.0, x, y)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf, 1e8])
def test_refuses_ranges_that_are_not_positive_or_too_long(worlds, bad):
    index = worlds.index(worlds.hall())
    with pytest.raises(InvalidInputError, match="range"):
        visibility_polygon(index, 5.0, 5.0, bad)
    with pytest.raises(InvalidInputError, match="range"):
        laser_ranges(index, 5.0, 5.0, bad, 90)
