"""Known maps, trees and trajectories of runs, read by readers that know nothing of runs."""

import csv
import hashlib
import io
import itertools
import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ET

import ezdxf
import numpy as np
import pytest
import shapely
import trimesh
import yaml
from PIL import Image

import multisrt as ms
from multisrt.analysis.known_maps import known_regions
from multisrt.analysis.poses import poses
from multisrt.environments import read_environment
from multisrt.events import Motion, NodeAdded
from multisrt.exporting import MapOptions, known_map, save_map, save_world
from multisrt.exporting.drawings import dxf_bytes
from multisrt.exporting.trajectories import pose_rows
from multisrt.exporting.trees import exploration_tree

CELL_M = 0.1


@pytest.fixture(scope="module")
def bidders() -> ms.Run:
    """Two robots that bid for frontiers, whose scans form no tree."""
    return ms.explore("apartment", robots=2, strategy="minpos", seed=1, max_time_s=20.0)


def union_of(run, robot, time_s):
    """What a robot, or the team, knew, by the analysis of known maps."""
    known = known_regions(run.recording, run.environment)
    lists = known if robot is None else [known[robot]]
    regions = [region for one in lists for region in one if region.time_s <= time_s]
    polygons = shapely.make_valid(
        np.array([shapely.Polygon(region.corners) for region in regions], np.object_)
    )
    return shapely.union_all(polygons)


# Known maps


@pytest.mark.parametrize("robot", [None, 0, 3])
@pytest.mark.parametrize("time_s", [2.0, 10.0, 30.0])
def test_the_known_map_is_the_union_of_known_regions(team, robot, time_s):
    found = known_map(team.recording, robot=robot, time_s=time_s)
    expected = union_of(team, robot, time_s)
    assert found.free.symmetric_difference(expected).area < 1e-3
    inside = [s for s in team.recording.starts if shapely.contains_xy(found.free, s.x, s.y)]
    assert found.starts == tuple((start.x, start.y) for start in inside)
    assert inside


def test_maps_grow_and_the_team_knows_what_its_robots_know(team):
    areas = [team.known_map(time_s=time_s).area_m2 for time_s in (1.0, 8.0, 16.0, 30.0)]
    assert areas == sorted(areas)
    assert areas[0] < areas[-1] == team.known_map().area_m2
    alone = [team.known_map(robot=robot).free for robot in range(4)]
    assert shapely.union_all(alone).symmetric_difference(team.known_map().free).area < 1e-3


@pytest.mark.parametrize("strategy", ["srt-radial", "minpos"])
def test_images_of_known_maps_have_unknown_cells(team, bidders, strategy, tmp_path):
    run = team if strategy == "srt-radial" else bidders
    save_map(
        run.recording, tmp_path / "a.yaml", robot=1, time_s=12.0, options=MapOptions(cell_m=CELL_M)
    )
    pixels = np.asarray(Image.open(tmp_path / "a.pgm"))
    assert set(np.unique(pixels)) == {0, 205, 254}
    entries = yaml.safe_load((tmp_path / "a.yaml").read_text())
    x0, y0, _ = entries["origin"]
    row, column = np.nonzero(np.ones_like(pixels))
    x, y = (
        x0 + CELL_M * (column + 0.5),
        y0 + CELL_M * (len(pixels) - row - 0.5),
    )
    known = union_of(run, 1, 12.0)
    free = pixels.ravel() == 254
    assert shapely.contains_xy(known.buffer(1e-6), x[free], y[free]).all()
    # Every centre inside that no wall is near is free, and no unknown cell is inside.
    inside = shapely.contains_xy(known.buffer(-1.5 * CELL_M), x, y)
    assert free[inside].all()
    walls = pixels.ravel() == 0
    points = shapely.points(x[walls], y[walls])
    assert shapely.distance(points, run.environment.free.boundary).max() < CELL_M
    again = read_environment(tmp_path / "a.yaml")
    assert again.free.symmetric_difference(known).area < CELL_M * known.length


