"""The summary of which claims hold agrees with the pages of the papers."""

import shutil
from pathlib import Path
from types import ModuleType

import pytest

from benchmarks import published
from multisrt.presets import PRESETS
from multisrt.presets.summary import summary
from tests.multisrt.presets.constructed import SOME, results_of

ROOT = Path(__file__).parents[2]

PAGE = """# A page

## Claims

| claim | verdict |
| ----- | ------- |
| It is so. | holds |
| It is not. | does not hold |
| Who knows. | inconclusive (a difference of 12 % would have been detected) |

### It is so.
"""


@pytest.fixture(scope="module")
def verdicts(load_module) -> ModuleType:
    """The program that writes the summary."""
    return load_module(ROOT / "docs" / "verdicts.py")


@pytest.fixture
def results(verdicts, tmp_path) -> Path:
    """A folder with a page for each paper."""
    for name in verdicts.PAPERS:
        (tmp_path / f"{name}.md").write_text(PAGE)
    return tmp_path


def test_the_summary_is_that_of_todays_pages(verdicts):
    text = verdicts.SUMMARY.read_text("utf-8")
    assert verdicts.replaced(text, verdicts.SUMMARY.parent) == text
    assert verdicts.PAPERS.keys() == PRESETS.keys()
    assert verdicts.EARLIER == published.EARLIER


def test_every_claim_is_named_by_its_verdict(verdicts, results):
    lines = verdicts.verdicts(results).splitlines()
    assert lines[:4] == [
        "- **[Multi-SRT](multi-srt.md): 1 of 3 claims holds.**",
        "  - *Does not hold:* It is not.",
        "  - *Inconclusive:* Who knows.",
        "  - *Holds:* It is so.",
    ]
    assert len(lines) == 16


def test_a_page_of_an_earlier_experiment_is_said_to_be_one(verdicts, results):
    (results / "minpos.md").write_text(f"> {verdicts.EARLIER}.\n\n{PAGE}")
    lines = [line for line in verdicts.verdicts(results).splitlines() if "earlier" in line]
    (line,) = lines
    assert line.startswith("- **[MinPos](minpos.md), by an earlier version of the experiment:")


def test_many_claims_that_are_inconclusive_are_counted(verdicts, results):
    row = "| Who knows. | inconclusive |\n"
    for more, told in ((2, "Who knows. Who knows. Who knows."), (3, "4 claims.")):
        (results / "sbx-r.md").write_text(PAGE.replace("\n\n### It", f"\n{more * row}\n### It"))
        line = verdicts.verdicts(results).splitlines()[6]
        assert line == f"  - *Inconclusive:* {told}"


def test_other_verdicts_are_told_where_they_differ(verdicts, results):
    row = "| It is so. | holds (by weight: holds; by length: inconclusive) |"
    (results / "sbx-r.md").write_text(PAGE.replace("| It is so. | holds |", row))
    line = verdicts.verdicts(results).splitlines()[7]
    assert line == "  - *Holds:* It is so (by length: inconclusive)."


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS)
def test_claims_of_a_page_that_is_made_today_are_read(verdicts, name):
    preset = PRESETS[name]
    found = results_of(preset.experiment(True), SOME[name])
    claims = preset.claims(found)
    page = summary(preset, found, "it", claims=claims, tables=[])
    read = verdicts.claims_of(page)
    assert [(one.text, one.verdict) for one in read] == [(one.text, one.verdict) for one in claims]
    assert [len(one.others) for one in read] == [len(one.other_verdicts) for one in claims]


def test_what_is_missing_is_named(verdicts, results):
    (results / "sbx-r.md").write_text("# Nothing\n")
    with pytest.raises(ValueError, match=r"sbx-r\.md: there is no table of claims"):
        verdicts.verdicts(results)
    with pytest.raises(ValueError, match="needs the lines"):
        verdicts.replaced("no marks", results)


def test_it_writes_the_summary_once(verdicts, results, monkeypatch, capsys):
    shutil.copy(verdicts.SUMMARY, results / "README.md")
    monkeypatch.setattr(verdicts, "SUMMARY", results / "README.md")
    verdicts.main()
    verdicts.main()
    assert [line.split(": ")[1] for line in capsys.readouterr().out.splitlines()] == [
        "written",
        "unchanged",
    ]
    assert "1 of 3 claims holds" in (results / "README.md").read_text("utf-8")
