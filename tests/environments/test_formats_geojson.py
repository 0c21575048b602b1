import json
import re
from pathlib import Path

import pytest
import shapely

from multisrt.analysis.map_check import check_map
from multisrt.environments.formats import read_environment
from multisrt.environments.formats.geojson import KINDS
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError, MapFormatError
from multisrt.simulation.starts import starts_of
from multisrt.simulation.worlds import inline
from multisrt.spec import RobotSpec, RunSpec

HALL = [[0, 0], [10, 0], [10, 8], [0, 8], [0, 0]]
BLOCK = [[4, 3], [6, 3], [6, 5], [4, 5], [4, 3]]


def polygon(*rings):
    return {"type": "Polygon", "coordinates": list(rings)}


def feature(geometry, **properties):
    return {"type": "Feature", "properties": properties or None, "geometry": geometry}


def collection(*features):
    return {"type": "FeatureCollection", "features": list(features)}


@pytest.fixture
def read(tmp_path):
    def write_and_read(document, **options):
        path = tmp_path / "world.geojson"
        path.write_text(document if isinstance(document, str) else json.dumps(document))
        return read_environment(path, **options)

    return write_and_read


WITH_A_HOLE = shapely.box(0, 0, 10, 8) - shapely.box(4, 3, 6, 5)


@pytest.mark.parametrize(
    "document",
    [
        polygon(HALL, BLOCK),
        feature(polygon(HALL, BLOCK)),
        {"type": "MultiPolygon", "coordinates": [[HALL, BLOCK]]},
        {"type": "GeometryCollection", "geometries": [polygon(HALL, BLOCK)]},
        collection(feature(polygon(HALL)), feature(polygon(BLOCK), kind="obstacle")),
        collection(feature(polygon(BLOCK), type="Obstacle"), feature(polygon(HALL), kind="free")),
        collection(
            feature(polygon(HALL), kind="outline", type="x"),
            feature(polygon(BLOCK), kind="obstacle"),
        ),
        polygon([[*p, 3.5] for p in HALL], BLOCK),
    ],
)
def test_equivalent_documents_give_the_same_world(read, document):
    world = read(document)
    assert world.free.equals(WITH_A_HOLE)
    assert (world.name, world.origin, world.starts) == ("world", "world.geojson", ())


def test_free_polygons_are_united_and_obstacles_may_overlap(read):
    world = read(
        collection(
            feature(polygon(HALL)),
            feature(polygon([[8, 2], [14, 2], [14, 4], [8, 4], [8, 2]])),
            feature(polygon([[-1, -1], [2, -1], [2, 2], [-1, 2], [-1, -1]]), kind="obstacle"),
            feature(polygon([[1, 1], [3, 1], [3, 3], [1, 3], [1, 1]]), kind="obstacle"),
        )
    )
    assert world.area_m2 == pytest.approx(80 + 8 - 4 - 3)


def test_starts_come_in_the_order_of_the_file(read):
    points = {"type": "MultiPoint", "coordinates": [[2, 2], [3, 7]]}
    world = read(
        collection(
            feature({"type": "Point", "coordinates": [9, 1]}, kind="start"),
            feature(polygon(HALL, BLOCK)),
            feature(points, kind="start"),
        )
    )
    assert world.starts == ((9, 1), (2, 2), (3, 7))


def test_start_in_an_obstacle_is_refused(read):
    start = feature({"type": "Point", "coordinates": [5, 4]}, kind="start")
    with pytest.raises(MapFormatError, match=r"world\.geojson.*start \(5, 4\) is not in free"):
        read(collection(feature(polygon(HALL, BLOCK)), start))


def test_json_suffix_and_byte_order_mark(tmp_path):
    path = tmp_path / "world.json"
    path.write_bytes(b"\xef\xbb\xbf" + json.dumps(polygon(HALL)).encode())
    assert read_environment(path).area_m2 == 80


@pytest.mark.parametrize(
    "bad", ["NaN", "Infinity", "-Infinity", "1e999", "1e8", '"1"', "true", "null", "1" + "0" * 400]
)
def test_bad_coordinate_is_placed(read, bad):
    text = json.dumps(collection(feature(polygon(HALL)), feature(polygon(HALL, BLOCK))))
    at = text.rindex("[6, 5]")
    with pytest.raises(MapFormatError, match=r"feature 2, ring 2, position 3: a coordinate is"):
        read(text[:at] + f"[6, {bad}]" + text[at + 6 :])


