"""`multisrt figure`."""

from importlib import import_module

import pytest

from multisrt.cli.layers import LAYERS
from multisrt.drawing import LAYERS as ALL_LAYERS
from multisrt.drawing import PICTURES
from multisrt.drawing.figures import KINDS, STYLES
from multisrt.drawing.figures.heat import COUNT_LABELS


@pytest.fixture
def run(call, folder):
    """A short run of two robots in the folder `out`."""
    call("explore", "pillar.wkt", "--robots", "2", "--max-time", "20", "--out", "out", "--quiet")
    return folder / "out"


def test_words_of_the_options_are_those_of_the_figures():
    # The package has the command by this name.
    command = import_module("multisrt.cli.figure")
    assert tuple(KINDS) == command.KINDS
    assert tuple(STYLES) == command.STYLES
    assert tuple(COUNT_LABELS) == command.COUNTS
    assert LAYERS == PICTURES
    assert {name for names in LAYERS.values() for name in names} == set(ALL_LAYERS)


@pytest.mark.slow
def test_every_kind_is_drawn(call, run, folder):
    for kind in KINDS:
        code, out, err = call("figure", kind, "out", "--style", "ieee")
        assert (code, out, err) == (0, f"out/{kind}.pdf\n", "")
        assert (folder / "out" / f"{kind}.pdf").read_bytes().startswith(b"%PDF-1")
    for suffix, begins in ((".svg", b"<?xml"), (".png", b"\x89PNG")):
        assert call("figure", "activity", "out", "--quiet", "--out", f"a{suffix}") == (0, "", "")
        assert (folder / f"a{suffix}").read_bytes().startswith(begins)


def test_tables_of_decisions_are_text(call, run, folder):
    for suffix, begins in ((".csv", "Strategy,"), (".md", "Decisions by"), (".tex", "% needs")):
        code, _, err = call("figure", "decisions", "out", "--out", f"d{suffix}", "--robot", "1")
        assert (code, err) == (0, "")
        text = (folder / f"d{suffix}").read_text()
        assert text.startswith(begins)
        assert "Robot 1" in text
        assert "Robot 0" not in text


def test_files_are_replaced_only_by_force(call, run, folder):
    (folder / "map.svg").write_text("mine")
    code, _, err = call("figure", "map", "out", "--out", "map.svg")
    assert code == 2
    assert "map.svg exists already" in err
    assert (folder / "map.svg").read_text() == "mine"
    assert call("figure", "map", "out", "--out", "map.svg", "--force", "--quiet") == (0, "", "")
    assert "<svg" in (folder / "map.svg").read_text()


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["mpa", "out"], "KIND: 'mpa' is not one of map, maps"),
        (["maps", "out", "--time", "1e9"], "not within the run"),
        (["maps", "out", "--time", "nan"], "not within the run"),
        (["map", "out", "--time", "3"], "does not depend on times; these do: maps"),
        (["map", "out", "--without", "egdes"], "(did you mean 'edges'?)"),
        (["coverage", "out", "--robot", "0"], "does not depend on robots"),
        (["trajectories", "out", "--robot", "2"], "there is no robot 2"),
        (["decisions", "out", "--robot", "2", "--out", "d.csv"], "there is no robot 2"),
        (["visits", "out", "--count", "scan"], "(did you mean 'scans'?)"),
        (["activity", "out", "out"], "shows one run, not 2"),
        (["activity", "out", "--style", "iee"], "(did you mean 'ieee'?)"),
        (["activity", "out", "--out", "a.jpg"], "a.jpg: figures are written as"),
        (["activity", "out", "--out", "d.csv"], "d.csv: figures are written as"),
        (["activity", "none"], "none does not exist: name the folder of a run"),
        (["activity", "room.wkt"], "room.wkt is not a recording"),
        (["activity", "out/run.json"], "is not a recording"),
        (["activity"], "RECORDING... is missing"),
    ],
)
def test_bad_input_is_refused(call, run, folder, words, named):
    before = sorted(folder.iterdir())
    code, out, err = call("figure", *words)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert named in err
    assert sorted(folder.iterdir()) == before


def test_runs_of_different_worlds_are_refused(call, run):
    call("explore", "room.wkt", "--max-time", "10", "--out", "other", "--quiet")
    code, _, err = call("figure", "trajectories", "out", "other")
    assert code == 2
    assert "needs runs of one world, and these are of 'pillar' and 'room'" in err


def test_layers_are_left_out(call, folder):
    words = ("explore", "pillar.wkt", "--robots", "2", "--max-time", "20", "--quiet")
    call(*words, "--out", "bare", "--without", "nodes", "--without", "outlines")
    call(*words, "--out", "whole")
    bare, whole = ((folder / name / "tree.svg").read_text() for name in ("bare", "whole"))
    for label in ("robot 0: nodes", "robot 1: regions"):
        assert label in whole
        assert label not in bare
    assert (folder / "bare" / "spec.toml").read_bytes() == (
        folder / "whole" / "spec.toml"
    ).read_bytes()
    again = ("explore", "--spec", "bare/spec.toml", "--out", "again", "--without", "edges")
    assert call(*again, "--quiet")[0] in (0, 3)
