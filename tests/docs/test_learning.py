"""The page on learning: its code runs from top to bottom."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.test_pages import blocks

PAGE = Path(__file__).parents[2] / "docs" / "learning.md"


@pytest.mark.slow
def test_the_code_of_the_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    assert len(blocks) > 5
    file = tmp_path / "page.py"
    file.write_text("\n".join(blocks))
    # Not as the main module: what is vectorized over processes has a test of its own.
    runpy.run_path(str(file), run_name="page")
    told = capsys.readouterr().out
    assert "complete 100.0 % covered" in told
    assert (tmp_path / "learned.svg").exists()


@pytest.mark.slow
def test_teams_are_played_in_a_pool_of_processes(tmp_path):
    [block] = [block for block in blocks(PAGE) if block.file]
    file = tmp_path / block.file
    file.write_text(block.text)
    done = subprocess.run(
        [sys.executable, file],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    rewards = re.findall(r"([\d.]+) m2", done.stdout)
    assert len(rewards) == len(set(rewards)) == 4
