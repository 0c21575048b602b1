import struct
import zlib

import numpy as np
import pytest
import shapely
from PIL import Image

from multisrt.environments.formats import read_environment, read_image
from multisrt.geometry.errors import MapFormatError

# An image of 6 x 4 pixels that is light in columns 1 to 4 of its upper two rows.
FREE = np.zeros((4, 6), dtype=bool)
FREE[:2, 1:5] = True
ROOM = shapely.box(1, 2, 5, 4)


def as_pgm(values, magic, maximum=255, comment=b"# CREATOR: by hand 0.1 m/pix\n"):
    rows, columns = values.shape
    head = magic + b"\n" + comment + b"%d %d\n%d\n" % (columns, rows, maximum)
    if magic == b"P2":
        return head + b"\n".join(b" ".join(b"%d" % v for v in row) for row in values.tolist())
    return head + values.astype(">u2" if maximum > 255 else "u1").tobytes()


def assert_room(path, **options):
    world = read_image(path, resolution_m=1.0, **options)
    assert world.free.equals(ROOM), shapely.to_wkt(world.free)


@pytest.mark.parametrize("magic", [b"P2", b"P5"])
@pytest.mark.parametrize("maximum", [15, 255, 65535])
def test_pgm_of_any_depth_is_read(tmp_path, magic, maximum):
    path = tmp_path / "room.pgm"
    path.write_bytes(as_pgm(FREE * maximum, magic, maximum))
    assert_room(path)


def test_pgm_comment_between_the_sizes(tmp_path):
    path = tmp_path / "room.pgm"
    pixels = (FREE * np.uint8(255)).tobytes()
    path.write_bytes(b"P5 # a\n6\n# b\n4\n255\n" + pixels)
    assert_room(path)


@pytest.mark.parametrize("suffix", [".png", ".bmp", ".gif", ".tif", ".jpg", ".pbm", ".ppm"])
def test_every_suffix_is_read(tmp_path, suffix):
    scale = 8 if suffix == ".jpg" else 1  # a JPEG's blocks, so that no wall is blurred
    grey = (FREE * np.uint8(255)).repeat(scale, axis=0).repeat(scale, axis=1)
    image = Image.fromarray(grey)
    image = image.convert({".pbm": "1", ".ppm": "RGB"}.get(suffix, "L"))
    path = tmp_path / f"room{suffix}"
    image.save(path)
    world = read_environment(path, resolution_m=1 / scale)
    assert world.free.equals(ROOM)


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "PA", "RGB", "RGBA", "CMYK"])
def test_every_mode_of_pillow_is_read(tmp_path, mode):
    image = Image.fromarray(FREE * np.uint8(255)).convert("RGB" if mode == "PA" else "L")
    path = tmp_path / ("room.tif" if mode in ("PA", "CMYK") else "room.png")
    image = image.convert("P").convert("PA") if mode == "PA" else image.convert(mode)
    image.save(path)
    with Image.open(path) as saved:
        assert saved.mode == mode
    assert_room(path)


def test_sixteen_bit_grey_png(tmp_path):
    path = tmp_path / "room.png"
    Image.fromarray(FREE * np.uint16(65533)).save(path)
    assert_room(path)


def test_transparent_pixels_are_not_free(tmp_path):
    rgba = np.full((4, 6, 4), 255, np.uint8)
    rgba[:, :, 3] = np.where(FREE, 255, 254)
    path = tmp_path / "room.png"
    Image.fromarray(rgba).save(path)
    assert_room(path)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_transparent_grey_is_not_free(tmp_path, dtype):
    full = np.iinfo(dtype).max
    path = tmp_path / "room.png"
    image = Image.fromarray(np.where(FREE, full, full - 1).astype(dtype))
    image.save(path, transparency=int(full) - 1)
    assert_room(path)


def test_transparent_palette_colour_is_not_free(tmp_path):
    image = Image.fromarray(FREE.astype(np.uint8)).convert("P")
    image.putpalette([255, 255, 255, 255, 255, 255])
    path = tmp_path / "room.png"
    image.save(path, transparency=0)
    assert_room(path)


def test_colours_count_by_their_luma(tmp_path):
    rgb = np.zeros((4, 6, 3), np.uint8)
    rgb[FREE] = (0, 255, 0)
    path = tmp_path / "green.png"
    Image.fromarray(rgb).save(path)
    assert_room(path, threshold=0.586)
    with pytest.raises(MapFormatError, match=r"no opaque pixel is lighter than 0\.588"):
        read_image(path, resolution_m=1.0, threshold=0.588)


@pytest.mark.parametrize(
    ("free", "wall"), [(255, 204), (254, 205), (195, 127), (253, 0), (255, 211), (208, 180)]
)
def test_default_threshold_follows_the_white_of_the_map(tmp_path, free, wall):
    path = tmp_path / "room.png"
    Image.fromarray(np.where(FREE, free, wall).astype(np.uint8)).save(path)
    assert_room(path)


def test_few_bright_pixels_do_not_make_the_white(tmp_path):
    grey = np.full((40, 50), 195, np.uint8)
    grey[20, 20] = 255
    path = tmp_path / "hall.png"
    Image.fromarray(grey).save(path)
    assert read_image(path, resolution_m=1.0).area_m2 == 2000


def test_threshold_is_exclusive(tmp_path):
    path = tmp_path / "room.png"
    Image.fromarray(np.where(FREE, 129, 128).astype(np.uint8)).save(path)
    assert_room(path, threshold=128 / 255)
    assert read_image(path, resolution_m=1.0, threshold=127 / 255).area_m2 == 24


