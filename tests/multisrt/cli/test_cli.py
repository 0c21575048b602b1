import json
import os
import re
import resource
import struct
import subprocess
import sys
import xml.etree.ElementTree as ET
import zlib
from importlib import import_module
from pathlib import Path
from typing import get_args, get_type_hints

import msgspec
import pytest
from PIL import Image

from multisrt import cli
from multisrt.cli.run_options import DRIVES
from multisrt.environments.catalog import names
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.robots.registry import strategies
from multisrt.spec import (
    Death,
    DriveSpec,
    FileEnvironment,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)

ROOT = Path(__file__).parents[3]

FILES = ["recording.jsonl", "run.json", "spec.toml", "tree.svg"]

ROOM = "POLYGON ((0 0, 6 0, 6 5, 0 5, 0 0))"
PILLAR = "POLYGON ((0 0, 9 0, 9 6, 0 6, 0 0), (3 2, 5 2, 5 4, 3 4, 3 2))"
# Two rooms of 6 x 5 m, a door of 0.4 m between them in a wall of 0.2 m.
NARROW = (
    "POLYGON ((0 0, 6 0, 6 2, 6.2 2, 6.2 0, 12.2 0, 12.2 5, 6.2 5, 6.2 2.4, 6 2.4, 6 5, 0 5, 0 0))"
)


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in (("room", ROOM), ("pillar", PILLAR), ("narrow", NARROW)):
        (tmp_path / f"{name}.wkt").write_text(text)
    return tmp_path


@pytest.fixture
def call(folder, monkeypatch, capsys):
    """Run a command; return exit code, standard output and standard error."""

    def run(*words: str):
        monkeypatch.setattr(sys, "argv", ["multisrt", *words])
        with pytest.raises(SystemExit) as end:
            cli.main()
        captured = capsys.readouterr()
        return end.value.code, captured.out, captured.err

    return run


