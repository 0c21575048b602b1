import math

import numpy as np
import pytest
import shapely
from PIL import Image

from multisrt.environments.formats import read_environment
from multisrt.geometry.errors import MapFormatError

DEFAULTS = {
    "image": "map.pgm",
    "resolution": 1.0,
    "origin": "[0.0, 0.0, 0.0]",
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}


def write_yaml(folder, **changes):
    entries = {**DEFAULTS, **changes}
    path = folder / "map.yaml"
    path.write_text("".join(f"{k}: {v}\n" for k, v in entries.items() if v is not ...))
    return path


def write_pixels(folder, pixels, name="map.pgm"):
    Image.fromarray(np.asarray(pixels, dtype=np.uint8)).save(folder / name)


@pytest.fixture
def room(tmp_path):
    """Free 3 x 2 metres at the lower left of an image of 5 x 4 pixels; the rest is unknown."""
    pixels = np.full((4, 5), 205)
    pixels[2:, :3] = 254
    pixels[1, :4] = 0
    write_pixels(tmp_path, pixels)
    return tmp_path


def test_free_is_free_and_unknown_is_not(room):
    world = read_environment(write_yaml(room))
    assert world.free.equals(shapely.box(0, 0, 3, 2))
    assert world.name == "map"
    assert world.origin == "map.yaml with map.pgm, 1 m per pixel"


def test_resolution_and_origin(room):
    path = write_yaml(room, resolution=0.05, origin="[-12.5, 3, 0]")
    assert read_environment(path).bounds == pytest.approx((-12.5, 3, -12.35, 3.1))


def test_yaw_turns_the_world_about_its_lower_left_corner(room):
    path = write_yaml(room, origin=f"[10, 20, {math.pi / 2}]")
    world = read_environment(path)
    assert world.bounds == pytest.approx((8, 20, 10, 23))
    path = write_yaml(room, origin=f"[1, 1, {math.pi / 6}]")
    turned = shapely.affinity.rotate(shapely.box(0, 0, 3, 2), 30, origin=(0, 0))
    expected = shapely.affinity.translate(turned, 1, 1)
    assert read_environment(path).free.symmetric_difference(expected).area < 1e-12


@pytest.mark.parametrize("negate", [1, "true", "'1'"])
def test_negate_reverses_occupancy(tmp_path, negate):
    write_pixels(tmp_path, [[0, 255, 0], [49, 50, 128]])
    # p = x / 255: 49 is 0.192 and free, 50 is 0.19608 and unknown.
    world = read_environment(write_yaml(tmp_path, negate=negate))
    expected = shapely.box(0, 0, 1, 2) | shapely.box(2, 1, 3, 2)
    assert world.free.symmetric_difference(expected).area < 0.1
    assert len(world.free.geoms) == 2


@pytest.mark.parametrize(
    ("free_thresh", "area"), [(0.196, 2), (0.2, 3), (0.2001, 4), (1.0, 5), (0.0039, 1)]
)
def test_thresholds_are_exclusive(tmp_path, free_thresh, area):
    # p: 0, 0.00392, 0.19608, 0.2 exactly, 0.647, 0.651.
    write_pixels(tmp_path, [[255, 254, 205, 204, 90, 89]])
    path = write_yaml(tmp_path, free_thresh=free_thresh, occupied_thresh=0.65)
    assert read_environment(path).area_m2 == pytest.approx(area)


def test_occupied_wins_where_thresholds_overlap(tmp_path):
    write_pixels(tmp_path, [[255, 200, 100]])
    path = write_yaml(tmp_path, free_thresh=0.9, occupied_thresh=0.1)
    assert read_environment(path).area_m2 == 1


def test_colour_is_the_mean_of_its_channels(tmp_path):
    write_pixels(tmp_path, [[(255, 255, 105), (255, 255, 104)]], "map.png")
    # Means 205 and 204.67, so p is 0.19608 and 0.1974.
    path = write_yaml(tmp_path, image="map.png", free_thresh=0.197)
    assert read_environment(path).free.equals(shapely.box(0, 0, 1, 1))


