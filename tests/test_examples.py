import ast
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from multisrt.experiments.crossing import runs
from multisrt.experiments.spec import ExperimentSpec
from multisrt.robots import registry

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.mark.slow
def test_own_explorer_is_checked_and_explores_as_a_script(tmp_path):
    run = subprocess.run(
        [sys.executable, EXAMPLES / "own_explorer.py"],
        cwd=tmp_path,
        capture_output=True,
        check=False,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    assert "nearest-frontier keeps to the contract of explorers" in run.stdout
    assert "99." in run.stdout or "100.0 % covered" in run.stdout
    assert "Robot 1 at 20.00 s: its last decision was at" in run.stdout
    drawn = tmp_path / "out" / "examples" / "own_explorer.svg"
    assert drawn.read_text().count("<path") > 10


def test_robustness_has_a_hundred_runs_of_every_strategy():
    experiment = ExperimentSpec.from_toml((EXAMPLES / "robustness.toml").read_text())
    planned = runs(experiment)
    built_in = [known for known in registry.strategies() if registry.is_built_in(known.name)]
    names = [strategy.name for strategy in built_in if not strategy.sees_truth]
    labels = [*names, "gain, rooms"]
    assert Counter(run.condition.strategy for run in planned) == dict.fromkeys(labels, 100)
    assert all(run.spec.faults for run in planned)


def lines_of(node: ast.stmt) -> set[int]:
    assert node.end_lineno is not None
    return set(range(node.lineno, node.end_lineno + 1))


def test_own_explorer_has_at_most_forty_lines():
    text = (EXAMPLES / "own_explorer.py").read_text()
    tree = ast.parse(text)
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    explorer = next(node for node in classes if node.name == "NearestFrontier")
    lines = lines_of(explorer)
    for node in ast.walk(explorer):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            lines -= lines_of(node)
    assert sum(bool(text.splitlines()[k - 1].strip()) for k in lines) <= 40


@pytest.mark.slow
def test_faults_reports_every_fault(load_module, tmp_path, capsys):
    load_module(EXAMPLES / "faults.py").main(folder=tmp_path)
    told = capsys.readouterr().out
    for what in ("robot 1: Died", "robot 2: FellSilent", "robot 3: Joined", "presumes 1 lost"):
        assert what in told
    assert "Robot 0 at 100.00 s" in told
    assert (tmp_path / "faults.svg").exists()


@pytest.mark.slow
def test_a_grid_world_of_someone_else_is_explored_wholly(load_module, tmp_path, capsys):
    world = (EXAMPLES / "grid_world.py").read_text()
    assert "multisrt" not in "".join(re.findall(r"^(?:import|from) .*$", world, re.MULTILINE))
    load_module(EXAMPLES / "drive_grid_world.py").main(folder=tmp_path)
    alone, together = capsys.readouterr().out.splitlines()
    for told in (alone, together):
        # Beams are marched in steps, so that a strip along the walls is not taken as free.
        share = re.search(r"complete after \d+ s, (9[67]\.\d) % covered", told)
        assert share, told
    assert alone.endswith(", 0 messages")
    assert int(together.split()[-2]) > 100
    for name in ("alone", "together"):
        assert (tmp_path / f"drive_grid_world_{name}.svg").read_text().count("<path") > 10


@pytest.mark.slow
def test_a_learned_policy_beats_random_choice(load_module, capsys):
    example = load_module(EXAMPLES / "learn_policy.py")
    found = example.main(rounds=2, candidates=3, worlds=1, tests=2)
    gain = found["learned"] - found["random"]
    assert gain.mean() > 0.0
    told = capsys.readouterr().out
    assert "mazes that it has not seen" in told
    assert f"learned - random   {gain.mean():+6.1f} a mission, 95 % interval" in told
