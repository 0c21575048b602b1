"""What campaigns have found: each failure, shrunk, holds all invariants now."""

from pathlib import Path

import pytest

from multisrt.campaign.mission import judge
from multisrt.spec import RunSpec

FOUND = sorted((Path(__file__).parent / "found").glob("*.toml"))


@pytest.mark.parametrize("path", FOUND, ids=lambda path: path.stem)
def test_what_was_found_holds_all_invariants(path):
    verdict = judge(RunSpec.from_toml(path.read_text()))
    assert verdict.violations == ()
    assert verdict.digest
