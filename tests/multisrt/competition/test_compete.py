"""`multisrt compete` on a small competition, and on the real one where there is a clone."""

import ast
import os
import sys

import pytest

from multisrt.competition.policies import NAMES, PolicySource
from multisrt.competition.published import SIZES, winning_score

ARGUMENTS = ("--any-version", "--maps", "env1", "--steps", "30", "--workers", "1", "--draws", "1")

LOST = """
from base_policy import BasePolicy

class Policy(BasePolicy):
    def decide(self, obs, collect_opts):
        raise ValueError('no idea')
"""


@pytest.mark.parametrize("name", NAMES)
def test_a_written_policy_needs_no_more_than_it_says(name):
    source = PolicySource.of(name)
    imported = {
        node.module if isinstance(node, ast.ImportFrom) else alias.name
        for node in ast.walk(ast.parse(source.text))
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    third = {
        module
        for module in imported
        if module and module.partition(".")[0] not in sys.stdlib_module_names
    }
    own = {"numpy", "numpy.typing", "numba", "base_policy"}
    package = {"base_policy", "multisrt.competition.frontier_policies"}
    assert third == (own if name == "gain-home" else package)


def test_winning_scores_are_means_over_seven_maps():
    assert winning_score(1, SIZES) == pytest.approx(61.58, abs=0.01)
    assert winning_score(3, SIZES) == pytest.approx(63.97, abs=0.01)


def test_runs_are_scored_and_not_made_again(call, fake, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    clone = os.path.relpath(fake)
    code, out, err = call("compete", clone, *ARGUMENTS, "--robots", "1,2", "--out", "found")
    assert code == 0, err
    table = (tmp_path / "found" / "runs.csv").read_text().splitlines()
    assert table[0].startswith("map,robots,start_x,start_y,steps,coverage,")
    shares = [float(row.split(",")[5]) for row in table[1:]]
    # All but the insides of walls 3 cells thick: 8250 free cells of 9600, and their faces.
    assert min(shares) > 0.85
    assert "winner's score 73.89 %" in out
    assert "not the known version" in out
    before = (tmp_path / "found" / "runs.jsonl").read_bytes()
    again = call("compete", clone, *ARGUMENTS, "--robots", "1,2", "--out", "found")
    assert again == (code, out, err)
    assert (tmp_path / "found" / "runs.jsonl").read_bytes() == before


def test_results_of_faster_functions_do_not_count_as_it_is(call, fake, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    asked = ("compete", str(fake), *ARGUMENTS, "--robots", "1", "--out", "found", "--as-it-is")
    assert call(*asked)[0] == 0
    store = tmp_path / "found" / "runs.jsonl"
    (line,) = store.read_text().splitlines()
    store.write_text(line.replace('"fast":false', '"fast":true') + "\n")
    assert call(*asked)[0] == 0
    fast, as_it_is = store.read_text().splitlines()
    assert '"fast":true' in fast
    assert '"fast":false' in as_it_is
    assert call(*asked)[0] == 0
    assert store.read_text().splitlines() == [fast, as_it_is]


def test_every_strategy_and_the_written_policy_run(call, fake, tmp_path):
    shares = {}
    for name in NAMES:
        words = ("compete", str(fake), *ARGUMENTS, "--robots", "2", "--out", str(tmp_path / name))
        code, _, err = call(*words, "--strategy", name)
        assert code == 0, err
        shares[name] = (tmp_path / name / "runs.csv").read_text().splitlines()[1].split(",")[5]
    assert min(map(float, shares.values())) > 0.6

    written = tmp_path / "own.py"
    assert call("compete", str(fake), "--any-version", "--policy-out", str(written))[0] == 0
    words = ("compete", str(fake), *ARGUMENTS, "--robots", "2", "--out", str(tmp_path / "file"))
    code, _, err = call(*words, "--policy", str(written))
    assert code == 0, err
    row = (tmp_path / "file" / "runs.csv").read_text().splitlines()[1]
    assert row.split(",")[5] == shares["gain-home"]


def test_a_policy_that_fails_is_told_with_its_place(call, fake, tmp_path):
    (tmp_path / "lost.py").write_text(LOST)
    words = ("compete", str(fake), *ARGUMENTS, "--robots", "1", "--out", str(tmp_path / "o"))
    code, _, err = call(*words, "--policy", str(tmp_path / "lost.py"))
    assert code == 2
    assert "lost on env1, 1 robots from" in err
    assert "step 0: ValueError: no idea" in err
    (tmp_path / "none.py").write_text("Policy = 3\n")
    code, _, err = call(*words, "--policy", str(tmp_path / "none.py"))
    assert code == 2
    assert "has no class Policy that is a BasePolicy" in err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--strategy", "minposs"), "did you mean 'minpos'"),
        (("--strategy", "gain", "--policy", "x.py"), "exclude each other"),
        (("--policy", "missing.py"), "missing.py cannot be read"),
        (("--robots", "6"), "teams of 1 to 5 robots"),
        (("--robots", "two"), "not numbers of robots"),
        (("--start", "1"), "not a cell"),
        (("--start", "50,30"), "a start is a cell of one map, and 7 are to be run"),
        (("--maps", "env1", "--start", "0,0"), "is in a wall of env1"),
    ],
)
def test_wrong_arguments_are_told_in_one_line(call, fake, words, told):
    code, out, err = call("compete", str(fake), "--any-version", *words)
    assert (code, out) == (2, "")
    assert told in err
    assert len(err.splitlines()) == 1


def test_the_competition_runs_our_policy(call, real, tmp_path):
    words = ("--maps", "env1", "--robots", "2", "--draws", "1", "--steps", "60")
    code, out, err = call("compete", str(real), *words, "--out", str(tmp_path / "o"))
    assert code == 0, err
    assert "winner's score 64.89 %" in out
