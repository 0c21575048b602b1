"""What another process cannot import is told, and no failure; what fails there is told why."""

import sys

import pytest

from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.loading import load_strategy
from multisrt.simulation.worlds import inline
from multisrt.spec import RunSpec
from multisrt.testing import check_explorer
from multisrt.testing.other_process import digests_elsewhere
from tests.multisrt.testing.explorers import HALL, explorer

pytestmark = pytest.mark.usefixtures("forgotten")

MINE = """
import os
from multisrt.robots.explorer import Done
from multisrt.testing import check_explorer

class Mine:
    def __init__(self, me):
        self.me = me

    def run(self):
        yield Done(complete=False, reason="has nothing to do")

"""


def unchecked(make):
    return " ".join(check_explorer(make, worlds=[HALL], teams=[1]).unchecked)


def elsewhere(tmp_path, text):
    path = tmp_path / "mine.py"
    path.write_text(text)
    own = load_strategy(f"{path}:Mine")
    spec = RunSpec(environment=inline(HALL), strategy=own.name)
    return digests_elsewhere(own, [spec], 120.0)


@pytest.mark.slow
def test_a_class_that_a_function_makes_is_not_imported():
    made = explorer(lambda self: iter([]))
    assert "has no strategy 'acting' and registers none" in unchecked(made)


def test_a_class_of_exec_is_in_no_module():
    known: dict[str, type] = {}
    exec(MINE, known)
    assert unchecked(known["Mine"]).endswith("it is defined by exec, in no module")


@pytest.mark.slow
def test_a_file_that_checks_itself_is_not_checked_for_ever(tmp_path, monkeypatch):
    monkeypatch.setenv("MULTISRT_REPEATS_A_CHECK", "1")
    with pytest.raises(InvalidInputError, match="begins a check whenever it is imported"):
        check_explorer("srt-star")
    monkeypatch.delenv("MULTISRT_REPEATS_A_CHECK")
    guard = "if 'MULTISRT_REPEATS_A_CHECK' in os.environ:\n    check_explorer(Mine)\n"
    with pytest.raises(InvalidInputError, match="__main__"):
        elsewhere(tmp_path, MINE + guard)


@pytest.mark.slow
def test_what_fails_there_says_why(tmp_path):
    there = "if 'MULTISRT_REPEATS_A_CHECK' in os.environ:"
    fails = f"{there}\n    def run(self):\n        raise KeyError('there')\n"
    digests, reason = elsewhere(tmp_path, MINE + fails + "    Mine.run = run\n")
    assert digests == ()
    assert reason == "it raised KeyError: 'there' (mine.py:15, in run: raise KeyError('there'))"


@pytest.mark.slow
def test_files_of_the_working_directory_shadow_no_library(tmp_path, monkeypatch):
    for name in ("numpy", "queue"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('shadows a library')\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", ["", *sys.path])
    digests, reason = elsewhere(tmp_path, MINE)
    assert len(digests) == 1, reason
