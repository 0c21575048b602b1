"""Files of rerun, read back and compared with the MCAP file of the same run."""

import os
import subprocess
import sys
from collections import defaultdict

import numpy as np
import pytest
import shapely
from rerun.chunk import RrdReader

import multisrt as ms
from tests.multisrt.exporting.conftest import OPTIONS

PROGRAM = """
import os, pathlib, sys
import multisrt as ms
ms.Run(ms.Recording.load(sys.argv[1])).export(sys.argv[2])
# Sockets of this process, by their inodes, that are of the internet.
own = pathlib.Path("/proc/self")
held = [os.readlink(fd) for fd in (own / "fd").iterdir() if fd.exists()]
net = [(own / "net" / kind).read_text().split() for kind in ("tcp", "tcp6", "udp", "udp6")]
print([name for name in held if any(name[8:-1] in words for words in net)])
"""


@pytest.fixture(scope="module")
def team_rrd(team, tmp_path_factory):
    path = tmp_path_factory.mktemp("rerun") / "team.rrd"
    team.export(path, OPTIONS)
    return path


@pytest.fixture(scope="module")
def columns(team_rrd):
    return read(team_rrd)


def read(path):
    """Return for each entity and component its rows: time in nanoseconds (or None), values."""
    found: dict[tuple[str, str], list] = defaultdict(list)
    for chunk in RrdReader(path).stream():
        table = chunk.to_record_batch()
        names = table.schema.names
        times = [None] * table.num_rows
        if "sim_time" in names:
            times = table.column("sim_time").cast("int64").to_pylist()
        for name in names:
            if ":" in name:
                rows = zip(times, table.column(name).to_pylist(), strict=True)
                found[chunk.entity_path, name] += [row for row in rows if row[1] is not None]
    return {key: sorted(rows, key=lambda row: row[0] or 0) for key, rows in found.items()}


def test_time_is_simulated_time_alone(team_rrd):
    names = {name for chunk in RrdReader(team_rrd).stream() for name in chunk.timeline_names}
    assert names == {"sim_time"}


def test_poses_are_those_of_the_mcap_file(columns, messages):
    for robot in range(4):
        entity = f"/robots/{robot}/body"
        shifts = columns[entity, "Transform3D:translation"]
        turns = columns[entity, "Transform3D:quaternion"]
        poses = messages[f"/robot_{robot}/pose"]
        assert [time for time, _ in shifts] == [time for time, _ in poses]
        expected = [(p.pose.position.x, p.pose.position.y, 0.0) for _, p in poses]
        assert np.allclose([value[0] for _, value in shifts], expected, atol=1e-5)
        facing = [(0.0, 0.0, p.pose.orientation.z, p.pose.orientation.w) for _, p in poses]
        assert np.allclose([value[0] for _, value in turns], facing, atol=1e-6)


def test_maps_are_those_of_the_mcap_file(columns, messages):
    pairs = [(f"/robots/{robot}/map", f"/robot_{robot}/map") for robot in range(4)]
    for entity, topic in [*pairs, ("/world/truth", "/truth/map")]:
        shown, grids = columns[entity, "GridMap:data"], messages[topic]
        assert len(shown) == len(grids)
        for (time, data), (expected, grid) in zip(shown, grids, strict=True):
            assert time in (None, expected)
            # Images begin at the top, maps of ROS at the bottom.
            rows = np.array(grid.data, np.int8).reshape(grid.info.height, grid.info.width)
            assert bytes(data[0]) == rows[::-1].tobytes()
        info = grids[0][1].info
        image = columns[entity, "GridMap:format"][0][1][0]
        assert (image["width"], image["height"]) == (info.width, info.height)
        (corner,) = columns[entity, "GridMap:translation"][0][1]
        origin = info.origin.position
        assert np.allclose(corner[:2], (origin.x, origin.y), atol=1e-6)


