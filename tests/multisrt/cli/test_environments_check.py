import json
import re
import xml.etree.ElementTree as ET

import pytest
import shapely

from multisrt.cli.environments import FIXED
from multisrt.environments.formats import FORMATS, read_environment
from multisrt.environments.written_suffixes import READABLE_SUFFIXES
from multisrt.exporting.worlds import MAP_SUFFIXES
from tests.multisrt.cli.commands import everything

STAIRS = "type octile\nheight 5\nwidth 5\nmap\n@@@..\n@@...\n@....\n.....\n.....\n"
BOW = "POLYGON ((0 0, 4 4, 4 0, 0 4))"


def test_a_map_that_suits_the_body_exits_with_0(call):
    code, out, err = call("environments", "check", "pillar.wkt")
    assert (code, err) == (0, "")
    assert out.splitlines()[:2] == [
        "pillar: 9 x 6 m, 50 m2 free, 8 vertices",
        "free space: 1 part",
    ]
    assert "the body disc:0.25 reaches 100 % of it" in out


def test_a_narrow_door_is_a_problem(call, folder):
    code, out, err = call("environments", "check", "narrow.wkt", "--out", "narrow.svg")
    assert (code, err) == (1, "")
    assert re.search(r"narrowest passage: 0.4 m wide at \(6.[012]., 2.20\), 30.\d+ m2", out)
    assert "is 0.4 m wide: bodies up to 0.2 m in radius pass" in out
    assert "\nproblem: the body disc:0.25 reaches 50.0 % of the main part" in out
    assert ET.parse(folder / "narrow.svg").getroot().tag.endswith("svg")
    code, out, _ = call("environments", "check", "narrow.wkt", "--footprint", "disc:0.2")
    assert code == 0
    assert re.search(r"tight for it: the passage at \(6.[012]., 2.20\), 0.4 m wide or", out)


@pytest.mark.parametrize("name", ["narrow.png", "narrow", "narrow.svg.txt"])
@pytest.mark.parametrize("command", ["show", "check"])
def test_pictures_are_svg_by_their_suffix(call, folder, command, name):
    code, _, err = call("environments", command, "pillar.wkt", "--out", name)
    assert code == 2
    assert f"{name}: this picture is written as SVG; name the file narrow" in err
    assert not (folder / name).exists()


def test_quiet_prints_problems_only(call):
    code, out, err = call("environments", "check", "narrow.wkt", "--quiet")
    assert (code, out) == (1, "")
    assert err.startswith("problem: ")
    assert err.count("\n") == 1


def test_a_share_decides_what_is_everywhere(call):
    assert call("environments", "check", "narrow.wkt", "--share", "0.4")[0] == 0


def test_fix_writes_a_clean_copy_beside_the_original(call, folder):
    path = folder / "bow.wkt"
    path.write_text(BOW)
    code, _, err = call("environments", "check", "bow.wkt")
    assert code == 2
    assert "'multisrt environments check FILE --fix OUT' writes a repaired copy" in err
    code, out, _ = call("environments", "check", "bow.wkt", "--fix", "bow.geojson")
    assert code == 1  # two triangles
    assert "cleaned: 1 open ring closed; 1 polygon repaired that crossed itself" in out
    assert "written to bow.geojson" in out
    assert path.read_text() == BOW
    copy = read_environment(folder / "bow.geojson")
    assert copy.area_m2 == 8.0
    assert not copy.cleaning


