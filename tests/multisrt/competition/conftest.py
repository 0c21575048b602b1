"""A small competition, the real one if there is a clone, and commands in a folder."""

import os
from pathlib import Path

import pytest

from tests.multisrt.cli.conftest import call, folder
from tests.multisrt.competition.fake_clone import make_fake_clone

__all__ = ["call", "folder"]


@pytest.fixture
def fake(tmp_path: Path) -> Path:
    return make_fake_clone(tmp_path / "fake")


@pytest.fixture
def real() -> Path:
    clone = os.environ.get("MULTISRT_COMPETITION")
    if not clone:
        pytest.skip("MULTISRT_COMPETITION names no clone of the competition")
    return Path(clone)
