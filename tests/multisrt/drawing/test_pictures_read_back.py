"""Pictures of runs and checks as maps: space and starts come back, and nothing is left out."""

import math
import re

import numpy as np
import pytest
import shapely

from multisrt.analysis.map_check import check_map
from multisrt.drawing import map_check_svg, tree_svg
from multisrt.environments.environment import Environment
from multisrt.environments.formats import read_environment
from multisrt.events import AnyEvent
from multisrt.geometry.bodies.footprint import Footprint
from tests.multisrt.drawing.recordings import HALL, A, C, E, end, motion, node, recorded

HEADINGS = [0.0, 1.0, math.pi / 2, -2.5]


def read(folder, svg):
    path = folder / "picture.svg"
    path.write_text(svg)
    return read_environment(path)


def pictured(starts, world=HALL):
    """Return the picture of robots that each made a node and a motion."""
    events: list[AnyEvent] = []
    for robot, place in enumerate([A, C, E, (6.0, 6.0)][: len(starts)]):
        events += [node(0.0, robot, 0, place), motion(1.0, robot, place, (place[0], 1.0))]
        events.append(end(5.0, robot))
    return tree_svg(recorded(starts, events, world))


@pytest.mark.parametrize("heading", HEADINGS)
def test_the_start_of_a_robot_is_where_its_arrow_is(tmp_path, heading):
    world = read(tmp_path, pictured([(4.0, 5.0, heading)]))
    np.testing.assert_allclose(world.starts, [(4.0, 5.0)], atol=0.01)


def test_starts_of_a_team_are_the_centres_of_their_discs(tmp_path):
    starts = [(2.0 + 4.0 * k, 5.0, heading) for k, heading in enumerate(HEADINGS)]
    svg = pictured(starts)
    assert "data-to-start" not in svg
    world = read(tmp_path, svg)
    np.testing.assert_allclose(world.starts, [start[:2] for start in starts], atol=0.005)
    assert world.free.equals_exact(HALL.free, 0.01)


def test_starts_of_a_crowd_are_where_robots_start_not_where_numbers_stand(tmp_path):
    starts = [(4.0, 5.0, 0.3), (4.06, 5.0, 1.0), (4.0, 5.3, 2.0), (9.0, 5.0, 3.0)]
    svg = pictured(starts)
    assert "lines to starts" in svg
    assert "data-to-start" in svg
    np.testing.assert_allclose(
        read(tmp_path, svg).starts, [start[:2] for start in starts], atol=0.01
    )


def test_starts_far_from_the_origin_are_read_back(tmp_path):
    world = Environment("far", shapely.box(70_000, -90_000, 70_020, -89_992))
    starts = [(70_004.0, -89_995.0, 1.0), (70_004.05, -89_995.0, 2.0)]
    svg = tree_svg(recorded(starts, [end(5.0, 0), end(5.0, 1)], world))
    np.testing.assert_allclose(
        read(tmp_path, svg).starts, [start[:2] for start in starts], atol=0.01
    )


def test_other_shapes_of_starts_count_by_their_middle(tmp_path):
    svg = pictured([(4.0, 5.0, 0.0)])
    arrow = re.search(r'label="robot 0: start"[^>]*>\s*<path d="([^"]*)"', svg)
    assert arrow is not None
    kite = "M4 5l2 .5l-2 .5l-1 -.5z"
    world = read(tmp_path, svg.replace(arrow[1], kite))
    np.testing.assert_allclose(world.starts, [(4.5, 5.5)], atol=1e-9)


def test_a_wrong_vector_to_a_start_is_an_error_with_its_line(tmp_path):
    svg = pictured([(4.0, 5.0, 0.3), (4.06, 5.0, 1.0)])
    broken = re.sub(r'data-to-start="[^"]*"', 'data-to-start="1 x"', svg)
    with pytest.raises(ValueError, match=r"picture\.svg, line \d+, <path>: 'x' is not part of"):
        read(tmp_path, broken)


def test_no_layer_of_our_own_is_told_as_left_out(tmp_path):
    starts = [(4.0, 5.0, 0.3), (4.06, 5.0, 1.0)]
    world = read(tmp_path, pictured(starts))
    assert world.layers is not None
    assert world.layers.left_out == ()
    narrow = HALL.free - shapely.box(10, 0, 10.2, 7.7)
    checked = check_map(Environment("hall", narrow, starts=[(1, 1)]), Footprint.disc(0.25))
    svg = map_check_svg(checked)
    assert "out of reach of" in svg
    assert "passage that is too narrow" in svg
    layers = read(tmp_path, svg).layers
    assert layers is not None
    assert layers.left_out == ()


def test_a_layer_that_was_added_to_a_picture_is_told(tmp_path):
    svg = pictured([(4.0, 5.0, 0.3)])
    added = '<g inkscape:groupmode="layer" inkscape:label="Sofas"><path d="M8 2h2v1h-2z"/></g></g>'
    before, _, after = svg.partition('<g id="robot-0-start"')
    layers = read(tmp_path, f'{before}{added[:-4]}<g id="robot-0-start"{after}').layers
    assert layers is not None
    assert [layer.name for layer in layers.left_out] == ["Sofas"]
