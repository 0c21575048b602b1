import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.analysis.remaining_frontier import remaining_frontier
from multisrt.drawing import environment_svg, save_environment_svg, save_tree_svg, tree_svg
from multisrt.drawing.areas import seen_first
from multisrt.drawing.colours import ROBOT_COLOURS, RobotStyles
from multisrt.drawing.sheet import round_length, wrapped
from multisrt.drawing.svg import Pen, number, plain, text_width
from multisrt.drawing.traces import traces_of
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import (
    ArcClosed,
    Blocked,
    Collision,
    Decision,
    Died,
    Ended,
    Event,
    GoalChosen,
    Joined,
    MapComplete,
    Motion,
    NodeAdded,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.recording import Footer, Recording, header_of
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import InlineEnvironment, LateStart, RadioSpec, RobotSpec, RunSpec, StopRule

SVG = "{http://www.w3.org/2000/svg}"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


def run(world: Environment, *, start=None, max_time_s=86_400.0, **spec) -> Recording:
    robot = RobotSpec(start=start)
    stop = StopRule(max_time_s=max_time_s)
    described = inline(world)
    return simulate(RunSpec(environment=described, robots=(robot,), stop=stop, **spec), world)


@pytest.fixture(scope="module")
def museum() -> Recording:
    return run(environment("museum"), seed=1)


@pytest.fixture(scope="module")
def cut_off() -> Recording:
    return run(environment("museum"), seed=1, max_time_s=60.0)


@pytest.fixture(scope="module")
def stalled() -> Recording:
    options = {"complete": False, "approach": False, "max_draws": 1}
    return run(environment("museum"), seed=1, options=options)


@pytest.fixture(scope="module")
def one_node() -> Recording:
    return run(Environment("closet", shapely.box(0, 0, 2, 1)), start=(0.5, 0.5))


def of_robot(event: Event, robot: int) -> Event:
    changes = {"robot": robot}
    match event:
        case NodeAdded(parent=(_, serial)):
            changes["parent"] = robot, serial
        case Decision(node=(_, serial)) | ArcClosed(node=(_, serial)):
            changes["node"] = robot, serial
    return msgspec.structs.replace(event, **changes)


def team(*runs: Recording) -> Recording:
    """Put runs of one world together, as if each robot knew nothing of the others."""
    spec = msgspec.structs.replace(runs[0].spec, robots=tuple(r.spec.robots[0] for r in runs))
    starts = tuple(r.header.starts[0] for r in runs)
    events = [
        of_robot(event, number)
        for number, recording in enumerate(runs)
        for event in recording.events
    ]
    header = msgspec.structs.replace(runs[0].header, spec=spec, starts=starts)
    return replace(runs[0], header=header, events=tuple(sorted(events, key=lambda e: e.time_s)))


HALL = Environment("hall", shapely.box(0, 0, 20, 8))
HALL_INDEX = EdgeIndex(
    np.array([(0, 0, 20, 0), (20, 0, 20, 8), (20, 8, 0, 8), (0, 8, 0, 0)], float), 1.0
)


def node(time_s, robot, serial, place, parent=None, stage="draw") -> NodeAdded:
    """A node in the hall, seen from there as far as 4 m."""
    scan = take_scan(HALL_INDEX, Configuration(*place), 0.0, 4.0)
    region = local_safe_region(scan, "radial")
    return NodeAdded(
        time_s=time_s,
        robot=robot,
        serial=serial,
        parent=parent,
        configuration=(*place, 0.0),
        stage=stage if parent else "root",
        boundary=tuple(map(tuple, region.boundary.tolist())),
        tags="".join(map(str, region.tags.tolist())),
    )


def motion(time_s, robot, *places, purpose="explore") -> Motion:
    """A drive without turns through places of the hall, a second each."""
    waypoints = tuple((time_s + k, x, y, 0.0) for k, (x, y) in enumerate(places))
    return Motion(time_s=time_s, robot=robot, waypoints=waypoints, purpose=purpose)


def end(time_s, robot, frontier=()) -> Ended:
    return Ended(time_s=time_s, robot=robot, reason="done", complete=True, frontier=frontier)


def recorded(starts, events, world=HALL, **spec) -> Recording:
    robots = tuple(RobotSpec(start=start) for start in starts)
    run_spec = RunSpec(environment=inline(world), robots=robots, **spec)
    header = header_of(run_spec, world, tuple(Configuration(*start) for start in starts))
    footer = Footer(time_s=100.0, outcome="complete", reason="done", digest="0")
    return Recording(header=header, events=tuple(events), footer=footer)


A, B = (2.0, 3.0), (5.0, 3.0)  # of robot 0
C, D, E = (18.0, 3.0), (15.0, 3.0), (10.0, 3.0)  # of robot 1; E is seen by neither B nor D
F = (11.5, 4.0)  # of robot 0 in the tree of robot 1


@pytest.fixture(scope="module")
def support() -> Recording:
    """Robot 0 is done, goes over a bridge to the tree of robot 1, adds a node there, goes home."""
    return recorded(
        [A, C],
        [
            node(0.0, 0, 0, A),
            node(0.0, 1, 0, C),
            motion(1.0, 0, A, B),
            motion(1.0, 1, C, D),
            node(2.0, 0, 1, B, parent=(0, 0)),
            node(2.0, 1, 1, D, parent=(1, 0)),
            end(2.0, 0, frontier=((9.0, 1.0, 9.0, 5.0),)),
            motion(3.0, 1, D, E),
            node(4.0, 1, 2, E, parent=(1, 1)),
            motion(5.0, 1, E, D, C),
            end(7.0, 1),
            motion(8.0, 0, A, B, E, purpose="support"),
            motion(11.0, 0, E, F, purpose="support"),
            node(12.0, 0, 2, F, parent=(1, 2)),
            motion(12.0, 0, F, E, B, A, purpose="home"),
            end(15.0, 0),
        ],
    )


def layers(svg: str) -> dict[str, ET.Element]:
    return {
        group.get(INKSCAPE + "label", ""): group
        for group in ET.fromstring(svg).iter(SVG + "g")
        if group.get(INKSCAPE + "groupmode") == "layer"
    }


def texts(svg: str) -> list[str]:
    return [element.text or "" for element in ET.fromstring(svg).iter(SVG + "text")]


def lines(path: str) -> list[np.ndarray]:
    """Read path data of straight lines back into points."""
    found = []
    for piece in re.findall(r"M([^Mz]*)z?", path):
        first, *rest = piece.split("l")
        values = [np.array(re.findall(r"-?[\d.]+", part), float) for part in (first, *rest)]
        found.append(np.concatenate(values).reshape(-1, 2).cumsum(axis=0))
    return found


def paths(layer: ET.Element) -> str:
    return "".join(path.get("d", "") for path in layer.iter(SVG + "path"))


def on_page(svg: str, x: float, y: float) -> tuple[float, float]:
    """Where a place of the map is on the page, in user units."""
    transform = layers(svg)["map"].get("transform", "")
    right, down = map(float, re.findall(r"translate\((\S+) (\S+)\) scale\(1 -1\)", transform)[0])
    return right + x, down - y


# The tree


def test_every_kind_of_thing_of_a_robot_is_a_layer(museum):
    names = set(layers(tree_svg(museum)))
    own = ("regions", "path", "tree", "nodes", "frontier", "frontier given up", "start")
    assert {f"robot 0: {kind}" for kind in own} <= names
    assert {"free space", "obstacles", "heading", "legend", "scale bar"} <= names


def test_ids_are_unique(museum):
    ids = re.findall(r' id="([^"]+)"', tree_svg(team(museum, museum)))
    assert len(ids) == len(set(ids)) > 100


def test_every_node_edge_and_region_is_drawn_in_its_place(museum):
    found = layers(tree_svg(museum))
    nodes = [event for event in museum.events if isinstance(event, NodeAdded)]
    places = {(node.robot, node.serial): node.configuration[:2] for node in nodes}
    edges = [(places[n.parent], n.configuration[:2]) for n in nodes if n.parent is not None]
    np.testing.assert_allclose(lines(paths(found["robot 0: tree"])), edges, atol=0.51e-3)
    regions = found["robot 0: regions"].findall(SVG + "path")
    assert len(regions) == len(nodes)
    for node, region in zip(nodes, regions, strict=True):
        drawn = shapely.Polygon(lines(region.get("d", ""))[0])
        true = shapely.Polygon(node.boundary)
        assert drawn.symmetric_difference(true).area < 0.003 * true.length
    assert paths(found["robot 0: nodes"]).count("M") == len(nodes)
    discs = paths(found["robot 0: nodes"]).split("M")
    drawn = [re.match(r"(-?[\d.]+) ?(-?[\d.]+)a([\d.]+)", disc) for disc in discs]
    centres = [(float(m[1]) + float(m[3]), float(m[2])) for m in drawn if m]
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


@pytest.mark.parametrize("strategy", ["srt-radial", "srt-star"])
def test_a_node_costs_less_than_a_kilobyte(strategy):
    recording = run(environment("museum"), strategy=strategy, seed=2)
    nodes = sum(isinstance(event, NodeAdded) for event in recording.events)
    assert len(tree_svg(recording).encode()) < 20_000 + 1_000 * nodes


def test_all_numbers_are_numbers(cut_off, one_node):
    for recording in (cut_off, one_node, team(cut_off, cut_off)):
        for element in ET.fromstring(tree_svg(recording)).iter():
            for value in element.attrib.values():
                assert not re.search(r"\b(nan|inf)\b|\de[-+]?\d", value.lower())


# Frontier


def test_a_run_that_is_cut_off_shows_its_frontier(cut_off, museum):
    assert cut_off.footer.outcome == "out_of_time"
    frontier = lines(paths(layers(tree_svg(cut_off))["robot 0: frontier"]))
    length = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in frontier)
    said = re.findall(r"([\d.]+) m of open frontier left", texts(tree_svg(cut_off))[1])
    assert length == pytest.approx(float(said[0]), abs=0.1)
    assert length > 10
    assert "open frontier" in texts(tree_svg(cut_off))
    assert paths(layers(tree_svg(museum))["robot 0: frontier"]) == ""
    assert "open frontier" not in texts(tree_svg(museum))


