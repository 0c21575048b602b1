import contextlib
import io
import itertools
import math
import random

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.environments.formats import format_of, read_environment
from multisrt.environments.formats.dxf import reader
from multisrt.environments.formats.dxf.reader import WALL_THICKNESS_M
from multisrt.geometry.errors import MapFormatError

ezdxf = pytest.importorskip("ezdxf")

T = WALL_THICKNESS_M


def new(units=6):
    drawing = ezdxf.new(units=units)
    return drawing, drawing.modelspace()


def read(tmp_path, drawing, **options):
    path = tmp_path / "plan.dxf"
    drawing.saveas(path)
    return read_environment(path, **options)


def on(layer):
    return {"layer": layer}


def outlined(units=6, size=(10, 8)):
    """A drawing of an outline, to which walls and obstacles are added."""
    drawing, space = new(units)
    x, y = size
    space.add_lwpolyline([(0, 0), (x, 0), (x, y), (0, y)], close=True, dxfattribs=on("OUTLINE"))
    return drawing, space


def pairs(*lines):
    """The text of a DXF file from pairs of group code and value."""
    words = [word for line in lines for word in line.split("|")]
    assert len(words) % 2 == 0
    return "".join(f"{code:>3}\n{value}\n" for code, value in zip(*[iter(words)] * 2, strict=True))


def line(layer, x0, y0, x1, y1):
    return f"0|LINE|8|{layer}|10|{x0}|20|{y0}|30|0|11|{x1}|21|{y1}|31|0"


# As LibreCAD writes it: units of millimetres, layers, a frozen layer, blocks.
LIBRECAD = pairs(
    "999|dxfrw 1.1.0",
    "0|SECTION|2|HEADER|9|$ACADVER|1|AC1009|9|$INSUNITS|70|4|0|ENDSEC",
    "0|SECTION|2|TABLES|0|TABLE|2|LAYER|70|4",
    "0|LAYER|2|0|70|0|62|7|6|CONTINUOUS",
    "0|LAYER|2|A-WALL|70|0|62|7|6|CONTINUOUS",
    "0|LAYER|2|A-WALL-DEMO|70|1|62|7|6|CONTINUOUS",  # frozen
    "0|LAYER|2|Furniture|70|0|62|3|6|CONTINUOUS",
    "0|LAYER|2|Furniture-old|70|0|62|-3|6|CONTINUOUS",  # off
    "0|ENDTAB|0|ENDSEC",
    "0|SECTION|2|BLOCKS",
    "0|BLOCK|8|0|2|TABLE|70|0|10|0|20|0|30|0|3|TABLE|1|",
    line(0, 0, 0, 1000, 0),
    line(0, 1000, 0, 1000, 1000),
    line(0, 1000, 1000, 0, 1000),
    line(0, 0, 1000, 0, 0),
    "0|ENDBLK|8|0|0|ENDSEC",
    "0|SECTION|2|ENTITIES",
    line("A-WALL", 0, 0, 8000, 0),
    line("A-WALL", 8000, 0, 8000, 5000),
    line("A-WALL", 8000, 5000, 0, 5000),
    line("A-WALL", 0, 5000, 0, 0),
    line("A-WALL", 4000, 0, 4000, 4000),
    line("A-WALL-DEMO", 0, 2000, 8000, 2000),
    line("A-DIMS", 0, -500, 8000, -500),
    "0|TEXT|8|A-ANNO-TEXT|10|100|20|100|30|0|40|200|1|Kitchen",
    "0|INSERT|8|Furniture|2|TABLE|10|1000|20|1000|30|0|41|2|42|1",
    "0|INSERT|8|Furniture|2|TABLE|10|6000|20|2000|30|0|50|90",
    "0|INSERT|8|Furniture-old|2|TABLE|10|6000|20|3500|30|0",
    "0|CIRCLE|8|Furniture|10|2000|20|4000|30|0|40|500",
    "0|POINT|8|Starts|10|500|20|500|30|0",
    "0|ENDSEC|0|EOF",
)


