import os
import struct
import zlib
from pathlib import Path

import pytest
from PIL import Image

from multisrt.robots.registry import strategies
from tests.multisrt.cli.commands import everything


def bad_worlds(folder: Path) -> None:
    (folder / "lonely.yaml").write_text(
        "image: nothing.png\nresolution: 0.05\norigin: [0, 0, 0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    Image.new("L", (20, 20), 0).save(folder / "black.png")
    (folder / "black.yaml").write_text(
        "image: black.png\nresolution: 0.05\norigin: [0, 0, 0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    (folder / "bow.wkt").write_text("POLYGON ((0 0, 4 4, 4 0, 0 4, 0 0))")
    (folder / "nan.wkt").write_text("POLYGON ((0 0, nan 0, 4 4, 0 4, 0 0))")
    (folder / "nan.geojson").write_text(
        '{"type": "Polygon", "coordinates": [[[0, 0], [NaN, 0], [4, 4], [0, 4], [0, 0]]]}'
    )
    (folder / "bow.geojson").write_text(
        '{"type": "Polygon", "coordinates": [[[0, 0], [4, 4], [4, 0], [0, 4], [0, 0]]]}'
    )
    (folder / "empty.wkt").write_text("")
    (folder / "folder.png").mkdir()
    (folder / "words.txt").write_text("words")
    (folder / "team.txt").write_text("2 A 330 520 0.0 200 200 1000 Explorer 1 1")
    (folder / "lost.world").write_text('model ( bitmap "cave.png" size [16 16 1] )')
    size = struct.pack(">IIBBBBB", 100_000, 100_000, 8, 0, 0, 0, 0)
    (folder / "huge.png").write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + b"".join(
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
            for kind, data in ((b"IHDR", size), (b"IDAT", zlib.compress(b"\0")), (b"IEND", b""))
        )
    )
    (folder / "huge.pgm").write_bytes(b"P5 100000 100000 255\n\0\0\0")


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["nothing.wkt"], "nothing.wkt"),
        (["no/such/folder/plan.png", "--resolution", "0.1"], "no/such/folder/plan.png"),
        (["offise"], "did you mean 'office'"),
        (["a" * 5000], "no file of that name"),
        (["lonely.yaml"], "nothing.png"),
        (["black.yaml"], "free"),
        (["black.png", "--resolution", "0.1"], "free"),
        (["black.png"], "resolution"),
        (["empty.wkt"], "empty.wkt"),
        (["words.txt"], "words.txt"),
        (["bow.wkt"], "bow.wkt"),
        (["bow.geojson"], "bow.geojson"),
        (["nan.wkt"], "nan.wkt"),
        (["nan.geojson"], "nan.geojson"),
        (["folder.png", "--resolution", "0.1"], "folder.png"),
        (["huge.png", "--resolution", "0.1"], "10,000,000,000 pixels"),
        (["huge.pgm", "--resolution", "0.1"], "10,000,000,000 pixels"),
        (["pillar.wkt", "--start", "4,3"], "m from free space; the nearest place"),
        (["pillar.wkt", "--start", "40,3"], "(40, 3)"),
        (["pillar.wkt", "--start", "2.9,3"], "fits is (2.74, 3), 0.16 m from there"),
        (["pillar.wkt", "--start", "nan,1"], "start"),
        (["pillar.wkt", "--start", "1,inf"], "start"),
        (["pillar.wkt", "--footprint", "disc:4", "--range", "8"], "fits nowhere"),
        (["pillar.wkt", "--footprint", "disc:4"], "give it a longer range"),
        (["room.wkt", "--footprint", "disc:-1"], "disc:-1"),
        (["room.wkt", "--footprint", "disc:nan"], "disc:nan"),
        (["room.wkt", "--footprint", "sphere:1"], "sphere:1"),
        (["room.wkt", "--footprint", "polygon:-1,-1 1,1 1,-1 -1,1"], "polygon"),
        (["room.wkt", "--range", "0"], "range"),
        (["room.wkt", "--range", "-4"], "range"),
        (["room.wkt", "--range", "nan"], "range"),
        (["room.wkt", "--range", "inf"], "range"),
        (["room.wkt", "--range", "1e300"], "range"),
        (["room.wkt", "--beams", "2"], "beams"),
        (["room.wkt", "--beams", "4"], "beams"),
        (["room.wkt", "--speed", "0"], "speed"),
        (["room.wkt", "--max-time", "0"], "--max-time"),
        (["room.wkt", "--max-time", "nan"], "--max-time"),
        (["room.wkt", "--seed", "-1"], "seed"),
        (["room.wkt", "--resolution", "0.1"], "room.wkt"),
        (["open", "--resolution", "0.1"], "images"),
        (["open", "--starts-from", "team.txt"], "images"),
        (["room.wkt", "--starts-from", "team.txt"], "room.wkt is not a plain image"),
        (["team.txt"], "give this file with --starts-from"),
        (["lost.world"], "lost.world, line 1 names the bitmap cave.png, which is not in"),
        (["room.wkt", "--option", "colour=red"], "colour"),
        (["room.wkt", "--option", "alpha=much"], "alpha"),
        (["room.wkt", "--option", "alpha=7"], "alpha"),
        (["room.wkt", "--option", "cones=2"], "cones"),
        (
            ["room.wkt", "--option", "cones=8", "--option", "cones=9"],
            "--option: cones is given twice, as 8 and 9; give it once",
        ),
        (
            ["office", "--set", "cells=8", "--set", "cells=9"],
            "--set: cells is given twice, as 8 and 9; give it once",
        ),
        (["room.wkt", "--option", "cones", "8"], "too many words: 8; write X,Y and KEY=VALUE"),
        (["room.wkt", "--drive", "dubins", "--turning-radius", "0"], "--turning-radius"),
        (["room.wkt", "--robots", "0"], "at least one robot"),
        (["room.wkt", "--robots", "3", "--start", "1,1", "--start", "2,2"], "2 starts for 3"),
        (["room.wkt", "--robots", "2", "--start", "1,1"], "1 start for 2 robots: give --start for"),
        (["room.wkt", "--robots", "1", "--robot", "range=2", "--robot", "range=3"], "2 times"),
        (["room.wkt", "--robots", "4", "--robot", "range=2"], "is given once for 4"),
        (["room.wkt", "--range", "2", "--robot", "range=3"], "--range is used by no robot"),
        (["room.wkt", "--turning-radius", "0.6"], "--turning-radius is used by no robot: none"),
        (["room.wkt", "--robot", "turning-radius=1"], "this robot is not a car"),
        (["room.wkt", "--start", "1,1", "--robot", "start=2,2"], "not both"),
        (["room.wkt", "--starts", "clustered"], "--starts is for teams"),
        (["room.wkt", "--jitter", "0.1"], "--jitter is for teams"),
        (["room.wkt", "--no-multi-hop"], "--no-multi-hop is for teams"),
        (["room.wkt", "--start", "1,1", "--starts", "clustered"], "given its start"),
        (["room.wkt", "--option", "approach=flase"], "did you mean 'false'"),
        (["room.wkt", "--robot", "footprint=disc:-1"], "disc:-1"),
        (
            ["room.wkt", "--robot", "drive=sail"],
            "no drive 'sail'; there are: differential, holonomic",
        ),
        (
            ["room.wkt", "--option", "select=first"],
            "srt-radial: unknown value 'first'; allowed: 'closest_root', 'most_recent'",
        ),
        (
            [
                *("room.wkt", "--strategy", "minpos", "--strategy", "srt-star"),
                *("--option", "alpha=0.5"),
            ],
            "--option alpha applies to all strategies, and minpos has no such option",
        ),
        (["room.wkt", "--robot", "range=0"], "range"),
        (["room.wkt", "--robots", "2", "--radio-range", "-1"], "--radio-range is"),
        (["room.wkt", "--robots", "2", "--loss", "1"], "--loss is"),
        (
            ["room.wkt", "--robots", "2", "--range", "2.5", "--radio-range", "7"],
            "7.5 m for a sensor range of 2.5 m, not 7 m",
        ),
        (["room.wkt", "--robots", "2", "--walls", "weaken"], "give --radio-range"),
        (["room.wkt", "--fault", "death:1@30"], "there is no such robot"),
        (["room.wkt", "--fault", "death:0@30", "--max-time", "20"], "not within the run"),
        (["room.wkt", "--fault", "silence:0@3+-1"], "positive number of seconds"),
        (["--spec", "nothing.toml"], "nothing.toml: No such file"),
        (["--spec", "room.wkt"], "room.wkt: not a run spec"),
        (["--spec", "folder.png"], "folder.png is a folder; name the file in it"),
        (["room.wkt", "--strategy", "srt-star", "--strategy", "srt-square"], "srt-square"),
        (
            ["room.wkt", "--strategy", "srt-star", "--strategy", "srt-ball", "--option", "x=1"],
            "option 'x'",
        ),
        (["room.wkt", "--out", "room.wkt"], "room.wkt"),
        (["room.wkt", "--out", "room.wkt/below"], "room.wkt"),
        (["room.wkt", "--out", "/proc/results"], "/proc/results"),
        (["room.wkt", "--out", "b" * 300], "name too long"),
    ],
)
def test_bad_input_is_one_line_and_leaves_no_files(call, folder, words, named):
    bad_worlds(folder)
    before = everything(folder)
    code, out, err = call("explore", *words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert err.endswith("\n")
    assert named in err
    assert everything(folder) == before


def test_an_unknown_strategy_lists_the_known_ones(call, folder):
    before = everything(folder)
    code, _, err = call("explore", "room.wkt", "--strategy", "srt-square")
    assert code == 2
    assert err.count("\n") == 1
    assert all(known.name in err for known in strategies())
    assert everything(folder) == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_output_folder(call, folder):
    (folder / "locked").mkdir(mode=0o500)
    code, _, err = call("explore", "room.wkt", "--out", "locked")
    assert code == 2
    assert err.count("\n") == 1
    assert "Permission denied" in err


def test_an_unreadable_output_folder(call, monkeypatch):
    exists = Path.exists

    def guarded(path):
        if path.name == "locked":
            raise PermissionError(13, "Permission denied")
        return exists(path)

    monkeypatch.setattr(Path, "exists", guarded)
    code, _, err = call("explore", "room.wkt", "--out", "locked")
    assert code == 2
    assert err == "error: cannot create the folder locked: Permission denied\n"


@pytest.mark.parametrize(
    "words",
    [
        ["explore"],
        ["explore", "room.wkt", "--range", "wide"],
        ["explore", "room.wkt", "--start", "1"],
        ["explore", "room.wkt", "--start", "1,2,3,4"],
        ["explore", "room.wkt", "--start", "a,b"],
        ["explore", "room.wkt", "--option", "alpha"],
        ["explore", "room.wkt", "--colour"],
        ["explore", "room.wkt", "--drive", "sail"],
        ["explore", "room.wkt", "--starts", "nowhere"],
        ["explore", "room.wkt", "--robots", "many"],
        ["explore", "room.wkt", "--robot", "range"],
        ["explore", "room.wkt", "--robot", "colour=red"],
        ["explore", "room.wkt", "--robot", "range=wide"],
        ["explore", "room.wkt", "--robot", "start=1"],
        ["explore", "room.wkt", "--strategy", "srt-star", "--strategy", "srt-star"],
        *(
            ["explore", "room.wkt", "--fault", fault]
            for fault in (
                "death:1",
                "death:x@3",
                "death:0@soon",
                "death:0@3:dancing",
                "silence:0@3",
                "death:0@3+4",
                "late:0@3:moving",
                "flood:0@3",
            )
        ),
        ["explore", "room.wkt", "--spec", "spec.toml"],
        ["explore", "--spec", "spec.toml", "--seed", "1"],
        ["why"],
        ["why", "r.jsonl", "--robot", "x"],
        ["why", "r.jsonl", "--time", "3", "--all"],
        ["dance"],
    ],
)
def test_wrong_usage_is_one_line(call, folder, words):
    before = everything(folder)
    code, out, err = call(*words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert "--help'" in err
    assert everything(folder) == before
