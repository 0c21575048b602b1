import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.drawing import environment_svg, save_environment_svg, save_tree_svg, tree_svg
from multisrt.drawing.traces import traces_of
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import Collision, Ended, MapComplete, Motion, NodeAdded
from multisrt.geometry.errors import InvalidInputError
from multisrt.simulation.simulate import simulate
from multisrt.spec import InlineEnvironment, RobotSpec, RunSpec
from tests.multisrt.drawing.pictures import SVG, layers, lines, on_page, paths, texts
from tests.multisrt.drawing.recordings import node, recorded, run, team


def test_every_kind_of_mark_of_a_robot_has_a_layer(museum):
    names = set(layers(tree_svg(museum)))
    own = ("regions", "path", "tree", "nodes", "frontier", "frontier given up", "start")
    assert {f"robot 0: {kind}" for kind in own} <= names
    assert {"free space", "obstacles", "heading", "legend", "scale bar"} <= names


@pytest.mark.slow
def test_ids_are_unique(museum):
    ids = re.findall(r' id="([^"]+)"', tree_svg(team(museum, museum)))
    assert len(ids) == len(set(ids)) > 30


def test_every_node_edge_and_region_is_drawn_in_its_place(museum):
    found = layers(tree_svg(museum))
    nodes = [event for event in museum.events if isinstance(event, NodeAdded)]
    places = {(node.robot, node.serial): node.configuration[:2] for node in nodes}
    edges = [(places[n.parent], n.configuration[:2]) for n in nodes if n.parent is not None]
    np.testing.assert_allclose(lines(paths(found["robot 0: tree"])), edges, atol=0.51e-3)
    regions = found["robot 0: regions"].findall(SVG + "path")
    assert len(regions) == len(nodes)
    for added, region in zip(nodes, regions, strict=True):
        drawn = shapely.Polygon(lines(region.get("d", ""))[0])
        true = shapely.Polygon(added.boundary)
        assert drawn.symmetric_difference(true).area < 0.003 * true.length
    assert paths(found["robot 0: nodes"]).count("M") == len(nodes)
    discs = paths(found["robot 0: nodes"]).split("M")
    circles = [re.match(r"(-?[\d.]+) ?(-?[\d.]+)a([\d.]+)", disc) for disc in discs]
    centres = [(float(m[1]) + float(m[3]), float(m[2])) for m in circles if m]
    random_places = [n.configuration[:2] for n in nodes if n.stage == "draw"]
    assert len(random_places) > 10
    np.testing.assert_allclose(centres, random_places, atol=1e-3)


def test_stages_have_shapes_of_their_own(museum):
    nodes = layers(tree_svg(museum))["robot 0: nodes"].findall(SVG + "path")
    drawn, approached = (
        next(n for n in nodes if n.get("id") == f"robot-0-nodes-{stage}").get("d", "")
        for stage in ("draw", "approach")
    )
    assert "a" in drawn
    assert {len(corners) for corners in lines(approached)} == {3}


def test_y_points_up_and_the_map_is_on_the_page(museum):
    svg = tree_svg(museum)
    x0, y0, x1, y1 = museum.environment().bounds
    left, bottom = on_page(svg, x0, y0)
    right, top = on_page(svg, x1, y1)
    _, _, width, height = map(float, ET.fromstring(svg).get("viewBox", "").split())
    assert 0 < left < right < width
    assert 0 < top < bottom < height
    assert right - left == pytest.approx(x1 - x0)
    assert bottom - top == pytest.approx(y1 - y0)
    frame = lines(paths(layers(svg)["free space"]))[0]
    assert shapely.box(x0, y0, x1, y1).within(shapely.Polygon(frame))