def test_where_a_robot_was_cut_off_is_marked(cut_off, museum):
    assert "robot 0: end" in layers(tree_svg(cut_off))
    assert "robot 0: end" not in layers(tree_svg(museum))


def test_the_computed_frontier_is_that_reported_by_the_robot(stalled, museum):
    for recording in (stalled, museum):
        said = next(event.frontier for event in recording.events if isinstance(event, Ended))
        silent = replace(
            recording, events=tuple(e for e in recording.events if not isinstance(e, Ended))
        )
        assert remaining_frontier(recording) == {0: said}
        assert set(remaining_frontier(silent)[0]) == set(said)
    assert stalled.footer.outcome == "stalled"


def test_closed_arcs_are_drawn_by_reason_and_are_no_frontier(cut_off):
    left = remaining_frontier(cut_off)[0]
    arcs = {n: [] for n in range(100)}
    boundaries = {
        e.serial: shapely.LinearRing(e.boundary) for e in cut_off.events if isinstance(e, NodeAdded)
    }
    for segment in left:
        middle = shapely.Point((segment[0] + segment[2]) / 2, (segment[1] + segment[3]) / 2)
        node = min(boundaries, key=lambda k: boundaries[k].distance(middle))
        arcs[node].append(segment)
    node, arc = next((n, tuple(a)) for n, a in arcs.items() if a)
    closing = ArcClosed(time_s=60.0, robot=0, node=(0, node), reason="not reachable", arc=arc)
    closed = replace(cut_off, events=(*cut_off.events, closing))
    assert set(remaining_frontier(closed)[0]) == set(left) - set(arc)
    svg = tree_svg(closed)
    drawn = layers(svg)["robot 0: frontier given up"].findall(SVG + "path")
    assert len(drawn) == 1
    assert drawn[0].get("stroke-dasharray")
    assert "frontier given up: not reachable" in texts(svg)


