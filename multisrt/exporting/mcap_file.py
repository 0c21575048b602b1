"""MCAP files of the ROS 2 profile, as Foxglove and `ros2 bag` read them.

The container is written by the package mcap. Messages are encoded here, since its companion
mcap-ros2-support takes 35 ms for a map of 100,000 cells (0.1 ms here), and cannot write the quality
of service of a topic.
"""

from __future__ import annotations

import json
from importlib.metadata import version
from typing import IO, Any, Final, NamedTuple

import yaml

from multisrt.exporting.ros_definitions import definition_of
from multisrt.extras import extra

BAG_VERSION: Final = 5
"""Version of the metadata of `ros2 bag`, which all releases since ROS 2 Humble read."""

INFINITE: Final = {"sec": 9223372036, "nsec": 854775807}
"""Infinite duration, in the quality of service of a topic."""


class Topic(NamedTuple):
    """Where messages of one type are published.

    Attributes
    ----------
    name : str
        Name of the topic.
    kind : str
        Type of its messages, a key of `DEFINITIONS`.
    latched : bool
        Whether late subscribers receive the last message (durability `transient local`).
    """

    name: str
    kind: str
    latched: bool = False


class McapFile:
    """An MCAP file that is being written.

    Parameters
    ----------
    file : binary file
        File to write to.

    Raises
    ------
    MissingExtraError
        If mcap is not installed.
    """

    def __init__(self, file: IO[bytes]) -> None:
        with extra("mcap", "an MCAP file"):
            from mcap.writer import CompressionType, Writer
        self._writer = Writer(file, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library=f"multisrt {version('multisrt')}")
        self._schemas: dict[str, int] = {}
        self._channels: dict[Topic, int] = {}
        self._counts: dict[Topic, int] = {}
        self._first = self._last = 0

    def write(self, topic: Topic, now: int, message: bytes) -> None:
        """Write a message; `now`, in nanoseconds, must not decrease."""
        if topic not in self._channels:
            self._channels[topic] = self._channel(topic)
            self._counts[topic] = 0
        if not any(self._counts.values()):
            self._first = now
        self._writer.add_message(self._channels[topic], now, message, now, self._counts[topic])
        self._counts[topic] += 1
        self._last = now

    def close(self, about: dict[str, str]) -> None:
        """Write the metadata and the index; the file itself stays open."""
        self._writer.add_metadata("multisrt", about)
        # What `ros2 bag` adds to its own files; without it newer releases misread the topics.
        text = yaml.safe_dump(self._bag_metadata(), sort_keys=False)
        self._writer.add_metadata("rosbag2", {"serialized_metadata": text})
        self._writer.finish()  # type: ignore[no-untyped-call]

    def _channel(self, topic: Topic) -> int:
        if topic.kind not in self._schemas:
            package, name = topic.kind.split("/")
            self._schemas[topic.kind] = self._writer.register_schema(
                f"{package}/msg/{name}", "ros2msg", definition_of(topic.kind).encode()
            )
        return self._writer.register_channel(
            topic.name, "cdr", self._schemas[topic.kind], {"offered_qos_profiles": _quality(topic)}
        )

    def _bag_metadata(self) -> dict[str, Any]:
        return {
            "version": BAG_VERSION,
            "storage_identifier": "mcap",
            "duration": {"nanoseconds": self._last - self._first},
            "starting_time": {"nanoseconds_since_epoch": self._first},
            "message_count": sum(self._counts.values()),
            "topics_with_message_count": [
                {
                    "topic_metadata": {
                        "name": topic.name,
                        "type": topic.kind.replace("/", "/msg/"),
                        "serialization_format": "cdr",
                        "offered_qos_profiles": _quality(topic),
                    },
                    "message_count": count,
                }
                for topic, count in self._counts.items()
            ],
            "compression_format": "",
            "compression_mode": "",
            # Readers fill these in.
            "relative_file_paths": [],
            "files": [],
        }


def _quality(topic: Topic) -> str:
    # Numbers are those of ROS: keep last, reliable, transient local or volatile, automatic.
    profile = {
        "history": 1,
        "depth": 1 if topic.latched else 10,
        "reliability": 1,
        "durability": 1 if topic.latched else 2,
        "deadline": INFINITE,
        "lifespan": INFINITE,
        "liveliness": 1,
        "liveliness_lease_duration": INFINITE,
        "avoid_ros_namespace_conventions": False,
    }
    return json.dumps([profile])  # JSON is YAML without anchors