def test_a_plan_of_librecad(tmp_path):
    path = tmp_path / "plan.dxf"
    path.write_text(LIBRECAD)
    assert format_of(path).name == "DXF"
    world = read_environment(path)
    inside = (8 - T) * (5 - T) - T * 4 - 2 - 1 - math.pi / 4
    assert world.area_m2 == pytest.approx(inside, abs=0.01)
    assert world.bounds == pytest.approx((T / 2, T / 2, 8 - T / 2, 5 - T / 2))
    assert len(world.components) == 1
    assert world.starts == ((0.5, 0.5),)
    assert not world.contains(5.5, 2.5)  # the table turned by 90 degrees
    assert world.contains(6.5, 2.5)
    assert world.origin == ("plan.dxf at 0.001 m per unit, walls by their layers, lines 2 cm thick")


@pytest.mark.parametrize("form", ["asc", "bin"])
@pytest.mark.parametrize("version", ["R12", "R2000", "R2018"])
def test_all_versions_and_both_encodings_are_read(tmp_path, version, form):
    drawing = ezdxf.new(version, units=6)
    space = drawing.modelspace()
    space.add_polyline2d([(0, 0), (4, 0), (4, 3), (0, 3)], close=True, dxfattribs=on("outline"))
    space.add_circle((2, 1), 0.5, dxfattribs=on("Columns"))
    path = tmp_path / "plan.dxf"
    drawing.saveas(path, fmt=form)
    assert format_of(path).name == "DXF"
    resolution_m = 1.0 if version == "R12" else None  # R12 has no unit
    world = read_environment(path, resolution_m=resolution_m)
    assert world.area_m2 == pytest.approx(12 - math.pi / 4, abs=0.01)


@pytest.mark.parametrize(
    ("units", "metres"), [(1, 0.0254), (2, 0.3048), (4, 0.001), (5, 0.01), (6, 1), (14, 0.1)]
)
def test_units_of_the_header(tmp_path, units, metres):
    drawing, _ = outlined(units)
    assert read(tmp_path, drawing).area_m2 == pytest.approx(80 * metres**2)


def test_a_drawing_without_unit_asks_for_it(tmp_path):
    drawing, _ = outlined(0)
    with pytest.raises(MapFormatError, match=r"how large a drawing unit is.*--resolution"):
        read(tmp_path, drawing)
    assert read(tmp_path, drawing, resolution_m=0.5).area_m2 == pytest.approx(20)


def test_a_resolution_counts_more_than_the_header(tmp_path):
    drawing, _ = outlined(4)
    assert read(tmp_path, drawing, resolution_m=1.0).area_m2 == pytest.approx(80)


def test_threshold_is_refused(tmp_path):
    drawing, _ = outlined()
    with pytest.raises(MapFormatError, match="leave out --threshold"):
        read(tmp_path, drawing, threshold=0.5)


def lens(space, layer):
    space.add_lwpolyline(
        [(2, 2, 1), (4, 2, 1)], format="xyb", close=True, dxfattribs=on(layer)
    )  # two half circles


def hatch(space, layer, solid=True):
    one = space.add_hatch(dxfattribs=on(layer))
    if not solid:
        one.set_pattern_fill("ANSI31", scale=0.1)
    one.paths.add_polyline_path([(1, 1), (5, 1), (5, 5), (1, 5)], is_closed=True)
    edges = one.paths.add_edge_path(flags=ezdxf.const.BOUNDARY_PATH_OUTERMOST)
    edges.add_arc((3, 3), 1, 0, 360)