# Teams


def test_teams_have_layers_colours_and_numbers_for_every_robot(cut_off):
    other = run(environment("museum"), seed=2, start=(3.0, 12.0), max_time_s=60.0)
    svg = tree_svg(team(cut_off, other, cut_off))
    found = layers(svg)
    strokes = {found[f"robot {k}: tree"].get("stroke") for k in range(3)}
    assert len(strokes) == 3
    assert [t for t in texts(svg) if t.isdigit()] == ["0", "1", "2"]
    numbers = [found[f"robot {k}: start"].find(SVG + "text") for k in range(3)]
    assert all(re.search(r"scale\((\S+) -\1\)$", t.get("transform", "")) for t in numbers)
    assert len([t for t in texts(svg) if re.fullmatch(r"\d: \d+ nodes, \d+ m", t)]) == 3


def test_nodes_in_the_tree_of_another_hang_there(support):
    svg = tree_svg(support)
    own, other = layers(svg)["robot 0: tree"].findall(SVG + "path")
    assert [own.get("id"), other.get("id")] == [
        "robot-0-edges-in-tree-0",
        "robot-0-edges-in-tree-1",
    ]
    np.testing.assert_allclose(lines(own.get("d", "")), [(A, B)])
    np.testing.assert_allclose(lines(other.get("d", "")), [(E, F)])
    np.testing.assert_allclose(lines(paths(layers(svg)["robot 1: tree"])), [(C, D), (D, E)])
    assert "0: 3 nodes, 23 m" in texts(svg)
    assert "1: 3 nodes, 16 m" in texts(svg)


