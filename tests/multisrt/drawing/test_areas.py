import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.drawing import tree_svg
from multisrt.drawing.areas import seen_first
from tests.multisrt.drawing.pictures import layers, lines, paths
from tests.multisrt.drawing.recordings import F


def test_places_belong_to_the_robot_that_saw_them_first(support):
    found = layers(tree_svg(support))
    areas = []
    for robot in (0, 1):
        rings = lines(paths(found[f"robot {robot}: seen first"]))
        areas.append(shapely.union_all([shapely.Polygon(ring) for ring in rings]))
    assert areas[0].intersection(areas[1]).area < 1e-3
    # Seen from E first, then from F; the way back to B was seen from B.
    assert areas[1].contains(shapely.Point(F))
    assert areas[0].contains(shapely.Point(8.5, 3.0))
    assert found["robot 0: regions"].get("fill") == "none"
    assert len(found["robot 0: regions"]) == 3


boxes = st.tuples(
    st.integers(0, 20), st.integers(0, 20), st.integers(1, 9), st.integers(1, 9), st.integers(0, 3)
)


@pytest.mark.slow
@given(st.lists(boxes, min_size=1, max_size=12), st.data())
def test_areas_partition_the_explored_area(found, data):
    regions = [shapely.box(x, y, x + w, y + h) for x, y, w, h, _ in found]
    robots = [robot for *_, robot in found]
    areas = {
        robot: shapely.build_area(shapely.MultiLineString(rings))
        for robot, rings in seen_first(regions, robots, 0.01).items()
    }
    assert sum(area.area for area in areas.values()) == pytest.approx(
        shapely.union_all(regions).area
    )
    # Cells of the grid on which the boxes lie.
    x, y = (data.draw(st.integers(0, 29)) + 0.5 for _ in "xy")
    first = next(
        (r for r, b in zip(robots, regions, strict=True) if shapely.contains_xy(b, x, y)), None
    )
    assert [r for r, area in areas.items() if shapely.contains_xy(area, x, y)] == (
        [] if first is None else [first]
    )


def test_regions_that_cross_themselves_can_be_shared_out():
    bow = shapely.Polygon([(0, 0), (2, 2), (2, 0), (0, 2)])
    areas = seen_first([bow, shapely.box(0, 0, 2, 2), shapely.box(0, 0, 1, 1)], [0, 1, 2], 0.01)
    assert sorted(areas) == [0, 1]
    assert sum(shapely.Polygon(ring).area for ring in areas[0]) == pytest.approx(2.0)