@pytest.mark.parametrize(("mode", "area"), [("scale", 1), ("trinary", 2), ("Trinary", 2)])
def test_alpha_counts_by_mode(tmp_path, mode, area):
    # Trinary averages alpha in: 254.75 and 250; scale takes any transparency for unknown.
    pixels = [[(255, 255, 255, 255), (255, 255, 255, 235), (255, 255, 255, 0)]]
    write_pixels(tmp_path, pixels, "map.png")
    path = write_yaml(tmp_path, image="map.png", mode=mode)
    assert read_environment(path).area_m2 == area


def test_grey_with_alpha_is_four_channels(tmp_path):
    image = Image.fromarray(np.array([[(200, 255), (180, 255)]], np.uint8))
    assert image.mode == "LA"
    image.save(tmp_path / "map.png")
    # Trinary: means 213.75 and 198.75, so p is 0.162 and 0.221. Scale: 0.216 and 0.294.
    assert read_environment(write_yaml(tmp_path, image="map.png")).area_m2 == 1
    with pytest.raises(MapFormatError, match="no free space"):
        read_environment(write_yaml(tmp_path, image="map.png", mode="scale"))


def test_scale_takes_between_for_partly_occupied(room):
    assert read_environment(write_yaml(room, mode="scale")).area_m2 == 6


def test_sixteen_bit_image(tmp_path):
    Image.fromarray(np.array([[65535, 52690, 52680, 0]], np.uint16)).save(tmp_path / "map.png")
    # p: 0, 0.19600, 0.19615, 1
    path = write_yaml(tmp_path, image="map.png", free_thresh=0.1961)
    assert read_environment(path).area_m2 == 2


def test_raw_is_refused(room):
    with pytest.raises(MapFormatError, match="mode is raw"):
        read_environment(write_yaml(room, mode="raw"))


@pytest.mark.parametrize("folder", [".", "images"])
def test_image_is_relative_to_the_yaml_or_absolute(room, folder):
    (room / "images").mkdir()
    (room / "map.pgm").rename(room / folder / "plan.pgm")
    for image in (f"{folder}/plan.pgm", room / folder / "plan.pgm"):
        assert read_environment(write_yaml(room, image=image)).area_m2 == 6


def test_missing_image_names_yaml_image_and_folder(room):
    path = write_yaml(room, image="maps/other.pgm")
    with pytest.raises(MapFormatError) as caught:
        read_environment(path)
    assert str(path) in str(caught.value)
    assert "the image maps/other.pgm, which is not in" in str(caught.value)
    assert f"which is not in {room}; copy it there" in str(caught.value)
    path = write_yaml(room, image="maps/map.pgm")
    with pytest.raises(
        MapFormatError, match=r'beside the map: write "map\.pgm", or move it to maps'
    ):
        read_environment(path)


@pytest.mark.parametrize("key", DEFAULTS)
def test_missing_key_is_named(room, key):
    with pytest.raises(MapFormatError, match=f"map.yaml lacks {key};"):
        read_environment(write_yaml(room, **{key: ...}))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("resolution", "0", "resolution is 0 m"),
        ("resolution", "-0.1", "resolution is -0.1 m"),
        ("resolution", ".nan", "resolution is nan; it must be a finite number"),
        ("resolution", ".inf", "resolution is inf"),
        ("resolution", "1e308", "resolution is 1e.308 m per cell; .* at most 1e.07 m"),
        ("resolution", "!x" + "y" * 2000 + " 1", r"constructor for the tag '!xy{100,200}\.\.\.$"),
        ("resolution", "wide", "resolution is 'wide'"),
        ("resolution", "true", "resolution is True"),
        ("resolution", "[1, 2]", "resolution is a list of 2"),
        ("resolution", "1" + "0" * 400, "resolution is 1000"),
        ("origin", "[0, 0]", "origin is a list of 2; it must be a list"),
        ("origin", "0", "origin is 0; it must be a list"),
        ("origin", "[0, .nan, 0]", "origin, number 2 is nan"),
        ("origin", "[0, 0, north]", "origin, number 3 is 'north'"),
        ("negate", "2", "negate is 2; it must be 0 or 1"),
        ("negate", "[0]", "negate is a list"),
        ("free_thresh", "19.6", r"free_thresh is 19.6; it must be an occupancy in \[0, 1\]"),
        ("occupied_thresh", "-1", "occupied_thresh is -1"),
        ("mode", "ternary", "mode is 'ternary'; it must be trinary or scale"),
        ("mode", "3", "mode is 3"),
        ("image", "[a, b]", "image is a list of 2"),
        ("image", '"a\\0b"', "names the file 'a.*', which cannot be opened: embedded null byte"),
        ("image", "map.yaml", "map.yaml is not an image"),
        ("image", ".", "is a folder"),
    ],
)
def test_wrong_value_is_named(room, key, value, message):
    with pytest.raises(MapFormatError, match=message):
        read_environment(write_yaml(room, **{key: value}))