@pytest.mark.parametrize("suffix", [".geojson", ".wkt"])
def test_texts_of_known_maps_are_read_back(team, suffix, tmp_path):
    path = tmp_path / f"known{suffix}"
    team.save_map(path, robot=2, time_s=9.0)
    found = read_environment(path)
    expected = team.known_map(robot=2, time_s=9.0)
    assert found.free.symmetric_difference(expected.free).area < 1e-9
    assert found.starts == (expected.starts if suffix == ".geojson" else ())


def test_solids_of_known_maps_have_walls_where_they_were_seen(team, tmp_path):
    team.save_map(tmp_path / "k.glb", time_s=10.0, options=MapOptions(height_m=2.0))
    scene = trimesh.load_scene(tmp_path / "k.glb")
    assert all(solid.is_watertight for solid in scene.geometry.values())
    assert set(scene.geometry) >= {"walls", "floor", "robot_3_paths"}
    walls = scene.geometry["walls"]
    # On the ground, y of the world is -z of the file.
    ground = shapely.points(walls.vertices[:, 0], -walls.vertices[:, 2])
    assert shapely.distance(ground, team.environment.free.boundary).max() < 0.2
    seen_m = team.known_map(time_s=10.0).free.boundary.intersection(
        team.environment.free.boundary.buffer(1e-3)
    )
    assert walls.volume == pytest.approx(2.0 * 0.1 * seen_m.length, rel=0.15)


def test_lines_of_solids_can_be_left_out(team, tmp_path):
    save_world(team.recording, tmp_path / "w.glb", without=["paths"])
    names = set(trimesh.load_scene(tmp_path / "w.glb").geometry)
    assert {name.rpartition("_")[2] for name in names} == {"walls", "floor", "edges"}
    save_world(team.recording, tmp_path / "w.stl", without=["paths", "edges"])
    bare = trimesh.load_mesh(tmp_path / "w.stl")
    save_world(team.recording, tmp_path / "t.stl")
    whole = trimesh.load_mesh(tmp_path / "t.stl")
    assert bare.is_watertight
    assert whole.is_watertight
    assert whole.volume > bare.volume
    with pytest.raises(ms.InvalidInputError, match="did you mean 'edges'"):
        save_world(team.recording, tmp_path / "x.stl", without=["edge"])


def test_the_world_of_a_run_has_the_starts_of_its_robots(team, tmp_path):
    save_world(team.recording, tmp_path / "w.geojson")
    found = read_environment(tmp_path / "w.geojson")
    assert found.digest == team.environment.digest
    assert found.starts == tuple((start.x, start.y) for start in team.recording.starts)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"robot": 4}, "there is no robot 4: the run has robots 0 to 3"),
        ({"robot": -1}, "there is no robot -1"),
        ({"time_s": 31.0}, "the run lasts from 0 to 30.00 s; there is no 31 s"),
        ({"time_s": -0.1}, "there is no -0.1 s"),
        ({"time_s": float("nan")}, "there is no nan s"),
        ({"robot": 1, "time_s": 1.0}, "robot 1 knew nothing yet at 1 s"),
    ],
)
def test_unknown_robots_and_times_are_refused(team, given, said, tmp_path):
    with pytest.raises(ms.InvalidInputError, match=said):
        team.save_map(tmp_path / "a.yaml", **given)
    assert list(tmp_path.iterdir()) == []


# Trees

GRAPHML = "{http://graphml.graphdrawing.org/xmlns}"


def parsed_graphml(path):
    """Return the nodes with their attributes and the edges of a GraphML file."""
    root = ET.parse(path).getroot()
    types = {"double": float, "int": int, "string": str}
    keys = {
        key.get("id"): (key.get("attr.name"), types[str(key.get("attr.type"))])
        for key in root.iter(f"{GRAPHML}key")
    }
    nodes = {}
    for node in root.iter(f"{GRAPHML}node"):
        values = {}
        for data in node.iter(f"{GRAPHML}data"):
            name, kind = keys[data.get("key")]
            values[name] = kind(str(data.text))
        nodes[node.get("id")] = values
    edges = [(edge.get("source"), edge.get("target")) for edge in root.iter(f"{GRAPHML}edge")]
    return nodes, edges


