"""Pictures as pixels: the same things at the same places as in the document."""

import time

import numpy as np
import pytest
from PIL import ImageColor

from multisrt.drawing.animation.looks import area_fill, body_fill
from multisrt.drawing.animation.pace import Pace
from multisrt.drawing.animation.painter import Painter, dashes
from multisrt.drawing.animation.scene import Scene, scene_of
from multisrt.drawing.colours import INK, OBSTACLE, WHITE

PACE = Pace.of(40.0, duration_s=4.0, speed=None, fps=10.0)  # a picture for each second


def scene(recording, **given) -> Scene:
    return scene_of(recording, recording.environment(), PACE, width=960, **given)


@pytest.fixture(scope="module")
def hall(told) -> Scene:
    return scene(told)


def colour_at(image, scene: Scene, x: float, y: float) -> str:
    px = scene.layout.origin[0] + scene.layout.scale * x
    py = scene.layout.origin[1] - scene.layout.scale * y
    return "#{:02x}{:02x}{:02x}".format(*image.getpixel((round(px), round(py))))


def test_things_are_where_and_when_they_belong(hall):
    painter = Painter(hall)
    assert painter.picture(0).size == (hall.layout.width, hall.layout.height)
    before = painter.picture(5)
    # Off the centre of the body, where its heading is not drawn.
    assert colour_at(before, hall, 2.9, 3.1) == body_fill(0, "waits")
    assert colour_at(before, hall, 4.5, 1.5) == area_fill(0)
    assert colour_at(before, hall, 4.5, 5.5) == WHITE
    assert colour_at(before, hall, -0.05, 5.0) == OBSTACLE.fill
    assert colour_at(before, hall, 3.9, 7.1) == body_fill(1, "not started")
    later = painter.picture(15)
    assert colour_at(later, hall, 7.9, 3.1) == body_fill(0, "moves")
    assert colour_at(later, hall, 2.9, 3.1) != body_fill(0, "moves")
    assert colour_at(later, hall, 4.5, 5.5) == area_fill(1)
    end = painter.picture(40)
    assert colour_at(end, hall, 12.9, 3.1) == body_fill(0, "done")
    assert colour_at(end, hall, 14.9, 7.1) == INK
    assert colour_at(end, hall, 11.5, 1.5) == area_fill(0)


def test_paths_are_drawn_as_far_as_the_robot_has_come(hall, told):
    without = scene(told, without=["edges", "nodes", "areas"])
    painter = Painter(without)
    halfway = painter.picture(15)
    drawn = [colour_at(halfway, without, x, 3.0) != WHITE for x in (4.0, 6.0, 10.0, 12.0)]
    assert drawn == [True, True, False, False]
    end = painter.picture(60)
    assert colour_at(end, without, 10.0, 3.0) != WHITE


@pytest.mark.parametrize("name", ["trees", "bidding"])
def test_pictures_do_not_depend_on_those_before(request, name):
    recording = request.getfixturevalue(name)
    pace = Pace.of(recording.footer.time_s, duration_s=2.0, speed=None, fps=10.0)
    shown = scene_of(recording, recording.environment(), pace, width=400)
    one, all_of_them = Painter(shown), Painter(shown)
    for number in range(14):
        all_of_them.picture(number)
    a, b = (np.asarray(painter.picture(14), float) for painter in (one, all_of_them))
    # Joints of paths that were drawn in parts differ a little.
    assert np.mean(np.abs(a - b).max(axis=2) > 60.0) < 0.001


def test_equal_scenes_give_equal_pictures(told, hall):
    one, two = (Painter(own).picture(33).tobytes() for own in (hall, scene(told)))
    assert one == two


@pytest.mark.slow
def test_ten_pictures_take_less_than_a_second(trees):
    pace = Pace.of(trees.footer.time_s, duration_s=4.0, speed=None, fps=10.0)
    painter = Painter(scene_of(trees, trees.environment(), pace, width=960))
    painter.picture(0)
    begin = time.process_time()
    for number in range(1, 31):
        painter.picture(number)
    assert time.process_time() - begin < 3.0


def test_dashes_go_round_corners():
    line = [(0.0, 0.0), (2.0, 0.0), (2.0, 3.0)]
    assert list(dashes(line, [3.0, 1.0])) == [
        [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0)],
        [(2.0, 2.0), (2.0, 3.0)],
    ]


def test_colours_are_colours():
    for activity in ("moves", "dead", "done", "not started"):
        assert ImageColor.getrgb(body_fill(70, activity))
