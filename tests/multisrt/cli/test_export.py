import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader

from multisrt.recording import Recording
from tests.multisrt.cli.commands import everything

FAST = "--max-time", "3", "--quiet"


@pytest.fixture
def run(call):
    call("explore", "room.wkt", "--out", "out", *FAST)


@pytest.mark.parametrize("suffix", [".mcap", ".rrd", ".MCAP"])
def test_export_writes_a_file(call, folder, run, suffix):
    code, out, err = call("export", "out", "--out", f"a run{suffix}", "--rate", "2")
    assert (code, err) == (0, "")
    assert out.startswith(f"a run{suffix}: ")
    assert out.endswith(" MB\n")
    begins = b"\x89MCAP0" if suffix.lower() == ".mcap" else b"RRF"
    assert (folder / f"a run{suffix}").read_bytes().startswith(begins)
    assert not list(folder.rglob("*.part"))


def test_export_finds_the_recording_and_can_be_quiet(call, folder, run):
    for given in ("out", "out/recording.jsonl"):
        assert call("export", given, "--out", f"{len(given)}.mcap", "--quiet") == (0, "", "")
    assert (folder / "3.mcap").read_bytes() == (folder / "19.mcap").read_bytes()


def test_options_change_what_is_exported(call, folder, run):
    sizes = []
    for number, words in enumerate((["--rate", "1"], ["--rate", "100"], ["--cell", "0.02"])):
        assert call("export", "out", "--out", f"{number}.mcap", "--quiet", *words)[0] == 0
        sizes.append((folder / f"{number}.mcap").stat().st_size)
    assert sizes[0] < sizes[1]
    assert len(set(sizes)) == 3


def test_layers_are_left_out(call, folder, run):
    topics = {}
    for name, words in (("whole", ()), ("bare", ("--without", "paths", "--without", "decisions"))):
        assert call("export", "out", "--out", f"{name}.mcap", "--quiet", *words)[0] == 0
        with (folder / f"{name}.mcap").open("rb") as file:
            summary = make_reader(file).get_summary()
        assert summary is not None
        topics[name] = {channel.topic for channel in summary.channels.values()}
    assert topics["whole"] - topics["bare"] == {"/robot_0/path", "/rosout"}
    code, out, err = call("export", "out", "--out", "x.mcap", "--without", "caption")
    assert (code, out) == (2, "")
    assert "'caption' is not one of paths, edges, nodes, bodies, maps, links, decisions" in err


def test_nothing_is_replaced_unless_asked_for(call, folder, run):
    (folder / "mine.mcap").write_text("mine")
    code, out, err = call("export", "out", "--out", "mine.mcap")
    assert (code, out) == (2, "")
    assert err == (
        "error: mine.mcap exists already: name another file, or replace it with --force\n"
    )
    assert (folder / "mine.mcap").read_text() == "mine"
    assert call("export", "out", "--out", "mine.mcap", "--force", "--quiet")[0] == 0
    assert (folder / "mine.mcap").stat().st_size > 1000


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["out", "--out", "x.bag"], "x.bag: '.bag' is no format of exports; run: .mcap .rrd; traj"),
        (["out", "--out", "x.mcpa"], "(did you mean '.mcap'?)"),
        (["out", "--out", "x"], "x: no suffix determines the format; run: .mcap"),
        (["out", "--out", "no/folder/x.mcap"], "cannot write no/folder/x.mcap: there is no folder"),
        (["out", "--out", "no/folder/x.rrd"], "cannot write no/folder/x.rrd: there is no folder"),
        (["none", "--out", "x.mcap"], "none does not exist: name the folder of a run"),
        (["room.wkt", "--out", "x.mcap"], "room.wkt is not a recording"),
        (["cut.jsonl", "--out", "x.mcap"], "cut.jsonl: the run was cut off"),
        (["out/run.json", "--out", "x.mcap"], "the recording of the run is out/recording.jsonl"),
        (["out", "--out", "x.mcap", "--rate", "0"], "the rate of poses must be above 0"),
        (["out", "--out", "x.mcap", "--rate", "nan"], "the rate of poses must be above 0"),
        (
            ["out", "--out", "x.mcap", "--map-interval", "0"],
            "the interval of maps must be from 0.01",
        ),
        (["out", "--out", "x.mcap", "--cell", "-1"], "cells of maps must be 0.001 to 1000 m wide"),
        (["out", "--out", "x.yaml", "--cell", "-1"], "cells of maps must be 0.001 to 1000 m wide"),
        (["out", "--out", "x.mcap", "--at", "1"], "--at has no meaning for run as .mcap; it takes"),
        (["out", "--out", "x.wkt", "--cell", "1"], "--cell has no meaning for map as .wkt"),
        (["out", "--out", "x.csv", "--without", "maps"], "it takes --robot, --rate"),
        (["out", "--out", "x.stl", "--without", "maps"], "solids have no layer 'maps'"),
        (["out", "--out", "x.csv", "--what", "map"], "x.csv: '.csv' is no format of maps"),
        (
            ["out", "--what", "map"],
            "--what map needs a file whose suffix determines the format: --out",
        ),
        (["out", "--out", "x.yaml", "--robot", "1"], "no robot 1: the run has robot 0 only"),
        (["out", "--out", "x.yaml", "--at", "4"], "the run lasts from 0 to 3.00 s"),
        (["out", "--out", "no/folder/x.yaml"], "cannot write no/folder/x.yaml: there is no folder"),
        (["out", "--out", "x.tum", "--rate", "0"], "the rate of poses must be above 0"),
    ],
)
def test_export_refuses_bad_input(call, folder, run, words, named):
    text = (folder / "out" / "recording.jsonl").read_text()
    (folder / "cut.jsonl").write_text("".join(text.splitlines(keepends=True)[:-1]))
    before = everything(folder)
    code, out, err = call("export", *words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert named in err
    assert everything(folder) == before


@pytest.mark.parametrize(
    ("suffix", "module", "said"),
    [
        (".mcap", "mcap", "an MCAP file needs mcap, which is not installed"),
        (".rrd", "rerun", "a file of rerun needs rerun-sdk, which is not installed"),
    ],
)
def test_a_missing_package_is_named(call, folder, run, monkeypatch, suffix, module, said):
    for name in [name for name in sys.modules if name.partition(".")[0] == module]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, module, None)
    before = everything(folder)
    code, out, err = call("export", "out", "--out", f"x{suffix}")
    assert (code, out) == (2, "")
    assert err.startswith(f"error: {said}: pip install 'multisrt[")
    assert everything(folder) == before


