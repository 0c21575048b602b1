import math
import shutil
import tempfile
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from multisrt.analysis.map_check import check_map
from multisrt.cli.map_report import report
from multisrt.environments.cleaning import CleaningOptions
from multisrt.environments.fixing import fixed
from multisrt.environments.formats import files, read_environment, stage
from multisrt.environments.formats.map_format import Beginning
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import MapFormatError

MAPS = Path(__file__).resolve().parents[2].parent / "shared" / "maps"
needs_maps = pytest.mark.skipif(not MAPS.is_dir(), reason="the shared maps are not here")

# A dark frame of 8 x 6 squares, with a dark square in the lower left corner of its inside.
SQUARE = np.ones((4, 4), np.uint8)
FRAME = np.full((6, 8), 255, np.uint8)
FRAME[[0, -1]] = FRAME[:, [0, -1]] = FRAME[4, 1] = 0
FRAME = np.kron(FRAME, SQUARE)

FLOORPLAN = 'define floorplan model ( color "gray30" boundary 1 )\n'
PLAIN = 'model ( bitmap "a.png" size [8 6 1] )'


@pytest.fixture
def read(tmp_path):
    Image.fromarray(FRAME).save(tmp_path / "a.png")

    def write_and_read(text, **options):
        path = tmp_path / "w.world"
        path.write_text(text)
        return read_environment(path, **options)

    return write_and_read


def inside(x0, y0, cell_x, cell_y):
    """Free space of the frame whose lower left corner is (x0, y0)."""
    room = shapely.box(x0 + cell_x, y0 + cell_y, x0 + 7 * cell_x, y0 + 5 * cell_y)
    return room - shapely.box(x0 + cell_x, y0 + cell_y, x0 + 2 * cell_x, y0 + 2 * cell_y)


def assert_free(world, expected, tolerance=1e-9):
    assert world.free.symmetric_difference(expected).area < tolerance, world.free.wkt


def test_pose_is_the_centre_and_pixels_need_not_be_square(read):
    assert_free(read(PLAIN), inside(-4, -3, 1, 1))
    world = read('model ( bitmap "a.png" size [4 12 1] pose [10 20 5 0] )')
    assert_free(world, inside(8, 14, 0.5, 2))
    assert world.name == "w"
    assert world.origin == "w.world with a.png"


@pytest.mark.parametrize("degrees", [90, -90, 180, 450, 30, -123.4])
def test_heading_turns_the_floorplan_about_its_centre(read, degrees):
    world = read(f'model ( bitmap "a.png" size [8 6 1] pose [1 2 0 {degrees}] )')
    expected = shapely.affinity.rotate(inside(-4, -3, 1, 1), degrees, origin=(0, 0))
    assert_free(world, shapely.affinity.translate(expected, 1, 2))
    if degrees == 90:
        # The dark pixel, at the lower left before, is at the lower right.
        assert world.bounds == (-1, -1, 3, 5)
        assert not world.contains(2.5, -0.5)
        assert world.contains(-0.5, -0.5)


def test_origin_is_the_pose_of_the_rectangle_in_the_model(read):
    world = read('model ( bitmap "a.png" size [8 6 1] pose [1 2 0 90] origin [3 0 0 90] )')
    assert_free(
        world,
        shapely.affinity.translate(
            shapely.affinity.rotate(inside(-4, -3, 1, 1), 180, origin=(0, 0)), 1, 5
        ),
    )


def test_units_are_applied(read):
    world = read(
        'unit_length "cm" unit_angle "radians"\n'
        f'model ( bitmap "a.png" size [800 600 1] pose [100 0 0 {math.pi / 2}] )'
    )
    assert_free(
        world,
        shapely.affinity.translate(
            shapely.affinity.rotate(inside(-4, -3, 1, 1), 90, origin=(0, 0)), 1, 0
        ),
    )
    assert_free(read(PLAIN.replace("[8 6 1]", "[8 6]")), inside(-4, -3, 1, 1))
    assert read(PLAIN[:-1] + "pose [1 2 90] )").bounds == pytest.approx((-1, -1, 3, 5))