def test_exponent_without_a_point_is_a_number(room):
    assert read_environment(write_yaml(room, resolution="5e-1")).area_m2 == 1.5


def test_a_map_without_free_cells_is_refused(tmp_path):
    write_pixels(tmp_path, np.full((3, 3), 205))
    with pytest.raises(MapFormatError, match=r"no pixel's occupancy is below free_thresh 0\.196"):
        read_environment(write_yaml(tmp_path))


def test_scale_and_threshold_are_the_files_own(room):
    path = write_yaml(room)
    with pytest.raises(MapFormatError, match="has its own scale"):
        read_environment(path, resolution_m=0.1)
    with pytest.raises(MapFormatError, match="--threshold"):
        read_environment(path, threshold=0.5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("image: [a", r"is not YAML, line \d+, column \d+"),
        ("image: !!python/object/apply:os.getcwd []", "is not YAML, line 1"),
        ("- 1\n- 2", "has no keys"),
        ("just words", "has no keys"),
        ("# nothing", "has no keys"),
        ("{" * 3000, "is not YAML"),
        ("image: a\x01b", "is not YAML"),
        ("resolution: 2020-99-99", "is not YAML|lacks"),
    ],
)
def test_text_that_is_no_map(tmp_path, content, message):
    path = tmp_path / "map.yaml"
    path.write_text(content)
    with pytest.raises(MapFormatError, match=message):
        read_environment(path)


def test_aliases_that_multiply_are_refused(room):
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 12)]
    path = write_yaml(room, resolution="*a11")
    path.write_text("\n".join(lines) + "\n" + path.read_text())
    with pytest.raises(MapFormatError, match="has an alias"):
        read_environment(path)


@pytest.mark.parametrize(
    ("repeated", "message"),
    [
        ("resolution: 0.1", "line 7 states 'resolution' again, after line 2; remove one of them"),
        ('"resolution": 1', "line 7 states 'resolution' again, after line 2; remove one of them"),
        ("note: 1\nnote: 1", "line 8 states 'note' again, after line 7"),
    ],
)
def test_a_key_that_is_given_twice_is_refused(room, repeated, message):
    path = write_yaml(room)
    path.write_text(path.read_text() + repeated)
    with pytest.raises(MapFormatError, match=message):
        read_environment(path)


def test_a_key_that_is_given_twice_on_one_line_is_refused(room):
    path = room / "map.yaml"
    path.write_text("{image: map.pgm, resolution: 1, resolution: 2}")
    with pytest.raises(MapFormatError, match="line 1 states 'resolution' again, after line 1"):
        read_environment(path)


def test_large_yaml_and_other_encodings_are_refused(tmp_path):
    path = tmp_path / "map.yaml"
    path.write_bytes(b"# " + b"x" * 2**20)
    with pytest.raises(MapFormatError, match=r"1,048,578 bytes.*up to 65,536"):
        read_environment(path)
    path.write_bytes("image: größe.pgm".encode("latin-1"))
    with pytest.raises(MapFormatError, match="not UTF-8 text: byte 9 is 0xf6"):
        read_environment(path)


def test_swapped_thresholds_are_read_as_ros_does_and_told(room):
    world = read_environment(write_yaml(room, occupied_thresh=0.25, free_thresh=0.65))
    # Unknown pixels have the occupancy 50/255: not above one, and below the other.
    assert world.free.equals(shapely.box(0, 0, 5, 4) - shapely.box(0, 2, 4, 3))
    assert "occupied_thresh 0.25 is below free_thresh 0.65: were they swapped?" in str(
        world.cleaning
    )
    assert not read_environment(write_yaml(room)).cleaning
    assert not read_environment(write_yaml(room, free_thresh=0.3, occupied_thresh=0.3)).cleaning
