"""`multisrt strategy new`."""

import sys

import pytest

from multisrt.cli.strategy import SIZES
from multisrt.robots.toolkit import templates
from tests.multisrt.cli.commands import everything

pytestmark = pytest.mark.usefixtures("forgotten")


def test_sizes_are_those_of_the_templates():
    assert tuple(templates.SIZES) == SIZES


@pytest.mark.parametrize("size", SIZES)
def test_a_new_strategy_is_written_and_explores(call, folder, size):
    code, out, err = call("strategy", "new", "own/mine.py", "--size", size)
    assert (code, err) == (0, "")
    assert out.splitlines() == [
        "own/mine.py",
        "next: multisrt check own/mine.py",
        "      multisrt explore museum --strategy own/mine.py --robots 3",
    ]
    code, out, err = call("explore", "room.wkt", "--strategy", "own/mine.py", "--robots", "2")
    assert code == 0, err
    assert "100.0" in out
    [recording] = folder.rglob("recording.jsonl")
    code, out, _ = call("why", str(recording), "--all")
    assert code == 0
    assert len(out.splitlines()) > 1


def test_the_name_is_that_of_the_file_or_given(call, folder):
    call("strategy", "new", "nearest-door.py", "--size", "rule")
    assert "def nearest_door(" in (folder / "nearest-door.py").read_text()
    call("strategy", "new", "b.py", "--name", "farthest_door")
    assert "class FarthestDoor(RegionExplorer)" in (folder / "b.py").read_text()


def test_an_existing_file_is_overwritten_only_by_force(call, folder):
    (folder / "mine.py").write_text("precious")
    before = everything(folder)
    code, out, err = call("strategy", "new", "mine.py")
    assert (code, out) == (2, "")
    assert err == ("error: mine.py exists already: name another file, or replace it with --force\n")
    assert everything(folder) == before
    assert call("strategy", "new", "mine.py", "--force")[0] == 0
    assert "RegionExplorer" in (folder / "mine.py").read_text()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["mine.txt"], "mine.txt must have the suffix .py"),
        (["2nd.py"], "a strategy cannot be called '2nd'"),
        (["minpos.py"], "there is a strategy 'minpos' already"),
        (["mine.py", "--size", "huge"], "'huge' is not one of"),
        (["room.wkt/mine.py"], "room.wkt"),
        (["own/numpy.py"], "would hide the module 'numpy' from scripts beside it: choose another"),
        (["random.py", "--force"], "another name, such as my_random.py"),
        (["sys.py"], "such as my_sys.py"),
        (["multisrt.py"], "such as my_multisrt.py"),
    ],
)
def test_what_cannot_be_written_is_told(call, folder, words, told):
    before = everything(folder)
    code, out, err = call("strategy", "new", *words)
    assert (code, out) == (2, "")
    assert told in err
    assert "Traceback" not in err
    assert everything(folder) == before


def test_the_main_program_need_have_no_spec(call, folder, monkeypatch):
    # As when the command is started by its script.
    monkeypatch.setattr(sys.modules["__main__"], "__spec__", None)
    code, out, err = call("strategy", "new", "my own/__main__.py", "--name", "far")
    assert (code, err) == (0, "")
    assert "next: multisrt check 'my own/__main__.py'\n" in out
    assert "multisrt check 'my own/__main__.py'" in (folder / "my own/__main__.py").read_text()
