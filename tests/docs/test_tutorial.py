"""The tutorial on a strategy of one's own, as a user follows it: every command, and its output.

With MULTISRT_WHOLE=1 (``make tutorial``) it is made as it stands there; else with two worlds
instead of twenty, and the output of the comparison is compared by what does not depend on that.
"""

import doctest
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.test_pages import DOCS, blocks

PAGE = DOCS / "tutorials" / "own-strategy.md"
IS_WHOLE = os.environ.get("MULTISRT_WHOLE") == "1"
WORLDS, FEW_WORLDS, STRATEGIES = 20, 2, 4


def run(command: str, folder: Path) -> str:
    """Run a command of the page in a process of its own, and return what it prints."""
    words = command.split()
    assert words[0] == "multisrt"
    done = subprocess.run(
        [sys.executable, "-m", *words],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def as_in_the_page(got: str) -> str:
    """Return the output for few worlds as far as that for all is known."""
    for few, all in ((FEW_WORLDS * STRATEGIES, WORLDS * STRATEGIES), (FEW_WORLDS, WORLDS)):
        got = re.sub(rf"\b{few} (of|runs|repetitions)\b", rf"{all} \1", got)
        got = re.sub(rf"\bof {few}\b", f"of {all}", got)
    return got.replace(f"0 to {FEW_WORLDS - 1}", f"0 to {WORLDS - 1}")


def without_results(text: str) -> str:
    """Return the table of a comparison without its medians, and what is said of them."""
    table = text.partition("Success:")[0]
    return re.sub(r"\(\d.*?\)|-{3,}|(?<= of 20 ) .*", "", table)


@pytest.mark.slow
def test_the_tutorial_is_what_happens(tmp_path):
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    is_same = doctest.OutputChecker().check_output
    for block in blocks(PAGE):
        if block.file:
            text = block.text
            if not IS_WHOLE:
                text = text.replace(f"repetitions = {WORLDS}", f"repetitions = {FEW_WORLDS}")
            (tmp_path / block.file).write_text(text)
        if block.language != "console":
            continue
        command, _, expected = block.text.removeprefix("$ ").partition("\n")
        got = run(command, tmp_path)
        if not IS_WHOLE and command.split()[1] in ("experiment", "report"):
            got = as_in_the_page(got)
            if " experiment run " in command:
                expected, got = without_results(expected), without_results(got)
        assert is_same(expected, got, flags), got
    drawn = (tmp_path / "lonely-1" / "tree.svg").read_bytes()
    assert drawn == (DOCS / "pictures" / "lonely-first.svg").read_bytes()
    assert (tmp_path / "lonely-report" / "index.html").stat().st_size > 10_000


def test_the_explorer_is_about_forty_lines():
    [code] = [block.text for block in blocks(PAGE) if block.file == "lonely.py"]
    written = [line for line in code.splitlines() if line and not line.strip().startswith("#")]
    assert 30 <= len(written) <= 45
