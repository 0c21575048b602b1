"""MCAP files, read back by two independent readers and compared with the recording."""

import bisect
import itertools
import json
import math
from dataclasses import fields, is_dataclass

import numpy as np
import pytest
import shapely
import yaml
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import ConnectionExtRosbag2, QosDurability, QosReliability
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import multisrt as ms
from multisrt.events import Died, Joined, Motion, NodeAdded, Sent
from multisrt.explain.srt import explain_all
from multisrt.exporting.ros_definitions import DEFINITIONS, definition_of
from multisrt.planners.motion.trajectory import leg_pose
from tests.multisrt.exporting.conftest import OPTIONS, read_with_mcap, read_with_rosbags

EVERY_S = 1e-9
"""Resolution of stamps."""


def nanoseconds(time_s):
    return round(time_s * 1e9)


def stamp_ns(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


def plain(message):
    # The contents of a message of either reader, for comparison.
    if isinstance(message, np.ndarray | list | tuple | bytes):
        return [plain(item) for item in message] if len(message) < 500 else bytes_of(message)
    if is_dataclass(message):
        names = [field.name for field in fields(message) if not field.name.startswith("__")]
        return {name: plain(getattr(message, name)) for name in names}
    if hasattr(message, "__slots__"):
        return {name: plain(getattr(message, name)) for name in message.__slots__}
    return message.item() if isinstance(message, np.generic) else message


def bytes_of(values):
    if not isinstance(values, np.ndarray) and hasattr(values[0], "__slots__"):
        return [plain(item) for item in values]
    if isinstance(values, np.ndarray) and values.dtype == object:
        return [plain(item) for item in values]
    return np.asarray(values).astype(np.float64).tobytes()


def yaw_of(orientation):
    assert orientation.x == orientation.y == 0.0
    return 2.0 * math.atan2(orientation.z, orientation.w)


def same_angle(one, two):
    return abs(math.remainder(one - two, 2.0 * math.pi)) < 1e-9


def true_pose(recording, robot, time_s):
    """Return where a robot was, from its motions alone."""
    pose = recording.header.starts[robot]
    motions = sorted((m for m in recording.of(Motion) if m.robot == robot), key=lambda m: m.time_s)
    for motion in motions:
        for a, b in itertools.pairwise(motion.waypoints):
            if a[0] <= time_s:
                share = 1.0 if b[0] <= a[0] else min(1.0, (time_s - a[0]) / (b[0] - a[0]))
                pose = leg_pose(a, b, share)
    return pose


def qualities(bag):
    assert isinstance(bag, ConnectionExtRosbag2)
    return bag.offered_qos_profiles


def points_of(marker):
    return np.array([(point.x, point.y) for point in marker.points]).reshape(-1, 2)


def test_two_readers_decode_the_same_messages(team_mcap, messages):
    other = read_with_rosbags(team_mcap)
    assert other.keys() == messages.keys()
    for topic, found in messages.items():
        assert [time for time, _ in found] == [time for time, _ in other[topic]]
        for (_, one), (_, two) in zip(found, other[topic], strict=True):
            assert plain(one) == plain(two)


def test_the_topics_are_those_of_the_page(team, messages):
    own = ("pose", "map", "frontier", "tree", "body")
    expected = {"/tf", "/truth/map", "/links", "/rosout", "/coverage", "/seen"}
    expected |= {f"/robot_{robot}/{name}" for robot in range(4) for name in own}
    expected |= {f"/robot_{motion.robot}/path" for motion in team.recording.of(Motion)}
    assert messages.keys() == expected


def test_messages_stand_in_the_order_of_simulated_time(team, team_mcap, messages):
    with team_mcap.open("rb") as file:
        times = [message.log_time for _, _, message in make_reader(file).iter_messages(None)]
    with team_mcap.open("rb") as file:
        written = make_reader(file).iter_messages(log_time_order=False)
        assert [message.log_time for _, _, message in written] == times
    assert times == sorted(times)
    assert times[0] == 0
    assert times[-1] == nanoseconds(team.recording.footer.time_s)
    for topic, found in messages.items():
        for time, message in found:
            headers = [
                message,
                *getattr(message, "markers", ()),
                *getattr(message, "transforms", ()),
            ]
            for one in headers:
                if hasattr(one, "header"):
                    assert stamp_ns(one.header.stamp) == time, topic


def test_definitions_are_those_of_ros():
    for release in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_LYRICAL):
        theirs = get_typestore(release)
        for name in DEFINITIONS:
            full = name.replace("/", "/msg/")
            ours = get_typestore(Stores.EMPTY)
            ours.register(get_types_from_msg(definition_of(name), full))
            assert ours.hash_rihs01(full) == theirs.hash_rihs01(full), (release, name)