def test_lower_left_corner_is_the_origin(tmp_path):
    grey = np.zeros((30, 10), np.uint8)
    grey[28:, :4] = 255  # the picture's lower left
    path = tmp_path / "corner.png"
    Image.fromarray(grey).save(path)
    world = read_image(path, resolution_m=0.25)
    assert world.bounds == (0, 0, 1, 0.5)
    assert world.origin == "corner.png at 0.25 m per pixel, free above lightness 0.9"


def test_resolution_is_asked_for(tmp_path):
    path = tmp_path / "room.png"
    Image.fromarray(FREE * np.uint8(255)).save(path)
    with pytest.raises(MapFormatError, match=r"room\.png .*--resolution"):
        read_environment(path)


@pytest.mark.parametrize(
    "resolution_m", [0.0, -0.1, float("nan"), float("inf"), 1e-4, 1e-300, 2e7, 1e308]
)
def test_resolution_is_checked(tmp_path, resolution_m):
    path = tmp_path / "room.png"
    Image.fromarray(FREE * np.uint8(255)).save(path)
    with pytest.raises(MapFormatError, match=r"finite number, at least 0.001 and at most 1e.07 m"):
        read_environment(path, resolution_m=resolution_m)


@pytest.mark.parametrize("threshold", [-0.1, 1.1, 128.0, float("nan")])
def test_threshold_is_checked(tmp_path, threshold):
    path = tmp_path / "room.png"
    Image.fromarray(FREE * np.uint8(255)).save(path)
    with pytest.raises(MapFormatError, match=r"threshold is .*\[0, 1\]"):
        read_environment(path, resolution_m=1.0, threshold=threshold)


def test_black_image_has_no_free_space(tmp_path):
    path = tmp_path / "black.png"
    Image.fromarray(np.zeros((5, 5), np.uint8)).save(path)
    with pytest.raises(MapFormatError, match=r"every opaque pixel is black, .* light and opaque$"):
        read_image(path, resolution_m=1.0)
    with pytest.raises(MapFormatError, match=r"lighter than 0\.5, .*give a lower --threshold"):
        read_image(path, resolution_m=1.0, threshold=0.5)
    Image.fromarray(np.zeros((5, 5, 2), np.uint8), "LA").save(path)
    with pytest.raises(MapFormatError, match="no pixel is opaque"):
        read_image(path, resolution_m=1.0)


def test_world_beyond_the_largest_coordinate_is_named(tmp_path):
    path = tmp_path / "room.png"
    Image.fromarray(FREE * np.uint8(255)).save(path)
    with pytest.raises(MapFormatError, match=r"room\.png.*finite numbers of metres"):
        read_image(path, resolution_m=1e7)


def png_header(width, height):
    def chunk(kind, body):
        check = zlib.crc32(kind + body)
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", check)

    head = chunk(b"IHDR", struct.pack(">II5B", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(b"\0" * 40))


@pytest.mark.parametrize(("width", "height"), [(10_000, 10_000), (8001, 8000)])
def test_large_header_is_refused_with_its_size(tmp_path, width, height):
    pgm, png = tmp_path / "large.pgm", tmp_path / "large.png"
    pgm.write_bytes(b"P5\n%d %d\n255\n" % (width, height))
    png.write_bytes(png_header(width, height))
    for path in (pgm, png):
        with pytest.raises(MapFormatError, match=f"{width} x {height} pixels.*64,000,000"):
            read_image(path, resolution_m=1.0)


def test_huge_header_is_refused(tmp_path):
    pgm, png = tmp_path / "huge.pgm", tmp_path / "huge.png"
    pgm.write_bytes(b"P2\n100000 100000\n255\n0 0 0")
    png.write_bytes(png_header(100_000, 100_000))
    for path in (pgm, png):
        with pytest.raises(MapFormatError, match=r"10,000,000,000 pixels.*64,000,000"):
            read_image(path, resolution_m=1.0)


@pytest.mark.parametrize("name", ["room.png", "room.bmp", "room.gif", "room.tif", "room.jpg"])
def test_truncated_image_is_damaged(tmp_path, name):
    path = tmp_path / name
    noise = np.random.default_rng(1).integers(0, 256, (60, 60)).astype(np.uint8)
    Image.fromarray(noise).save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(MapFormatError, match=f"{name} is (a damaged|not an) image.*save it"):
        read_image(path, resolution_m=1.0)


@pytest.mark.parametrize(
    "content",
    [
        b"P5\n6 4\n255\n" + b"\xff" * 23,
        b"P2\n6 4\n255\n" + b"255 " * 23,
        b"P2\n6 4\n255\n" + b"255 " * 23 + b"nine",
        b"P5\n0 4\n255\n",
        b"P5\n6 4\n",
        b"P5\nsix 4\n255\n",
        b"P5\n6 4\n70000\n" + b"\xff" * 96,
    ],
)
def test_faulty_pgm_is_named(tmp_path, content):
    path = tmp_path / "room.pgm"
    path.write_bytes(content)
    with pytest.raises(MapFormatError, match=r"room\.pgm is"):
        read_image(path, resolution_m=1.0)


def test_floating_point_image_is_refused(tmp_path):
    path = tmp_path / "room.tif"
    Image.fromarray(FREE.astype(np.float32)).save(path)
    with pytest.raises(MapFormatError, match="floating-point"):
        read_image(path, resolution_m=1.0)
    Image.fromarray(FREE.astype(np.int32) * 70_000).save(path)
    with pytest.raises(MapFormatError, match="from 0 to 70000"):
        read_image(path, resolution_m=1.0)
