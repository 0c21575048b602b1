"""What is written is read back, by readers of this package and by others."""

import io
import re
import xml.etree.ElementTree as ET

import ezdxf
import numpy as np
import pytest
import shapely
import trimesh
import yaml
from ezdxf.entities.lwpolyline import LWPolyline
from hypothesis import given, settings
from PIL import Image

import multisrt as ms
from multisrt.environments import read_environment
from multisrt.environments.formats import FORMATS
from multisrt.exporting import MapOptions, save_environment
from multisrt.exporting.drawings import dxf_bytes, svg_bytes
from multisrt.exporting.map_content import MapContent
from multisrt.exporting.map_server import map_server_files
from multisrt.exporting.polygon_text import geojson_bytes, wkt_bytes
from multisrt.exporting.solids import apart, glb_bytes, stl_bytes, walls_of
from tests.multisrt.exporting.small_worlds import area_of_difference, small_worlds

CATALOGUE = ["office", "maze", "garden", "hospital", "museum"]


def read_back(files, folder):
    for path, content in files.items():
        (folder / path.name).write_bytes(content)
    return read_environment(folder / next(iter(files)).name)


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    return tmp_path_factory.mktemp("worlds")


@given(world=small_worlds())
@settings(max_examples=60)
def test_texts_of_polygons_keep_everything(shared, world):
    (shared / "a.wkt").write_bytes(wkt_bytes(world))
    (shared / "a.geojson").write_bytes(geojson_bytes(world))
    for name in ("a.wkt", "a.geojson"):
        # Parts that touch at a point may gain a vertex when they are united.
        assert area_of_difference(read_environment(shared / name), world) < 1e-9
    assert read_environment(shared / "a.geojson").starts == world.starts


# The map server


@given(world=small_worlds())
@settings(max_examples=60)
def test_maps_of_the_server_differ_by_less_than_two_cells(shared, world):
    cell = 0.05
    files = map_server_files(MapContent(environment=world), shared / "a.yaml", MapOptions())
    again = read_back(files, shared)
    assert again.free.difference(world.free.buffer(2.0 * cell)).area == 0.0
    # What a body of two cells can reach stays, wherever passages are wider than that.
    wide = world.free.buffer(-2.0 * cell)
    assert wide.difference(again.free).area == 0.0
    assert area_of_difference(again, world) < cell * world.free.length


@given(world=small_worlds())
@settings(max_examples=60)
def test_no_wall_opens_however_thin(shared, world):
    files = map_server_files(
        MapContent(environment=world), shared / "b.yaml", MapOptions(cell_m=0.2)
    )
    again = read_back(files, shared)
    for part in again.components:
        # One component of the grid lies in one component of the world, but for its fringe.
        core = shapely.get_parts(part.buffer(-0.15))
        met = [own for own in world.components if any(own.intersects(one) for one in core)]
        assert len(met) <= 1 or not _crosses(met, part)


def _crosses(components, part):
    shares = [part.intersection(own).area / own.area for own in components]
    return sum(share > 0.5 for share in shares) > 1


@pytest.mark.parametrize("steep", [False, True])
def test_a_wall_thinner_than_a_cell_stays_closed(steep, tmp_path):
    corners = np.array([(-1, 5.293), (-1, 5.303), (11, 1.703), (11, 1.693)])
    wall = shapely.Polygon(corners[:, ::-1] if steep else corners)
    hall = shapely.box(0, 0, 8, 10) if steep else shapely.box(0, 0, 10, 8)
    world = ms.Environment("slanted", hall - wall)
    assert len(world.components) == 2
    save_environment(world, tmp_path / "a.yaml", options=MapOptions(cell_m=0.1))
    again = read_environment(tmp_path / "a.yaml")
    assert sorted(part.area for part in again.components) == pytest.approx(
        sorted(part.area for part in world.components), abs=1.0
    )