def test_a_light_margin_is_no_part_of_the_model(read, tmp_path):
    Image.fromarray(np.pad(FRAME, ((2, 1), (3, 0)), constant_values=255)).save(tmp_path / "a.png")
    assert_free(read(PLAIN), inside(-4, -3, 1, 1))


@pytest.mark.parametrize(
    ("mode", "dark", "free"),
    [
        ("L", 127, 128),
        ("RGB", (127, 255, 255), (128, 0, 0)),
        ("LA", (127, 255), (128, 0)),
        ("I;16", 32767, 32768),
        ("1", 0, 1),
    ],
)
def test_the_first_channel_decides_as_in_stage(read, tmp_path, mode, dark, free):
    image = Image.new(mode, FRAME.shape[::-1], free)
    for row, column in np.argwhere(FRAME == 0).tolist():
        image.putpixel((column, row), dark)
    image.save(tmp_path / "a.png")
    assert_free(read(PLAIN), inside(-4, -3, 1, 1))


def test_a_bitmap_without_dark_pixels_is_a_free_rectangle(read, tmp_path):
    Image.new("L", (8, 6), 255).save(tmp_path / "a.png")
    assert_free(read(PLAIN), shapely.box(-4, -3, 4, 3))
    assert_free(read(PLAIN[:-1] + "boundary 1 )"), shapely.box(-3.99, -2.99, 3.99, 2.99))


def test_floorplans_that_touch_are_one_world(read, tmp_path):
    # Two open halves of a room of 16 x 6 with walls above and below, and a frame apart from it.
    half = np.full((6, 8), 255, np.uint8)
    half[[0, -1]] = 0
    Image.fromarray(np.kron(half, SQUARE)).save(tmp_path / "half.png")
    halves = "".join(
        f'model ( bitmap "half.png" size [8 6 1] pose [{x} 0.1 0 {turn}] )'
        for x, turn in ((0.1, 0), (8.1, 180))
    )
    apart = 'model ( bitmap "a.png" size [8 6 1] pose [30 0 0 0] )'
    world = read(halves + apart)
    room = shapely.box(-3.9, -1.9, 12.1, 2.1)
    assert_free(world, room | inside(26, -3, 1, 1), 1e-4)
    assert len(world.components) == 2
    closed = read(halves.replace("pose", "boundary 1 pose"))
    assert len(closed.components) == 2


def test_walls_of_one_floorplan_are_obstacles_in_another(read):
    world = read(PLAIN + 'model ( bitmap "a.png" size [8 6 1] pose [3 0 0 0] )')
    walls = (shapely.box(-4, -3, 4, 3) - inside(-4, -3, 1, 1)) | (
        shapely.box(-1, -3, 7, 3) - inside(-1, -3, 1, 1)
    )
    assert_free(world, shapely.box(-4, -3, 7, 3) - walls, 1e-4)


def test_models_without_a_bitmap_are_obstacles(read):
    world = read(
        PLAIN
        + "define crate model ( size [1 2 1] ) crate ( pose [1 0 0 90] origin [0 0.5 0 0] )"
        + "model ( size [2 1 1] pose [-1 1.5 0 0] block ( points 3"
        + " point[0] [0 0] point[1] [10 0] point[2] [0 10] z [0 1] ) )"
    )
    crate = shapely.box(-0.5, -0.5, 1.5, 0.5)
    triangle = shapely.Polygon([(-2, 1), (0, 1), (-2, 2)])
    assert_free(world, inside(-4, -3, 1, 1) - crate - triangle)
    none = read(PLAIN + "model ( size [1 1 1] noblocks 1 )")
    assert_free(none, inside(-4, -3, 1, 1))
    # The wall of 1 cm along a box of blocks.
    ring = read(
        PLAIN + "model ( size [2 2 1] boundary 1 block ( points 4"
        " point[0] [0 0] point[1] [1 0] point[2] [1 1] point[3] [0 1] ) block ( points 3"
        " point[0] [0 0] point[1] [1 0] point[2] [0 1] ) )"
    )
    assert not ring.contains(0, 0)


