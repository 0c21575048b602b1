import pytest
import shapely

from multisrt.environments.formats import read_environment
from multisrt.geometry.errors import MapFormatError

GRID = "type octile\nheight 3\nwidth 5\nmap\n.G.S.\n.@T.W\n..O..\n"
IMR = """[SCALE]
0.01

[BORDER]
0 0
1000 0
1000 800
0 800

[OBSTACLE]
400 300
400 500
600 500
600 300

[OBSTACLE]
500 400
700 400
700 600
"""


@pytest.fixture
def read(tmp_path):
    def write_and_read(text, suffix, **options):
        path = tmp_path / f"world{suffix}"
        path.write_text(text, newline="")
        return read_environment(path, **options)

    return write_and_read


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_moving_ai_grid(read, ends):
    world = read(GRID.replace("\n", ends), ".map", resolution_m=0.5)
    assert world.origin == "world.map at 0.5 m per cell"
    assert world.bounds == (0, 0, 2.5, 1.5)
    assert world.contains(0.25, 0.75)
    assert world.contains(1.75, 1.25)
    assert not world.contains(0.75, 0.75)
    assert not world.contains(2.25, 0.75)
    assert not world.contains(1.25, 0.25)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("type octile", "kind octile", "line 1 is 'kind octile'; a MovingAI map has type"),
        ("height 3", "height three", "line 2 is 'height three'; height must be a positive"),
        ("height 3", "height 0", "height must be a positive"),
        ("height 3", "height 4", "ends after 3 of 4 lines"),
        ("width 5", "width 6", "line 5 has 5 cells, not 6"),
        ("width 5", "width 99999999", "99999999 x 3 cells"),
        (".@T.W", ".@T.X", "line 6, column 5 is 'X'; cells must be one of"),
        (".G.S.\n.@T.W\n..O..\n", "@@@@@\n" * 3, "no free cell"),
        (GRID[11:], "", "line 2 is 'the end'; a MovingAI map has height"),
    ],
)
def test_moving_ai_fault_is_named(read, old, new, message):
    assert old in GRID
    with pytest.raises(MapFormatError, match=message):
        read(GRID.replace(old, new), ".map", resolution_m=1.0)


def test_moving_ai_needs_a_resolution_and_no_threshold(read):
    with pytest.raises(MapFormatError, match="--resolution"):
        read(GRID, ".map")
    with pytest.raises(MapFormatError, match="--threshold"):
        read(GRID, ".map", resolution_m=1.0, threshold=0.5)


def test_imr_polygons(read):
    world = read(IMR, ".txt")
    triangle = shapely.Polygon([(5, 4), (7, 4), (7, 6)])
    assert world.free.equals(shapely.box(0, 0, 10, 8) - shapely.box(4, 3, 6, 5) - triangle)
    plain = "[BORDER]\n0 0\n0 2\n2 2\n2 0\n"
    assert read(plain, ".txt").area_m2 == 4


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.01", "0", "line 2: the scale is 0 m per unit; it must be a finite number, at least"),
        ("0.01", "-1", "line 2: the scale is -1 m per unit"),
        ("0.01", "1 2", r"line 1: \[SCALE\]"),
        ("0.01", "nan", "line 2 is 'nan'; it must consist of finite numbers"),
        ("1000 800", "1000 eight", "line 7 is '1000 eight'"),
        ("1000 800", "1000", r"line 4: \[BORDER\] must be followed by"),
        ("[BORDER]", "[OBSTACLE]", "has 0 borders"),
        ("[BORDER]", "[LIMITS]", r"line 4: \[LIMITS\] does not belong to a layout with \[SCALE\]"),
        ("700 400\n700 600\n", "", r"line 16: \[OBSTACLE\] must be followed by at least three"),
        ("600 300", "300 480", r"line 10: \[OBSTACLE\] is not a valid polygon"),
        ("0.01", "1e9", "line 2: the scale is 1e.09 m per unit.* at most 1e.07 m"),
        ("0.01", "5e-324", "line 2: the scale is .*e-324 m per unit"),
        ("0.01", "1e6", "line 4: .*beyond 1e.07 m"),
        ("0 0\n", "0 0\n1e308 0\n", "line 4: .*beyond"),
    ],
)
def test_imr_fault_is_named(read, old, new, message):
    assert old in IMR
    with pytest.raises(MapFormatError, match=message):
        read(IMR.replace(old, new, 1), ".txt")


MAP_POINTS = """[INFO]
FORMAT=MAP_POINTS
VERSION=1

[MAP_POINTS]
0 0 0
1 10 0
2 10 8
3 0 8
4 4 3
5 4 5
6 6 5
7 6 3

[MAP_BORDER]
0
1
2
3

[MAP_OBSTACLE]
4 5
6 7

[MAP_CONVEX_REGION]
anything 1 2
[MESH_NODES]
0 1
"""