def test_rows_origin_and_levels_are_those_of_map_server(tmp_path):
    # The lower right quarter of a square is missing.
    corners = [(-1, 2), (0, 2), (0, 3), (1, 3), (1, 4), (-1, 4)]
    world = ms.Environment("an L", shapely.Polygon(corners))
    save_environment(world, tmp_path / "l.yaml", options=MapOptions(cell_m=0.5))
    entries = yaml.safe_load((tmp_path / "l.yaml").read_text())
    assert entries == {
        "image": "l.pgm",
        "mode": "trinary",
        "resolution": 0.5,
        "origin": [-1.5, 1.5, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }
    pixels = np.asarray(Image.open(tmp_path / "l.pgm"))
    assert pixels.tolist() == [
        [0, 0, 0, 0, 0, 0],
        [0, 254, 254, 254, 254, 0],
        [0, 254, 254, 254, 254, 0],
        [0, 254, 254, 0, 0, 0],
        [0, 254, 254, 0, 0, 0],
        [0, 0, 0, 0, 0, 0],
    ]
    assert area_of_difference(read_environment(tmp_path / "l.yaml"), world) == 0.0


@pytest.mark.parametrize("name", CATALOGUE)
@pytest.mark.parametrize("cell", [0.05, 0.1])
def test_catalogue_survives_the_map_server(name, cell, tmp_path):
    world = ms.environment(name)
    save_environment(world, tmp_path / "a.yaml", options=MapOptions(cell_m=cell))
    again = read_environment(tmp_path / "a.yaml")
    assert area_of_difference(again, world) < 0.5 * cell * world.free.length
    assert len(again.components) == len(world.components)


@pytest.mark.parametrize("name", ["a b.yaml", "ä: #1.yml", 'quo"te.yaml'])
def test_any_name_of_a_file_is_found_again(name, tmp_path):
    world = ms.Environment("hall", shapely.box(0.1, 0, 4, 1e-4 + 3))
    save_environment(world, tmp_path / name)
    assert area_of_difference(read_environment(tmp_path / name), world) < 0.5


def test_grids_too_large_to_read_are_refused(tmp_path):
    wide = ms.Environment("wide", shapely.box(0, 0, 1000, 1000))
    with pytest.raises(ms.InvalidInputError, match=r"choose cells wider than 0\.1 m"):
        save_environment(wide, tmp_path / "a.yaml", options=MapOptions(cell_m=0.1))
    assert list(tmp_path.iterdir()) == []
    save_environment(wide, tmp_path / "a.yaml")
    assert yaml.safe_load((tmp_path / "a.yaml").read_text())["resolution"] == 0.4


def test_neither_file_is_replaced_if_one_exists(tmp_path):
    (tmp_path / "a.pgm").write_text("mine")
    with pytest.raises(ms.InvalidInputError, match=r"a\.pgm exists already"):
        save_environment(ms.environment("open"), tmp_path / "a.yaml")
    assert [file.name for file in tmp_path.iterdir()] == ["a.pgm"]
    assert (tmp_path / "a.pgm").read_text() == "mine"


# SVG and DXF, read by other programs


def svg_world(text):
    """The free space and the starts of an SVG document, by its absolute commands."""
    root = ET.fromstring(text)
    name = "{http://www.w3.org/2000/svg}"
    parts = []
    for path in root.iter(f"{name}path"):
        assert path.get("fill-rule") == "evenodd"
        rings = [
            [tuple(map(float, word.split())) for word in re.split("[ML]", ring) if word]
            for ring in str(path.get("d")).split("Z")[:-1]
        ]
        parts.append(shapely.Polygon(rings[0], rings[1:]))
    starts = [
        (float(str(circle.get("cx"))), float(str(circle.get("cy"))))
        for circle in root.iter(f"{name}circle")
    ]
    return ms.Environment("read", shapely.MultiPolygon(parts), starts=starts)


@given(world=small_worlds())
@settings(max_examples=40)
def test_drawings_hold_all_digits_and_starts(world):
    drawn = svg_world(svg_bytes(world))
    assert area_of_difference(drawn, world) == 0.0
    assert drawn.starts == world.starts
    document = ezdxf.read(io.StringIO(dxf_bytes(world).decode()))
    assert document.header["$INSUNITS"] == 6  # metres
    rings: dict[str, list[shapely.Polygon]] = {"OUTLINE": [], "OBSTACLES": []}
    for line in document.modelspace():
        if not isinstance(line, LWPolyline):
            continue
        assert line.closed
        rings[line.dxf.layer].append(shapely.Polygon(list(line.vertices())))
    free = shapely.union_all(rings["OUTLINE"]) - shapely.union_all(rings["OBSTACLES"])
    assert free.symmetric_difference(world.free).area < 1e-9
    points = document.modelspace().query("POINT")
    assert [tuple(point.dxf.location)[:2] for point in points] == list(world.starts)
    assert {point.dxf.layer for point in points} == {"STARTS"}
    assert not document.audit().has_errors


@pytest.mark.parametrize("suffix", [".svg", ".dxf"])
@given(world=small_worlds())
@settings(max_examples=25)
def test_drawings_are_read_back(shared, suffix, world):
    if not any(suffix in known.suffixes for known in FORMATS):
        pytest.skip(f"{suffix} is not read")
    (shared / f"a{suffix}").write_bytes({".svg": svg_bytes, ".dxf": dxf_bytes}[suffix](world))
    again = read_environment(shared / f"a{suffix}")
    assert area_of_difference(again, world) < 1e-9
    assert again.starts == world.starts


def test_dxf_keeps_a_room_within_an_obstacle():
    ring, room = shapely.box(0, 0, 10, 10) - shapely.box(2, 2, 8, 8), shapely.box(3, 3, 7, 7)
    world = ms.Environment("nested", shapely.union_all([ring, room - shapely.box(4, 4, 5, 5)]))
    document = ezdxf.read(io.StringIO(dxf_bytes(world).decode()))
    areas = {"OUTLINE": 0.0, "OBSTACLES": 0.0}
    for line in document.modelspace():
        if isinstance(line, LWPolyline):
            areas[line.dxf.layer] += shapely.Polygon(list(line.vertices())).area
    # The outer outline holds the inner one; obstacles do not overlap it.
    assert areas == {"OUTLINE": 100.0 + 16.0, "OBSTACLES": 20.0 + 1.0}


def test_names_that_xml_cannot_hold_are_made_printable():
    world = ms.Environment("a <b> & \x00\n", shapely.box(0, 0, 1, 1))
    title = ET.fromstring(svg_bytes(world)).find("{http://www.w3.org/2000/svg}title")
    assert title is not None
    assert title.text == "a <b> & ��"


# Solids


@given(world=small_worlds())
@settings(max_examples=60)
def test_walls_are_closed_solids_of_the_right_volume(world):
    options = MapOptions(height_m=2.5, thickness_m=0.2)
    content = MapContent(environment=world)
    filled = [shapely.Polygon(part.exterior) for part in world.free.geoms]
    around = shapely.union_all([one.buffer(0.2, join_style="mitre") for one in filled])
    area = around.area - world.free.area
    stl = trimesh.load_mesh(io.BytesIO(stl_bytes(content, options)), file_type="stl")
    assert stl.is_watertight
    assert stl.is_winding_consistent
    rounding = 1e-4 * (world.free.length + around.length) + 1e-5
    assert stl.volume == pytest.approx(2.5 * area, abs=2.5 * rounding)
    assert stl.bounds[:, 2].tolist() == [0.0, 2.5]
    scene = trimesh.load_scene(io.BytesIO(glb_bytes(content, options)), file_type="glb")
    walls, floor = (scene.geometry[name] for name in ("walls", "floor"))
    assert walls.is_watertight
    assert floor.is_watertight
    assert walls.volume == pytest.approx(2.5 * area, abs=2.5 * rounding)
    assert floor.volume == pytest.approx(0.02 * world.area_m2, abs=0.02 * rounding + 1e-6)


def test_glb_is_upright_and_at_its_place():
    world = ms.Environment("hall", shapely.box(1, 2, 5, 4))
    scene = trimesh.load_scene(
        io.BytesIO(glb_bytes(MapContent(environment=world), MapOptions())), file_type="glb"
    )
    # y is up in glTF, and z is -y of the world.
    assert scene.geometry["floor"].bounds.round(6).tolist() == [[1, -0.02, -4], [5, 0, -2]]
    assert scene.geometry["walls"].bounds.round(6).tolist() == [[0.9, 0, -4.1], [5.1, 1, -1.9]]


def test_walls_that_touch_at_a_corner_are_separated():
    pillars = [shapely.box(2, 2, 3, 3), shapely.box(3, 3, 4, 4)]
    world = ms.Environment.from_outline("corner", shapely.box(0, 0, 8, 8), pillars)
    content = MapContent(environment=world)
    stl = trimesh.load_mesh(io.BytesIO(stl_bytes(content, MapOptions())), file_type="stl")
    assert stl.is_watertight
    walls = walls_of(content, 0.1)
    assert len(walls.geoms) == 3
    assert walls.area == pytest.approx(8.2**2 - 62.0, abs=1e-6)


def test_rings_that_touch_along_another_are_found():
    tooth = shapely.Polygon([(2, 1), (3, 0), (3, 1)])
    area = shapely.box(0, 0, 4, 4) - shapely.Polygon([(1, 2), (2, 0), (3, 2)])
    for own in (area, shapely.box(0, 0, 4, 4) - tooth):
        found = apart(own, 1e-4)
        coordinates = shapely.get_coordinates(shapely.boundary(found))
        rings = sum(1 + len(part.interiors) for part in found.geoms)
        assert len(np.unique(coordinates, axis=0)) == len(coordinates) - rings
        assert found.symmetric_difference(own).area < 1e-6


def test_worlds_beyond_single_precision_are_refused():
    far = ms.Environment("far", shapely.box(5e5, 0, 5e5 + 10, 10))
    for encoded in (stl_bytes, glb_bytes):
        with pytest.raises(ms.InvalidInputError, match="move it to the origin"):
            encoded(MapContent(environment=far), MapOptions())


@pytest.mark.parametrize("name", CATALOGUE)
def test_solids_of_the_catalogue_are_closed(name):
    for seed in range(3) if name != "museum" else [None]:
        given_seed = {} if seed is None else {"seed": seed}
        content = MapContent(environment=ms.environment(name, **given_seed))
        stl = trimesh.load_mesh(io.BytesIO(stl_bytes(content, MapOptions())), file_type="stl")
        assert stl.is_watertight
        assert stl.volume == pytest.approx(walls_of(content, 0.1).area, rel=1e-5)


@pytest.mark.parametrize(
    "options",
    [{"cell_m": 0.0}, {"cell_m": float("nan")}, {"height_m": -1.0}, {"thickness_m": 1e9}],
)
def test_options_out_of_range_are_refused(options):
    with pytest.raises(ms.InvalidInputError):
        MapOptions(**options)