def test_models_in_models_are_placed_in_their_frame(read):
    world = read(
        "model ( noblocks 1 pose [2 3 0 90] "
        'model ( bitmap "a.png" size [8 6 1] pose [10 0 0 0] position ( pose [1 0 0 0] ) ) )'
    )
    turned = shapely.affinity.rotate(inside(6, -3, 1, 1), 90, origin=(0, 0))
    assert_free(world, shapely.affinity.translate(turned, 2, 3))
    assert world.starts == ((pytest.approx(2), pytest.approx(14)),)


@pytest.mark.parametrize(
    ("returns", "solid"),
    [
        ("", True),
        ("obstacle_return 0", True),
        ("obstacle_return 0 ranger_return 0.5", True),
        ("obstacle_return 1 ranger_return -1", True),
        ("obstacle_return 0 ranger_return -1", False),
        ("obstacle_return 0 laser_return 0", False),
        ("obstacle_return 0 laser_return 1", True),
    ],
)
def test_models_that_nothing_meets_are_left_out(read, returns, solid):
    world = read(PLAIN + f"model ( size [1 1 1] {returns} )")
    assert world.contains(0.1, 0.1) is not solid


def test_robots_are_suggested_starts(read):
    world = read(
        PLAIN
        + "define pr2 position ( size [1 1 1] ranger ( pose [1 1 0 0] ) position ( ) )\n"
        + "pr2 ( pose [1 1 0 45] ) pr2 ( ) pr2 ( pose [1 1 0 0] ) pr2 ( pose [50 1 0 0] )"
        + 'pr2 ( bitmap "none.png" pose [2 -1 0 0] ) window ( pose [1 0 0 0] ) charger ( )'
    )
    assert world.starts == ((1, 1), (0, 0), (2, -1))
    assert world.origin == "w.world with a.png; 4 of 5 robots are in free space"


def test_definitions_that_are_missing_are_told(read):
    text = (
        'include "p3at.inc"\ninclude "floorplan.inc"\ninclude "p3at.inc"\n'
        'floorplan ( bitmap "a.png" size [8 6 1] )\n'
        "pioneer3at ( pose [1 -1 0 45] ) pioneer3at ( pose [1 -2 0 45] sick ( pose [0 0 0 0] ) )"
    )
    world = read(text)
    assert_free(world, inside(-4, -3, 1, 1))
    assert world.starts == ((1, -1),)
    assert world.origin == (
        "w.world with a.png; p3at.inc is missing; floorplan.inc is missing; "
        "1 of 2 robots are in free space"
    )
    with pytest.raises(MapFormatError, match=r"no floorplan; is it in p3at\.inc, floorplan\.inc, "):
        read(text.replace("bitmap", "picture"))


def test_models_of_unknown_types_without_equipment_are_no_robots(read):
    chargers = 'charger ( pose [-2 1 0 0] ) charger ( name "c" pose [-1 1 0 0] )'
    for robots in (
        'bot ( pose [1 -1 0 0] ctrl "wander" ) bot ( pose [2 -1 0 0] )',
        "bot ( pose [1 -1 0 0] sick ( ) ) bot ( pose [2 -1 0 0] )",
        'bot ( pose [1 -1 0 0] localization "gps" ) bot ( pose [2 -1 0 0] )',
        'define cb bot ( ctrl "wander" ) cb ( pose [1 -1 0 0] ) cb ( pose [2 -1 0 0] )',
        "position ( pose [1 -1 0 0] ) position ( pose [2 -1 0 0] )",
    ):
        world = read(f"{PLAIN} {chargers} {robots}")
        assert world.starts == ((1, -1), (2, -1))
        assert world.origin == "w.world with a.png; charger is not defined, and is no robot"
    # Nothing tells robots from other models.
    assert len(read(f"{PLAIN} {chargers} bot ( pose [1 -1 0 0] )").starts) == 3