def test_graphml_has_every_node_and_edge(team, tmp_path):
    team.save_trees(tmp_path / "t.graphml")
    nodes, edges = parsed_graphml(tmp_path / "t.graphml")
    made = team.recording.of(NodeAdded)
    assert list(nodes) == [f"r{node.robot}n{node.serial}" for node in made]
    assert list(nodes.values()) == [
        {
            "x": node.configuration[0],
            "y": node.configuration[1],
            "heading": node.configuration[2],
            "time": node.time_s,
            "robot": node.robot,
            "kind": node.stage,
        }
        for node in made
    ]
    assert edges == [
        ("r{}n{}".format(*node.parent), f"r{node.robot}n{node.serial}")
        for node in made
        if node.parent is not None
    ]
    # A forest: every node but the roots has one parent.
    assert len({child for _, child in edges}) == len(edges) == len(nodes) - 4


def test_networkx_reads_the_graph(team, tmp_path):
    networkx = pytest.importorskip("networkx")
    team.save_trees(tmp_path / "t.graphml", robot=3)
    graph = networkx.read_graphml(tmp_path / "t.graphml")
    assert networkx.is_arborescence(graph)
    assert isinstance(graph.nodes["r3n0"]["x"], float)


def test_trees_of_one_robot_at_a_time(team, tmp_path):
    team.save_trees(tmp_path / "t.graphml", robot=3, time_s=12.0)
    nodes, _ = parsed_graphml(tmp_path / "t.graphml")
    assert {node["robot"] for node in nodes.values()} == {3}
    assert max(node["time"] for node in nodes.values()) <= 12.0
    assert len(nodes) < len(exploration_tree(team.recording, robot=3).nodes)
    with pytest.raises(ms.InvalidInputError, match="robot 1 made no node by 1 s"):
        team.save_trees(tmp_path / "x.graphml", robot=1, time_s=1.0)


def test_geojson_of_trees_has_points_and_lines(team, tmp_path):
    team.save_trees(tmp_path / "t.geojson")
    features = json.loads((tmp_path / "t.geojson").read_text())["features"]
    tree = exploration_tree(team.recording)
    points = {
        feature["properties"]["name"]: feature["geometry"]["coordinates"]
        for feature in features
        if feature["geometry"]["type"] == "Point"
    }
    lines = [feature for feature in features if feature["geometry"]["type"] == "LineString"]
    assert (len(points), len(lines)) == (len(tree.nodes), len(tree.edges))
    for line in lines:
        ends = [points[line["properties"][end]] for end in ("source", "target")]
        assert line["geometry"]["coordinates"] == ends


def test_scans_of_bidders_have_no_edges(bidders, tmp_path):
    bidders.save_trees(tmp_path / "t.graphml")
    nodes, edges = parsed_graphml(tmp_path / "t.graphml")
    assert edges == []
    assert {node["kind"] for node in nodes.values()} == {"root", "scan"}


# Trajectories


