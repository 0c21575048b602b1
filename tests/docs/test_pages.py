import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from multisrt.cli import cli

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    """The code blocks of a page that are marked as in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text(), re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for link in re.findall(r"\]\(([^)#]+)", page.read_text()):
        if "://" not in link:
            assert (page.parent / link).exists(), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_python_in_pages_names_what_exists(page):
    import multisrt as ms

    for code in blocks(page, "python"):
        compile(code, page.name, "exec")
        for name in re.findall(r"\bms\.(\w+)", code):
            assert hasattr(ms, name), name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_in_pages_have_the_options_they_name(page):
    for line in "".join(blocks(page, "")).splitlines():
        words = line.partition("#")[0].split()
        if words[:1] != ["multisrt"]:
            continue
        command = words[1:3] if words[1] in ("experiment", "strategy") else words[1:2]
        if words[1:3] == ["environments", "show"]:
            command = words[1:3]
        shown = CliRunner().invoke(cli, [*command, "--help"])
        assert shown.exit_code == 0, line
        for option in re.findall(r"(?<!\S)--[a-z-]+", line):
            assert option in shown.output, line


def test_every_make_target_of_the_readme_exists():
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    named = set(re.findall(r"`make ([a-z]+)`", (ROOT / "README.md").read_text()))
    assert named
    assert named <= targets
