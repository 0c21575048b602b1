from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from multisrt.environments.formats import read_environment
from multisrt.environments.formats.start_mark import marked_starts

MAPS = Path(__file__).resolve().parents[2].parent / "shared" / "maps"
IMAGES = sorted(p for p in MAPS.rglob("*") if p.suffix in (".png", ".pgm"))
WALL, FREE, MARK = 127, 195, 208


def dungeon():
    """A room of 60 x 40 pixels in walls, with a mark of 5 x 5 pixels."""
    levels = np.full((50, 70), WALL, np.uint32)
    levels[5:45, 5:65] = FREE
    levels[10:15, 30:35] = MARK
    return levels


def marks(levels):
    return marked_starts(levels, levels > 127, 0.1)


def test_the_middle_of_the_mark_is_in_metres_with_y_up():
    assert marks(dungeon()) == (pytest.approx((3.25, 3.75)),)


def test_a_mark_may_touch_a_wall():
    levels = dungeon()
    levels[9, :] = WALL
    assert marks(levels) == (pytest.approx((3.25, 3.75)),)
    levels[:, 29] = levels[15, :] = WALL
    assert marks(levels) == ()


def test_other_squares_are_not_marks():
    def changed(rows, columns, value):
        levels = dungeon()
        levels[rows, columns] = value
        return levels

    pixel = slice(12, 13)
    assert marks(changed(pixel, slice(34, 35), FREE)) == ()  # not a full square
    assert marks(changed(slice(10, 15), slice(35, 36), MARK)) == ()  # not as wide as high
    assert marks(changed(slice(40, 41), slice(60, 61), MARK)) == ()  # elsewhere too
    assert marks(changed(slice(10, 15), slice(30, 35), 100)) == ()  # not free
    assert marks(changed(pixel, slice(35, 36), 196)) == ()  # two levels around it
    assert marks(changed(slice(40, 44), slice(60, 64), 209)) == ()  # a second mark
    assert marks(changed(slice(10, 15), slice(30, 35), FREE)) == ()
    small = changed(slice(10, 15), slice(30, 35), FREE)
    small[10:13, 30:33] = MARK
    assert marks(small) == ()
    large = changed(slice(10, 20), slice(30, 40), MARK)
    assert marks(large) == ()
    edge = np.full((50, 70), FREE, np.uint32)
    edge[0:5, 30:35] = MARK
    assert marks(edge) == ()


def test_an_image_of_many_levels_has_no_mark():
    levels = dungeon()
    levels[45:50, 0] = [1, 2, 3, 4, 5]
    assert len(marks(levels)) == 1
    levels[45:50, 1] = [6, 7, 8, 9, 10]
    assert marks(levels) == ()


def test_a_mark_in_an_image_becomes_a_suggested_start(tmp_path):
    path = tmp_path / "dungeon.png"
    Image.fromarray(dungeon().astype(np.uint8)).convert("RGBA").save(path)
    world = read_environment(path, resolution_m=0.1)
    (start,) = world.starts
    assert start == pytest.approx((3.25, 3.75))
    assert world.area_m2 == pytest.approx(24.0)


@pytest.mark.slow
@pytest.mark.skipif(not IMAGES, reason="the shared maps are not here")
@pytest.mark.parametrize("path", IMAGES, ids=lambda path: path.name)
def test_public_images_have_a_mark_only_in_dungeons(path):
    world = read_environment(path, resolution_m=0.05)
    if path.parent.name != "ir2_dungeon":
        assert world.starts == ()
        return
    grey = np.asarray(Image.open(path).convert("L"))
    row, column = np.nonzero((grey == 208) | (grey == 203))
    x, y = 0.05 * (column.mean() + 0.5), 0.05 * (len(grey) - row.mean() - 0.5)
    (start,) = world.starts
    assert start == pytest.approx((x, y))
