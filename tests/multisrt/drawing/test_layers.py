"""Layers that can be left out, and labels that nothing covers."""

import re
import xml.etree.ElementTree as ET
from importlib import import_module
from itertools import combinations

import numpy as np
import pytest
import shapely
from shapely.geometry.base import BaseGeometry

import multisrt as ms
from multisrt.drawing import PICTURES, tree_svg
from multisrt.drawing.badges import label_place, spread
from multisrt.drawing.sheet import MIN_WEIGHT, Sheet
from multisrt.drawing.svg import text_width
from multisrt.drawing.tree_svg import MAX_OUTLINES
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Died, NodeAdded
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from tests.multisrt.drawing.pictures import SVG, layers, lines, paths, texts
from tests.multisrt.drawing.recordings import A, B, C, D, motion, node, recorded

CONTENTS = {
    "areas": "seen first",
    "outlines": "regions",
    "paths": "path",
    "support": "supporting moves",
    "bridges": "bridges",
    "edges": "tree",
    "nodes": "nodes",
    "frontier": "frontier",
    "given-up": "frontier given up",
    "starts": "start",
    "ends": "end",
}
"""What the layers are called in trees of each robot."""


@pytest.fixture(scope="module")
def trees() -> Recording:
    """Four robots that start together; one dies near the others."""
    return ms.explore(
        "rooms",
        robots=4,
        starts="clustered",
        seed=2,
        max_time_s=90.0,
        faults=[ms.Death(robot=2, time_s=4.0)],
    ).recording


@pytest.fixture(scope="module")
def bidders() -> Recording:
    """Six robots that bid for frontiers, until they are stopped."""
    return ms.explore(
        "apartment", strategy="minpos", robots=6, starts="clustered", seed=3, max_time_s=30.0
    ).recording


def kinds(svg: str) -> set[str]:
    return {name.partition(": ")[2] or name for name in layers(svg)}


@pytest.mark.slow
def test_each_layer_is_left_out_alone(trees):
    whole = kinds(tree_svg(trees))
    for name in PICTURES["map"]:
        gone = whole - kinds(tree_svg(trees, without=[name]))
        expected = {CONTENTS[name]} & whole if name in CONTENTS else set()
        if name == "failures":
            expected = {"death"}
        assert gone == expected, name


@pytest.mark.slow
def test_legends_say_nothing_of_what_is_left_out(trees, bidders):
    for recording in (trees, bidders):
        svg = tree_svg(recording, without=PICTURES["map"])
        below = texts(svg)
        assert kinds(svg) >= {"free space", "obstacles", "heading", "legend"}
        assert not kinds(svg) & (set(CONTENTS.values()) | {"known", "goals", "death"})
        words = ("seen first", "outline", "border", "node: ", "start", "death", "no map", "of each")
        for word in words:
            assert not any(word in text for text in below), word


@pytest.mark.slow
def test_colours_of_robots_are_those_of_what_is_drawn(trees):
    def heading(*without: str) -> list[str]:
        return [text for text in texts(tree_svg(trees, without=without)) if "of each robot" in text]

    what = "of each robot: nodes, path length"
    assert heading() == [f"area seen first and tree {what}"]
    assert heading("areas") == [f"tree {what}"]
    assert heading("edges", "nodes") == [f"area seen first {what}"]
    assert heading("areas", "edges", "nodes") == [f"colour {what}"]


def test_regions_of_many_nodes_are_outlined_as_one(trees, monkeypatch):
    nodes = trees.of(NodeAdded)
    assert 20 < len(nodes) <= MAX_OUTLINES
    own = [n for n in nodes if n.robot == 0]
    assert len(layers(tree_svg(trees))["robot 0: regions"]) == len(own) > 1
    # The package has the function by the name of its module.
    monkeypatch.setattr(import_module("multisrt.drawing.tree_svg"), "MAX_OUTLINES", 20)
    (outline,) = layers(tree_svg(trees))["robot 0: regions"]
    regions = [shapely.make_valid(shapely.Polygon(n.boundary)) for n in own]
    drawn: BaseGeometry = shapely.Polygon()
    for ring in lines(outline.get("d", "")):
        drawn = drawn.symmetric_difference(shapely.make_valid(shapely.Polygon(ring)))
    union = shapely.union_all(regions)
    assert drawn.symmetric_difference(union).area < 0.01 * union.area


def test_unknown_layers_are_named(bidders):
    with pytest.raises(InvalidInputError, match=r"no layer 'node' \(did you mean 'nodes'\?\)"):
        tree_svg(bidders, without=["node"])
    with pytest.raises(InvalidInputError, match="no layer 'xyz'; its layers are areas, "):
        ms.Run(bidders).to_svg(without="xyz")
    assert ms.Run(bidders).to_svg(without="goals") == tree_svg(bidders, without=["goals"])


