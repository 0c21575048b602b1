"""Maps for the terminal, compared with maps drawn by hand."""

import re

import numpy as np
import pytest
import shapely

from multisrt.drawing.colours import ROBOT_COLOURS, tint
from multisrt.drawing.console import SEEN_SHARE, UNSEEN_COLOUR, WALL_COLOUR, ConsoleMap, Ink
from multisrt.environments.environment import Environment

PAINTED = re.compile(r"\x1b\[([\d;]+)m")


def box(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


@pytest.fixture(scope="module")
def hall() -> Environment:
    """A hall of 8 x 8 m with a wall from below to the middle, 1 m thick."""
    return Environment("hall", shapely.box(0, 0, 8, 8).difference(shapely.box(3, 0, 4, 4)))


def test_walls_seen_area_and_robots_are_letters(hall):
    # 8 cells of 1 x 2 m, and one of wall on each side.
    console = ConsoleMap(hall, 10, 6, "ascii")
    assert console.lines({}) == [
        "##########",
        "#        #",
        "#        #",
        "#   #    #",
        "#   #    #",
        "##########",
    ]
    console.add_seen(0, box(0, 0, 3, 8))
    console.add_seen(1, box(2, 4, 6, 8))
    assert console.lines({0: (0.5, 0.5), 1: (5.5, 7.5)}, {1}) == [
        "##########",
        "#.....x  #",
        "#......  #",
        "#...#    #",
        "#0..#    #",
        "##########",
    ]


def test_numbers_of_two_digits_fill_two_cells(hall):
    lines = ConsoleMap(hall, 10, 6, "plain").lines({12: (6.0, 1.0), 3: (40.0, 40.0)})
    assert "12" in lines[4]
    # What is not on the map is at its edge.
    assert lines[0][-1] == "3"
    assert {len(line) for line in lines} == {10}


def test_the_key_explains_the_signs(hall):
    key = ConsoleMap(hall, 10, 6, "ascii").key(80, team=True, dead=True)
    assert key == "# wall  ' ' not seen  . seen  0 1 robots  x dead robot"
    painted = ConsoleMap(hall, 10, 6, "true").key(80, team=False, dead=False)
    assert PAINTED.sub("", painted) == "  wall    not seen    seen  0 robot"
    assert painted.count("\x1b[0m") == 3


@pytest.mark.parametrize("ink", ["ascii", "plain", "256", "true"])
def test_a_key_is_never_wider_than_asked_for(hall, ink):
    console = ConsoleMap(hall, 10, 6, ink)
    texts = [PAINTED.sub("", console.key(n, team=True, dead=True)) for n in range(5, 90)]
    assert all(len(text) <= n for n, text in enumerate(texts, 5))
    assert texts[-1].endswith("dead robot")


@pytest.mark.parametrize("ink", ["256", "true"])
def test_areas_of_robots_have_different_colours(hall, ink):
    colours = set()
    for robot in range(len(ROBOT_COLOURS)):
        console = ConsoleMap(hall, 10, 6, ink)
        console.add_seen(robot, box(0, 0, 8, 8))
        colours.add(frozenset(PAINTED.findall("".join(console.lines({})))))
    assert len(colours) == len(ROBOT_COLOURS)


def test_who_saw_an_area_first_keeps_it(hall):
    console = ConsoleMap(hall, 10, 6, "true")
    console.add_seen(0, box(0, 0, 3, 8))
    before = console.lines({})
    console.add_seen(1, box(0, 0, 3, 8))
    assert console.lines({}) == before
    console.add_seen(1, np.empty((0, 2)))
    assert console.lines({}) == before


def test_cells_have_two_squares_in_the_colours_of_robots(hall):
    console = ConsoleMap(hall, 10, 6, "true")
    console.add_seen(1, box(0, 7, 8, 8))
    upper = console.lines({0: (0.5, 4.5)})[1]
    assert upper.endswith("\x1b[0m")
    assert PAINTED.sub("", upper) == " " + "▀" * 8 + " "

    def code(colour: str) -> str:
        return ";".join(str(int(colour[k : k + 2], 16)) for k in (1, 3, 5))

    seen = tint(ROBOT_COLOURS[1], SEEN_SHARE)
    assert f"38;2;{code(seen)};48;2;{code(UNSEEN_COLOUR)}m▀" in upper
    assert f"48;2;{code(WALL_COLOUR)}m " in upper
    assert f";48;2;{code(ROBOT_COLOURS[0])}m0" in console.lines({0: (0.5, 4.5)})[2]


@pytest.mark.parametrize("ink", ["ascii", "plain", "256", "true"])
@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (3, 40), (200, 5), (80, 24)])
def test_maps_fit_the_terminal(hall, ink: Ink, columns, rows):
    lines = ConsoleMap(hall, columns, rows, ink).lines({0: (1.0, 1.0)})
    texts = [PAINTED.sub("", line) for line in lines]
    assert len(texts) <= max(rows, 3)
    assert len({len(text) for text in texts}) == 1
    assert len(texts[0]) <= max(columns, 3)


def test_colours_of_256_are_near_those_that_are_meant(hall):
    line = ConsoleMap(hall, 10, 6, "256").lines({2: (1.0, 1.0)})[4]
    codes = {int(code) for code in re.findall(r"[34]8;5;(\d+)", line)}
    assert 35 in codes
    assert all(16 <= code <= 255 for code in codes)


def test_a_thin_wall_is_seen_on_a_coarse_map():
    free = shapely.box(0, 0, 40, 20).difference(shapely.box(20.1, 0, 20.25, 18))
    world = Environment("thin", free)
    lines = ConsoleMap(world, 42, 12, "ascii").lines({})
    assert [line.count("#") for line in lines[2:-1]] == [3] * 9
    assert lines[1].count("#") == 2