NAMED = """[NAME]
a room of 10 m
[LIMITS]
0 10 0 8
[POINTS]
8
0 0 0
1 10 0
2 10 8
3 0 8
4 4 3
5 4 5
6 6 5
7 6 3
[BORDER]
4
0 0
1 1
2 2
3 3
[NUM_HOLES]
1
[HOLE]
0
4
0 4
1 5
2 6
3 7
"""

ROOM = shapely.box(0, 0, 10, 8) - shapely.box(4, 3, 6, 5)


@pytest.mark.parametrize(
    "text",
    [
        MAP_POINTS,
        NAMED,
        NAMED.replace("\n", "\r\n"),
        NAMED.replace("[HOLE]\n0\n4", "[HOLE]\n0 4"),
        NAMED.replace("[HOLE]\n0\n4", "[HOLE] 0 4").replace("[NAME]\n", "[NAME] "),
        NAMED.replace("0 4\n1 5\n2 6\n3 7", "0 7\n1 6\n2 5\n3 4"),
    ],
)
def test_imr_polygons_by_indices(read, text):
    world = read(text, ".txt")
    assert world.free.equals(ROOM)
    assert (world.name, world.origin) == ("world", "world.txt")


def test_imr_heading_and_number_may_share_a_line(read):
    world = read(IMR.replace("[SCALE]\n", "[SCALE] "), ".txt")
    assert world.bounds == (0, 0, 10, 8)


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (MAP_POINTS, "=MAP_POINTS", "=GRID", "line 2 is 'FORMAT=GRID'; the format is MAP_POINTS"),
        (MAP_POINTS, "3 0 8", "4 0 8", "line 9: a point is a line index x y, .* must be 3"),
        (MAP_POINTS, "3 0 8", "3 0", "line 9: a point is a line index x y"),
        (MAP_POINTS, "6 7", "6 8", "line 23: 8 is not the index of a point; they are 0 to 7"),
        (MAP_POINTS, "6 7", "6 -1", "line 23: -1 is not the index of a point"),
        (MAP_POINTS, "6 7", "6 5.5", "line 23: 5.5 is not the index of a point"),
        (
            MAP_POINTS,
            "4 5\n6 7",
            "4 5",
            r"line 21: \[MAP_OBSTACLE\] must be followed by at least three",
        ),
        (MAP_POINTS, "[MAP_BORDER]", "[MAP_OBSTACLE]", "has 0 borders; a map has one"),
        (
            MAP_POINTS,
            "[MAP_BORDER]",
            "[BORDER]",
            r"\[BORDER\] does not belong to a layout with \[IN",
        ),
        (
            MAP_POINTS,
            "[MAP_POINTS]",
            "[MAP_BORDER]",
            r"has 0 sections \[MAP_POINTS\]; a map has one",
        ),
        (MAP_POINTS, "1 10 0", "1 1e9 0", r"line 15: \[MAP_BORDER\] has a coordinate beyond"),
        (MAP_POINTS, "4 5\n6 7", "4 6\n5 7", r"line 21: \[MAP_OBSTACLE\] is not a valid polygon"),
        (NAMED, "[POINTS]\n8", "[POINTS]\n9", r"\[POINTS\] says that 9 lines follow, and 8 do"),
        (NAMED, "[POINTS]\n8", "[POINTS]\neight", "line 6 is 'eight'; it must consist of finite"),
        (
            NAMED,
            "[BORDER]\n4",
            "[BORDER]\n4.5",
            r"\[BORDER\] must be followed by a line with one whole",
        ),
        (NAMED, "2 2\n", "2\n", "line 19: a vertex is a line position index"),
        (NAMED, "2 2\n", "2 9\n", "line 19: 9 is not the index of a point"),
        (NAMED, "[NUM_HOLES]\n1", "[NUM_HOLES]\n2", r"line 21: \[NUM_HOLES\] is 2; the sections"),
        (NAMED, "[NUM_HOLES]\n1", "[NUM_HOLES]\n1e300", r"line 21: \[NUM_HOLES\] is 1e.300; the"),
        (NAMED, "[HOLE]\n0", "[HOLE]\n1", r"line 21: \[NUM_HOLES\] is 1; the sections"),
        (NAMED, "[HOLE]", "[OBSTACLE]", r"\[OBSTACLE\] does not belong to a layout with \[NAME\]"),
        (
            NAMED,
            "[NUM_HOLES]",
            "[HOLES]",
            r"line 21 is '\[HOLES\]'; a polygon map has the sections",
        ),
    ],
)
def test_imr_fault_of_a_layout_is_named(read, text, old, new, message):
    assert old in text
    with pytest.raises(MapFormatError, match=message):
        read(text.replace(old, new, 1), ".txt")