def labels(svg: str):
    """The place of each number on the map in the order of drawing, and its box in metres."""
    found = []
    for number, element in enumerate(layers(svg)["map"].iter()):
        if element.tag == SVG + "text":
            transform = element.get("transform", "")
            (x, y), scale = (
                [float(n) for n in re.findall(r"-?[\d.]+", transform)[:2]],
                float(re.findall(r"scale\(([\d.]+)", transform)[0]),
            )
            size = float(element.get("font-size", "")) * scale
            # The bold digits of Helvetica are 0.556 wide, and capitals 0.72 high.
            half = 0.5 * 0.56 * size * len(element.text or ""), 0.36 * size
            found.append((number, shapely.box(x - half[0], y - half[1], x + half[0], y + half[1])))
    return found


def shapes_above(svg: str, number: int):
    """The shapes that are drawn above an element of the map."""
    for later, element in enumerate(layers(svg)["map"].iter()):
        if later > number and element.tag == SVG + "path":
            for line in lines(re.sub(r"a.*?z", "", element.get("d", ""))):
                if len(line) > 2:
                    yield shapely.make_valid(shapely.Polygon(line))
                elif len(line) == 2:
                    yield shapely.LineString(line)


@pytest.mark.slow
def test_nothing_covers_the_numbers_of_robots(trees, bidders):
    starts = [(1.0 + 0.6 * (k % 4), 1.0 + 0.6 * (k // 4)) for k in range(12)]
    crowd = recorded(starts, [], Environment("yard", shapely.box(0, 0, 120, 80)))
    for recording, count in ((trees, 5), (bidders, 6), (crowd, 12)):
        svg = tree_svg(recording)
        found = labels(svg)
        assert len(found) == count
        for (_, one), (_, other) in combinations(found, 2):
            assert not one.intersects(other)
        for number, box in found:
            assert not any(shape.intersects(box) for shape in shapes_above(svg, number))


def test_the_number_of_a_death_keeps_clear_of_starts():
    died = Died(time_s=2.0, robot=1, configuration=(A[0] + 0.3, A[1] - 0.3, 0.0), doing="moving")
    events: list[AnyEvent] = [node(0.0, 0, 0, A), node(0.0, 1, 0, C), motion(1.0, 1, C, D), died]
    svg = tree_svg(recorded([A, C], events))
    (_, death), (_, first), (_, second) = labels(svg)
    assert layers(svg)["robot 1: death"].findtext(SVG + "text") == "1"
    pins = [shapely.Polygon(lines(paths(layers(svg)[f"robot {k}: start"]))[-1]) for k in (0, 1)]
    assert not any(death.intersects(pin) for pin in pins)
    assert not death.intersects(first)
    assert not death.intersects(second)


def test_badges_with_room_stay_and_others_are_moved_apart():
    places = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.0), (9.0, 9.0)]
    moved = spread(places, 0.5)
    np.testing.assert_array_equal(moved[3], (9.0, 9.0))
    for i, j in combinations(range(3), 2):
        assert np.hypot(*(moved[i] - moved[j])) >= 2.5 * 0.5
    assert np.abs(moved[:3]).max() < 3.0
    np.testing.assert_array_equal(moved, spread(places, 0.5))


def test_labels_take_the_first_place_that_is_free():
    size = text_width("12", 1.0), 1.0
    assert label_place(B, size, 1.0, []) == (B[0] + 1.0 + size[0] / 2, B[1] + 1.5)
    blocked = [(B[0], B[1], B[0] + 9.0, B[1] + 9.0)]
    x, y = label_place(B, size, 1.0, blocked)
    assert y < B[1] < B[1] + 9.0
    assert x > B[0]


def test_lines_are_thinner_where_corridors_are_narrow():
    hall = Sheet(Environment("hall", shapely.box(0, 0, 40, 30)), ["hall"], "")
    street = shapely.LineString([(0, 0), (300, 0), (300, 200), (0, 200)]).buffer(1.5)
    assert isinstance(street, shapely.Polygon)
    narrow = Sheet(Environment.from_outline("street", street), ["street"], "")
    assert hall.weight == 1.0
    assert narrow.weight == MIN_WEIGHT
    assert narrow.metres(1.0) == MIN_WEIGHT * narrow.mm
    sample = ET.fromstring(narrow_svg(narrow))
    assert sample.get("viewBox")


def narrow_svg(sheet: Sheet) -> str:
    sheet.draw_ground("free space")
    return sheet.svg()