def test_bridges_are_paths_between_nodes_without_an_edge(support):
    svg = tree_svg(support)
    np.testing.assert_allclose(lines(paths(layers(svg)["robot 0: bridges"])), [(B, E)])
    assert "robot 1: bridges" not in layers(svg)
    assert "bridge between two nodes" in texts(svg)
    assert "path off the tree" not in texts(svg)


def test_moves_to_support_others_are_dashed_and_drawn_once(support):
    found = layers(tree_svg(support))
    (line,) = lines(paths(found["robot 0: supporting moves"]))
    np.testing.assert_allclose(line, [A, B, E, F])
    assert found["robot 0: supporting moves"].get("stroke-dasharray")
    assert "robot 1: supporting moves" not in found


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


def test_a_robot_that_is_alone_needs_no_numbers_and_no_areas(museum):
    found = layers(tree_svg(museum))
    assert not {"robot 0: seen first", "swatches"} & set(found)
    assert found["robot 0: start"].find(SVG + "text") is None


boxes = st.tuples(
    st.integers(0, 20), st.integers(0, 20), st.integers(1, 9), st.integers(1, 9), st.integers(0, 3)
)


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


def test_a_death_is_marked_by_number_and_in_the_heading():
    events = [
        node(0.0, 0, 0, A),
        node(0.0, 1, 0, C),
        motion(1.0, 1, C, D),
        Died(time_s=2.0, robot=1, configuration=(*D, 0.0), doing="moving"),
    ]
    svg = tree_svg(recorded([A, C], events))
    found = layers(svg)
    halo, cross = found["robot 1: death"].findall(SVG + "path")
    np.testing.assert_allclose([line.mean(axis=0) for line in lines(cross.get("d", ""))], [D, D])
    assert halo.get("d") == cross.get("d")
    assert found["robot 1: death"].findtext(SVG + "text") == "1"
    assert "robot 1: end" not in found
    assert "robot 0: death" not in found
    assert "died: robot 1 at 2 s" in texts(svg)
    assert "death" in texts(svg)


def test_protective_stops_and_late_starts_are_marked():
    stop = Blocked(time_s=2.0, robot=0, by=1, configuration=(*B, 0.0))
    events = [
        node(0.0, 0, 0, A),
        motion(1.0, 0, A, B),
        stop,
        stop,
        Joined(time_s=40.0, robot=1),
        node(40.0, 1, 0, C),
    ]
    late = LateStart(robot=1, time_s=40.0)
    svg = tree_svg(recorded([A, C], events, faults=(late,)))
    found = layers(svg)
    (octagon,) = lines(paths(found["robot 0: protective stops"]))
    assert len(octagon) == 8
    np.testing.assert_allclose(octagon.mean(axis=0), B, atol=1e-3)
    assert found["robot 0: start"].get("fill") != found["robot 1: start"].get("fill")
    assert {"protective stop", "late start"} <= set(texts(svg))
    assert "joined late: robot 1 at 40 s" in texts(svg)


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


