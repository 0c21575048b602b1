"""Short campaigns: all invariants hold in what is drawn over all there is."""

import sqlite3
import subprocess
import sys
from contextlib import closing

import pytest

MISSIONS = 16


@pytest.mark.slow
@pytest.mark.parametrize("seed", [11, 12])
def test_a_short_campaign_finds_nothing(tmp_path, seed):
    command = ["campaign", "run", "--missions", str(MISSIONS), "--seed", str(seed), "--quiet"]
    made = subprocess.run(
        [sys.executable, "-m", "multisrt", *command, "--store", "missions.sqlite"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert made.returncode == 0, made.stdout + made.stderr
    assert f"{MISSIONS} missions, 0 of them failed" in made.stdout
    with closing(sqlite3.connect(tmp_path / "missions.sqlite")) as store:
        assert store.execute("select count(*) from missions").fetchone() == (MISSIONS,)