@pytest.mark.parametrize(
    ("draw", "layer", "area"),
    [
        (lambda s, on: s.add_circle((3, 3), 2, dxfattribs=on), "pillar", 4 * math.pi),
        (lambda s, on: s.add_ellipse((3, 3), (2, 0), 0.5, dxfattribs=on), "pillar", 2 * math.pi),
        (lambda s, on: lens(s, on["layer"]), "pillar", math.pi),
        (lambda s, on: hatch(s, on["layer"]), "pillar", 16 - math.pi),
        (lambda s, on: hatch(s, on["layer"], solid=False), "A-WALL", 16 - math.pi),
        (lambda s, on: s.add_solid([(1, 1), (3, 1), (1, 2), (3, 2)], dxfattribs=on), "wall", 2),
        (lambda s, on: s.add_line((1, 1), (4, 5), dxfattribs=on), "wall", (5 + T) * T),
        (lambda s, on: s.add_arc((3, 3), 2, 0, 180, dxfattribs=on), "wall", 2 * math.pi * T),
        (lambda s, on: s.add_circle((3, 3), 2, dxfattribs=on), "wall", 4 * math.pi * T),
        (
            lambda s, on: s.add_lwpolyline(
                [(1, 1), (5, 1), (5, 5)], dxfattribs=on | {"const_width": 0.5}
            ),
            "wall",
            8 * 0.5 + 0.25,
        ),
        (
            lambda s, on: s.add_spline_control_frame(
                [(1, 1), (2, 4), (4, 4), (5, 1)], dxfattribs=on
            ),
            "wall",
            None,
        ),
        (lambda s, on: s.add_mline([(1, 1), (5, 1)], dxfattribs=on), "wall", None),
        (lambda s, on: s.add_line((1, 1), (4, 5), dxfattribs=on), "door", 0),
        (lambda s, on: s.add_text("wall", dxfattribs=on), "wall", 0),
        (lambda s, on: s.add_line((1, 1), (4, 5), dxfattribs=on), "A-DIMS", 0),
        (lambda s, on: s.add_line((1, 1), (4, 5), dxfattribs=on | {"invisible": 1}), "wall", 0),
    ],
)
def test_areas_of_entities(tmp_path, draw, layer, area):
    drawing, space = outlined()
    draw(space, on(layer))
    covered = 80 - read(tmp_path, drawing).area_m2
    if area is None:
        assert 0.05 < covered < 0.5
    else:
        assert covered == pytest.approx(area, rel=0.007, abs=1e-9)


def test_a_large_circle_is_within_five_millimetres(tmp_path):
    drawing, space = outlined(size=(100, 100))
    space.add_circle((50, 50), 40, dxfattribs=on("obstacle"))
    (hole,) = read(tmp_path, drawing).components[0].interiors
    points = np.asarray(hole.coords) - 50
    middles = (points[1:] + points[:-1]) / 2
    assert np.abs(np.hypot(*points.T) - 40).max() < 1e-3
    assert 0.003 < (40 - np.hypot(*middles.T)).max() < 0.0051


def test_blocks_are_placed_scaled_turned_mirrored_and_repeated(tmp_path):
    drawing, space = outlined(size=(100, 100))
    inner = drawing.blocks.new("inner", base_point=(1, 0))
    inner.add_lwpolyline([(1, 0), (3, 0), (3, 1)], close=True)
    outer = drawing.blocks.new("outer")
    outer.add_blockref("inner", (10, 0), dxfattribs={"rotation": 90})
    outer.add_line((0, 0), (1, 0), dxfattribs=on("nothing"))
    space.add_blockref("outer", (50, 50), dxfattribs=on("furniture") | {"xscale": -2, "yscale": 3})
    space.add_blockref(
        "inner",
        (5, 5),
        dxfattribs=on("furniture")
        | {"column_count": 3, "row_count": 2, "column_spacing": 10, "row_spacing": 20},
    )
    world = read(tmp_path, drawing)
    triangle = shapely.Polygon([(0, 0), (2, 0), (2, 1)])
    turned = shapely.affinity.rotate(triangle, 90, origin=(0, 0))
    placed = shapely.affinity.translate(turned, 10, 0)
    mirrored = shapely.affinity.scale(placed, -2, 3, origin=(0, 0))
    solid = [shapely.affinity.translate(mirrored, 50, 50)] + [
        shapely.affinity.translate(triangle, 5 + 10 * k, 5 + 20 * n)
        for k in range(3)
        for n in range(2)
    ]
    # The line of the block inherits the role of the layer that the block is on.
    wall = shapely.LineString([(50, 50), (48, 50)]).buffer(T / 2, cap_style="square")
    free = shapely.box(0, 0, 100, 100) - shapely.union_all([*solid, wall])
    assert world.free.symmetric_difference(free).area < 1e-6


def test_layer_0_of_a_block_is_the_layer_that_it_is_on(tmp_path):
    drawing, space = outlined()
    block = drawing.blocks.new("pillar")
    block.add_lwpolyline([(0, 0), (1, 0), (1, 1), (0, 1)], close=True)
    block.add_circle((5, 5), 1, dxfattribs=on("hidden"))
    space.add_blockref("pillar", (1, 1), dxfattribs=on("obstacles"))
    drawing.layers.get("0").off()
    drawing.layers.add("hidden").freeze()
    assert read(tmp_path, drawing).area_m2 == pytest.approx(79)


