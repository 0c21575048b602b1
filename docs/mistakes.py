"""Write docs/mistakes.md from the wrong explorers of the tests: ``python docs/mistakes.py``.

A test holds that the page is what this writes, and others that the checker says so.
"""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "mistakes.md"
sys.path.insert(0, str(ROOT))

from tests.multisrt.testing import wrong_explorers as wrong  # noqa: E402
from tests.multisrt.testing.test_wrong_explorers import TOLD, WARNED  # noqa: E402

SHOWN = {
    "Actions": {
        "ReturnsAList": "It returns actions instead of yielding them",
        "YieldsAProcedure": "It yields a procedure",
        "YieldsNothing": "It yields nothing",
        "RaisesAnError": "It raises an error",
    },
    "What it knows": {
        "NeverSenses": "It never senses",
        "DrivesBlind": "It drives where it has not looked",
        "DrivesThroughAWall": "It drives through a wall",
        "ImportsTheWorld": "It looks at the true world",
        "WritesALog": "It writes a log of its own",
        "ChangesItsScan": "It changes what it is given",
    },
    "Motions": {
        "BeginsElsewhere": "A motion begins where the robot is not",
        "DrivesTooFast": "A motion is too fast",
        "DrivesToNowhere": "A place is not a number",
        "Collides": "It touches another robot",
    },
    "The same again": {
        "DrawsByNumpy": "It draws random numbers of its own",
        "ReadsAClock": "It reads a clock",
        "SharesAClassAttribute": "Robots share what they know",
    },
    "Messages": {
        "SendsWhatCannotBeWritten": "A message cannot be written",
        "ChangesItsMessage": "A message is changed after it was sent",
    },
    "The end": {
        "WaitsForEver": "It waits for ever",
        "ComputesForEver": "It computes for ever",
        "ReturnsWithoutDone": "It ends without a word",
        "EndsAtOnce": "It ends at once",
        "CoversLittle": "It ends too early",
    },
}
"""Headings of the page, and the titles of the mistakes below them, by the names of classes."""

HEAD = """\
# Mistakes, and what the checker says

<!-- Written by docs/mistakes.py from the wrong explorers of the tests. -->

`multisrt check mine.py` ends at the first mistake and reports what the explorer did, at which \
action, and what to change. Here are {count} explorers with one mistake each, and the messages. \
`LINE` stands for a line number. Code that is only useless causes a warning, and the check \
continues.

All of them derive from this base class:

"""


def page() -> str:
    """Return the text of the page."""
    count = sum(map(len, SHOWN.values()))
    parts = [HEAD.format(count=count) + _code(f"{_imports()}\n\n\n{_source(wrong.Explorer)}")]
    for heading, mistakes in SHOWN.items():
        parts.append(f"## {heading}\n")
        for name, title in mistakes.items():
            parts.append(f"### {title}\n\n{_code(_program(name))}\n{_said(name)}")
    return "\n".join(parts)


def _imports() -> str:
    # Those that the page has a use for.
    source = inspect.getsource(wrong)
    lines = source[source.index("import ") : source.index("HEARD")].strip().splitlines()
    shown = [wrong.Explorer, *(getattr(wrong, n) for group in SHOWN.values() for n in group)]
    code = "".join(inspect.getsource(each) for each in (wrong.Hello, wrong.Wanders, *shown))
    used = set(re.findall(r"\w+", code))
    kept = []
    for line in lines:
        begin, imports, names = line.partition("import ")
        taken = [n for n in names.split(", ") if n.split(" as ")[-1] in used]
        if taken or not line:
            kept.append(f"{begin}{imports}{', '.join(taken)}")
    return "\n".join(kept)


def _program(name: str) -> str:
    # With the classes that it needs and that are not in the head.
    found = getattr(wrong, name)
    own = [each for each in found.__mro__[1:-1] if each.__module__ == wrong.__name__]
    needed = [each for each in reversed(own) if each is not wrong.Explorer]
    if "Hello(" in inspect.getsource(found):
        needed.append(wrong.Hello)
    return "\n\n\n".join(_source(each) for each in (*needed, found))


def _source(of: type) -> str:
    return re.sub(r"  # (noqa|type: ignore).*", "", inspect.getsource(of)).rstrip()


def _said(name: str) -> str:
    if name in TOLD:
        return f"> {_escaped(TOLD[name])}\n"
    return "\n>\n".join(f"> WARNING: {_escaped(warning)}" for warning in WARNED[name]) + "\n"


def _escaped(text: str) -> str:
    return re.sub(r"([\\*<>\[\]_`])", r"\\\1", text.replace("wrong_explorers.py", "mine.py"))


def _code(text: str) -> str:
    return f"```python\n{text}\n```\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE.relative_to(ROOT))
