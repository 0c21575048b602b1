import pytest
import shapely

from multisrt.environments.formats import read_environment
from multisrt.geometry.errors import MapFormatError


@pytest.fixture
def read(tmp_path):
    def write_and_read(text, **options):
        path = tmp_path / "world.wkt"
        path.write_text(text)
        return read_environment(path, **options)

    return write_and_read


SQUARE = "((0 0, 4 0, 4 4, 0 4, 0 0), (1 1, 1 2, 2 2, 2 1, 1 1))"
WORLD = shapely.box(0, 0, 4, 4) - shapely.box(1, 1, 2, 2)


@pytest.mark.parametrize(
    "text",
    [
        f"POLYGON {SQUARE}",
        f"polygon\n{SQUARE}\n\n",
        f"MULTIPOLYGON ({SQUARE})",
        f"GEOMETRYCOLLECTION (POLYGON {SQUARE})",
        f"GEOMETRYCOLLECTION (POLYGON EMPTY, GEOMETRYCOLLECTION (MULTIPOLYGON ({SQUARE})))",
        f"SRID=32633;POLYGON {SQUARE}",
        f" srid = 7 ;\nMULTIPOLYGON ({SQUARE})",
        "POLYGON Z ((0 0 9, 4 0 9, 4 4 9, 0 4 9, 0 0 9), (1 1 9, 1 2 9, 2 2 9, 2 1 9, 1 1 9))",
    ],
)
def test_equivalent_texts_give_the_same_world(read, text):
    world = read(text)
    assert world.free.equals(WORLD)
    assert (world.name, world.origin) == ("world", "world.wkt")
    assert world.edges.shape == (8, 4)


def test_parts_are_united_or_stay_apart(read):
    touching = "((0 0, 2 0, 2 2, 0 2, 0 0))", "((2 0, 4 0, 4 2, 2 2, 2 0))"
    apart = "((10 0, 12 0, 12 2, 10 2, 10 0))"
    polygons = ", ".join(f"POLYGON {rings}" for rings in (*touching, apart))
    world = read(f"GEOMETRYCOLLECTION ({polygons})")
    assert world.free.equals(shapely.box(0, 0, 4, 2) | shapely.box(10, 0, 12, 2))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("POLYGON ((0 0, 4 0, 4 4, 0 0)", r"is cut off: it ends within 1 open parenthesis; copy"),
        ("POLYGON ((0 0, 4 0, 4 4, 0", r"is cut off: it ends within 2 open parentheses; copy"),
        ("POLYGON ((0 0, 4 0, 4 4)", r"is cut off: it ends within 1 open parenthesis; copy"),
        (
            "POLYGON ((0 0, 4 0, 4 4, 0 0)) POLYGON ((9 0, 9 1, 8 1, 9 0))",
            r"is not well-known text: Unexpected text .*; join several polygons as MULTIPOLYGON",
        ),
        ("POLYGON ((0 0, 4 0, 4 4, 0 4))", "is not well-known text: .*closed.*; repeat.*--fix"),
        ("hello ((", r"is not well-known text: .*HELLO.*; it must be POLYGON \(\(x y, x y"),
        ("POLYGON ((0 0, 4 0, 0 0))", "is not well-known text|not valid"),
        ("POLYGON ((0 0, 4 zero, 4 4, 0 0))", "is not well-known text"),
        ("SRID=4326;POLYGON ((0 0, 4 0, 4 4, 0 0))", "SRID=4326 is longitude and latitude"),
        ("SRID=;POLYGON ((0 0, 4 0, 4 4, 0 0))", "is not well-known text"),
        ("SRID=7;", "is not well-known text"),
        ("hello", "is not well-known text"),
        (
            "POLYGON ((0 0, 9 0, 9 9, 0 0), (5 1, nan 2, 6 2, 5 1))",
            r"polygon 1, ring 2, position 2 is \(nan, 2\)",
        ),
        ("POLYGON ((0 0, inf 0, 4 4, 0 0))", r"polygon 1, ring 1, position 2 is \(inf, 0\)"),
        ("POLYGON ((0 0, 4e8 0, 4 4, 0 0))", r"position 2 is \(4e\+08, 0\)"),
        (
            f"MULTIPOLYGON ({SQUARE}, ((10 0, 14 4, 14 0, 10 4, 10 0)))",
            "polygon 2 is not valid: Self-intersection",
        ),
        ("POLYGON EMPTY", "no polygon that is not empty"),
        ("GEOMETRYCOLLECTION EMPTY", "no polygon that is not empty"),
        ("POINT (1 1)", "part 1 is a Point"),
        (f"GEOMETRYCOLLECTION (POLYGON {SQUARE}, LINESTRING (0 0, 1 1))", "part 2 is a LineString"),
        ("GEOMETRYCOLLECTION (" * 200_000, "more than 16 deep"),
    ],
)
def test_fault_is_named_and_placed(read, text, message):
    with pytest.raises(MapFormatError, match=message):
        read(text)


def test_options_of_images_are_refused(read):
    with pytest.raises(MapFormatError, match="leave out --resolution"):
        read(f"POLYGON {SQUARE}", resolution_m=0.1)
    with pytest.raises(MapFormatError, match="leave out --threshold"):
        read(f"POLYGON {SQUARE}", threshold=0.5)


def test_extended_text_is_recognised_whatever_the_suffix(tmp_path):
    path = tmp_path / "world.txt"
    path.write_text(f"SRID=32633;POLYGON {SQUARE}")
    assert read_environment(path).free.equals(WORLD)


def test_only_rings_that_are_open_are_said_to_be_fixed(read):
    for text in ("POLYGON ((0 0, 4 0", "POLYGON ((0 0, 1 0, 1 1, 0 0)) x", "POLYGON (0 0)"):
        with pytest.raises(MapFormatError) as error:
            read(text)
        assert "--fix" not in str(error.value)