@pytest.mark.parametrize(
    ("text", "is_world"),
    [
        (PLAIN, True),
        ('# of a\n\ninclude "a.inc"\n', True),
        ("define a model ( size [1 1 1] )", True),
        (
            'resolution 0.02 paused 1 include "a.inc" window ( size [9 9] rotate [0 0] ) ' + PLAIN,
            True,
        ),
        ('name "cave" size [16 16 0.8] model ( point[0] [1 2] ) bitmap "x.png"', True),
        ('# A map\n\nEvery bitmap "a.png" is free.\ninclude "x" in the file\n', False),
        ('The map (drawn by hand) has a bitmap "a.png"\n', False),
        ("x,y\n1,2\n", False),
        ("", False),
        ('def f(x):\n    bitmap "a"\n', False),
    ],
)
def test_prose_is_no_world(tmp_path, text, is_world):
    assert stage.STAGE.recognises(Beginning(text.encode())) is is_world
    (tmp_path / "notes.md").write_text(text + "\n")
    if not is_world and text:
        with pytest.raises(MapFormatError, match=r"notes\.md is not a map"):
            read_environment(tmp_path / "notes.md", resolution_m=0.1)


def test_an_included_definition_is_used(read, tmp_path):
    (tmp_path / "inc").mkdir()
    (tmp_path / "inc" / "map.inc").write_text(FLOORPLAN)
    Image.new("L", (8, 6), 255).save(tmp_path / "inc" / "b.png")
    world = read(
        'include "inc/map.inc"\nfloorplan ( bitmap "./inc/b.png" size [8 6 1] name "cave" )'
    )
    assert_free(world, shapely.box(-3.99, -2.99, 3.99, 2.99))


def test_starts_are_bounded_and_distinct(read, monkeypatch):
    monkeypatch.setattr(files, "MAX_STARTS", 3)
    robots = "".join(f"position ( pose [{n // 2 / 10} 0 0 0] )" for n in range(20))
    assert read(PLAIN + robots).starts == ((0, 0), (0.1, 0), (0.2, 0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("model ( size [1 1 1] )", r"w\.world has no model with a bitmap, so there is no floorp"),
        ('model ( bitmap "b.png" )', "line 1 names the bitmap b.png, which is not in .*; copy it"),
        (
            'model ( bitmap "x/a.png" )',
            r'a\.png is beside the map: write "a\.png", or move it to x$',
        ),
        ('model ( bitmap "../a.png" )', r'a\.png is beside the map: write "a\.png"$'),
        ('model ( bitmap "/x/a.png" )', r'a\.png is beside the map: write "a\.png"$'),
        ('model ( bitmap "../a.png" )', r"line 1 names the file '\.\./a\.png', which is not in th"),
        ('model ( bitmap "/dev/zero" )', "line 1 names the file '/dev/zero', which is not in the"),
        ('model ( bitmap "w.world" )', r"w\.world is not an image"),
        ('model ( bitmap "." )', "is a folder"),
        ("model ( bitmap 5 )", "line 1: bitmap must be the name of an image in quotes"),
        ('model ( bitmap "" )', "line 1: bitmap must be the name of an image in quotes"),
        ('model ( bitmap "a\0.png" )', "cannot be opened|no closing|does not belong"),
        (PLAIN.replace("[8 6 1]", "[8 0 1]"), "line 1: the size is 8 x 0 m; both are above 0"),
        (PLAIN.replace("[8 6 1]", "[8 1e6 1]"), "line 1: the size is 8 x 1e.06 m"),
        (PLAIN.replace("[8 6 1]", "8"), r"line 1: size must be a tuple of numbers \[x y z\]"),
        (PLAIN.replace("[8 6 1]", '[8 "6" 1]'), "line 1: size must be a tuple of numbers"),
        (PLAIN[:-1] + "pose [1 2] )", r"line 1: pose must be a tuple of numbers \[x y z heading\]"),
        (PLAIN[:-1] + "pose [1e9 2 0 0] )", "line 1: pose is beyond 1e.07 m"),
        (PLAIN[:-1] + 'boundary "yes" )', "line 1: boundary must be a tuple of numbers with one"),
        ('unit_length "inch" ' + PLAIN, "line 1: unit_length must be one of m, cm, mm, in quotes"),
        ("unit_angle 5 " + PLAIN, "line 1: unit_angle must be one of degrees, radians"),
        (PLAIN + "model ( block ( points 2 ) )", "line 1: a block has points N, at least 3"),
        (PLAIN + "model ( block ( points 1e9 ) )", "line 1: a block has points N, at least 3"),
        (
            PLAIN + "model ( block ( points 3 point[0] [0 0] point[1] [1 0] z [0 1] ) )",
            r"line 1: the block has no point\[2\]",
        ),
        (
            PLAIN + "model ( block ( points 3 point[0] [0 0] point[1] [1 0] point[2] [2 0] ) )",
            "line 1: the block is not a valid polygon",
        ),
    ],
)
def test_fault_is_named(read, text, message):
    with pytest.raises(MapFormatError, match=message):
        read(text)


