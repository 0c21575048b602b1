from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from multisrt.environments.formats import mresim, read_environment
from multisrt.environments.formats.mresim import read_team
from multisrt.geometry.errors import MapFormatError

MAPS = Path(__file__).resolve().parents[2].parent / "shared" / "maps"
needs_maps = pytest.mark.skipif(not MAPS.is_dir(), reason="the shared maps are not here")

BASE = "1 BaseStation 3 0 0.0 0 300 1000 BaseStation 1 1"
RELAY = "2 A 1 1 3.14 100 300 1000 Relay 1 4"
EXPLORER = "3 B 4 2 -.5e-1 100 300 1000 Explorer 1 5"


@pytest.fixture
def image(tmp_path):
    """Six by four pixels with a free inside."""
    grey = np.zeros((4, 6), np.uint8)
    grey[1:3, 1:5] = 255
    path = tmp_path / "room.png"
    Image.fromarray(grey).save(path)
    return path


@pytest.fixture
def team(tmp_path):
    def write(*lines, ends="\n"):
        path = tmp_path / "team.txt"
        path.write_text(ends.join(lines) + ends, newline="")
        return path

    return write


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_robots_start_at_their_pixels_counted_from_the_top(image, team, ends):
    path = team(BASE, EXPLORER, "", RELAY, ends=ends)
    world = read_environment(image, resolution_m=0.5, starts_from=path)
    assert world.starts == ((2.25, 0.75), (0.75, 1.25))
    assert world.name == "room"
    assert world.origin.startswith("room.png at 0.5 m per pixel")
    assert world.origin.endswith(", starts of team.txt")
    plain = read_environment(image, resolution_m=0.5)
    assert world.free.equals(plain.free)
    assert plain.starts == ()


def test_a_team_replaces_a_marked_start(tmp_path, team):
    grey = np.full((40, 40), 195, np.uint8)
    grey[:, 0] = 127
    grey[20:24, 20:24] = 208
    path = tmp_path / "dungeon.png"
    Image.fromarray(grey).save(path)
    assert read_environment(path, resolution_m=1.0).starts == ((22.0, 18.0),)
    world = read_environment(path, resolution_m=1.0, starts_from=str(team(RELAY)))
    assert world.starts == ((1.5, 38.5),)


def test_starts_are_distinct_and_bounded(image, team, monkeypatch):
    path = team(RELAY, RELAY, EXPLORER)
    world = read_environment(image, resolution_m=1.0, starts_from=path)
    assert world.starts == ((1.5, 2.5), (4.5, 1.5))
    monkeypatch.setattr(mresim, "MAX_STARTS", 1)
    world = read_environment(image, resolution_m=1.0, starts_from=path)
    assert world.starts == ((1.5, 2.5),)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (BASE, r"has no robot that moves \(Relay or Explorer"),
        (
            RELAY.replace(" 1 1 ", " 0 1 "),
            r"line 1: A starts in the pixel \(0, 1\), which is not f",
        ),
        (
            RELAY.replace(" 1 1 ", " 1 9 "),
            r"line 1: A starts in the pixel \(1, 9\), which is not f",
        ),
        (
            RELAY.replace("Relay", "Leader"),
            "line 1 is .* a team file of MRESim has the fields numb",
        ),
        (RELAY.replace(" 1 1 ", " -1 1 "), "line 1 is .* has the fields"),
        (RELAY.replace(" 1 1 ", " 1.5 1 "), "line 1 is .* has the fields"),
        (RELAY.replace(" 1 1 ", " 999999999 1 "), "line 1 is .* has the fields"),
        (RELAY + " 7", "line 1 is .* has the fields"),
        ("", "has no robot that moves"),
    ],
)
def test_fault_is_named(image, team, line, message):
    with pytest.raises(MapFormatError, match=message) as error:
        read_environment(image, resolution_m=1.0, starts_from=team(line))
    assert "team.txt" in str(error.value)


def test_a_missing_team_is_named(image, tmp_path):
    with pytest.raises(MapFormatError, match=r"no\.txt does not exist"):
        read_environment(image, resolution_m=1.0, starts_from=tmp_path / "no.txt")


def test_a_team_alone_is_no_map(team):
    message = r"team\.txt is a team file of MRESim, which has robots and no map.* --starts-from"
    with pytest.raises(MapFormatError, match=message):
        read_environment(team(BASE, RELAY))


def test_starts_from_is_for_images(tmp_path, team):
    path = tmp_path / "room.wkt"
    path.write_text("POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0))")
    with pytest.raises(MapFormatError, match=r"room\.wkt is not a plain image.* --starts-from"):
        read_environment(path, starts_from=team(RELAY))


@needs_maps
@pytest.mark.parametrize(
    ("image", "team", "robots"),
    [
        ("rooms.png", "team_4robots_rooms.txt", 4),
        ("rooms.png", "team_8robots-rooms.txt", 8),
        ("maze1.png", "team_4robots_maze.txt", 4),
    ],
)
def test_public_teams_stand_in_free_pixels(image, team, robots):
    folder = MAPS / "mresim"
    grey = np.asarray(Image.open(folder / image).convert("L"))
    for member in read_team(folder / team):
        assert grey[member.row, member.column] > 250
    world = read_environment(folder / image, resolution_m=0.1, starts_from=folder / team)
    assert len(world.starts) == robots