def test_the_file_is_one_of_the_ros2_profile(team_mcap):
    with team_mcap.open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
    assert summary is not None
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
    names = {schema.name for schema in summary.schemas.values()}
    assert all(name.split("/")[1] == "msg" for name in names)
    assert {chunk.compression for chunk in summary.chunk_indexes} == {"zstd"}


def test_maps_and_bodies_are_latched_and_streams_are_not(team_mcap):
    with AnyReader([team_mcap]) as reader:
        quality = {one.topic: qualities(one.ext) for one in reader.connections}
    for topic, profiles in quality.items():
        (profile,) = profiles
        assert profile.reliability == QosReliability.RELIABLE
        latched = topic.endswith(("/map", "/body"))
        assert (profile.durability == QosDurability.TRANSIENT_LOCAL) == latched, topic


def test_the_metadata_of_ros_bag_and_of_the_run_are_there(team, team_mcap, messages):
    with team_mcap.open("rb") as file:
        found = {record.name: record.metadata for record in make_reader(file).iter_metadata()}
    bag = yaml.safe_load(found["rosbag2"]["serialized_metadata"])
    counts = {
        one["topic_metadata"]["name"]: one["message_count"]
        for one in bag["topics_with_message_count"]
    }
    assert counts == {topic: len(own) for topic, own in messages.items()}
    assert bag["message_count"] == sum(counts.values())
    assert bag["duration"]["nanoseconds"] == nanoseconds(team.recording.footer.time_s)
    about = found["multisrt"]
    assert ms.RunSpec.from_json(about["spec"]) == team.spec
    assert about["digest"] == team.digest


@pytest.mark.parametrize("robot", range(4))
def test_poses_are_those_of_the_recording(team, messages, robot):
    recording, found = team.recording, messages[f"/robot_{robot}/pose"]
    for time, message in found:
        x, y, heading = true_pose(recording, robot, time * EVERY_S)
        position = message.pose.position
        # Stamps are rounded to nanoseconds, and robots drive up to 1 m in a second.
        assert math.dist((position.x, position.y), (x, y)) < 1e-8
        assert position.z == 0.0
        assert abs(math.remainder(yaw_of(message.pose.orientation) - heading, 2 * math.pi)) < 1e-7
    stamps = [time for time, _ in found]
    assert len(set(stamps)) == len(stamps)
    # Every waypoint is there, and between waypoints a pose at least each quarter of a second.
    for motion in recording.of(Motion):
        if motion.robot != robot:
            continue
        for a, b in itertools.pairwise(motion.waypoints):
            begin, end = nanoseconds(a[0]), nanoseconds(b[0])
            assert {begin, end} <= set(stamps)
            if a[1:] != b[1:]:
                inside = stamps[
                    bisect.bisect_left(stamps, begin) : bisect.bisect_right(stamps, end)
                ]
                assert max(np.diff(inside), default=0) <= 1e9 / OPTIONS.rate_hz + 1
    assert max(np.diff(stamps)) <= 1e9 + 1