def everything(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


def test_explore_writes_its_files(call, folder):
    code, out, err = call("explore", "room.wkt", "--seed", "3")
    assert (code, err) == (0, "")
    assert "srt-radial in room, seed 3: complete" in out
    results = folder / "runs" / "room-srt-radial-3"
    assert sorted(os.listdir(results)) == FILES
    summary = json.loads((results / "run.json").read_text())
    recording = Recording.load(results / "recording.jsonl")
    assert summary["outcome"] == "complete"
    assert summary["digest"] == recording.footer.digest
    assert summary["spec"] == json.loads(recording.spec.to_json())
    assert summary["metrics"]["coverage"] > 0.99
    assert ET.parse(results / "tree.svg").getroot().tag.endswith("svg")
    for name in FILES:
        assert str(Path("runs") / "room-srt-radial-3" / name) in out


def test_explore_with_many_options(call, folder):
    code, _, err = call(
        *("explore", "pillar.wkt", "--strategy", "srt-star", "--seed", "1", "--out", "a/b"),
        *("--start", "1.5,1.5,0.5", "--range", "3", "--beams", "360", "--footprint", "box:0.5x0.3"),
        *("--drive", "holonomic", "--speed", "1", "--max-time", "5000", "--option", "cones=12"),
        *("--option", "backtrack=nearest_open", "--quiet"),
    )
    assert (code, err) == (0, "")
    spec = Recording.load(folder / "a" / "b" / "recording.jsonl").spec
    assert spec.strategy == "srt-star"
    assert spec.options == {"cones": "12", "backtrack": "nearest_open"}
    assert spec.robots[0].start == (1.5, 1.5, 0.5)
    assert spec.robots[0].range_finder.beams == 360
    assert spec.robots[0].drive.kind == "holonomic"
    assert spec.stop.max_time_s == 5000.0


def test_quiet_prints_nothing(call):
    assert call("explore", "room.wkt", "--quiet") == (0, "", "")


def test_exploring_again_overwrites_with_the_same(call, folder):
    call("explore", "pillar.wkt", "--out", "out")
    before = everything(folder)
    code, _, _ = call("explore", "pillar.wkt", "--out", "out")
    assert code == 0
    assert everything(folder) == before


def test_out_of_time_is_exit_code_3(call, folder):
    code, out, err = call("explore", "pillar.wkt", "--range", "2", "--max-time", "5", "--out", "o")
    assert (code, err) == (3, "")
    assert "out_of_time" in out
    assert (folder / "o" / "tree.svg").exists()


def test_stalled_is_exit_code_3(call):
    code, out, _ = call(
        *("explore", "office", "--seed", "1"),
        *("--option", "approach=false", "--option", "complete=false"),
    )
    assert code == 3
    assert "stalled" in out


def test_a_body_too_wide_for_a_door_is_reported(call):
    code, out, err = call("explore", "narrow.wkt", "--start", "1,1", "--range", "3")
    assert err == ""
    # The door is too narrow to pass; the other room is seen as far as the range allows.
    assert code == 0
    explorable = float(re.search(r"covered .* of ([\d.]+) m2 explorable", out)[1])
    free = float(re.search(r"free space +([\d.]+) m2", out)[1])
    assert free == pytest.approx(60.1, abs=0.1)
    assert 30.0 < explorable < 45.0
    assert re.search(r"body disc:0\.25 only [\d.]+ of 60\.1 m2 of free space", out)
    assert re.search(r"too narrow|not reachable|seen from near", out)


def test_a_spec_repeats_its_run(call, folder):
    code, first, _ = call("explore", "pillar.wkt", "--seed", "5", "--out", "a")
    assert code == 0
    again = call("explore", "--spec", "a/spec.toml", "--out", "b")
    assert again == (0, first.replace("a/", "b/"), "")
    for name in FILES:
        assert (folder / "a" / name).read_bytes() == (folder / "b" / name).read_bytes()
    (folder / "spec.json").write_text(Recording.load("a/recording.jsonl").spec.to_json())
    assert call("explore", "--spec", "spec.json", "--quiet") == (0, "", "")
    assert sorted(os.listdir(folder / "runs" / "spec-srt-radial-5")) == FILES


def test_two_strategies_side_by_side(call, folder):
    code, out, err = call(
        *("explore", "pillar.wkt", "--strategy", "srt-radial", "--strategy", "srt-star"),
        *("--out", "both"),
    )
    assert (code, err) == (0, "")
    assert sorted(os.listdir(folder / "both")) == ["srt-radial", "srt-star"]
    assert re.search(r"measure +srt-radial +srt-star", out)
    distances = []
    for name in ("srt-radial", "srt-star"):
        assert sorted(os.listdir(folder / "both" / name)) == FILES
        assert f"both/{name}/tree.svg" in out
        assert f"{name} in pillar, seed 0: complete" in out
        metrics = json.loads((folder / "both" / name / "run.json").read_text())["metrics"]
        distances.append(f"{metrics['total_distance_m']:.1f} m")
    assert re.search(rf"distance +{distances[0]} +{distances[1]} *\n", out)
    assert max(map(len, out.splitlines())) <= 100


def test_one_incomplete_run_of_two_is_exit_code_3(call):
    words = "--strategy", "srt-radial", "--strategy", "srt-star", "--max-time", "3"
    code, out, _ = call("explore", "pillar.wkt", "--range", "2", *words)
    assert code == 3
    assert "runs/pillar-0/srt-star/tree.svg" in out


def test_why_explains_decisions(call, folder):
    call("explore", "pillar.wkt", "--out", "out", "--quiet")
    recording = "out/recording.jsonl"
    code, out, err = call("why", recording, "--robot", "0", "--time", "0")
    assert (code, err) == (0, "")
    assert "Robot 0 at 0.00 s: its last decision was at 0.00 s." in out
    assert "at node 0" in out
    code, out, _ = call("why", recording)
    assert code == 0
    assert "it chose end" in out
    code, out, _ = call("why", recording, "--all")
    decisions = [e for e in Recording.load(recording).events if type(e).__name__ == "Decision"]
    assert code == 0
    assert len(out.splitlines()) == 1 + len(decisions)


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["out/recording.jsonl", "--robot", "1"], "there is no robot 1: the run has 1"),
        (["out/recording.jsonl", "--robot", "-1"], "there is no robot -1"),
        (["out/recording.jsonl", "--robot", "1", "--all"], "there is no robot 1"),
        (["out/recording.jsonl", "--time", "1e6"], "not within the run"),
        (["out/recording.jsonl", "--time", "-1"], "not within the run"),
        (["out/recording.jsonl", "--time", "nan"], "not within the run"),
        (["none.jsonl"], "none.jsonl: No such file"),
        (["room.wkt"], "room.wkt, line 1"),
    ],
)
def test_why_refuses_bad_input(call, folder, words, named):
    call("explore", "room.wkt", "--out", "out", "--quiet")
    code, out, err = call("why", *words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert named in err


def spec_of(folder: Path, call, *words: str):
    """Return the spec that `explore` makes of its options, without running it."""
    given = None
    # Imported before the patch: it binds the real function.
    import_module("multisrt.run")

    def kept(spec, *args, **kwargs):
        nonlocal given
        given = spec
        raise InvalidInputError("that will do")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("multisrt.simulation.simulate.simulate", kept)
        code, _, err = call("explore", *words)
    assert (code, err) == (2, "error: that will do\n")
    return given


def test_options_of_a_team(call, folder):
    spec = spec_of(
        folder,
        call,
        *("room.wkt", "--robots", "4", "--starts", "clustered", "--radio-range", "15"),
        *("--no-multi-hop", "--latency", "0.1", "--jitter", "0.2", "--loss", "0.3"),
        *("--walls", "weaken", "--drive", "dubins", "--turning-radius", "0.8"),
        *("--fault", "death:2@30", "--fault", "silence:1@20+15", "--fault", "late:3@60"),
        *("--fault", "death:0@1.5:moving"),
    )
    assert spec.starts == "clustered"
    assert spec.robots == 4 * (RobotSpec(drive=DriveSpec(kind="dubins", turning_radius_m=0.8)),)
    assert spec.radio == RadioSpec(
        range_m=15.0, multi_hop=False, latency_s=0.1, jitter_s=0.2, loss=0.3, walls="weaken"
    )
    assert spec.faults == (
        Death(robot=2, time_s=30.0),
        Silence(robot=1, time_s=20.0, duration_s=15.0),
        LateStart(robot=3, time_s=60.0),
        Death(robot=0, time_s=1.5, when="moving"),
    )


def test_every_drive_can_be_chosen():
    assert get_args(get_type_hints(DriveSpec)["kind"]) == DRIVES


def test_options_of_robots_that_differ(call, folder):
    spec = spec_of(
        folder,
        call,
        *("room.wkt", "--speed", "0.7", "--robots", "3"),
        *("--robot", "footprint=polygon:-0.2,-0.1 0.3,0 -0.2,0.1,range=6,speed=1,beams=90"),
        *("--robot", "start=2,3,0.5,drive=reeds-shepp,turning-radius=0.9"),
    )
    usual = DriveSpec(speed_m_s=0.7)
    assert spec.robots == (
        RobotSpec(
            footprint="polygon:-0.2,-0.1 0.3,0 -0.2,0.1",
            drive=DriveSpec(speed_m_s=1.0),
            range_finder=RangeFinderSpec(range_m=6.0, beams=90),
        ),
        RobotSpec(
            start=(2.0, 3.0, 0.5),
            drive=DriveSpec(kind="reeds-shepp", speed_m_s=0.7, turning_radius_m=0.9),
        ),
        RobotSpec(drive=usual),
    )
    starts = spec_of(folder, call, "room.wkt", "--start", "1,1", "--start", "3,3,1")
    assert [robot.start for robot in starts.robots] == [(1.0, 1.0), (3.0, 3.0, 1.0)]
    two = spec_of(folder, call, "room.wkt", "--robot", "range=2", "--robot", "range=3")
    assert [robot.range_finder.range_m for robot in two.robots] == [2.0, 3.0]


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
        (["pillar.wkt", "--start", "4,3"], "clearance 0 m"),
        (["pillar.wkt", "--start", "40,3"], "(40, 3)"),
        (["pillar.wkt", "--start", "2.9,3"], "clearance there is 0.1 m"),
        (["pillar.wkt", "--start", "nan,1"], "start"),
        (["pillar.wkt", "--start", "1,inf"], "start"),
        (["pillar.wkt", "--footprint", "disc:4"], "fits nowhere"),
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
        (["room.wkt", "--max-time", "0"], "max_time_s"),
        (["room.wkt", "--max-time", "nan"], "max_time_s"),
        (["room.wkt", "--seed", "-1"], "seed"),
        (["room.wkt", "--resolution", "0.1"], "room.wkt"),
        (["open", "--resolution", "0.1"], "images"),
        (["room.wkt", "--option", "colour=red"], "colour"),
        (["room.wkt", "--option", "alpha=much"], "alpha"),
        (["room.wkt", "--option", "alpha=7"], "alpha"),
        (["room.wkt", "--option", "cones=2"], "cones"),
        (["room.wkt", "--drive", "dubins", "--turning-radius", "0"], "turning_radius_m"),
        (["room.wkt", "--robots", "0"], "at least one robot"),
        (["room.wkt", "--robots", "3", "--start", "1,1", "--start", "2,2"], "2 starts for 3"),
        (["room.wkt", "--robots", "1", "--robot", "range=2", "--robot", "range=3"], "2 times"),
        (["room.wkt", "--robot", "footprint=disc:-1"], "disc:-1"),
        (
            ["room.wkt", "--robot", "drive=sail"],
            "no drive 'sail'; there are: differential, holonomic",
        ),
        (
            ["room.wkt", "--option", "select=first"],
            "srt-radial: Invalid enum value 'first'; allowed: 'closest_root', 'most_recent'",
        ),
        (["room.wkt", "--robot", "range=0"], "range"),
        (["room.wkt", "--radio-range", "-1"], "range_m of a radio"),
        (["room.wkt", "--loss", "1"], "loss of a radio"),
        (
            ["room.wkt", "--robots", "2", "--range", "2.5", "--radio-range", "7"],
            "7.5 m for a sensor range of 2.5 m, not 7 m",
        ),
        (["room.wkt", "--walls", "weaken"], "give range_m"),
        (["room.wkt", "--fault", "death:1@30"], "there is no such robot"),
        (["room.wkt", "--fault", "death:0@30", "--max-time", "20"], "not within the run"),
        (["room.wkt", "--fault", "silence:0@3+-1"], "positive number of seconds"),
        (["--spec", "nothing.toml"], "nothing.toml: No such file"),
        (["--spec", "room.wkt"], "room.wkt: not a run spec"),
        (["--spec", "folder.png"], "folder.png: Is a directory"),
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
    assert err == "error: cannot make the folder locked: Permission denied\n"


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
def test_wrong_usage_is_explained(call, folder, words):
    before = everything(folder)
    code, out, err = call(*words)
    assert (code, out) == (2, "")
    assert "Error: " in err
    assert "Traceback" not in err
    assert everything(folder) == before


def test_every_help_page_has_examples_and_fits_80_columns(call, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    groups = ["experiment", "environments"]
    commands = [[], *([name] for name in cli.cli.commands)]
    commands += [[g, name] for g in groups for name in cli.cli.commands[g].commands]
    for command in commands:
        code, out, err = call(*command, "--help")
        assert (code, err) == (0, "")
        assert "Usage: multisrt" in out
        assert "Examples" in out
        assert "..." not in out.partition("Commands:")[2].partition("Examples")[0]
        assert max(map(len, out.splitlines())) <= 80
    code, out, err = call("--version")
    assert (code, err) == (0, "")
    assert out.startswith("multisrt, version ")


def test_help_states_the_defaults_of_the_specs(call):
    _, out, _ = call("explore", "--help")
    stated = {}
    for entry in re.split(r"\n {2}(?=--)", out):
        text = " ".join(entry.split())
        if found := re.search(r"\[default: ([^\],]*)", text):
            stated[text.split()[0]] = found[1]
    robot = RobotSpec()
    defaults = {field.name: field.default for field in msgspec.structs.fields(RunSpec)}
    assert stated == {
        "--strategy": defaults["strategy"],
        "--seed": str(defaults["seed"]),
        "--max-time": f"{StopRule().max_time_s:g}",
        "--robots": str(len(defaults["robots"])),
        "--starts": defaults["starts"],
        "--range": f"{robot.range_finder.range_m:g}",
        "--beams": str(robot.range_finder.beams).lower(),
        "--footprint": robot.footprint,
        "--drive": robot.drive.kind,
        "--speed": f"{robot.drive.speed_m_s:g}",
        "--turning-radius": f"{robot.drive.turning_radius_m:g}",
        "--radio-range": str(RadioSpec().range_m).lower(),
        "--latency": f"{RadioSpec().latency_s:g}",
        "--jitter": f"{RadioSpec().jitter_s:g}",
        "--loss": f"{RadioSpec().loss:g}",
        "--walls": RadioSpec().walls,
        "--out": "runs/ENV-STRATEGY-SEED",
    }


def test_options_not_given_have_the_defaults_of_the_specs(call, folder):
    spec = spec_of(folder, call, "room.wkt")
    assert spec == RunSpec(environment=FileEnvironment(path="room.wkt"))


def test_environments_lists_the_catalogue(call):
    code, out, err = call("environments")
    assert (code, err) == (0, "")
    assert all(re.search(rf"^ *{name} ", out, re.M) for name in names())


def test_environments_show_draws_a_map(call, folder):
    code, out, err = call("environments", "show", "office")
    assert (code, err) == (0, "")
    assert "parameters: " in out
    assert ET.parse(folder / "office.svg").getroot().tag.endswith("svg")
    code, out, _ = call("environments", "show", "pillar.wkt", "--out", "p.svg")
    assert code == 0
    assert "9 x 6 m, 50 m2 free, 1 component, 8 edges" in out
    assert (folder / "p.svg").exists()


@pytest.mark.parametrize("out", [".", "room.wkt/x.svg", "none/x.svg", "/"])
def test_environments_show_refuses_bad_paths(call, folder, out):
    before = everything(folder)
    code, _, err = call("environments", "show", "room.wkt", "--out", out)
    assert code == 2
    assert err.startswith("error: cannot write ")
    assert err.count("\n") == 1
    assert everything(folder) == before


def test_strategies_lists_names_and_options(call):
    code, out, err = call("strategies")
    assert (code, err) == (0, "")
    assert all(known.name in out for known in strategies())
    code, out, err = call("strategies", "srt-star")
    assert (code, err) == (0, "")
    for option, default in (("alpha", "0.8"), ("cones", "16"), ("approach", "true")):
        assert re.search(rf"{option} +{default} +\w", out)
    code, _, err = call("strategies", "srt-square")
    assert code == 2
    assert err.count("\n") == 1


def test_an_interrupted_run_leaves_no_files(call, folder, monkeypatch):
    def interrupted(*args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr("multisrt.simulation.sensing.take_scan", interrupted)
    before = everything(folder)
    code, out, err = call("explore", "room.wkt", "--out", "new/results")
    assert (code, out, err.strip()) == (130, "", "interrupted")
    assert everything(folder) == before


# In a process of its own.


def process(*words: str, cwd: Path = ROOT, **options) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "multisrt.cli", *words],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
        **options,
    )


def test_exit_codes_of_a_process(folder):
    out = str(folder / "out")
    room = str(folder / "room.wkt")
    assert process("explore", room, "--out", out).returncode == 0
    late = process("explore", room, "--out", out, "--range", "1", "--max-time", "1")
    assert late.returncode == 3
    bad = process("explore", str(folder / "nothing.wkt"), "--out", str(folder / "new"))
    assert bad.returncode == 2
    assert bad.stdout == ""
    assert bad.stderr.count("\n") == 1
    assert not (folder / "new").exists()


def test_a_full_disk(folder):
    def small_files_only():
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    done = process(
        *("explore", str(folder / "pillar.wkt"), "--out", str(folder / "out"), "--range", "2"),
        preexec_fn=small_files_only,
    )
    assert done.returncode == 2
    assert done.stderr.startswith("error: cannot write ")
    assert done.stderr.count("\n") == 1
    assert not (folder / "out").exists()


def test_a_closed_pipe_raises_no_traceback():
    command = [sys.executable, "-m", "multisrt.cli", "environments"]
    with subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        running.stdout.close()
        assert "Traceback" not in running.stderr.read()


def test_summary_of_a_bidding_team(call, folder):
    words = ("room.wkt", "--strategy", "minpos", "--robots", "2", "--radio-range", "15")
    code, out, _ = call("explore", *words, "--out", "bids")
    assert code == 0
    assert re.search(r"informative scans +\d+", out)
    assert re.search(r"a robot isolated for +0\.0 s \(longest 0\.0 s\)", out)
    assert re.search(r"known to one robot only +\d+ m2 s \(0\.0 m2 at the end\)", out)
    assert "nodes" not in out
    code, out, _ = call("why", "bids/recording.jsonl", "--robot", "1", "--time", "0")
    assert code == 0
    assert "How it chose: minpos" in out
    assert "> robot 1" in out
