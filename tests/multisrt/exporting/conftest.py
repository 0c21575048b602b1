"""Runs that are exported, and readers of MCAP files that know nothing of this package."""

from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

import multisrt as ms
from multisrt.exporting import ExportOptions

OPTIONS = ExportOptions(rate_hz=4.0, map_interval_s=3.0, cell_m=0.1)

Messages = dict[str, list[tuple[int, Any]]]


@pytest.fixture(scope="session")
def team() -> ms.Run:
    """Four robots, one of each kind: one dies, one starts late, one falls silent, one is a car."""
    finder = ms.RangeFinderSpec(range_m=2.0)
    car = ms.DriveSpec(kind="reeds-shepp", turning_radius_m=0.4)
    robots = [
        ms.RobotSpec(range_finder=finder),
        ms.RobotSpec(range_finder=finder),
        ms.RobotSpec(footprint="box:0.5x0.3", range_finder=finder),
        ms.RobotSpec(footprint="disc:0.2", range_finder=finder, drive=car),
    ]
    faults = (
        ms.Death(robot=0, time_s=14.0),
        ms.LateStart(robot=1, time_s=5.0),
        ms.Silence(robot=2, time_s=8.0, duration_s=6.0),
    )
    return ms.explore(
        "apartment",
        robots=robots,
        starts="clustered",
        radio=ms.RadioSpec(range_m=6.0, walls="block"),
        faults=faults,
        seed=2,
        max_time_s=30.0,
    )


@pytest.fixture(scope="session")
def team_mcap(team, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("export") / "team.mcap"
    team.export(path, OPTIONS)
    return path


def read_with_mcap(path: Path) -> Messages:
    """Return all messages by topic, read by the package mcap and decoded by mcap-ros2-support."""
    found: Messages = defaultdict(list)
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        for _, channel, message, decoded in reader.iter_decoded_messages():
            assert message.publish_time == message.log_time
            found[channel.topic].append((message.log_time, decoded))
    return found


def read_with_rosbags(path: Path) -> Messages:
    """Return all messages by topic, read by rosbags with the definitions of the file."""
    found: Messages = defaultdict(list)
    with AnyReader([path]) as reader:
        for connection, time_ns, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            found[connection.topic].append((time_ns, message))
    return found


@pytest.fixture(scope="session")
def messages(team_mcap) -> Messages:
    return read_with_mcap(team_mcap)