def test_heading_scale_bar_and_legend_do_not_touch_the_map(museum):
    for svg in (tree_svg(museum), environment_svg(museum.environment())):
        frame = lines(paths(layers(svg)["free space"]))[0]
        top, bottom = (on_page(svg, 0.0, y)[1] for y in (frame[:, 1].max(), frame[:, 1].min()))
        found = layers(svg)
        mm = float(re.findall(r"scale\((\S+)\)", found["legend"].get("transform", ""))[0])
        below = [mm * float(text.get("y", "")) for text in found["heading"].iter(SVG + "text")]
        assert max(below) < top
        samples = [mm * float(text.get("y", "")) for text in found["legend"].iter(SVG + "text")]
        ends = [mm * float(text.get("y", "")) for text in found["scale bar"].iter(SVG + "text")]
        assert bottom < min(ends) < min(samples)
        assert max(samples) < float(ET.fromstring(svg).get("viewBox", "").split()[3])


def test_the_size_of_the_page_matches_its_view_box(museum):
    root = ET.fromstring(tree_svg(museum))
    width, height = (float(root.get(name, "").removesuffix("mm")) for name in ("width", "height"))
    *_, w, h = map(float, root.get("viewBox", "").split())
    assert w / h == pytest.approx(width / height)
    assert 150 < width < 300
    assert 100 < height < 300


def test_heading_names_the_run(museum):
    nodes = sum(isinstance(event, NodeAdded) for event in museum.events)
    title, account, *_ = texts(tree_svg(museum))
    assert title == "srt-radial in museum, seed 1"
    assert account.startswith(f"complete after {museum.footer.time_s:,.0f} s: {nodes} nodes, ")


def test_equal_recordings_give_equal_bytes(museum, tmp_path):
    again = run(environment("museum"), seed=1)
    assert tree_svg(again) == tree_svg(museum)
    save_tree_svg(museum, tmp_path / "tree.svg")
    assert (tmp_path / "tree.svg").read_bytes() == tree_svg(museum).encode()
    assert [path.name for path in tmp_path.iterdir()] == ["tree.svg"]


def test_a_folder_that_is_not_there_is_named(museum, tmp_path):
    path = tmp_path / "nowhere" / "tree.svg"
    with pytest.raises(InvalidInputError, match="nowhere"):
        save_tree_svg(museum, path)
    with pytest.raises(InvalidInputError, match="nowhere"):
        save_environment_svg(museum.environment(), path)


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["srt-radial", "srt-star"])
def test_a_node_costs_less_than_a_kilobyte(strategy):
    recording = run(environment("museum"), strategy=strategy, seed=2)
    nodes = sum(isinstance(event, NodeAdded) for event in recording.events)
    assert len(tree_svg(recording).encode()) < 20_000 + 1_000 * nodes


def test_no_number_is_written_as_nan_or_with_an_exponent(cut_off, one_node):
    for recording in (cut_off, one_node, team(cut_off, cut_off)):
        for element in ET.fromstring(tree_svg(recording)).iter():
            for value in element.attrib.values():
                assert not re.search(r"\b(nan|inf)\b|\de[-+]?\d", value.lower())


def test_paths_on_an_arc_are_drawn_as_arcs():
    quarter = Motion(
        time_s=0.0,
        robot=0,
        waypoints=((0.0, 5.0, 1.0, 0.0), (4.0, 8.0, 4.0, np.pi / 2)),
    )
    nodes = node(0.0, 0, 0, (5.0, 1.0)), node(4.0, 0, 1, (8.0, 4.0), parent=(0, 0))
    recording = recorded([(5.0, 1.0)], [nodes[0], quarter, nodes[1]])
    svg = tree_svg(recording)
    (line,) = lines(paths(layers(svg)["robot 0: path"]))
    np.testing.assert_allclose(np.hypot(*(line - (5.0, 4.0)).T), 3.0, atol=5e-3)
    assert len(line) > 8
    assert traces_of(recording)[0].distance_m == pytest.approx(1.5 * np.pi)
    assert "path off the tree" in texts(svg)


def test_a_run_of_one_node(one_node):
    found = layers(tree_svg(one_node))
    assert len(found["robot 0: regions"]) == 1
    assert len(found["robot 0: tree"]) == len(found["robot 0: path"]) == 0
    assert "1 node, 0 m travelled" in texts(tree_svg(one_node))[1]
    assert "edge of the tree" not in texts(tree_svg(one_node))


