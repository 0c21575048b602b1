import os
import shutil
from pathlib import Path

import pytest

from multisrt.environments.formats import FORMATS, format_of, read_environment
from multisrt.environments.formats.geojson import read_geojson
from multisrt.environments.formats.house_expo import read_house_expo
from multisrt.environments.formats.imr import read_imr
from multisrt.environments.formats.map_format import beginning_of
from multisrt.environments.formats.wkt import read_wkt
from multisrt.geometry.errors import MapFormatError

MAPS = Path(__file__).resolve().parents[2].parent / "shared" / "maps"
HAVE_MAPS = MAPS.is_dir()
SUFFIXES = [suffix for known in FORMATS for suffix in known.suffixes]
IN_METRES = (".yaml", ".yml", ".geojson", ".json", ".wkt", ".txt", ".world")

UNREADABLE = {
    "explore_bench/loop.yaml": "names the image square_loop.pgm, which is not in",
    "explore_bench/room.yaml": "names the image room1_modified.pgm, which is not in",
    "stage/autolab.world": "names the bitmap bitmaps/autolab.png, which is not in",
    "stage/simple.world": "names the bitmap bitmaps/cave.png, which is not in",
    "navigation_tutorials/roomba_lse_arena.world": "names the bitmap ./maps/lse_arena.pgm, which",
    "navigation_tutorials/willow-pr2.world": r"\.\./maps/willow-full\.pgm', which is not in",
    "navigation_tutorials/willow-pr2-5cm.world": r"willow-full-0\.05\.pgm', which is not in",
    "explore_bench/loop_with_corridor.yaml": "loop_with_corridor_sym.pgm, which is not in",
    **dict.fromkeys(
        (
            "mresim/team_4robots_maze.txt",
            "mresim/team_4robots_rooms.txt",
            "mresim/team_8robots-rooms.txt",
            "mresim/team_M1_L1_R8.txt",
        ),
        "is a team file of MRESim, .* --starts-from",
    ),
}


def public_maps():
    found = (p for p in sorted(MAPS.rglob("*")) if p.suffix.lower() in SUFFIXES)
    return [path.relative_to(MAPS).as_posix() for path in found]


def read_public(name, resolution_m=0.05):
    path = MAPS / name
    if path.suffix in IN_METRES:
        return read_environment(path)
    return read_environment(path, resolution_m=resolution_m)


needs_maps = pytest.mark.skipif(not HAVE_MAPS, reason="the shared maps are not here")


@pytest.mark.parametrize(
    ("name", "begins", "message"),
    [
        ("map.webp", b"RIFF\n\x00\x00\x00WEBPVP8 ", r"map\.webp is a WebP image; save it as PNG"),
        ("map.npz", b"PK\x03\x04\x2d", r"map\.npz is a zip archive, as \.npz files are; unzip it"),
        ("map.svgz", b"\x1f\x8b\x08", r"map\.svgz is compressed by gzip, as \.svgz .*; unpack it"),
    ],
)
def test_files_that_have_to_be_converted_are_told_how(tmp_path, name, begins, message):
    (tmp_path / name).write_bytes(begins)
    with pytest.raises(MapFormatError, match=message):
        format_of(tmp_path / name)


@pytest.mark.slow
@needs_maps
@pytest.mark.parametrize("name", public_maps() if HAVE_MAPS else [])
def test_public_map_is_read_or_its_fault_is_named(name):
    if name in UNREADABLE:
        with pytest.raises(MapFormatError, match=UNREADABLE[name]):
            read_public(name)
        return
    world = read_public(name)
    assert world.name == Path(name).stem
    assert world.origin.startswith(Path(name).name)
    assert world.area_m2 > 0.5
    assert world.free.is_valid


@needs_maps
def test_inside_of_outlined_blocks_is_another_component():
    outlines = read_public("stage/cave.png", 0.032)
    around = outlines.component(1, 1)
    solid = read_public("stage/cave_filled.png", 0.032)
    blocks = [part for part in outlines.free.geoms if not part.equals(around)]
    assert len(blocks) == 7
    # In the filled picture the blocks are solid, so what is free there is free around them.
    assert all(solid.free.intersection(block).area < 0.05 * block.area for block in blocks)
    assert around.equals(solid.component(1, 1))


@needs_maps
def test_unknown_is_not_free_without_a_yaml():
    world = read_public("explore_bench/loop.pgm", 0.1)
    assert world.area_m2 == pytest.approx(19041 * 0.01, rel=1e-3)
    assert len(world.edges) == 10


