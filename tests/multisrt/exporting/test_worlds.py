import json
from pathlib import Path

import pytest
import shapely

import multisrt as ms
from multisrt.environments import read_environment
from multisrt.exporting import MapOptions, save_environment

TWO_ROOMS = ms.Environment(
    "two rooms",
    shapely.union_all(
        [
            shapely.box(0, 0, 5, 4) - shapely.box(1 / 3, 1, 2, 2) - shapely.box(3, 1, 4, 3),
            shapely.box(6, -1e-3, 9.1, 0.7),
        ]
    ),
    starts=[(0.2, 0.1), (8, 0.3)],
)


@pytest.mark.parametrize("suffix", [".wkt", ".geojson", ".json", ".WKT"])
@pytest.mark.parametrize("name", ["office", "maze", "garden", "museum"])
def test_polygons_come_back_to_the_last_digit(name, suffix, tmp_path):
    world = ms.environment(name)
    path = tmp_path / f"{name}{suffix}"
    save_environment(world, path)
    again = read_environment(path)
    assert again.digest == world.digest
    assert again.starts == (() if suffix.lower() == ".wkt" else world.starts)


def test_components_and_starts_keep_their_order(tmp_path):
    save_environment(TWO_ROOMS, tmp_path / "rooms.geojson")
    again = read_environment(tmp_path / "rooms.geojson")
    assert again.digest == TWO_ROOMS.digest
    assert again.starts == TWO_ROOMS.starts
    document = json.loads((tmp_path / "rooms.geojson").read_text())
    assert document["name"] == "two rooms"
    first = document["features"][0]["geometry"]["coordinates"][0]
    assert shapely.LinearRing(first).is_ccw  # RFC 7946, 3.1.6


def test_what_exists_is_replaced_only_if_allowed(tmp_path):
    path = tmp_path / "rooms.wkt"
    path.write_text("precious")
    with pytest.raises(ms.InvalidInputError, match=r"exists already; .* overwrite=True"):
        save_environment(TWO_ROOMS, path)
    assert path.read_text() == "precious"
    save_environment(TWO_ROOMS, path, overwrite=True)
    assert read_environment(path).digest == TWO_ROOMS.digest
    assert [file.name for file in tmp_path.iterdir()] == ["rooms.wkt"]


def test_equal_worlds_give_equal_bytes(tmp_path):
    for number, suffix in enumerate([".wkt", ".geojson"]):
        for copy in range(2):
            save_environment(ms.environment("rooms", seed=3), tmp_path / f"{number}{copy}{suffix}")
        first, second = (tmp_path / f"{number}{copy}{suffix}" for copy in range(2))
        assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("rooms.geojsn", "did you mean '.geojson'"),
        ("rooms", "no suffix determines the format"),
        ("rooms.mcap", "'.mcap' is no format of maps"),
        ("nowhere/rooms.wkt", "cannot write"),
    ],
)
def test_paths_that_cannot_be_written_are_named(name, said, tmp_path):
    with pytest.raises(ms.InvalidInputError, match=said) as raised:
        save_environment(TWO_ROOMS, tmp_path / name)
    assert str(Path(name).name) in str(raised.value)
    assert list(tmp_path.iterdir()) == []


def test_worlds_as_small_as_degrees_are_refused(tmp_path):
    tiny = ms.Environment("tiny", shapely.box(0, 0, 0.09, 0.05))
    with pytest.raises(ms.InvalidInputError, match="for degrees"):
        save_environment(tiny, tmp_path / "tiny.geojson")
    save_environment(tiny, tmp_path / "tiny.wkt")
    assert read_environment(tmp_path / "tiny.wkt").digest == tiny.digest


def test_cells_so_wide_that_none_is_free_are_refused(tmp_path):
    hall = ms.Environment("hall", shapely.box(0, 0, 12, 8) - shapely.box(5, 3, 7, 5))
    with pytest.raises(ms.InvalidInputError, match=r"cells of 20 m are too wide for h\.yaml: none"):
        save_environment(hall, tmp_path / "h.yaml", options=MapOptions(cell_m=20.0))
    assert list(tmp_path.iterdir()) == []


def test_the_suffixes_of_one_format_are_listed_together(tmp_path):
    with pytest.raises(ms.InvalidInputError, match=r"\.yaml, \.yml: ROS map server; \.geojson, "):
        save_environment(TWO_ROOMS, tmp_path / "rooms.png")
    with pytest.raises(ms.InvalidInputError, match="it is a folder; name a file"):
        save_environment(TWO_ROOMS, tmp_path)
