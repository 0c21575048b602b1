"""Marks of robots: starts, ends, deaths, stops and the numbers of a team."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import shapely

from multisrt.drawing import tree_svg
from multisrt.drawing.badges import spread
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Blocked, Died, Joined
from multisrt.spec import LateStart
from tests.multisrt.drawing.pictures import SVG, layers, lines, paths, texts
from tests.multisrt.drawing.recordings import A, B, C, D, motion, node, recorded, run, team


def test_where_a_robot_was_cut_off_is_marked(cut_off, museum):
    assert "robot 0: end" in layers(tree_svg(cut_off))
    assert "robot 0: end" not in layers(tree_svg(museum))


def test_teams_have_layers_colours_and_numbers_for_every_robot(cut_off):
    other = run(environment("museum"), seed=2, start=(3.0, 12.0), max_time_s=60.0)
    svg = tree_svg(team(cut_off, other, cut_off))
    found = layers(svg)
    strokes = {found[f"robot {k}: tree"].get("stroke") for k in range(3)}
    assert len(strokes) == 3
    assert [t for t in texts(svg) if t.isdigit()] == ["0", "1", "2"]
    numbers = [found[f"robot {k}: start"].find(SVG + "text") for k in range(3)]
    for text in numbers:
        assert text is not None
        assert re.search(r"scale\((\S+) -\1\)$", text.get("transform", ""))
    assert len([t for t in texts(svg) if re.fullmatch(r"\d: \d+ nodes, \d+ m", t)]) == 3


def test_a_robot_that_is_alone_needs_no_numbers_and_no_areas(museum):
    found = layers(tree_svg(museum))
    assert not {"robot 0: seen first", "swatches"} & set(found)
    assert found["robot 0: start"].find(SVG + "text") is None


def test_a_death_is_marked_by_number_and_in_the_heading():
    events: list[AnyEvent] = [
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
    events: list[AnyEvent] = [
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


def test_badges_stay_within_a_box():
    places = spread([(5.0, 0.2), (5.1, 0.2), (5.2, 0.2)], 0.4, within=(0.0, 0.0, 10.0, 8.0))
    assert places[:, 1].min() >= 0.4
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    assert apart[np.triu_indices(3, 1)].min() > 0.8
