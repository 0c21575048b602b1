"""Every code block of docs/own-strategy.md runs, as it stands there."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "own-strategy.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.DOTALL | re.MULTILINE)


@pytest.mark.slow
@pytest.mark.parametrize("code", BLOCKS, ids=lambda code: code.splitlines()[-1][:40])
def test_blocks_run(code, load_module, monkeypatch, tmp_path, capsys):
    path = tmp_path / "block.py"
    path.write_text(code)
    load_module(path)
    assert capsys.readouterr().out


def test_there_is_a_block_for_every_size():
    whole = "\n".join(BLOCKS)
    for word in ("@assignment", "(RegionExplorer)", "FrontierMap(me)", "(Message, frozen=True)"):
        assert word in whole
