"""The code of the pages on stepping and driving runs, one block after the other."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "told"),
    [
        ("stepping.md", "0.50 s  robot 0  ExactScan -> Move to (17.25, 2.39) in 0.50 s"),
        ("driving.md", "every frontier arc is explored or closed"),
    ],
)
def test_the_code_of_a_page_runs(page, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = (DOCS / page).read_text()
    names: dict[str, object] = {"__name__": page}
    for code in re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE):
        exec(compile(code, page, "exec"), names)
    assert told in capsys.readouterr().out
