import os

import pytest

from multisrt.environments.formats import files, read_environment
from multisrt.geometry.errors import MapFormatError

GRID = "type octile\nheight 3\nwidth 5\nmap\n.G.S.\n.@T.W\n..O..\n"
FIRST = "0\tmaps/a.map\t5\t3\t0\t0\t4\t2\t6.5"
SECOND = "1\tmaps/a.map\t5\t3\t4\t2\t0\t0\t6.5"
THIRD = "7\tmaps/a.map\t5\t3\t0\t0\t3\t1\t6.5"


@pytest.fixture
def read(tmp_path):
    (tmp_path / "a.map").write_text(GRID)

    def write_and_read(*lines, resolution_m=0.5, ends="\n", **options):
        path = tmp_path / "a.map.scen"
        path.write_text(ends.join(("version 1", *lines)) + ends, newline="")
        return read_environment(path, resolution_m=resolution_m, **options)

    return write_and_read


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_starts_are_centres_of_cells_once_and_in_order(read, ends):
    world = read(SECOND, FIRST, "", THIRD, ends=ends)
    assert world.starts == ((2.25, 0.25), (0.25, 1.25))
    assert world.name == "a.map"
    assert world.origin == "a.map.scen with a.map at 0.5 m per cell"
    assert world.bounds == (0, 0, 2.5, 1.5)
    assert not world.contains(0.75, 0.75)


def test_the_map_is_found_by_its_path_before_its_name(read, tmp_path):
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "a.map").write_text(GRID.replace("@", "."))
    assert read(FIRST).contains(0.75, 0.75)


def test_fields_may_be_separated_by_spaces(read):
    assert read(FIRST.replace("\t", " ")).starts == ((0.25, 1.25),)


def test_a_name_with_spaces_is_read(read, tmp_path):
    (tmp_path / "a b.map").write_text(GRID)
    assert read(FIRST.replace("a.map", "a b.map")).starts == ((0.25, 1.25),)


def test_a_grid_of_another_size_lies_over_the_map(read):
    # In a grid twice as fine, the cells (9, 4) and (8, 5) lie in the map's cell (4, 2).
    lines = [f"0\ta.map\t10\t6\t{x}\t{y}\t0\t0\t0" for x, y in ((9, 4), (8, 5), (0, 1))]
    assert read(*lines).starts == ((2.25, 0.25), (0.25, 1.25))
    assert read("0\ta.map\t1\t1\t0\t0\t0\t0\t0".replace("1\t1\t", "3\t3\t")).starts == (
        (0.25, 1.25),
    )


def test_a_grid_of_another_size_is_told(read):
    other = FIRST.replace("\t5\t3\t", "\t6\t3\t")
    (note,) = read(FIRST, other).cleaning.notes
    assert note == (
        "line 3 states a grid of 6 x 3 cells, but a.map has 5 x 3: is it the map of this "
        "scenario? Starts scaled to it"
    )
    assert not read(FIRST).cleaning.notes


def test_starts_are_bounded(read, monkeypatch):
    monkeypatch.setattr(files, "MAX_STARTS", 1)
    assert read(SECOND, FIRST).starts == ((2.25, 0.25),)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ((), r"a\.map\.scen has no problem that names a map"),
        ((FIRST.replace("6.5", ""), "x"), r"line 3 is 'x'; it has the fields bucket, map, "),
        ((FIRST + "\t1",), "line 2 is .* it has the fields bucket"),
        ((FIRST.replace("\t0\t0\t", "\t-1\t0\t", 1),), "line 2 is .* it has the fields bucket"),
        ((FIRST.replace("\t5\t", "\t999999999\t"),), "line 2 is .* it has the fields"),
        (
            (FIRST.replace("\t5\t3\t", "\t99999999\t99999999\t"),),
            "line 2 states a grid of 99999999 x 99999999 cells; grids are read up to 64,000,000",
        ),
        (
            (FIRST.replace("\t0\t0\t", "\t5\t0\t"),),
            r"line 2: the start \(5, 0\) is not in the grid of 5 x 3 cells that the line",
        ),
        ((FIRST.replace("\t0\t0\t", "\t1\t1\t"),), r"\(1, 1\) is not in a free cell of a\.map"),
        (
            (FIRST, SECOND.replace("a.map", "b.map")),
            "line 3 names the map 'maps/b.map', and an earlier",
        ),
        ((FIRST.replace("a.map", "b.map"),), "line 2 names the map maps/b.map, which is not in"),
        (
            (FIRST.replace("maps", ".."),),
            r"line 2 names the file '\.\./a\.map', which is not in the",
        ),
        ((FIRST.replace("maps", "/maps"),), "line 2 names the file '/maps/a.map', which is not"),
    ],
)
def test_fault_is_named(read, lines, message):
    with pytest.raises(MapFormatError, match=message):
        read(*lines)


def test_another_version_is_refused(tmp_path):
    path = tmp_path / "a.scen"
    for version in ("version 2.0", "version 0.0"):
        path.write_text(f"{version}\n{FIRST}\n")
        with pytest.raises(MapFormatError, match=f"line 1 is '{version}'; only version 1 is read"):
            read_environment(path, resolution_m=1.0)


def test_a_fault_of_the_map_names_the_map(read, tmp_path):
    (tmp_path / "a.map").write_text(GRID.replace("@", "?"))
    with pytest.raises(MapFormatError, match=r"a\.map, line 6, column 2 is '\?'"):
        read(FIRST)


def test_a_link_out_of_the_folder_is_not_followed(read, tmp_path):
    folder = tmp_path / "inner"
    folder.mkdir()
    os.symlink(tmp_path / "a.map", folder / "a.map")
    (folder / "a.scen").write_text(f"version 1.0\n{FIRST}\n")
    with pytest.raises(MapFormatError, match=r"'a\.map', which is not in the folder"):
        read_environment(folder / "a.scen", resolution_m=1.0)


def test_a_scenario_needs_a_resolution_and_no_threshold(read):
    with pytest.raises(MapFormatError, match="--resolution"):
        read(FIRST, resolution_m=None)
    with pytest.raises(MapFormatError, match="--threshold"):
        read(FIRST, threshold=0.5)