def test_entities_seen_from_below_are_mirrored(tmp_path):
    drawing, space = outlined(size=(20, 10))
    space.add_circle((-5, 5), 2, dxfattribs=on("column") | {"extrusion": (0, 0, -1)})
    assert not read(tmp_path, drawing).contains(5, 5)


def test_two_faces_of_a_wall_keep_rooms_apart(tmp_path):
    drawing, space = new()
    space.add_lwpolyline([(0, 0), (10, 0), (10, 5), (0, 5)], close=True)
    for x in (4, 4.2):
        space.add_line((x, 0), (x, 5))
    world = read(tmp_path, drawing)
    assert world.origin.endswith("all lines are walls, lines 2 cm thick")
    areas = sorted(part.area for part in world.components)
    assert areas == pytest.approx([0.18 * 4.98, 3.98 * 4.98, 5.78 * 4.98])


def test_doors_open_walls(tmp_path):
    drawing, space = outlined(size=(10, 5))
    hatch_wall = space.add_hatch(dxfattribs=on("walls"))
    hatch_wall.paths.add_polyline_path([(4, 0), (5, 0), (5, 5), (4, 5)], is_closed=True)
    assert len(read(tmp_path, drawing).components) == 2
    space.add_lwpolyline([(4, 2), (5, 2), (5, 3), (4, 3)], close=True, dxfattribs=on("doors"))
    world = read(tmp_path, drawing)
    assert len(world.components) == 1
    assert world.area_m2 == pytest.approx(46, abs=0.002)


def test_single_lines_close_an_outline_within_a_millimetre(tmp_path):
    drawing, space = new()
    corners = [(0, 0), (6, 0.0003), (6, 4), (0, 4), (0.0002, 0.0001)]
    for a, b in itertools.pairwise(corners):
        space.add_line(a, b, dxfattribs=on("free space"))
    assert read(tmp_path, drawing).area_m2 == pytest.approx(24, abs=0.01)


def test_patterns_count_only_by_name(tmp_path):
    drawing, space = new()
    space.add_lwpolyline([(0, 0), (10, 0), (10, 5), (0, 5)], close=True)
    hatch(space, "0", solid=False)
    assert read(tmp_path, drawing).area_m2 == pytest.approx(9.98 * 4.98)


def test_starts_are_points_centres_and_base_points(tmp_path):
    drawing, space = outlined()
    robot = drawing.blocks.new("robot")
    robot.add_circle((0, 0), 0.3)
    robot.add_line((0, 0), (0.3, 0))
    space.add_point((1, 2), dxfattribs=on("starts"))
    space.add_circle((3, 4), 0.5, dxfattribs=on("starts"))
    space.add_blockref("robot", (5, 6), dxfattribs=on("starts"))
    starts = read(tmp_path, drawing).starts
    np.testing.assert_allclose(starts, [(1, 2), (3, 4), (5, 6)], atol=1e-6)
    space.add_point((90, 2), dxfattribs=on("starts"))
    with pytest.raises(MapFormatError, match=r"start \(90, 2\) is not .*--fix OUT"):
        read(tmp_path, drawing)
    fixed = read_environment(tmp_path / "plan.dxf", repair=True)
    np.testing.assert_allclose(fixed.starts, starts, atol=1e-6)
    assert fixed.cleaning.removed_starts == 1


def test_paper_space_does_not_count(tmp_path):
    drawing, _ = outlined()
    drawing.layout().add_line((0, 0), (5, 5), dxfattribs=on("wall"))
    assert read(tmp_path, drawing).area_m2 == pytest.approx(80)


# What is wrong.


def test_faults_are_named(tmp_path):
    drawing, space = new()
    with pytest.raises(MapFormatError, match=r"plan\.dxf has no walls"):
        read(tmp_path, drawing)
    space.add_line((0, 0), (1, 1), dxfattribs=on("outline"))
    with pytest.raises(MapFormatError, match="no outline on the layers of free space is closed"):
        read(tmp_path, drawing)
    space.add_3dface([(0, 0), (1, 0), (1, 1)], dxfattribs=on("A-WALL"))
    with pytest.raises(MapFormatError, match="the 3DFACE on the layer 'A-WALL' is not read"):
        read(tmp_path, drawing)