def test_transforms_are_the_poses(messages):
    frames: dict[str, list] = {}
    for time, message in messages["/tf"]:
        (one,) = message.transforms
        assert one.header.frame_id == "map"
        shift, turn = one.transform.translation, one.transform.rotation
        frames.setdefault(one.child_frame_id, []).append((time, shift.x, shift.y, turn.z, turn.w))
    assert frames.keys() == {f"robot_{robot}/base_link" for robot in range(4)}
    for robot in range(4):
        expected = [
            (time, p.position.x, p.position.y, p.orientation.z, p.orientation.w)
            for time, p in ((time, m.pose) for time, m in messages[f"/robot_{robot}/pose"])
        ]
        assert frames[f"robot_{robot}/base_link"] == expected


def test_a_path_is_the_motion_that_begins(team, messages):
    for robot in range(4):
        motions = sorted(
            (m for m in team.recording.of(Motion) if m.robot == robot), key=lambda m: m.time_s
        )
        paths = messages[f"/robot_{robot}/path"]
        assert [time for time, _ in paths] == [nanoseconds(m.time_s) for m in motions]
        for motion, (_, path) in zip(motions, paths, strict=True):
            stamps = [stamp_ns(pose.header.stamp) for pose in path.poses]
            assert stamps == sorted(stamps)
            at = {stamp_ns(pose.header.stamp): pose.pose for pose in path.poses}
            for time_s, x, y, heading in motion.waypoints:
                pose = at[nanoseconds(time_s)]
                assert math.dist((pose.position.x, pose.position.y), (x, y)) < 1e-8
                assert same_angle(yaw_of(pose.orientation), heading)
    # The car drives arcs, which have points between their ends.
    arcs = [m for m in team.recording.of(Motion) if m.robot == 3]
    assert len(messages["/robot_3/path"][0][1].poses) > len(arcs[0].waypoints)


def test_trees_are_the_nodes_and_edges_of_the_recording(team, messages):
    nodes = team.recording.of(NodeAdded)
    places = {(node.robot, node.serial): node.configuration[:2] for node in nodes}
    for robot in range(4):
        own = [node for node in nodes if node.robot == robot]
        shown = messages[f"/robot_{robot}/tree"]
        assert [time for time, _ in shown] == [nanoseconds(node.time_s) for node in own]
        for number, (_, message) in enumerate(shown, 1):
            edges, dots = message.markers
            assert edges.ns == "edges"
            assert points_of(dots).tolist() == [
                list(node.configuration[:2]) for node in own[:number]
            ]
            expected = [
                [places[node.parent], node.configuration[:2]]
                for node in own[:number]
                if node.parent is not None
            ]
            assert np.allclose(points_of(edges), np.array(expected).reshape(-1, 2), atol=0.0)
            # A marker without points is deleted: viewers complain about empty ones.
            assert (edges.action == 2) == (not expected)
    assert (
        sum(
            len(found[-1][1].markers[0].points)
            for topic, found in messages.items()
            if topic.endswith("/tree")
        )
        > 0
    )


def test_bodies_show_what_happened_to_robots(team, messages):
    died, joined = team.recording.of(Died)[0], team.recording.of(Joined)[0]
    at = {robot: [time for time, _ in messages[f"/robot_{robot}/body"]] for robot in range(4)}
    assert at[0] == [0, nanoseconds(died.time_s)]
    assert at[1] == [0, nanoseconds(joined.time_s)]
    assert at[2] == [0, nanoseconds(8.0), nanoseconds(14.0)]
    assert at[3] == [0]
    opacities = [m.markers[0].color.a for _, m in messages["/robot_2/body"]]
    assert opacities == pytest.approx([1.0, 0.4, 1.0])
    for robot, spec in enumerate(team.spec.robots):
        body = messages[f"/robot_{robot}/body"][0][1].markers[0]
        assert body.header.frame_id == f"robot_{robot}/base_link"
        assert body.frame_locked
        triangles = [shapely.Polygon(t) for t in points_of(body).reshape(-1, 3, 2)]
        outline = shapely.Polygon(ms.Footprint.parse(spec.footprint).vertices)
        assert sum(t.area for t in triangles) == pytest.approx(outline.area)
        assert shapely.union_all(triangles).symmetric_difference(outline).area < 1e-9
        assert all(shapely.is_ccw(t.exterior) for t in triangles)