@needs_maps
@pytest.mark.parametrize(
    ("name", "free_pixels"),
    [
        ("ir2_dungeon/test_hybrid_1.png", 106875 + 625),
        ("ir2_dungeon/train_easy_img_2.png", 68352 + 256),
        ("nav2d/autolab_fill.png", 334090),
        ("mresim/mine.png", 169277),
        ("mresim/maze2.png", 175539 + 35071),
    ],
)
def test_default_threshold_finds_the_free_pixels(name, free_pixels):
    assert read_public(name, 1.0).area_m2 == pytest.approx(free_pixels, rel=2e-3)


def test_unknown_content_and_suffix_list_the_readable_ones(tmp_path):
    path = tmp_path / "map.xyz"
    path.write_text("0")
    with pytest.raises(
        MapFormatError, match=r"suffix '\.xyz'; readable formats: ROS map server \(\.yaml"
    ):
        read_environment(path)


CONTENTS = {
    "ROS map server": b"\xef\xbb\xbfresolution: 0.1\nimage: room.pgm\n",
    "image": b"P2\n1 1\n1\n1\n",
    "GeoJSON": b' {"type": "Polygon", "coordinates": []}',
    "well-known text": b"\nPolygon ((0 0, 1 0, 1 1, 0 0))",
    "MovingAI grid": b"type octile\nheight 1\nwidth 1\nmap\n.\n",
    "IMR polygons": b"\n[SCALE]\n1\n",
    "MovingAI scenario": b"version 1\n0\ta.map\t1\t1\t0\t0\t0\t0\t0\n",
    "Stage world": b'# a world\ninclude "map.inc"\nfloorplan ( bitmap "a.png" )\n',
    "HouseExpo": b'{"verts": [[0, 0], [1, 0], [1, 1]], "id": "a", "room_num": 1}',
    "numpy array": b"\x93NUMPY\x01\0",
    "SVG": b"<?xml version='1.0'?>\n<svg width='1'>",
    "DXF": b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n",
}


@pytest.mark.parametrize("name", [known.name for known in FORMATS])
def test_format_is_known_by_content_whatever_the_suffix(tmp_path, name):
    path = tmp_path / "world.xyz"
    path.write_bytes(CONTENTS[name])
    assert format_of(path).name == name
    assert sum(known.recognises(beginning_of(path)) for known in FORMATS) == 1


@needs_maps
def test_public_map_is_recognised_by_one_format():
    strange = {
        name: names
        for name in public_maps()
        if name not in UNREADABLE
        and len(names := [f.name for f in FORMATS if f.recognises(beginning_of(MAPS / name))]) != 1
    }
    assert not strange


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_missing_folder_and_empty_file_are_named(tmp_path, suffix):
    path = tmp_path / f"world{suffix}"
    with pytest.raises(MapFormatError, match=f"world{suffix} does not exist"):
        read_environment(path)
    path.write_bytes(b"")
    with pytest.raises(MapFormatError, match=f"world{suffix} is empty"):
        read_environment(path)
    path.unlink()
    path.mkdir()
    with pytest.raises(MapFormatError, match=f"world{suffix} is a folder"):
        read_environment(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    "content",
    [b"\x00", b"\xff\xfe\xfa", b"{", b"[]", b"P5\n", b"\x89PNG\r\n\x1a\n", b"()" * 50, b"a: 1"],
)
def test_rubbish_gives_a_map_format_error(tmp_path, suffix, content):
    path = tmp_path / f"world{suffix}"
    path.write_bytes(content)
    for resolution_m in (None, 1.0):
        with pytest.raises(MapFormatError, match=f"world{suffix}"):
            read_environment(path, resolution_m=resolution_m)


def test_suffix_in_capitals_string_path_and_name(tmp_path):
    path = tmp_path / "Hall.WKT"
    path.write_text("POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0))")
    world = read_environment(str(path))
    assert (world.name, world.area_m2, world.origin) == ("Hall", 12.0, "Hall.WKT")
    assert read_environment(path, name="room").name == "room"


@needs_maps
def test_name_with_dots_keeps_them(tmp_path):
    path = tmp_path / "lse-0.05.pgm"
    shutil.copy(MAPS / "navigation_tutorials" / "lse_arena.pgm", path)
    assert read_environment(path, resolution_m=0.05).name == "lse-0.05"


@pytest.mark.parametrize("reader", [read_wkt, read_geojson, read_imr, read_house_expo])
def test_files_of_polygons_have_a_bound_of_their_own(reader, tmp_path):
    path = tmp_path / "large"
    path.touch()
    os.truncate(path, 24 * 2**20 + 1)
    said = r"large has 25,165,825 bytes; files of this format are read up to 25,165,824"
    with pytest.raises(MapFormatError, match=said):
        reader(path)
    os.truncate(path, 24 * 2**20)
    with pytest.raises(MapFormatError, match=r"^(?!.*read up to)"):
        reader(path)