def test_missing_blocks_are_named(tmp_path):
    path = tmp_path / "plan.dxf"
    path.write_text(LIBRECAD.replace("  2\nTABLE\n 10\n1000", "  2\nCHAIR\n 10\n1000"))
    with pytest.raises(MapFormatError, match="inserts the block 'CHAIR'"):
        read_environment(path)


def test_points_too_far_away_are_named(tmp_path):
    drawing, space = outlined()
    space.add_line((0, 0), (1e8, 0), dxfattribs=on("wall"))
    with pytest.raises(MapFormatError, match=r"further than 1e\+07 m away; check the unit"):
        read(tmp_path, drawing)


def test_blocks_that_double_are_bounded(tmp_path):
    drawing, space = outlined()
    drawing.blocks.new("b0").add_line((0, 0), (1, 0))
    for k in range(1, 31):
        block = drawing.blocks.new(f"b{k}")
        for x in (0, 1):
            block.add_blockref(f"b{k - 1}", (x, 0))
    space.add_blockref("b30", (0, 0), dxfattribs=on("wall"))
    with pytest.raises(MapFormatError, match="draws more than"):
        read(tmp_path, drawing)


def test_blocks_within_themselves_are_bounded(tmp_path):
    drawing, space = outlined()
    drawing.blocks.new("b").add_blockref("b", (1, 0))
    space.add_blockref("b", (0, 0), dxfattribs=on("wall"))
    with pytest.raises(MapFormatError, match="nested more than 32 deep"):
        read(tmp_path, drawing)


def test_repeated_blocks_are_bounded(tmp_path):
    drawing, space = outlined()
    drawing.blocks.new("b").add_line((0, 0), (1, 0))
    many = {"column_count": 30_000, "row_count": 30_000, "column_spacing": 1, "row_spacing": 1}
    space.add_blockref("b", (0, 0), dxfattribs=on("wall") | many)
    with pytest.raises(MapFormatError, match="draws more than"):
        read(tmp_path, drawing)


def test_crossings_are_bounded(tmp_path):
    drawing, space = outlined()
    points = np.random.default_rng(1).uniform(0, 8, (4000, 2))
    space.add_lwpolyline(points.tolist(), dxfattribs=on("wall"))
    with pytest.raises(MapFormatError, match="cross too often"):
        read(tmp_path, drawing)


def test_large_files_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(reader, "MAX_DXF_BYTES", 1000)
    with pytest.raises(MapFormatError, match="read up to 1,000"):
        read(tmp_path, outlined()[0])


@pytest.mark.parametrize(
    "content",
    [
        b"  0\nSECTION\n  2\nENTITIES\n  0\nLINE\n",
        b"  0\nSECTION\n  2\nENTITIES\n  0\nLINE\n 10\nx\n  0\nENDSEC\n  0\nEOF\n",
        b"AutoCAD Binary DXF\r\n\x1a\0\0SECTION",
        b"no drawing",
    ],
)
def test_damaged_files_are_named(tmp_path, content):
    path = tmp_path / "plan.dxf"
    path.write_bytes(content)
    with pytest.raises(MapFormatError, match=r"plan\.dxf"):
        read_environment(path, resolution_m=1.0)


def test_a_cut_file_is_told_in_plain_words(tmp_path):
    path = tmp_path / "plan.dxf"
    outlined()[0].saveas(path)
    # Of whole pairs of lines: the length of what is before depends on the time and on ids.
    path.write_bytes(b"".join(path.read_bytes().splitlines(keepends=True)[:560]))
    with pytest.raises(MapFormatError, match=r"damaged DXF file: it ends too early, .*copy it"):
        read_environment(path)


# Damage.