def test_fix_leaves_out_starts_outside_free_space(call, folder):
    features = [
        {
            "type": "Feature",
            "properties": {"kind": "free"},
            "geometry": json.loads(shapely.to_geojson(shapely.box(0, 0, 8, 5))),
        },
        *(
            {
                "type": "Feature",
                "properties": {"kind": "start"},
                "geometry": {"type": "Point", "coordinates": place},
            }
            for place in ([50, 5], [4, 2.5])
        ),
    ]
    collection = {"type": "FeatureCollection", "features": features}
    (folder / "hall.geojson").write_text(json.dumps(collection))
    code, out, err = call("environments", "check", "hall.geojson")
    assert (code, out) == (2, "")
    assert err == (
        "error: hall.geojson, feature 2: the suggested start (50, 5) is not in free space, but "
        "42 m away from it; move it or remove it; 'multisrt environments check FILE --fix OUT' "
        "writes a repaired copy without it\n"
    )
    code, out, err = call("environments", "check", "hall.geojson", "--fix", "clean.geojson")
    assert (code, err) == (0, "")
    assert "cleaned: 1 suggested start removed as not in free space\n" in out
    assert read_environment(folder / "clean.geojson").starts == ((4.0, 2.5),)


def test_fix_never_replaces_a_file_without_force(call, folder):
    path = folder / "bow.wkt"
    path.write_text(BOW)
    code, _, err = call("environments", "check", "bow.wkt", "--fix", "bow.wkt")
    assert code == 2
    assert "exists already" in err
    assert path.read_text() == BOW
    assert call("environments", "check", "bow.wkt", "--fix", "bow.wkt", "--force")[0] == 1
    assert read_environment(path).area_m2 == 8.0


def test_fix_drops_closes_and_simplifies(call, folder):
    ring = [[0, 0], [9, 0], [9, 3], [9.01, 4], [9, 6], [0, 6], [0, 0]]
    speck = [[1, 1], [1, 1.1], [1.1, 1.1], [1.1, 1], [1, 1]]
    walls = [
        [[4, -1], [4.2, -1], [4.2, 2], [4, 2], [4, -1]],
        [[4, 2.15], [4.2, 2.15], [4.2, 7], [4, 7], [4, 2.15]],
    ]
    kinds = [("free", ring), *(("obstacle", other) for other in (speck, *walls))]
    features = [
        {
            "type": "Feature",
            "properties": {"kind": kind},
            "geometry": {"type": "Polygon", "coordinates": [corners]},
        }
        for kind, corners in kinds
    ]
    (folder / "drawn.json").write_text(
        json.dumps({"type": "FeatureCollection", "features": features})
    )
    words = ("--specks", "0.2", "--close", "0.3", "--simplify", "0.02", "--fix", "clean.wkt")
    code, out, _ = call("environments", "check", "drawn.json", *words)
    assert code == 1
    assert "1 obstacle dropped as too small (0.01 m2)" in out
    assert "1 narrow gap closed" in out
    assert re.search(r"moved by up to 0.01\d* m", out)
    copy = read_environment(folder / "clean.wkt")
    assert len(copy.components) == 2
    assert all(not part.interiors for part in copy.components)


@pytest.mark.parametrize("name", ["clean.stl", "clean.glb", "clean.png", "clean"])
def test_fix_writes_what_can_be_read_again(call, folder, name):
    before = everything(folder)
    code, out, err = call("environments", "check", "room.wkt", "--fix", name)
    assert (code, out) == (2, "")
    assert "; repaired copies are written as .yaml, .yml: ROS map server; " in err
    assert "STL" not in err
    assert everything(folder) == before


def test_the_help_of_fix_lists_the_formats():
    read = {suffix for known in FORMATS for suffix in known.suffixes}
    assert {MAP_SUFFIXES[suffix] for suffix in FIXED} == set(READABLE_SUFFIXES.values())
    assert set(READABLE_SUFFIXES) == set(MAP_SUFFIXES) & read
    assert set(MAP_SUFFIXES) - read == {".stl", ".glb"}


def test_options_of_fix_need_it(call):
    code, _, err = call("environments", "check", "room.wkt", "--close", "0.2")
    assert code == 2
    assert "--close requires --fix OUT" in err