def test_dxf_without_its_package_names_the_extra(call, folder, run, monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == "ezdxf"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    before = everything(folder)
    code, out, err = call("export", "out", "--out", "x.dxf")
    assert (code, out) == (2, "")
    assert err.startswith("error: a DXF file needs ezdxf, which is not installed: pip install ")
    assert everything(folder) == before


@pytest.mark.parametrize("suffix", [".mcap", ".rrd"])
def test_an_interrupted_export_leaves_nothing(folder, run, suffix):
    from multisrt.exporting import export_run

    def stop(share):
        raise KeyboardInterrupt

    recording = Recording.load(folder / "out" / "recording.jsonl")
    before = everything(folder)
    with pytest.raises(KeyboardInterrupt):
        export_run(recording, folder / f"x{suffix}", progress=stop)
    assert everything(folder) == before


def test_progress_reaches_the_end(folder, run):
    from multisrt.exporting import export_run

    shares: list[float] = []
    recording = Recording.load(folder / "out" / "recording.jsonl")
    export_run(recording, folder / "x.mcap", progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert len(shares) > 10


@pytest.mark.parametrize(
    ("words", "files", "begins"),
    [
        (["--out", "m.yaml", "--cell", "0.2"], ["m.yaml", "m.pgm"], b'image: "m.pgm"'),
        (["--out", "m.geojson", "--at", "2"], ["m.geojson"], b'{"type": "FeatureCollection"'),
        (["--out", "m.json", "--what", "map"], ["m.json"], b'{"type": "FeatureCollection"'),
        (["--out", "m.WKT", "--robot", "0"], ["m.WKT"], b"MULTIPOLYGON"),
        (["--out", "m.svg"], ["m.svg"], b"<svg"),
        (["--out", "m.dxf", "--what", "world"], ["m.dxf"], b"  0\nSECTION"),
        (["--out", "m.stl", "--height", "2", "--without", "paths"], ["m.stl"], b"\0" * 80),
        (["--out", "m.glb", "--what", "world"], ["m.glb"], b"glTF"),
        (["--out", "t.graphml"], ["t.graphml"], b"<?xml"),
        (["--out", "t.geojson", "--what", "tree"], ["t.geojson"], b'{"type": "FeatureCollection"'),
        (["--out", "p.csv", "--rate", "4"], ["p.csv"], b"robot,time_s"),
        (["--out", "p.json"], ["p.json"], b'{"columns"'),
        (["--out", "p.tum", "--robot", "0"], ["p.tum"], b"# timestamp"),
    ],
)
def test_parts_of_a_run_are_written(call, folder, run, words, files, begins):
    code, out, err = call("export", "out", *words)
    assert (code, err) == (0, "")
    assert [line.partition(": ")[0] for line in out.splitlines()] == files
    assert (folder / files[0]).read_bytes().startswith(begins)
    assert not list(folder.rglob("*.part"))
    code, _, err = call("export", "out", *words)
    assert code == 2
    assert "exists already: name another file, or replace it with --force" in err
    assert call("export", "out", *words, "--force", "--quiet") == (0, "", "")


def test_the_second_file_of_a_map_is_not_replaced(call, folder, run):
    (folder / "m.pgm").write_text("mine")
    before = everything(folder)
    code, out, err = call("export", "out", "--out", "m.yaml")
    assert (code, out) == (2, "")
    assert err.startswith("error: m.pgm exists already")
    assert everything(folder) == before


def test_words_and_options_are_those_of_the_library():
    from multisrt.cli.export import OPTIONS, WHATS
    from multisrt.exporting.whats import SUFFIXES, options_of

    assert tuple(SUFFIXES) == WHATS
    used = {
        name
        for what, suffixes in SUFFIXES.items()
        for suffix in suffixes
        for name in options_of(Path(f"x{suffix}"), what)
    }
    # The thickness of walls has no option of its own.
    assert used == {*OPTIONS, "thickness_m"}
