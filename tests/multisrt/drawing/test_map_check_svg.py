import re
import xml.etree.ElementTree as ET

import numpy as np
import shapely
from shapely import Polygon, box

from multisrt.analysis.map_check import check_map
from multisrt.drawing import map_check_svg
from multisrt.drawing.map_check_svg import _lines_in
from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint

WALL = box(4, 0, 4.2, 1.8) | box(4, 2.2, 4.2, 4)
ROOMS = Environment("rooms", box(0, 0, 8.2, 4) - WALL, starts=[(6, 2)])


def layers(text):
    root = ET.fromstring(text)
    return {group.get("id"): group for group in root.iter() if group.get("id")}


def test_what_is_out_of_reach_is_hatched_and_doors_are_marked():
    found = layers(map_check_svg(check_map(ROOMS, Footprint.disc(0.25))))
    assert {"out-of-reach-of-disc-0-25", "passage-that-is-too-narrow"} <= set(found)
    assert "separate-part" not in found
    widths = [text.text for text in found["widths"].iter() if text.tag.endswith("text")]
    assert widths == ["0.40 m"]


def test_a_body_that_passes_has_nothing_hatched():
    found = layers(map_check_svg(check_map(ROOMS, Footprint.disc(0.15))))
    assert not any(name.startswith("out-of-reach") for name in found)
    assert "narrow-passage" in found


def test_separate_parts_are_hatched():
    world = Environment("two", shapely.union_all([box(0, 0, 8, 4), box(9, 0, 10, 4)]))
    assert "separate-part" in layers(map_check_svg(check_map(world, Footprint.disc(0.25))))


def test_equal_checks_give_equal_pictures():
    texts = [map_check_svg(check_map(ROOMS, Footprint.disc(0.25))) for _ in range(2)]
    assert texts[0] == texts[1]
    assert not re.search(r"nan|inf", texts[0].lower().replace("inkscape", "").replace("info", ""))


def test_hatching_covers_areas_evenly():
    ring = Polygon(box(0, 0, 3, 2).exterior, [box(1, 1, 2, 2).exterior])
    areas = [ring, box(4, -3, 5, 7)]
    for falling in (False, True):
        lines = list(_lines_in(areas, 0.05, falling=falling))
        length = sum(shapely.LineString(line).length for line in lines)
        assert np.isclose(length * 0.05, sum(area.area for area in areas), rtol=0.02)
