import json
from pathlib import Path
from types import ModuleType

import pytest

from multisrt.robots.registry import is_built_in, strategies

DIGESTS = json.loads(Path(__file__).with_name("digests.json").read_text())


@pytest.fixture(scope="module")
def golden_runs(load_module) -> ModuleType:
    """The module golden_runs.py, which cannot be imported in importlib mode."""
    return load_module(Path(__file__).with_name("golden_runs.py"))


@pytest.mark.parametrize("name", DIGESTS)
def test_a_run_is_the_same_to_the_byte(golden_runs, name):
    assert golden_runs.outcome(name) == DIGESTS[name]


def test_digests_and_runs_have_the_same_names(golden_runs):
    assert list(DIGESTS) == list(golden_runs.RUNS)


def test_all_strategies_have_a_run(golden_runs):
    tried = {spec.strategy for spec in golden_runs.RUNS.values()}
    assert tried == {each.name for each in strategies() if is_built_in(each.name)}
