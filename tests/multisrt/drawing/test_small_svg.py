"""The small picture of a run."""

import xml.etree.ElementTree as ET

import multisrt as ms
from multisrt.drawing.small_svg import small_svg
from multisrt.events import NodeAdded


def drawn(text: str) -> int:
    return sum(1 for one in ET.fromstring(text).iter() if one.tag.endswith("path"))


def test_the_base_station_and_what_it_knows_are_drawn():
    alone = ms.explore("apartment", strategy="minpos", seed=1, max_time_s=20.0)
    home = ms.explore("apartment", strategy="minpos", seed=1, max_time_s=20.0, base=(2.5, 2.0))
    assert alone.recording.of(NodeAdded) == home.recording.of(NodeAdded)
    # The station, and the border of what it knows.
    more = drawn(small_svg(home.recording, "home")) - drawn(small_svg(alone.recording, "alone"))
    assert more == 2
