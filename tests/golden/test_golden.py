import importlib.util
import json
from pathlib import Path

import pytest

from multisrt.robots.registry import strategies


def load():
    path = Path(__file__).with_name("golden_runs.py")
    module = importlib.util.module_from_spec(
        spec := importlib.util.spec_from_file_location("golden_runs", path)
    )
    spec.loader.exec_module(module)
    return module


golden_runs = load()
DIGESTS = json.loads(golden_runs.FILE.read_text())


@pytest.mark.parametrize("name", golden_runs.RUNS)
def test_a_run_is_the_same_to_the_byte(name):
    assert golden_runs.outcome(name) == DIGESTS[name]


def test_every_digest_is_of_a_run():
    assert list(DIGESTS) == list(golden_runs.RUNS)


def test_all_strategies_have_a_run():
    tried = {spec.strategy for spec in golden_runs.RUNS.values()}
    assert tried == {strategy.name for strategy in strategies()}