def test_a_world_has_its_own_scale_and_threshold(read):
    with pytest.raises(MapFormatError, match="leave out --resolution"):
        read(PLAIN, resolution_m=1.0)
    with pytest.raises(MapFormatError, match="leave out --threshold"):
        read(PLAIN, threshold=0.5)


@pytest.mark.parametrize(
    ("limit", "value", "message"),
    [
        ("MAX_BITMAPS", 1, "line 1: the world has more than 1 bitmaps"),
        (
            "MAX_CELLS",
            1535,
            "line 1: the bitmaps of the world have more than 1,535 pixels together",
        ),
        ("MAX_CORNERS", 20, r"w\.world: its models have more than 20 corners together"),
    ],
)
def test_sizes_of_worlds_are_bounded(read, tmp_path, monkeypatch, limit, value, message):
    shutil.copy(tmp_path / "a.png", tmp_path / "b.png")
    read(PLAIN * 2 + PLAIN.replace("a.png", "b.png"))
    monkeypatch.setattr(stage, limit, value)
    with pytest.raises(MapFormatError, match=message):
        read(PLAIN * 2 + PLAIN.replace("a.png", "b.png"))


@settings(deadline=None, max_examples=60)
@given(
    st.lists(
        st.tuples(
            st.integers(0, 300),
            st.integers(0, 4),
            st.text('()[]"#.-+e0123 \n\tadefinclub_', max_size=4),
        ),
        min_size=1,
        max_size=3,
    )
)
def test_mutated_worlds_are_read_or_refused(changes):
    text = (
        FLOORPLAN
        + 'floorplan ( bitmap "a.png" size [8 6 1] pose [1 2 0 30] origin [1 0 0 0] )\n'
        + "model ( size [1 1 1] block ( points 3 point[0] [0 0] point[1] [1 0] point[2] [0 1] ) )\n"
        + "define r position ( size [1 1 1] ) r ( pose [1 1 0 0] ) unknown ( pose [1 0 0 0] )"
    )
    for at, length, new in changes:
        text = text[:at] + new + text[at + length :]
    with tempfile.TemporaryDirectory() as folder:
        Image.fromarray(FRAME).save(Path(folder) / "a.png")
        path = Path(folder) / "w.world"
        path.write_text(text)
        try:
            world = read_environment(path)
        except MapFormatError:
            return
        assert world.free.is_valid


