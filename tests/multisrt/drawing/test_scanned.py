"""Pictures of runs in which robots scan on their way and have no tree."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
import shapely

import multisrt as ms
from multisrt.drawing import tree_svg
from multisrt.events import GoalChosen, NodeAdded
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.spec import RadioSpec
from tests.multisrt.drawing.pictures import layers, lines, paths, texts
from tests.multisrt.drawing.recordings import A, B, C, end, motion, node, recorded


@pytest.fixture(scope="module")
def bidding() -> Recording:
    """Robot 0 scans on its way to a goal; robot 1 stands out of its radio's range of 12 m."""

    def goal(time_s, because, place) -> GoalChosen:
        return GoalChosen(time_s=time_s, robot=0, rule="minpos", because=because, goal=place)

    return recorded(
        [A, C],
        [
            node(0.0, 0, 0, A),
            node(0.0, 1, 0, C),
            goal(0.0, "start", (9.0, 3.0)),
            motion(0.0, 0, A, B),
            node(1.0, 0, 1, B, parent=(0, 0), stage="scan"),
            goal(1.0, "news", (10.0, 3.0)),
            motion(1.0, 0, B, (7.0, 3.0)),
            node(2.0, 0, 2, (7.0, 3.0), parent=(0, 1), stage="scan"),
            goal(2.0, "nothing left", None),
            end(2.0, 0),
            end(2.0, 1),
        ],
        strategy="minpos",
        radio=RadioSpec(range_m=12.0),
    )


def test_scans_have_a_path_and_no_tree(bidding):
    svg = tree_svg(bidding)
    found = layers(svg)
    assert not {"robot 0: tree", "robot 0: nodes", "robot 0: regions"} & set(found)
    (line,) = lines(paths(found["robot 0: path"]))
    np.testing.assert_allclose(line, [A, B, (7.0, 3.0)], atol=0.01)
    assert "3 scans, 5 m" in " ".join(texts(svg))
    assert "nodes" not in " ".join(texts(svg))


def test_goals_are_those_that_news_did_not_end(bidding):
    (mark,) = lines(paths(layers(tree_svg(bidding))["robot 0: goals"]))
    np.testing.assert_allclose(mark.mean(axis=0), (10.0, 3.0), atol=0.05)


def test_the_path_of_an_isolated_robot_is_marked(bidding):
    # 12 m from robot 1, at x = 18, robot 0 is after 4 m of its way: between B and (7, 3).
    found = layers(tree_svg(bidding))
    (band,) = lines(paths(found["robot 0: cut off"]))
    np.testing.assert_allclose(band[[0, -1]], [A, (6.0, 3.0)], atol=0.01)
    assert "robot 1: cut off" not in found
    assert "path of an isolated robot" in texts(tree_svg(bidding))
    spec = msgspec.structs.replace(bidding.spec, radio=RadioSpec())
    unlimited = replace(bidding, header=msgspec.structs.replace(bidding.header, spec=spec))
    assert "path of an isolated robot" not in texts(tree_svg(unlimited))


def test_explored_cells_and_frontier_are_those_of_the_raster(bidding):
    found = layers(tree_svg(bidding))
    known = shapely.union_all([shapely.Polygon(r) for r in lines(paths(found["known"]))])
    seen = shapely.union_all(
        [shapely.Polygon(e.boundary) for e in bidding.events if isinstance(e, NodeAdded)]
    )
    assert known.symmetric_difference(seen).area < 0.1 * 1.5 * seen.length
    left = shapely.union_all([shapely.Polygon(r) for r in lines(paths(found["frontier left"]))])
    assert left.area > 0.5
    assert known.buffer(0.02).covers(left)
    assert left.distance(shapely.Point(11.0, 3.0)) < 0.1
    assert left.distance(shapely.Point(*A)) > 1.0


def test_pictures_and_metrics_use_one_word():
    run = ms.explore("open", strategy="closest", robots=2, seed=1, max_time_s=10.0)
    told = dict(run.metrics.outline())
    line = texts(tree_svg(run.recording))[1]
    assert f": {told['informative scans']} informative scans, " in line
    assert "nodes" not in told


def test_pictures_of_scans_repeat(bidding):
    assert tree_svg(bidding) == tree_svg(bidding)


def test_an_option_that_is_no_length_is_refused(bidding):
    spec = msgspec.structs.replace(bidding.spec, options={"cell_m": "wide"})
    bad = replace(bidding, header=msgspec.structs.replace(bidding.header, spec=spec))
    with pytest.raises(InvalidInputError, match="option cell_m"):
        tree_svg(bad)
