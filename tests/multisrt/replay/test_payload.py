import json
import zlib
from base64 import b64decode
from itertools import accumulate

import numpy as np
import pytest
import shapely

from multisrt.analysis.activity import activities
from multisrt.analysis.isolation import isolation
from multisrt.analysis.radio_links import radio_links
from multisrt.analysis.run_tables import coverage_curve
from multisrt.events import Decision, GoalChosen, Learned, Motion, NodeAdded, Sensed, Sent
from multisrt.geometry.errors import InvalidInputError
from multisrt.replay import page, replay_html, save_replay
from multisrt.replay.payload import DETAILS, Detail, compressed, payload
from multisrt.spec import RadioSpec
from tests.multisrt.drawing.recordings import motion, recorded
from tests.multisrt.replay.staged import staged

NAMED = ("robots", "nodes", "scans", "messages", "log", "explanations", "activities", "curves")


def values(differences, per_unit=1):
    return np.array([*accumulate(differences)]) / per_unit


def outlines(packed):
    points = np.column_stack([values(packed["x"], 1000), values(packed["y"], 1000)])
    return np.split(points, np.cumsum(packed["n"])[:-1])


@pytest.fixture(scope="module")
def data(team_run):
    return payload([team_run.recording])["runs"][0]


def test_it_has_all_parts_and_plain_data_only(data):
    assert set(NAMED) <= set(data)
    json.dumps(data, allow_nan=False)


def test_nodes_are_those_of_the_recording(team_run, data):
    nodes = team_run.recording.of(NodeAdded)
    packed = data["nodes"]
    assert packed["robot"] == [node.robot for node in nodes]
    assert values(packed["serial"]).tolist() == [node.serial for node in nodes]
    assert [packed["stages"][k] for k in packed["stage"]] == [node.stage for node in nodes]
    np.testing.assert_allclose(values(packed["t"], 1000), [n.time_s for n in nodes], atol=5.1e-4)
    numbers = {(node.robot, node.serial): k for k, node in enumerate(nodes)}
    parents = [-1 if node.parent is None else numbers[node.parent] for node in nodes]
    assert values(packed["parent"]).tolist() == parents


def test_regions_are_off_by_no_more_than_the_tolerance(team_run, data):
    found = outlines(data["nodes"]["region"])
    for node, outline in zip(team_run.recording.of(NodeAdded), found, strict=True):
        true = shapely.Polygon(node.boundary)
        assert shapely.Polygon(outline).exterior.hausdorff_distance(true.exterior) < 0.0035
    assert len(data["nodes"]["tags"]) == sum(data["nodes"]["region"]["n"])


def test_frontier_edges_keep_their_tags(team_run, data):
    packed, start = data["nodes"], 0
    for node, outline in zip(
        team_run.recording.of(NodeAdded), outlines(packed["region"]), strict=True
    ):
        tags = np.array([*packed["tags"][start : start + len(outline)]])
        start += len(outline)
        for kind in "0123":
            drawn = length_of(outline, tags == kind)
            true = length_of(np.array(node.boundary), np.array([*node.tags]) == kind)
            assert drawn == pytest.approx(true, abs=0.05 + 0.02 * true)


def length_of(outline, chosen):
    along = np.roll(outline, -1, axis=0) - outline
    return np.hypot(*along.T)[chosen].sum()


def test_scans_messages_and_what_was_learned_are_complete(team_run, data):
    recording = team_run.recording
    assert len(data["scans"]["t"]) == len(recording.of(Sensed))
    assert sum(node < 0 for node in values(data["scans"]["node"])) == len(
        data["scans"]["region"]["n"]
    )
    assert sum(data["learned"]["nodes"]["n"]) == sum(len(e.nodes) for e in recording.of(Learned))
    packed = data["messages"]
    sets = np.split(values(packed["sets"]["of"]), np.cumsum(packed["sets"]["n"])[:-1])
    for k, sent in enumerate(recording.of(Sent)):
        assert packed["robot"][k] == sent.robot
        assert tuple(sets[packed["reached"][k]]) == sent.reached


def test_tracks_have_all_waypoints_without_full_turns(team_run, data):
    for robot, packed in enumerate(data["robots"]):
        own = [m for m in team_run.recording.of(Motion) if m.robot == robot]
        assert len(packed["track"]["t"]) == 1 + sum(len(m.waypoints) for m in own)
        assert len(packed["track"]["begin"]) == len(own)
        heading = values(packed["track"]["heading"], 10000)
        begins = values(packed["track"]["begin"]).astype(int)
        assert (np.abs(heading[begins] - heading[begins - 1]) < 0.01).all()


def test_activities_and_curves_are_those_of_the_analysis(team_run, data):
    recording, environment = team_run.recording, team_run.environment
    names = data["activities"]["names"]
    found = activities(recording, with_isolation=False)
    for own, packed in zip(found, data["activities"]["robots"], strict=True):
        assert [names[k] for k in packed["what"]] == [spell.activity for spell in own]
    covered = coverage_curve(recording, environment)["coverage"].values
    np.testing.assert_allclose(
        values(data["curves"]["coverage"]["coverage"], 1e4), covered, atol=6e-5
    )