def test_a_recording_without_nodes(one_node):
    events = tuple(e for e in one_node.events if isinstance(e, Ended | MapComplete))
    found = layers(tree_svg(replace(one_node, events=events)))
    assert len(found["robot 0: regions"]) == 0
    assert len(found["robot 0: start"]) == 1


def test_a_collision_is_marked(one_node):
    hit = Collision(time_s=1.0, robot=0, configuration=(1.0, 0.5, 0.0), account="touched")
    svg = tree_svg(replace(one_node, events=(*one_node.events, hit)))
    cross = lines(paths(layers(svg)["robot 0: collision"]))
    np.testing.assert_allclose([line.mean(axis=0) for line in cross], [(1.0, 0.5)] * 2, atol=1e-3)
    assert "collision" in texts(svg)


def test_coordinates_stay_small_where_the_world_is_far_away():
    far = Environment("far", shapely.box(5e6, 7e6, 5e6 + 3, 7e6 + 2))
    recording = run(far, start=(5e6 + 1, 7e6 + 1))
    for path in layers(tree_svg(recording))["map"].iter(SVG + "path"):
        assert max(abs(float(v)) for v in re.findall(r"[\d.]+", path.get("d", "0"))) < 100


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robot": 3}, "mentions robot 3, but its team has 1"),
        ({"parent": (0, 77)}, "node 77 of robot 0, which it has not reported"),
        ({"parent": (5, 0)}, "node 0 of robot 5, which it has not reported"),
        ({"boundary": ((0.0, 0.0), (1.0, 1.0)), "tags": "00"}, "2 corners and 2 tags"),
        ({"tags": "01"}, "2 tags"),
        ({"tags": "09000"}, "digits from 0 to 3"),
    ],
)
def test_recordings_that_contradict_themselves_are_refused(change, message, one_node):
    node = next(e for e in one_node.events if isinstance(e, NodeAdded))
    bad = replace(one_node, events=(msgspec.structs.replace(node, **change),))
    with pytest.raises(InvalidInputError, match=re.escape(message)):
        tree_svg(bad)


def test_a_node_that_is_added_twice_is_refused(one_node):
    with pytest.raises(InvalidInputError, match="adds node 0 of robot 0 twice"):
        tree_svg(replace(one_node, events=one_node.events * 2))


def test_inline_worlds_keep_their_name():
    spec = RunSpec(
        environment=InlineEnvironment(name="cell", wkt="POLYGON((0 0,3 0,3 2,0 2,0 0))"),
        robots=(RobotSpec(start=(1.0, 1.0)),),
    )
    assert texts(tree_svg(simulate(spec)))[0] == "srt-radial in cell, seed 0"


def test_paths_are_drawn_where_they_are_off_the_tree():
    a, b, c = (2.0, 2.0), (6.0, 2.0), (6.0, 4.0)
    there, back = (0.0, *a, 0.0), (8.0, *a, 0.0)
    out = Motion(time_s=0.0, robot=0, waypoints=(there, (2.0, *b, 0.0)))
    detour = Motion(time_s=3.0, robot=0, waypoints=((3.0, *b, 0.0), (4.0, *c, 0.0)))
    home = Motion(time_s=5.0, robot=0, waypoints=((5.0, *c, 0.0), (6.0, *b, 0.0), back))
    nodes = node(0.0, 0, 0, a), node(2.0, 0, 1, b, parent=(0, 0))
    recording = recorded([a], [nodes[0], out, nodes[1], detour, home])
    svg = tree_svg(recording)
    # There and back again is one line.
    (line,) = lines(paths(layers(svg)["robot 0: path"]))
    np.testing.assert_allclose(line, [b, c])
    assert "path off the tree" in texts(svg)
    svg = tree_svg(recorded([a], [nodes[0], out, nodes[1]]))
    assert lines(paths(layers(svg)["robot 0: path"])) == []
    assert "path off the tree" not in texts(svg)


def test_the_sheet_shrinks_with_the_window(one_node):
    assert ' style="max-width:100%;height:auto"' in tree_svg(one_node).partition("<title>")[0]