def test_trees_links_and_paths_are_those_of_the_mcap_file(columns, messages):
    for robot in range(4):
        for (time, strips), (expected, markers) in zip(
            columns[f"/robots/{robot}/tree", "LineStrips3D:strips"],
            messages[f"/robot_{robot}/tree"],
            strict=True,
        ):
            assert time == expected
            edges = [(p.x, p.y) for p in markers.markers[0].points]
            found = [point[:2] for strip in strips for point in strip]
            assert np.allclose(np.reshape(found, (-1, 2)), np.reshape(edges, (-1, 2)), atol=1e-5)
    links = [len(strips) for _, strips in columns["/links", "LineStrips3D:strips"]]
    assert links == [len(m.markers[0].points) // 2 for _, m in messages["/links"]]
    path = columns["/robots/3/path", "LineStrips3D:strips"]
    assert [len(strips[0]) for _, strips in path] == [
        len(m.poses) for _, m in messages["/robot_3/path"]
    ]


def test_decisions_and_curves_are_those_of_the_mcap_file(columns, messages):
    for robot in range(4):
        own = [(t, m) for t, m in messages["/rosout"] if m.name == f"robot_{robot}"]
        texts = columns[f"/decisions/{robot}", "TextLog:text"]
        assert sorted((t, value[0]) for t, value in texts) == sorted((t, m.msg) for t, m in own)
    for name in ("coverage", "seen"):
        rows = [(t, value[0]) for t, value in columns[f"/curves/{name}", "Scalars:scalars"]]
        assert rows == [(t, m.data) for t, m in messages[f"/{name}"]]


def test_the_recording_is_named_and_has_a_blueprint(team, team_rrd, columns, tmp_path):
    reader = RrdReader(team_rrd)
    ((store,), (blueprint,)) = reader.recordings(), reader.blueprints()
    assert blueprint.application_id == store.application_id == "multisrt"
    name = columns["/__properties", "RecordingInfo:name"][0][1][0]
    assert name == "srt-radial in apartment, 4 robots, seed 2"
    team.export(tmp_path / "again.rrd", OPTIONS)
    assert [s.recording_id for s in RrdReader(tmp_path / "again.rrd").recordings()] == [
        store.recording_id
    ]
    again = read(tmp_path / "again.rrd")
    assert again == columns


def test_odd_names_of_worlds_and_files_are_kept(tmp_path):
    name = "näme: \"w\" 'x' \n{y} \\ 世界"
    world = ms.Environment(name, shapely.MultiPolygon([shapely.box(0.0, 0.0, 3.0, 3.0)]))
    path = tmp_path / 'it\'s a "run" ü [1] % {x}.rrd'
    ms.explore(world, max_time_s=2.0).export(path)
    assert name in read(path)["/__properties", "RecordingInfo:name"][0][1][0]


def test_a_recorder_that_is_turned_off_is_an_error(team, tmp_path, monkeypatch):
    monkeypatch.setenv("RERUN", "off")
    with pytest.raises(ms.InvalidInputError, match="environment variable RERUN"):
        team.export(tmp_path / "x.rrd", OPTIONS)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="needs /proc")
def test_nothing_is_sent_and_nothing_else_is_written(team, tmp_path):
    team.save_recording(tmp_path / "recording.jsonl")
    home = tmp_path / "home"
    home.mkdir()
    words = [
        sys.executable,
        "-c",
        PROGRAM,
        str(tmp_path / "recording.jsonl"),
        str(tmp_path / "x.rrd"),
    ]
    kept = {"NUMBA_CACHE_DIR", "PYTHONPATH", "PATH"}
    env = {name: value for name, value in os.environ.items() if name in kept}
    found = subprocess.run(
        words,
        env=env | {"HOME": str(home), "XDG_CACHE_HOME": os.path.expanduser("~/.cache")},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert (found.returncode, found.stdout, found.stderr) == (0, "[]\n", "")
    assert not list(home.iterdir())