@pytest.fixture
def packaged(tmp_path):
    """The public worlds with their images where they name them."""

    def copied(folder, world, image):
        text = (MAPS / folder / world).read_text()
        name = text.partition('bitmap "')[2].partition('"')[0]
        inner = name.removeprefix("../")
        (tmp_path / world).write_text(text.replace(name, inner))
        (tmp_path / inner).parent.mkdir(exist_ok=True)
        shutil.copy(MAPS / folder / image, tmp_path / inner)
        for included in (MAPS / folder).glob("*.inc"):
            shutil.copy(included, tmp_path)
        return read_environment(tmp_path / world)

    return copied


def pixels_of(folder, image, size, centre, turned=False):
    """Centres of the pixels in metres and whether they are free, as Stage has them."""
    dark = np.asarray(Image.open(MAPS / folder / image).convert("L")) <= 127
    rows, columns = np.flatnonzero(dark.any(axis=1)), np.flatnonzero(dark.any(axis=0))
    dark = dark[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    row, column = np.indices(dark.shape)
    x = (column.ravel() + 0.5) / dark.shape[1] * size[0] - size[0] / 2
    y = size[1] / 2 - (row.ravel() + 0.5) / dark.shape[0] * size[1]
    if turned:
        x, y = -y, x
    return x + centre[0], y + centre[1], ~dark.ravel()


@needs_maps
@pytest.mark.slow
@pytest.mark.parametrize(
    ("folder", "world", "image", "size", "centre", "turned", "robots"),
    [
        ("stage", "simple.world", "cave.png", (16, 16), (0, 0), False, 2),
        ("stage", "autolab.world", "autolab.png", (20, 20), (0, 0), False, 30),
        ("nav2d", "tutorial4.world", "autolab_fill.png", (34, 30), (0, 0), False, 2),
        *(
            ("navigation_tutorials", world, image, size, centre, True, 1)
            for world, image, size, centre in (
                ("roomba_lse_arena.world", "lse_arena.pgm", (4, 3), (-1.5, 2)),
                ("willow-pr2.world", "willow-full.pgm", (58.4, 52.6), (-26.3, 29.2)),
                (
                    "willow-pr2-5cm.world",
                    "willow-full-0.05.pgm",
                    (58.25, 47.25),
                    (-23.625, 29.125),
                ),
            )
        ),
    ],
)
def test_public_world_has_each_pixel_in_place(
    packaged, folder, world, image, size, centre, turned, robots
):
    found = packaged(folder, world, image)
    x, y, free = pixels_of(folder, image, size, centre, turned)
    # The centres of pixels keep their side of every wall, but for the block in Willow Garage.
    wrong = shapely.contains_xy(found.free, x, y) != free
    block = np.hypot(x + 25.251, y - 10.586) < 0.5
    block |= np.hypot(x + 24.269, y - 48.001) < 0.5
    assert not (wrong & ~block).any()
    assert len(found.starts) == robots


def test_insides_of_outlined_obstacles_are_no_problem_and_no_building(read, tmp_path):
    pixels = np.full((60, 80), 255, np.uint8)
    pixels[[0, -1]] = pixels[:, [0, -1]] = 0
    for x in (10, 45):
        pixels[15:45, x : x + 25] = 0
        pixels[16:44, x + 1 : x + 24] = 255
    Image.fromarray(pixels).save(tmp_path / "blocks.png")
    world = read('model ( bitmap "blocks.png" size [16 12 1] ) position ( pose [0 5 0 0] )')
    assert len(world.components) == 3
    assert world.outlined_obstacles
    assert not read_environment(tmp_path / "blocks.png", resolution_m=0.2).outlined_obstacles
    for one in (world, fixed(world, CleaningOptions())):
        check = check_map(one, Footprint.disc(0.25))
        assert check.problems == ()
        assert check.around is None
        assert (
            "; others may be the insides of obstacles drawn as outlines" in list(report(check))[1]
        )
    # A robot that starts inside of an obstacle explores little: that is a problem.
    lost = read('model ( bitmap "blocks.png" size [16 12 1] ) position ( pose [-4 0 0 0] )')
    assert "only " in check_map(lost, Footprint.disc(0.25)).problems[0]
