import numpy as np
import pytest

from multisrt.analysis import shown_regions
from multisrt.analysis.shown_regions import NOTHING, WHOLE, ShownRegions
from multisrt.geometry.grids.strip_map import StripMap
from multisrt.geometry.grids.strips import clipped, runs_of, strips

CUT = strips(np.array([(0.0, 0.0, 0.0, 6.0)]), 0.5)
TABLES = [[1, 1, 2], [2, 2, 2]]


def box(x, y, width, height):
    return np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)], float)


@pytest.fixture
def boxes():
    rng = np.random.default_rng(5)
    return [box(*rng.uniform(0, 4, 2), *rng.uniform(1.0, 3.0, 2)) for _ in range(12)]


@pytest.fixture(params=[1, 5, 100])
def at_once(request, monkeypatch):
    monkeypatch.setattr(shown_regions, "MAX_REGIONS", request.param)


def test_regions_change_labels_as_all_at_once(boxes, at_once):
    masks = [WHOLE, WHOLE, 0, NOTHING, 1, WHOLE, 5, 0, 0, WHOLE, NOTHING, 2]
    order, which = [3, 2, 0, 11, 7, 7, 4, 6, 1], [0, 1, 1, 0, 1, 1, 0, 1, 0]
    plane, twin = StripMap(CUT, 3), StripMap(CUT, 3)
    # A mask counts whole, even where the region itself is clipped.
    whole = clipped(runs_of(CUT, boxes), np.array(masks))
    expected = twin.relabel(whole, TABLES, order, which)
    found = ShownRegions(CUT, boxes, masks).relabel(plane, TABLES, order, which)
    np.testing.assert_array_equal(found, expected)
    assert found[-1, 1:].min() > 0.0


def test_no_regions_have_no_history():
    history = ShownRegions(CUT, [], []).relabel(StripMap(CUT, 3), TABLES, [])
    assert history.shape == (0, 3)


def test_what_is_measured_is_returned_for_every_region(boxes, at_once):
    regions = ShownRegions(CUT, boxes, [WHOLE] * len(boxes))
    order = range(len(boxes))
    both = regions.relabel(StripMap(CUT, 3), TABLES, order)
    one = regions.relabel(StripMap(CUT, 3), TABLES, order, measured=lambda areas: areas[:, 1])
    np.testing.assert_array_equal(one, both[:, 1])


def test_the_area_that_does_not_count(at_once):
    corners = [box(0, 0, 2, 2), box(1, 0, 2, 2), box(4, 0, 1, 1)]
    assert ShownRegions(CUT, corners, [WHOLE, 0, NOTHING]).unshown_m2() == 2.0 + 1.0
    assert ShownRegions(CUT, corners, [WHOLE] * 3).unshown_m2() == 0.0
