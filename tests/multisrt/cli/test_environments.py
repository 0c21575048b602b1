import re
import xml.etree.ElementTree as ET

import pytest

from multisrt.environments import suites
from multisrt.environments.catalog import names
from tests.multisrt.cli.commands import everything


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
    assert "9 x 6 m, 50 m2 free, 8 edges, 1 area" in out
    assert (folder / "p.svg").exists()


@pytest.mark.parametrize("out", [".", "room.wkt/x.svg", "none/x.svg", "/"])
def test_environments_show_refuses_bad_paths(call, folder, out):
    before = everything(folder)
    code, _, err = call("environments", "show", "room.wkt", "--out", out)
    assert code == 2
    assert err.startswith("error: cannot write ")
    assert err.count("\n") == 1
    assert everything(folder) == before


def test_a_picture_replaces_a_file_only_by_force(call, folder):
    (folder / "office.svg").write_text("mine")
    for words in (["office"], ["open", "--out", "office.svg"]):
        code, out, err = call("environments", "show", *words)
        assert (code, out) == (2, "")
        assert err == (
            "error: office.svg exists already: name another file, or replace it with --force\n"
        )
    assert (folder / "office.svg").read_text() == "mine"
    assert call("environments", "show", "office", "--force")[0] == 0
    assert (folder / "office.svg").read_text().startswith("<")


def test_environments_lists_suites_and_draws_their_worlds(call, folder):
    code, out, _ = call("environments")
    assert code == 0
    assert all(re.search(rf"^ *{name} +1 +30 ", out, re.M) for name in suites.names())
    code, out, err = call("environments", "show", "mazes-30/12")
    assert (code, err) == (0, "")
    assert "mazes-30/12: " in out
    assert (folder / "mazes-30-12.svg").exists()
    code, _, err = call("environments", "show", "mazes-30")
    assert code == 2
    assert "a suite of 30 worlds" in err
    assert "Traceback" not in err
