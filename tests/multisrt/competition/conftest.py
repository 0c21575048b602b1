import os
from pathlib import Path

import pytest

from tests.multisrt.cli.conftest import call, folder  # noqa: F401
from tests.multisrt.competition.fake_clone import make_fake_clone


@pytest.fixture
def fake(tmp_path):
    return make_fake_clone(tmp_path / "fake")


@pytest.fixture
def real():
    folder = os.environ.get("MULTISRT_COMPETITION")
    if not folder:
        pytest.skip("MULTISRT_COMPETITION names no clone of the competition")
    return Path(folder)
