"""Where the parts of a picture are."""

import pytest

from multisrt.drawing.animation.layout import MAX_ENTRIES, Layout, layout_of
from multisrt.geometry.errors import InvalidInputError

HALL = (-5.0, 2.0, 15.0, 7.0)


def pixel(layout: Layout, x: float, y: float) -> tuple[float, float]:
    return layout.origin[0] + layout.scale * x, layout.origin[1] - layout.scale * y


@pytest.mark.parametrize("height", [None, 500, 900])
@pytest.mark.parametrize("bounds", [HALL, (0.0, 0.0, 3.0, 40.0), (1e6, 1e6, 1e6 + 8, 1e6 + 9)])
def test_the_world_is_on_the_map_and_the_map_in_the_picture(bounds, height):
    layout = layout_of(bounds, 4, 960, height)
    left, top, wide, high = layout.map
    assert left >= 0.0
    assert top >= 0.0
    assert left + wide <= 960.0
    assert top + high < layout.caption_y < layout.entry(3)[1] < layout.height
    x0, y0, x1, y1 = bounds
    for x, y in ((x0, y0), (x1, y1)):
        px, py = pixel(layout, x, y)
        assert left < px < left + wide
        assert top < py < top + high


def test_the_height_follows_from_the_world():
    assert layout_of(HALL, 4, 960).height < layout_of((0, 0, 10, 10), 4, 960).height < 1100
    # A narrow world does not make a picture without end.
    assert layout_of((0.0, 0.0, 1.0, 100.0), 4, 960).height < 1600


def test_large_teams_are_not_listed():
    few, many = layout_of(HALL, MAX_ENTRIES, 960), layout_of(HALL, MAX_ENTRIES + 1, 960)
    assert many.height < few.height


def test_without_a_caption_the_map_fills_the_picture():
    layout = layout_of(HALL, 4, 960, captioned=False)
    left, top, _, high = layout.map
    assert left == pytest.approx(top, abs=1.0)
    assert layout.height - top - high == pytest.approx(top, abs=1.0)


@pytest.mark.parametrize(
    ("width", "height", "said"),
    [
        (100, None, "width of the animation is 100 pixels; give 200 to 4096"),
        (960, 5000, "height of the animation is 5000 pixels"),
        (4096, 200, "leave no room for the map .* give a height of at least 4"),
        (4096, 4097, "give 200 to 4096"),
    ],
)
def test_sizes_out_of_range_are_refused(width, height, said):
    with pytest.raises(InvalidInputError, match=said):
        layout_of(HALL, 4, width, height)


def test_pictures_that_would_be_too_high_are_refused():
    with pytest.raises(InvalidInputError, match=r"would be .* pixels high"):
        layout_of((0.0, 0.0, 1.0, 2.0), 4, 4000)


@pytest.mark.parametrize("width", [300, 480, 640, 960, 1920])
def test_letters_are_never_too_small_to_read(width):
    layout = layout_of(HALL, 4, width)
    sizes = layout.label_px, layout.text_px, layout.title_px
    # The digits of common fonts are 0.73 of the size of letters high.
    assert min(sizes) * 0.73 >= 9.0
    assert sizes == tuple(sorted(sizes))
    entries = [layout.entry(robot) for robot in range(4)]
    assert max(y for _, y in entries) + 0.5 * layout.row_px <= layout.height
    assert len(set(entries)) == 4
