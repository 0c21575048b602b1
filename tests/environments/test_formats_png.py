"""Every kind of PNG, written byte by byte."""

import contextlib
import struct
import tracemalloc
import zlib

import numpy as np
import pytest
import shapely

from multisrt.environments.formats import read_image
from multisrt.geometry.errors import MapFormatError

# An image of 13 x 9 pixels that is light in columns 1 to 11 of its upper four rows.
FREE = np.zeros((9, 13), dtype=bool)
FREE[:4, 1:12] = True
ROOM = shapely.box(1, 5, 12, 9)

GREY, RGB, PALETTE, GREY_ALPHA, RGBA = 0, 2, 3, 4, 6
CHANNELS = {GREY: 1, RGB: 3, PALETTE: 1, GREY_ALPHA: 2, RGBA: 4}
DEPTHS = {
    GREY: (1, 2, 4, 8, 16),
    RGB: (8, 16),
    PALETTE: (1, 2, 4, 8),
    GREY_ALPHA: (8, 16),
    RGBA: (8, 16),
}
KINDS = [(kind, depth) for kind, depths in DEPTHS.items() for depth in depths]
# First row, first column, and steps of the seven passes of Adam7.
PASSES = [(0, 0, 8, 8), (0, 4, 8, 8), (4, 0, 8, 4), (0, 2, 4, 4), (2, 0, 4, 2), (0, 1, 2, 2),
          (1, 0, 2, 1)]  # fmt: skip


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def packed(samples, depth):
    """Rows of samples, each after its filter, as bytes."""
    rows = samples.reshape(len(samples), -1)
    bits = (rows[:, :, np.newaxis] >> np.arange(depth - 1, -1, -1)) & 1
    lines = np.packbits(bits.reshape(len(rows), -1).astype(np.uint8), axis=1)
    return b"".join(b"\0" + line.tobytes() for line in lines)


def png(samples, kind, depth, interlaced=False, extra=()):
    """A PNG of samples of shape (rows, columns, channels)."""
    rows, columns = samples.shape[:2]
    parts = [samples]
    if interlaced:
        parts = [samples[r::down, c::right] for r, c, down, right in PASSES]
    body = b"".join(packed(part, depth) for part in parts if part.size)
    head = struct.pack(">II5B", columns, rows, depth, kind, 0, 0, int(interlaced))
    chunks = [(b"IHDR", head), *extra, (b"IDAT", zlib.compress(body)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*one) for one in chunks)


def assert_room(tmp_path, content, **options):
    path = tmp_path / "room.png"
    path.write_bytes(content)
    world = read_image(path, resolution_m=1.0, **options)
    assert world.free.equals(ROOM), shapely.to_wkt(world.free)


def light_and_dark(kind, depth):
    """The samples of a light pixel and of a dark one, both opaque, and the palette."""
    full = 2**depth - 1
    if kind == PALETTE:
        return [1], [0], [(b"PLTE", bytes([40, 40, 40, 250, 250, 240]))]
    opaque = [full] if kind in (GREY_ALPHA, RGBA) else []
    colours = CHANNELS[kind] - len(opaque)
    dark = full * 3 // 4 if depth > 1 else 0
    return [full] * colours + opaque, [dark] * colours + opaque, []


@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize(("kind", "depth"), KINDS)
def test_every_kind_of_png_is_read(tmp_path, kind, depth, interlaced):
    light, dark, extra = light_and_dark(kind, depth)
    samples = np.where(FREE[:, :, np.newaxis], light, dark)
    assert_room(tmp_path, png(samples, kind, depth, interlaced, extra))


@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize(("kind", "depth"), [one for one in KINDS if one[0] in (GREY, RGB)])
def test_the_transparent_colour_is_not_free(tmp_path, kind, depth, interlaced):
    full = 2**depth - 1
    # A colour that is as good as white, or the very white where there are but two greys.
    light, key = (full, full - 1) if depth > 2 else (full - 1, full)
    if depth == 1:
        light, key = 1, 0
    samples = np.where(FREE, light, key)[:, :, np.newaxis].repeat(CHANNELS[kind], axis=2)
    transparent = (b"tRNS", struct.pack(">H", key) * CHANNELS[kind])
    if (kind, depth) == (RGB, 16):
        with pytest.raises(MapFormatError, match="transparent colour of 16 bits"):
            assert_room(tmp_path, png(samples, kind, depth, interlaced, [transparent]))
        return
    assert_room(tmp_path, png(samples, kind, depth, interlaced, [transparent]))


@pytest.mark.parametrize("depth", DEPTHS[PALETTE])
def test_transparent_colours_of_a_palette_are_not_free(tmp_path, depth):
    samples = np.where(FREE, 0, 1)[:, :, np.newaxis]
    extra = [(b"PLTE", b"\xff" * 6), (b"tRNS", bytes([255, 254]))]
    assert_room(tmp_path, png(samples, PALETTE, depth, extra=extra))


@pytest.mark.parametrize("depth", [8, 16])
@pytest.mark.parametrize("kind", [GREY_ALPHA, RGBA])
def test_translucent_pixels_are_not_free(tmp_path, kind, depth):
    full = 2**depth - 1
    white = np.full((*FREE.shape, CHANNELS[kind]), full)
    white[:, :, -1] = np.where(FREE, full, full - 2 ** (depth - 8))
    assert_room(tmp_path, png(white, kind, depth))


def test_a_scale_for_printing_is_not_the_scale_of_the_map(tmp_path):
    """Programs write one into nearly every file, of 72 or 96 pixels per inch."""
    light, dark, _ = light_and_dark(GREY, 8)
    samples = np.where(FREE[:, :, np.newaxis], light, dark)
    path = tmp_path / "room.png"
    path.write_bytes(png(samples, GREY, 8, extra=[(b"pHYs", struct.pack(">IIB", 20, 20, 1))]))
    path.with_suffix(".pgw").write_text("0.05\n0\n0\n-0.05\n0\n0\n")
    with pytest.raises(MapFormatError, match="--resolution"):
        read_image(path)
    assert read_image(path, resolution_m=1.0).area_m2 == 44


def test_a_length_in_the_file_is_not_allocated(tmp_path):
    light, dark, _ = light_and_dark(GREY, 8)
    content = png(np.where(FREE[:, :, np.newaxis], light, dark), GREY, 8)
    at = content.index(b"IDAT") - 4
    path = tmp_path / "room.png"
    path.write_bytes(content[:at] + struct.pack(">I", 2**30) + content[at + 4 :])
    tracemalloc.start()
    try:
        with contextlib.suppress(MapFormatError):
            read_image(path, resolution_m=1.0)
        assert tracemalloc.get_traced_memory()[1] < 2**26
    finally:
        tracemalloc.stop()