def document(form):
    drawing, space = outlined(4)
    block = drawing.blocks.new("b")
    block.add_circle((1, 1), 1)
    block.add_blockref("c", (1, 1))
    drawing.blocks.new("c").add_line((0, 0), (1, 1), dxfattribs=on("wall"))
    space.add_blockref("b", (3, 3), dxfattribs=on("furniture") | {"xscale": 2, "column_count": 2})
    space.add_spline_control_frame([(1, 1), (2, 4), (4, 4), (5, 1)], dxfattribs=on("wall"))
    space.add_spline(fit_points=[(1, 1), (2, 4), (4, 4)], dxfattribs=on("wall"))
    space.add_ellipse((3, 3), (2, 0), 0.5, 0, 2, dxfattribs=on("wall"))
    space.add_polyline2d([(0, 0, 0.1), (1, 1, -2)], format="xyb", dxfattribs=on("wall"))
    space.add_arc((1, 1), 2, 30, 90, dxfattribs=on("door"))
    space.add_point((1, 2), dxfattribs=on("starts"))
    lens(space, "wall")
    hatch(space, "wall")
    if form == "bin":
        raw = io.BytesIO()
        drawing.write(raw, fmt="bin")
        return raw.getvalue()
    text = io.StringIO()
    drawing.write(text)
    return text.getvalue().encode()


DOCUMENTS = [LIBRECAD.encode(), document("asc"), document("bin")]
# The part behind the tables of large files, where the drawing is.
BEGINNINGS = [0] + [text.index(b"BLOCKS") for text in DOCUMENTS[1:]]
VALUES = [b"0", b"-1", b"1e300", b"nan", b"99999999", b"1e-300", b"inf", b"", b"WALL", b"b", b"c"]


@st.composite
def damaged(draw):
    """A drawing some of whose lines are replaced, left out, doubled or moved."""
    which = draw(st.integers(0, len(DOCUMENTS) - 1))
    text, first = DOCUMENTS[which], BEGINNINGS[which]
    rng = random.Random(draw(st.integers(0, 2**32)))
    if which == 2:
        raw = bytearray(text)
        for _ in range(draw(st.integers(1, 6))):
            at = rng.randrange(first, len(raw))
            kind = rng.choice(["byte", "cut", "double"])
            if kind == "byte":
                raw[at] = rng.randrange(256)
            elif kind == "cut":
                del raw[at : at + rng.randint(1, 30)]
            else:
                raw[at:at] = raw[at : at + rng.randint(1, 300)]
        return bytes(raw)
    lines = text.split(b"\n")
    start = text[:first].count(b"\n")
    for _ in range(draw(st.integers(1, 6))):
        at = rng.randrange(start, len(lines) - 2)
        kind = rng.choice(["value", "value", "code", "cut", "double", "swap", "line"])
        at += (at + start) % 2 if kind in ("code", "cut", "double") else 0
        if kind == "value":
            lines[at] = rng.choice(VALUES)
        elif kind == "code":
            lines[at] = b"%3d" % rng.choice(
                [0, 1, 2, 8, 10, 20, 40, 41, 42, 50, 62, 70, 71, 72, 90]
            )
        elif kind == "cut":
            del lines[at : at + 2 * rng.randint(1, 10)]
        elif kind == "double":
            lines[at:at] = lines[at : at + 2 * rng.randint(1, 30)]
        elif kind == "swap":
            other = rng.randrange(start, len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        else:
            lines[at] = lines[rng.randrange(start, len(lines))]
        if len(lines) < start + 4:
            break
    return b"\n".join(lines)


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(content=damaged(), resolution_m=st.sampled_from([None, 1.0, 0.01]))
def test_damage_raises_nothing_but_map_format_errors(tmp_path_factory, content, resolution_m):
    path = tmp_path_factory.getbasetemp() / "damaged.dxf"
    path.write_bytes(content)
    with contextlib.suppress(MapFormatError):
        read_environment(path, resolution_m=resolution_m)


def test_layers_that_are_read_and_left_out_are_told(tmp_path):
    drawing, space = new()
    space.add_circle((5, 5), 1, dxfattribs=on("FURNITURE"))
    for x in (0, 10):
        space.add_line((x, 0), (x, 8), dxfattribs=on("Layer 1"))
    world = read(tmp_path, drawing)
    assert str(world.layers).startswith(
        "layers read: FURNITURE (obstacles); left out: Layer 1 (2 shapes); name layers"
    )
    drawing, space = new()
    space.add_line((0, 0), (9, 8), dxfattribs=on("Layer 1"))
    assert read(tmp_path, drawing).layers is None
