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
        ("height 3", "height three", "line 2 is 'height three'; height is a positive"),
        ("height 3", "height 0", "height is a positive"),
        ("height 3", "height 4", "ends after 3 of 4 lines"),
        ("width 5", "width 6", "line 5 has 5 cells and not 6"),
        ("width 5", "width 99999999", "99999999 x 3 cells"),
        (".@T.W", ".@T.X", "line 6, column 5 is 'X'; cells are one of"),
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
        ("0.01", "0", r"line 1: \[SCALE\] is followed by one positive number"),
        ("0.01", "1 2", r"line 1: \[SCALE\]"),
        ("0.01", "nan", "line 2 is 'nan'; it is made of finite numbers"),
        ("1000 800", "1000 eight", "line 7 is '1000 eight'"),
        ("1000 800", "1000", r"line 4: \[BORDER\] is followed by"),
        ("[BORDER]", "[OBSTACLE]", r"has 0 sections \[BORDER\]"),
        ("[BORDER]", "[LIMITS]", r"line 4 is '\[LIMITS\]'"),
        ("700 400\n700 600\n", "", r"line 16: \[OBSTACLE\] is followed by at least three"),
        ("600 300", "300 480", r"line 10: \[OBSTACLE\] is not a valid polygon"),
        ("0.01", "1e9", "beyond 1e.07 m"),
        ("0 0\n", "0 0\n1e308 0\n", "line 4: .*beyond"),
    ],
)
def test_imr_fault_is_named(read, old, new, message):
    assert old in IMR
    with pytest.raises(MapFormatError, match=message):
        read(IMR.replace(old, new, 1), ".txt")