def test_what_a_robot_does_while_it_is_cut_off_is_kept():
    moved = motion(1.0, 0, (2.0, 4.0), (8.0, 4.0))
    made = recorded([(2.0, 4.0), (9.0, 4.0)], [moved], radio=RadioSpec(range_m=4.0))
    packed = payload([made])["runs"][0]["activities"]
    found = isolation(made)
    assert any(robot.spells for robot in found)
    for robot, own in zip(found, packed["cut_off"], strict=True):
        spells = np.column_stack([values(own["begin"], 1000), values(own["end"], 1000)])
        np.testing.assert_allclose(spells, np.reshape(robot.spells, (-1, 2)), atol=5.1e-4)
    doing = [packed["names"][k] for k in packed["robots"][0]["what"]]
    assert doing == ["waits", "moves", "waits"]


def test_robots_are_told_by_their_masters():
    orders = payload([staged()])["runs"][0]["groups"]["orders"]
    assert (orders["robot"], orders["master"]) == ([0, 1], [1, 1])
    assert values(orders["t"], 1000).tolist() == [5.2, 5.2]


def test_links_are_those_of_the_analysis(team_run, data):
    links = data["links"]
    spells = sum(len(own) for own in radio_links(team_run.recording).values())
    assert len(links["begin"]) == len(links["end"]) == spells > 0


def test_a_radio_that_reaches_everywhere_has_no_links(bidding_run):
    assert payload([bidding_run.recording])["runs"][0]["links"] is None


def test_goals_of_robots_that_bid_have_their_frontiers(bidding_run):
    goals = payload([bidding_run.recording])["runs"][0]["goals"]
    chosen = bidding_run.recording.of(GoalChosen)
    assert sum(goals["options"]["n"]) == sum(len(choice.frontiers) for choice in chosen)


def test_the_text_is_the_data_deflated(data):
    packed = zlib.decompress(b64decode(compressed({"a": [1, 2]})), -zlib.MAX_WBITS)
    assert json.loads(packed) == {"a": [1, 2]}


def test_equal_recordings_give_equal_pages(team_run, tmp_path):
    once = replay_html(team_run.recording)
    team_run.recording.save(tmp_path / "recording.jsonl")
    again = type(team_run.recording).load(tmp_path / "recording.jsonl")
    assert replay_html(again) == once
    team_run.replay(tmp_path / "replay.html")
    assert (tmp_path / "replay.html").read_text(encoding="utf-8") == once


def test_a_page_that_is_too_large_is_made_coarser(team_run, monkeypatch):
    recording = team_run.recording
    sizes = [len(compressed(payload([recording], detail))) for detail in DETAILS]
    assert sizes == sorted(sizes, reverse=True)
    whole = len(replay_html(recording))
    monkeypatch.setattr(page, "MAX_BYTES", whole - sizes[0] + sizes[-1])
    assert len(replay_html(recording)) < whole
    monkeypatch.setattr(page, "MAX_BYTES", 1000)
    with pytest.raises(InvalidInputError, match="the replay would have 0 MB, more than"):
        replay_html(recording)


@pytest.mark.parametrize(
    ("detail", "notes"),
    [
        (DETAILS[0], []),
        (Detail(tolerance_m=0.02), ["2 cm off"]),
        (Detail(tolerance_m=0.05, choices_only=True), ["5 cm off", "times of decisions"]),
        (Detail(tolerance_m=0.002, explanations=False), ["use multisrt why"]),
    ],
)
def test_what_is_left_out_is_said(detail, notes):
    told = payload([staged()], detail)["notes"]
    assert len(told) == len(notes)
    assert all(part in note for part, note in zip(notes, told, strict=True))


def test_explanations_of_decisions_only_are_fewer(team_run):
    recording = team_run.recording
    few = payload([recording], Detail(tolerance_m=0.1, choices_only=True))["runs"][0]
    counts = [len(own["t"]) for own in few["explanations"]["robots"]]
    decided = {(e.robot, e.time_s) for e in recording.of(Decision)}
    assert sum(counts) <= len(decided)


@pytest.mark.parametrize("count", [0, 5])
def test_a_page_shows_one_to_four_runs(count):
    with pytest.raises(InvalidInputError, match=f"shows 1 to 4 runs, not {count}"):
        replay_html([staged()] * count)


def test_a_page_that_cannot_be_written_leaves_nothing(tmp_path):
    with pytest.raises(InvalidInputError, match="cannot write"):
        save_replay(staged(), tmp_path / "none" / "replay.html")
    assert not list(tmp_path.iterdir())


def test_the_log_tells_what_happened():
    log = payload([staged()])["runs"][0]["log"]
    texts = [log["texts"][k] for k in values(log["text"]).astype(int)]
    assert "organised robots 0, 1 as their master" in texts
    assert "was told by master 1 to keep its target" in texts
    assert any(
        text.startswith("protective stop at (") and text.endswith("before the body of robot 1")
        for text in texts
    )
    assert "gave up a frontier arc: too narrow" in texts
    assert any(text.startswith("died at (17.00, 4.00), ") for text in texts)
    assert not any("map" in text for text in texts)


def test_scans_are_no_nodes_in_the_log(bidding_run):
    log = payload([bidding_run.recording])["runs"][0]["log"]
    assert "scan 1 showed something new" in log["texts"]
    assert not any("(scan)" in text for text in log["texts"])
