import sys

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
        (["out", "--out", "x.bag"], "x.bag: '.bag' is no format of exports; .mcap: MCAP with"),
        (["out", "--out", "x.mcpa"], "(did you mean '.mcap'?)"),
        (["out", "--out", "x"], "x: no suffix says the format; .mcap"),
        (["out", "--out", "no/folder/x.mcap"], "cannot write no/folder/x.mcap: there is no folder"),
        (["out", "--out", "no/folder/x.rrd"], "cannot write no/folder/x.rrd: there is no folder"),
        (["none", "--out", "x.mcap"], "none: No such file"),
        (["room.wkt", "--out", "x.mcap"], "room.wkt is not a recording"),
        (["cut.jsonl", "--out", "x.mcap"], "cut.jsonl: the run was cut off"),
        (["out/run.json", "--out", "x.mcap"], "the recording of the run is out/recording.jsonl"),
        (["out", "--out", "x.mcap", "--rate", "0"], "the rate of poses is above 0"),
        (["out", "--out", "x.mcap", "--rate", "nan"], "the rate of poses is above 0"),
        (["out", "--out", "x.mcap", "--map-interval", "0"], "the interval of maps is from 0.01"),
        (["out", "--out", "x.mcap", "--cell", "-1"], "cells of maps are 0.001 to 1000 m wide"),
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