def crowd(robots: int, apart_m: float) -> str:
    starts = [(1.0 + apart_m * (k % 16), 1.0 + apart_m * (k // 16)) for k in range(robots)]
    world = Environment("square", shapely.box(0, 0, 100, 60))
    return tree_svg(recorded(starts, [], world))


def test_legends_of_large_teams_stay_short():
    small, large = crowd(16, 3.0), crowd(64, 3.0)
    accounts = [t for t in texts(small) if re.fullmatch(r"\d+: 0 nodes, 0 m", t)]
    assert len(accounts) == 16
    swatches = layers(large)["swatches"]
    assert [t.text for t in swatches.iter(SVG + "text")][1:] == [str(k) for k in range(64)]
    assert len(swatches.findall(SVG + "path")) == 2 * 64
    rows = {t.get("y") for t in swatches.iter(SVG + "text")}
    assert len(rows) <= 6
    right = max(float(t.get("x", "")) for t in swatches.iter(SVG + "text"))
    page = ET.fromstring(large)
    assert right + 5 < float(page.get("width", "").removesuffix("mm"))
    assert float(page.get("height", "").removesuffix("mm")) < 240


@pytest.mark.parametrize("apart_m", [1.0, 2.0, 5.0])
def test_numbers_at_crowded_starts_do_not_cover_one_another(apart_m):
    found = layers(crowd(64, apart_m))
    discs = []
    for robot in range(64):
        (pin,) = lines(paths(found[f"robot {robot}: start"]))
        discs.append(shapely.Polygon(pin).centroid.buffer(np.ptp(pin[:, 1]) / 2))
    pairs = shapely.STRtree(discs).query(discs, predicate="intersects").T
    assert all(a == b for a, b in pairs.tolist())


def test_the_frontier_of_an_isolated_robot_bounds_its_area(cut_off):
    seen = shapely.union_all(
        [shapely.Polygon(e.boundary) for e in cut_off.events if isinstance(e, NodeAdded)]
    )
    walls = cut_off.environment().free.boundary
    for x0, y0, x1, y1 in remaining_frontier(cut_off)[0]:
        middle = shapely.Point((x0 + x1) / 2, (y0 + y1) / 2)
        assert seen.boundary.distance(middle) < 1e-6
        assert walls.distance(middle) > 1e-6


def test_a_frontier_that_another_robot_has_seen_is_none(cut_off):
    everything = run(environment("museum"), seed=2)
    assert len(remaining_frontier(cut_off)[0]) > 10
    assert remaining_frontier(team(cut_off, everything)) == {0: (), 1: ()}


def test_the_last_report_of_a_robot_counts(support):
    assert remaining_frontier(support) == {0: (), 1: ()}
    early = replace(support, events=support.events[:11])
    assert remaining_frontier(early) == {0: ((9.0, 1.0, 9.0, 5.0),), 1: ()}


def test_going_on_after_an_end_withdraws_its_report(support):
    dying = Died(time_s=13.0, robot=0, configuration=(*F, 0.0), doing="waiting")
    dead = replace(support, events=(*support.events[:-2], dying))
    # Nobody saw the hall's upper wall.
    left = remaining_frontier(dead)
    assert left[1] == ()
    seen = shapely.union_all(
        [shapely.Polygon(e.boundary) for e in dead.events if isinstance(e, NodeAdded)]
    )
    assert left[0]
    for x0, y0, x1, y1 in left[0]:
        middle = shapely.Point((x0 + x1) / 2, (y0 + y1) / 2)
        assert seen.boundary.distance(middle) < 1e-6
        assert shapely.box(1e-6, 1e-6, 20 - 1e-6, 8 - 1e-6).contains(middle)


@pytest.mark.parametrize(
    "reason", ["too narrow", "not reachable", "seen from near", "blocked by a robot"]
)
def test_an_arc_that_any_robot_gave_up_counts_as_closed(reason):
    events = [node(0.0, 0, 0, A), node(0.0, 1, 0, C)]
    arc = remaining_frontier(recorded([A, C], events))[0]
    assert arc
    closing = ArcClosed(time_s=1.0, robot=1, node=(0, 0), reason=reason, arc=arc)
    closed = recorded([A, C], [*events, closing])
    assert remaining_frontier(closed)[0] == ()
    assert remaining_frontier(closed)[1] != ()
    svg = tree_svg(closed)
    assert f"frontier given up: {reason}" in texts(svg)
    assert len(layers(svg)["robot 1: frontier given up"]) == 1


def test_sixty_four_robots_differ():
    looks = {(s.stroke, s.dashes_mm) for s in (RobotStyles.of(k).edge for k in range(64))}
    assert len(looks) == 64
    assert RobotStyles.of(64) == RobotStyles.of(0)
    assert len({RobotStyles.of(k).area.fill for k in range(32)}) == 32
    assert len({RobotStyles.of(k).edge.dashes_mm for k in range(8)}) == 8


def test_colours_of_neighbours_differ_without_seeing_green():
    # Machado, Oliveira and Fernandes 2009: deuteranopia, on linear RGB.
    deuteranopia = np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    )
    rgb = np.array([[int(c[i : i + 2], 16) / 255 for i in (1, 3, 5)] for c in ROBOT_COLOURS])
    seen = np.clip((rgb**2.2) @ deuteranopia.T, 0, 1) ** (1 / 2.2)
    apart = np.linalg.norm(seen - np.roll(seen, 1, axis=0), axis=1)
    assert apart.min() > 0.15


# Odd worlds and odd recordings


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


@pytest.mark.parametrize(
    "name",
    [
        "<b>&amp;\"'</b>]]>",
        "caf\u00e9 \u5730\u56f3 \U0001f916",
        "a\nb\tc",
        "\x00\x07\x1b",
        "\ud800",
        "",
        "x" * 5000,
    ],
)
def test_any_name_gives_valid_xml(name, one_node):
    header = msgspec.structs.replace(one_node.header, world=name)
    svg = tree_svg(replace(one_node, header=header))
    ET.fromstring(svg.encode())
    ET.fromstring(environment_svg(Environment(name, shapely.box(0, 0, 1, 1))).encode())


def test_special_letters_are_escaped_and_kept(one_node):
    header = msgspec.structs.replace(one_node.header, world="<R&D> \u5730\u56f3")
    svg = tree_svg(replace(one_node, header=header))
    assert texts(svg)[0] == "srt-radial in <R&D> \u5730\u56f3, seed 0"
    assert "&lt;R&amp;D&gt;" in svg


@pytest.mark.parametrize(
    "free",
    [
        shapely.box(-500, 2, 500, 3),
        shapely.box(-3, -4000, -2, 4000),
        shapely.box(0, 0, 0.02, 0.01),
        shapely.box(-9e6, -9e6, 9e6, 9e6),
        shapely.box(8_000_000.25, 9_000_000.5, 8_000_020, 9_000_010),
        shapely.MultiPolygon([shapely.box(0, 0, 1, 1), shapely.box(2, 0, 3, 5)]),
    ],
    ids=["wide", "tall", "tiny", "huge", "far", "parts"],
)
def test_worlds_of_any_size_and_place(free):
    x, y = (
        free.geoms[0].centroid.coords[0]
        if free.geom_type == "MultiPolygon"
        else (free.centroid.coords[0])
    )
    world = Environment("odd", free, starts=[(x, y)])
    svg = environment_svg(world)
    x0, y0, x1, y1 = world.bounds
    root, found = ET.fromstring(svg), layers(svg)
    shift = re.findall(r"metres from \((\S+), (\S+)\)", root.findtext(SVG + "desc", ""))
    ox, oy = map(float, shift[0]) if shift else (0.0, 0.0)
    origin = np.array([ox, oy])
    step = max(x1 - x0, y1 - y0) / 5000
    _frame, *rings = lines(paths(found["obstacles"]))
    drawn = [shapely.Polygon(ring + origin) for ring in rings]
    assert len(drawn) == len(world.free.geoms)
    for part, polygon in zip(world.free.geoms, drawn, strict=True):
        np.testing.assert_allclose(polygon.bounds, part.bounds, rtol=0, atol=step)
    place = lines(paths(found["suggested starts"]))[0].mean(axis=0) + origin
    np.testing.assert_allclose(place, (x, y), rtol=0, atol=step)
    left, bottom = on_page(svg, x0 - ox, y0 - oy)
    right, top = on_page(svg, x1 - ox, y1 - oy)
    _, _, width, height = map(float, root.get("viewBox", "").split())
    assert 0 < left < right < width
    assert 0 < top < bottom < height
    assert float(root.get("width", "").removesuffix("mm")) < 300
    assert float(root.get("height", "").removesuffix("mm")) < 300


def test_coordinates_stay_small_where_the_world_is_far_away():
    far = Environment("far", shapely.box(5e6, 7e6, 5e6 + 3, 7e6 + 2))
    recording = run(far, start=(5e6 + 1, 7e6 + 1))
    for path in layers(tree_svg(recording))["map"].iter(SVG + "path"):
        assert max(abs(float(v)) for v in re.findall(r"[\d.]+", path.get("d", "0"))) < 100


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robot": 3}, "tells of robot 3, but its team has 1"),
        ({"parent": (0, 77)}, "node 77 of robot 0, which it has not told of"),
        ({"parent": (5, 0)}, "node 0 of robot 5, which it has not told of"),
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


# The world alone


def test_the_picture_of_a_world():
    hall = Environment.from_outline(
        "hall", shapely.box(0, 0, 10, 10), [shapely.box(4, 4, 6, 6)], starts=[(1, 2)]
    )
    svg = environment_svg(hall)
    assert texts(svg)[:2] == ["hall", "10 m x 10 m, 96 m² free"]
    assert {"obstacle", "free space", "suggested start"} <= set(texts(svg))
    rings = [shapely.Polygon(ring) for ring in lines(paths(layers(svg)["obstacles"]))]
    assert sorted(ring.area for ring in rings)[:2] == pytest.approx([4.0, 100.0])


def test_worlds_in_parts_say_so():
    parts = shapely.MultiPolygon([shapely.box(0, 0, 1, 1), shapely.box(2, 0, 3, 1)])
    assert texts(environment_svg(Environment("two", parts)))[1].endswith("in 2 separate parts")


def test_save_environment_svg(tmp_path):
    world = environment("cave")
    save_environment_svg(world, tmp_path / "cave.svg")
    assert (tmp_path / "cave.svg").read_text(encoding="utf-8") == environment_svg(world)


# Writing


@given(st.integers(-(10**9), 10**9), st.integers(0, 6))
def test_numbers_are_exact(steps, decimals):
    assert float(number(steps, decimals)) == pytest.approx(steps / 10**decimals, rel=1e-15)


@given(st.floats(-1e9, 1e9).filter(lambda v: v == 0.0 or abs(v) > 1e-9))
def test_plain_numbers_have_no_exponent(value):
    assert re.fullmatch(r"-?\d*\.?\d+", plain(value))
    assert float(plain(value)) == pytest.approx(value, rel=1e-7)


@given(st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=2, max_size=200))
def test_rounding_does_not_add_up_along_a_line(points):
    drawn = lines(Pen(decimals=2).line(points))[0]
    distances = shapely.distance(shapely.points(points), shapely.MultiPoint(drawn))
    assert distances.max() < 0.0071
    np.testing.assert_allclose(drawn[[0, -1]], np.asarray(points)[[0, -1]], atol=0.00501)


def test_rings_below_the_rounding_are_left_out():
    pen = Pen(decimals=1)
    assert pen.rings([[(0, 0), (0.01, 0), (0.01, 0.01), (0, 0)]]) == ""
    assert pen.rings([[(0, 0), (2, 0), (2, 1), (0, 0)]]) == "M0 0l2 0 0 1z"


@given(st.floats(1e-6, 1e7))
def test_scale_bars_are_round_and_long_enough(longest):
    length = round_length(longest)
    assert longest / 2.5 <= length * (1 + 1e-12)
    assert length <= longest
    assert f"{length:e}"[0] in "125"


@given(st.text(max_size=300))
def test_wrapped_text_fits(text):
    for line in wrapped(text, 3.0, 60.0):
        assert text_width(line, 3.0) <= 60.0


def test_no_two_words_are_lost_in_wrapping():
    text = "a run that stalled because " + "x" * 90 + " could not be reached"
    assert "".join(wrapped(text, 3.0, 60.0)).replace(" ", "") == text.replace(" ", "")


def test_bundled_worlds_are_drawn(tmp_path: Path):
    for name in ("apartment", "clinic", "workshop"):
        svg = environment_svg(environment(name))
        assert ET.fromstring(svg).tag == SVG + "svg"
        assert len(svg) < 60_000


def test_inline_worlds_keep_their_name():
    spec = RunSpec(
        environment=InlineEnvironment(name="cell", wkt="POLYGON((0 0,3 0,3 2,0 2,0 0))"),
        robots=(RobotSpec(start=(1.0, 1.0)),),
    )
    assert texts(tree_svg(simulate(spec)))[0] == "srt-radial in cell, seed 0"


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
    (way,) = lines(paths(found["robot 0: path"]))
    np.testing.assert_allclose(way, [A, B, (7.0, 3.0)], atol=0.01)
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


def test_pictures_of_scans_repeat(bidding):
    assert tree_svg(bidding) == tree_svg(bidding)


def test_an_option_that_is_no_length_is_refused(bidding):
    spec = msgspec.structs.replace(bidding.spec, options={"cell_m": "wide"})
    bad = replace(bidding, header=msgspec.structs.replace(bidding.header, spec=spec))
    with pytest.raises(InvalidInputError, match="option cell_m"):
        tree_svg(bad)