def test_links_are_those_that_the_radio_allows(team, messages):
    recording, world = team.recording, team.environment
    died, joined = recording.of(Died)[0].time_s, recording.of(Joined)[0].time_s
    drawn = 0
    for time, message in messages["/links"]:
        now = time * EVERY_S
        off = {0: now >= died, 1: now < joined, 2: 8.0 <= now < 14.0, 3: False}
        expected = []
        for i, j in itertools.combinations(range(4), 2):
            ends = [true_pose(recording, robot, now)[:2] for robot in (i, j)]
            sight = shapely.LineString(ends)
            if not off[i] and not off[j] and sight.length <= 6.0 and world.free.covers(sight):
                expected.append(ends)
        found = points_of(message.markers[0]).reshape(-1, 2, 2)
        assert np.allclose(found, np.array(expected).reshape(-1, 2, 2), atol=1e-7), now
        drawn += len(found)
    assert drawn > 0
    assert len(messages["/links"]) == math.ceil(recording.footer.time_s) + 1


def test_logged_decisions_are_those_that_why_tells(team, messages):
    for robot in range(4):
        own = [m for _, m in messages["/rosout"] if m.name == f"robot_{robot}"]
        said = [m.msg for m in own if m.msg.startswith("decided: ")]
        texts = [text.removeprefix("decided: ") for text in said]
        lines = explain_all(team.recording, robot).splitlines()[1:]
        assert len(texts) == len(lines)
        assert all(line.endswith(text) for line, text in zip(lines, texts, strict=True))
    warned = {m.msg.split(",")[0].split(" at ")[0] for _, m in messages["/rosout"] if m.level == 30}
    assert {"died", "its radio failed", "its radio works again", "was switched on"} <= warned


def test_coverage_is_that_of_the_metrics(team, messages):
    assert messages["/coverage"][-1][1].data == team.metrics.coverage
    assert messages["/seen"][-1][1].data == team.metrics.seen
    values = [message.data for _, message in messages["/coverage"]]
    assert values == sorted(values)


def test_equal_runs_give_equal_bytes(team, team_mcap, tmp_path):
    # Also under a name that shells and formats might trip over.
    path = tmp_path / 'it\'s a "run" ü [1] % {x}.mcap'
    again = ms.Run(
        ms.Recording(
            header=team.recording.header, events=team.recording.events, footer=team.recording.footer
        )
    )
    again.export(path, OPTIONS)
    assert path.read_bytes() == team_mcap.read_bytes()


def test_odd_names_of_worlds_are_kept(tmp_path):
    name = "näme: \"w\" 'x' \n{y} \\ 世界"
    square = shapely.box(0.0, 0.0, 3.0, 3.0)
    run = ms.explore(ms.Environment(name, shapely.MultiPolygon([square])), max_time_s=2.0)
    run.export(tmp_path / "odd.mcap")
    with (tmp_path / "odd.mcap").open("rb") as file:
        found = {record.name: record.metadata for record in make_reader(file).iter_metadata()}
    assert found["multisrt"]["world"] == name
    assert json.loads(found["multisrt"]["spec"])["environment"]["name"] == name
    assert len(read_with_mcap(tmp_path / "odd.mcap")) == len(
        read_with_rosbags(tmp_path / "odd.mcap")
    )


def test_a_run_with_a_base_station_that_answers_is_exported(tmp_path):
    run = ms.explore("apartment", robots=2, starts="clustered", base=(2.5, 2.0), max_time_s=6.0)
    assert any(event.robot == 2 for event in run.recording.of(Sent)), "the base station sends"
    run.export(tmp_path / "base.mcap", OPTIONS)
    topics = read_with_mcap(tmp_path / "base.mcap")
    assert {topic for topic in topics if "robot" in topic} == {
        topic for topic in topics if topic.startswith(("/robot_0", "/robot_1"))
    }