def test_images_say_how_far_walls_moved(call, folder):
    (folder / "grid.map").write_text(STAIRS)
    for words in (("check", "grid.map"), ("show", "grid.map")):
        _, out, _ = call("environments", *words, "--resolution", "1")
        assert "cleaned: walls straightened within 0.673 m" in out
    (folder / "grid.map").write_text("type octile\nheight 2\nwidth 3\nmap\n.@.\n.@.\n")
    assert "cleaned" not in call("environments", "check", "grid.map", "--resolution", "1")[1]


def test_explore_says_what_was_cleaned(call, folder):
    (folder / "grid.map").write_text(STAIRS)
    code, out, _ = call("explore", "grid.map", "--resolution", "1")
    assert code == 0
    assert "  map cleaned: walls straightened within 0.673 m" in out
    assert "map cleaned" not in call("explore", "room.wkt")[1]


def test_layers_left_out_are_told_and_a_problem(call, folder):
    ink = 'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
    (folder / "flat.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" {ink} viewBox="0 0 10 8">'
        '<g inkscape:groupmode="layer" inkscape:label="Layer 1"><path d="M0 4h9v1h-9z"/></g>'
        '<g inkscape:groupmode="layer" inkscape:label="Furniture"><path d="M1 1h1v1z"/></g></svg>'
    )
    told = "layers read: Furniture (obstacles); left out: Layer 1 (1 shape); name layers walls, "
    code, out, _ = call("environments", "check", "flat.svg", "--resolution", "1")
    assert code == 1
    assert told in out
    assert (
        "problem: no layer is read as walls or free space, and Layer 1 (1 shape) is left out: "
        "name layers walls, obstacles, free, ... to read them" in out
    )
    code, out, _ = call("environments", "check", "flat.svg", "--resolution=1", "--fix", "flat.wkt")
    assert code == 1
    assert told in out
    code, out, _ = call("environments", "show", "flat.svg", "--resolution", "1", "--out", "a.svg")
    assert code == 0
    assert told in out
    text = (folder / "flat.svg").read_text().replace("Layer 1", "Walls")
    (folder / "flat.svg").write_text(text)
    code, out, _ = call("environments", "check", "flat.svg", "--resolution", "1")
    assert "layers read: Walls (walls), Furniture (obstacles)\n" in out
    assert "no layer" not in out


def test_a_start_chooses_the_part_that_is_checked(call, folder):
    wall = shapely.box(1, 1, 13, 13) - shapely.box(1.5, 1.5, 12.5, 12.5)
    (folder / "page.wkt").write_text(shapely.to_wkt(shapely.box(0, 0, 36, 30) - wall))
    check = ("environments", "check", "page.wkt")
    code, out, _ = call(*check)
    assert code == 1
    assert "explore with --start 7.00,7.00; else open doors" in out
    code, out, err = call(*check, "--start", "7,7", "--start", "3,3,1.57", "--out", "page.svg")
    assert (code, err) == (0, "")
    assert "2 separate parts (936, 121 m2); the starts are in that of 121 m2\n" in out
    assert "explore the inside" not in out
    assert "the body disc:0.25 reaches 100 % of the part of 121 m2\n" in out
    legend = "".join(ET.parse(folder / "page.svg").getroot().itertext())
    assert "start" in legend
    assert "suggested start" not in legend


def test_a_start_in_a_wall_is_told_with_the_nearest_place(call):
    code, out, err = call("environments", "check", "pillar.wkt", "--start", "4,2.5")
    assert (code, out) == (2, "")
    assert err == (
        "error: the start (4, 2.5) is not in the free space of 'pillar': it is in an obstacle or "
        "outside the outline, 0.5 m from free space; the nearest place where the body disc:0.25 "
        "fits is (4, 1.74), 0.76 m from there\n"
    )
    code, _, err = call("environments", "check", "pillar.wkt", "--start", "4")
    assert code == 2
    assert "--start: '4' is not X,Y or X,Y,HEADING" in err
    code, out, _ = call("environments", "check", "pillar.wkt", "--start", "0.1,3")
    assert code == 1
    assert "problem: the body disc:0.25 does not fit at the start (0.1, 3) of 'pillar'" in out