def test_waypoints_are_those_of_the_data_frame(team, tmp_path):
    team.save_trajectories(tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    frame = team.trajectories()
    assert list(rows[0]) == list(frame.columns)
    for name in ("robot", "time_s", "x_m", "y_m", "heading_rad"):
        assert [float(row[name]) for row in rows] == frame[name].tolist()
    assert [row["purpose"] or None for row in rows] == frame["purpose"].tolist()


@pytest.mark.parametrize("rate_hz", [0.7, 10.0])
def test_samples_lie_where_robots_were(team, rate_hz):
    rows = pose_rows(team.recording, rate_hz=rate_hz)
    bare = pose_rows(team.recording)
    assert set(bare) < set(rows)
    for robot in range(4):
        own = [row for row in rows if row.robot == robot]
        times = np.array([row.time_s for row in own])
        assert (np.diff(times) >= 0.0).all()
        expected = poses(team.recording, times)[robot]
        found = np.array([row[2:5] for row in own])
        assert np.abs(found[:, :2] - expected[:, :2]).max() < 1e-9
    for a, b in itertools.pairwise(rows):
        if (a.robot, a.motion) == (b.robot, b.motion) and a[2:5] != b[2:5]:
            assert b.time_s - a.time_s <= 1.0 / rate_hz + 1e-9


def test_tum_files_hold_places_and_headings(team, tmp_path):
    files = team.save_trajectories(tmp_path / "run.tum", rate_hz=5.0)
    assert [file.name for file in files] == [f"run-{robot}.tum" for robot in range(4)]
    for robot, file in enumerate(files):
        values = np.loadtxt(file, ndmin=2)
        assert values.shape[1] == 8
        times = values[:, 0]
        assert (np.diff(times) > 0.0).all()
        assert (values[:, 3:6] == 0.0).all()
        assert np.linalg.norm(values[:, 4:], axis=1) == pytest.approx(1.0, abs=1e-8)
        expected = poses(team.recording, times)[robot]
        assert np.abs(values[:, 1:3] - expected[:, :2]).max() < 1e-6
        turn = 2.0 * np.arctan2(values[:, 6], values[:, 7]) - expected[:, 2]
        assert np.abs(np.sin(0.5 * turn)).max() < 1e-6
    last = max(motion.waypoints[-1][0] for motion in team.recording.of(Motion) if motion.robot == 3)
    assert np.loadtxt(files[3])[-1, 0] == pytest.approx(last, abs=1e-8)
    assert team.save_trajectories(tmp_path / "own.txt", robot=2) == [tmp_path / "own.txt"]


def test_json_has_the_rows_of_the_table(team, tmp_path):
    team.save_trajectories(tmp_path / "a.json", rate_hz=2.0)
    found = json.loads((tmp_path / "a.json").read_text())
    rows = [(robot["robot"], *row) for robot in found["robots"] for row in robot["poses"]]
    assert found["columns"] == ["time_s", "x_m", "y_m", "heading_rad", "motion", "purpose"]
    assert rows == [tuple(row) for row in pose_rows(team.recording, rate_hz=2.0)]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"rate_hz": 0.0}, "above 0 and at most 1000 Hz, not 0"),
        ({"rate_hz": float("nan")}, "not nan"),
        ({"robot": 9}, "there is no robot 9"),
    ],
)
def test_rates_and_robots_out_of_range_are_refused(team, given, said, tmp_path):
    with pytest.raises(ms.InvalidInputError, match=said):
        team.save_trajectories(tmp_path / "a.csv", **given)
    assert list(tmp_path.iterdir()) == []


def test_no_trajectory_is_written_if_one_exists(team, tmp_path):
    (tmp_path / "run-2.tum").write_text("mine")
    with pytest.raises(ms.InvalidInputError, match=r"run-2\.tum exists already"):
        team.save_trajectories(tmp_path / "run.tum")
    assert [file.name for file in tmp_path.iterdir()] == ["run-2.tum"]
    team.save_trajectories(tmp_path / "run.tum", overwrite=True)
    assert len(list(tmp_path.iterdir())) == 4


# Determinism

WRITE = """
import sys
import multisrt as ms
recording, folder = sys.argv[1:]
run = ms.Run(ms.Recording.load(recording))
for suffix in ("yaml", "geojson", "wkt", "svg", "dxf", "stl", "glb"):
    run.save_map(f"{folder}/map.{suffix}", time_s=9.0)
run.save_trees(f"{folder}/tree.graphml")
run.save_trajectories(f"{folder}/run.tum", rate_hz=3.0)
"""


def test_equal_runs_give_equal_bytes_in_other_processes(team, tmp_path):
    team.save_recording(tmp_path / "recording.jsonl")
    digests = []
    for seed in ("1", "2"):
        folder = tmp_path / seed
        folder.mkdir()
        command = [sys.executable, "-c", WRITE, str(tmp_path / "recording.jsonl"), str(folder)]
        subprocess.run(command, check=True, env={**os.environ, "PYTHONHASHSEED": seed})
        files = sorted(folder.iterdir())
        digests.append([(f.name, hashlib.sha256(f.read_bytes()).hexdigest()) for f in files])
    assert len(digests[0]) == 13
    assert digests[0] == digests[1]


def test_files_of_cad_say_nothing_of_when_they_were_written(team):
    document = ezdxf.read(io.StringIO(dxf_bytes(team.environment).decode()))
    assert document.header["$TDUPDATE"] == pytest.approx(2451544.5)  # begin of 2000
    assert ezdxf.options.write_fixed_meta_data_for_testing is False