@pytest.mark.parametrize(
    ("document", "message"),
    [
        (polygon(HALL[:3]), r"world\.geojson, ring 1: the ring has 3 positions"),
        (polygon(HALL, BLOCK[:-1]), r"ring 2: the ring is open: it starts at \(4\.0, 3\.0\)"),
        (polygon(), "has no rings"),
        (polygon([]), "ring 1: the ring has 0 positions"),
        (polygon(5), "ring 1: the ring is 5"),
        (polygon([[0, 0], [1], [1, 1], [0, 0]]), "ring 1, position 2: the position is a list of 1"),
        (polygon([[0, 0], [8, 8], [8, 0], [0, 8], [0, 0]]), "not valid: Self-intersection"),
        (
            {"type": "MultiPolygon", "coordinates": [[HALL], [HALL[:2]]]},
            "polygon 2, ring 1: the ring has 2",
        ),
        ({"type": "Polygon"}, "coordinates is None"),
        ({"type": "LineString", "coordinates": HALL}, "'LineString' cannot be free"),
        (collection(feature({"type": "Point", "coordinates": [1, 1]})), "feature 1: .*'Point'"),
        (collection(feature(polygon(HALL), kind="start")), "'Polygon' cannot be start"),
        (
            collection(feature(polygon(HALL), kind="wall")),
            "kind is 'wall'; it must be one of outline",
        ),
        (collection(feature(polygon(HALL), kind=[1])), "kind is a list of 1"),
        (collection(feature(None)), "there is no free space"),
        (collection(polygon(HALL)), "feature 1: this is not a Feature"),
        (collection(), "no free space"),
        (collection(feature(polygon(HALL), kind="obstacle")), "no free space"),
        (collection(feature(polygon(HALL)), feature(polygon(HALL), kind="obstacle")), "is empty"),
        ({"type": "FeatureCollection"}, "features is None"),
        ({"type": "Feature", "properties": 3, "geometry": polygon(HALL)}, "properties are 3"),
        ([1, 2], "expected a GeoJSON object, found a list of 2"),
        ({"type": "Topology"}, "'Topology' cannot be free"),
        ({"a": 1}, "neither GeoJSON, .*, nor a floor plan of HouseExpo, which has"),
        ("{", r"is not JSON, line 1, column 2"),
        ("[" * 100_000, "is not GeoJSON"),
        ("1" * 5000, "is not GeoJSON|expected a GeoJSON object"),
    ],
)
def test_fault_is_named_and_placed(read, document, message):
    with pytest.raises(MapFormatError, match=message):
        read(document)


def test_degrees_are_suggested_where_no_body_fits(read):
    town = read(polygon([[12.5 + x / 20, 41.9 + y / 20] for x, y in HALL]))
    hint = "; if its coordinates are degrees, project them first: those of GeoJSON must be metres"
    (problem,) = check_map(town, Footprint.disc(0.25)).problems
    assert problem.endswith(hint)
    spec = RunSpec(environment=inline(town), robots=(RobotSpec(),))
    with pytest.raises(InvalidInputError, match=re.escape(f"choose a smaller body{hint}")):
        starts_of(spec, town)
    # A small body fits; metres beyond the degrees of longitude and latitude are no degrees.
    assert not check_map(town, Footprint.disc(0.05)).problems
    far = read(polygon([[200 + x / 20, y / 20] for x, y in HALL]))
    assert "degrees" not in check_map(far, Footprint.disc(0.25)).problems[0]


def test_degrees_are_refused(read):
    degrees = [[12.51 + x * 1e-6, 41.89 + y * 1e-6] for x, y in HALL]
    with pytest.raises(MapFormatError, match="metres, not degrees"):
        read(polygon(degrees))
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
    with pytest.raises(MapFormatError, match="longitude and latitude"):
        read({**collection(feature(polygon(HALL))), "crs": crs})
    metric = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25833"}}
    assert read({**collection(feature(polygon(HALL))), "crs": metric}).area_m2 == 80


def test_options_of_images_are_refused(read):
    with pytest.raises(MapFormatError, match="leave out --resolution"):
        read(polygon(HALL), resolution_m=0.1)
    with pytest.raises(MapFormatError, match="leave out --threshold"):
        read(polygon(HALL), threshold=0.5)


def test_features_without_a_place_are_left_out_and_counted(read):
    nowhere = feature(None, kind="obstacle"), feature(None, name="a road", type="road")
    world = read(collection(nowhere[0], feature(polygon(HALL, BLOCK)), nowhere[1]))
    assert world.free.equals(WITH_A_HOLE)
    assert str(world.cleaning) == "2 features without a place left out"
    one = read(collection(feature(polygon(HALL, BLOCK)), nowhere[0]))
    assert str(one.cleaning) == "1 feature without a place left out"
    with pytest.raises(MapFormatError, match="there is no free space"):
        read(collection(*nowhere))


def test_a_feature_that_has_no_member_geometry_is_an_error(read):
    with pytest.raises(MapFormatError, match="feature 2: expected a GeoJSON object, found None"):
        read(collection(feature(polygon(HALL)), {"type": "Feature", "properties": None}))


def test_kinds_of_documentation_and_message_are_those_that_are_read(read):
    with pytest.raises(MapFormatError, match="must be one of outline, free, boundary, obstacle, s"):
        read(feature(polygon(HALL), kind="house"))
    page = Path(__file__).resolve().parents[2] / "docs" / "formats.md"
    (said,) = re.findall(r"^- \*\*GeoJSON\*\*: (.*)$", page.read_text("utf-8"), re.MULTILINE)
    assert re.findall(r"`(\w+)`", said.partition("Coordinates")[0]) == ["kind", *KINDS]
    for kind in ("outline", "free", "boundary"):
        assert read(feature(polygon(HALL), kind=kind)).area_m2 == 80.0
