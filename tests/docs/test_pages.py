"""The pages that people read: their examples run, and their links lead somewhere."""

import contextlib
import doctest
import io
import json
import re
import shlex
import tomllib
import webbrowser
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import click
import msgspec
import pytest
import yaml
from click.testing import CliRunner
from PIL import Image

import multisrt as ms
from multisrt import comparison, run
from multisrt.cli import cli
from multisrt.experiments.from_keywords import from_keywords
from multisrt.recording import FORMAT, VERSION

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
TARGETS = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))

SHORT_S = 32.0
"""Simulated time at which runs of examples are stopped, unless they say so themselves."""

MAX_NOT_RUN = 15
"""Number of blocks that may be marked by ``<!-- not run: reason -->``."""

BLOCK = re.compile(
    r"(?:^<!-- not run: (?P<reason>[^\n]+) -->\n+)?"
    r"^(?P<fence>`{3,})(?P<language>[\w{}-]*) *(?P<file>[^\n]*)\n(?P<text>.*?)^(?P=fence)$",
    re.DOTALL | re.MULTILINE,
)
DIRECTIVE = re.compile(r"\{[\w-]+\}")


@dataclass(frozen=True)
class Block:
    """A code block: one with a file name is the text of that file."""

    language: str
    text: str
    file: str
    reason: str | None

    @property
    def commands(self) -> list[list[str]]:
        """The words of every command."""
        prompt = "$ " if self.language == "console" else ""
        lines = self.text.replace("\\\n", " ").splitlines()
        given = [line.removeprefix(prompt) for line in lines if line.startswith(prompt)]
        return [words for line in given if (words := shlex.split(line, comments=True))]


def blocks(page: Path) -> list[Block]:
    """The code blocks of a page, in order, without directives."""
    return [
        Block(found["language"], found["text"], found["file"], found["reason"])
        for found in BLOCK.finditer(page.read_text())
        if not DIRECTIVE.fullmatch(found["language"])
    ]


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


WITH_EXAMPLES = [page for page in PAGES if blocks(page)]
WITH_OWN_TESTS = {
    DOCS / "driving.md",
    DOCS / "learning.md",
    DOCS / "own-strategy.md",
    DOCS / "stepping.md",
    DOCS / "tutorials" / "own-strategy.md",
}
"""Pages whose examples are run by modules of their own beside this one."""

ALL_BLOCKS = [(page, block) for page in PAGES for block in blocks(page)]


# Examples ----------------------------------------------------------------------------------


@pytest.fixture
def workplace(tmp_path, monkeypatch):
    """A folder with the maps of a user; runs and comparisons there are short."""
    monkeypatch.chdir(tmp_path)
    drawing = Image.new("L", (160, 120), 0)
    drawing.paste(255, (4, 4, 156, 116))
    drawing.save("plan.png")
    Path("floor.yaml").write_text(
        "image: plan.png\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    square = [[[0, 0], [9, 0], [9, 7], [0, 7], [0, 0]]]
    Path("plan.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": square}))
    Path("flat.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 900 700">'
        '<rect class="free" width="900" height="700"/></svg>'
    )

    Path("simple.world").write_text(
        'model ( bitmap "plan.png" size [8 6 1] ) position ( pose [-2 0 0 0] )'
    )
    rows = "\n".join(["." * 12] * 10)
    Path("arena.map").write_text(f"type octile\nheight 10\nwidth 12\nmap\n{rows}\n")
    Path("arena.map.scen").write_text("version 1\n0\tarena.map\t12\t10\t1\t1\t8\t8\t9.9\n")

    def explore(world, **given):
        if isinstance(world, ms.RunSpec):
            world = msgspec.structs.replace(world, stop=ms.StopRule(max_time_s=SHORT_S))
        else:
            given = {"max_time_s": SHORT_S} | given
        return run.explore(world, **given)

    def compare(environments, strategies=None, robots=None, seeds=None, **given):
        if not all(isinstance(each, str) for each in strategies or ()):
            # With strategies of one's own, pages make few runs.
            chosen = {"robots": robots, "seeds": seeds, "workers": 1} | given
            return comparison.compare(environments, strategies, **chosen)
        options = {k: given.pop(k) for k in ("store", "imports") if k in given}
        fields = {"environments": environments, "strategies": strategies, "robots": robots}
        spec = from_keywords({**fields, "seeds": seeds, **given})
        spec = msgspec.structs.replace(
            spec,
            environments=spec.environments[:1],
            robots=spec.robots[:1],
            repetitions=1,
            stop=ms.StopRule(max_time_s=SHORT_S),
        )
        return comparison.compare(spec, workers=0, progress=False, **options)

    monkeypatch.setattr(ms, "explore", explore)
    monkeypatch.setattr(ms, "compare", compare)
    monkeypatch.setattr(webbrowser, "open", lambda url: True)
    return tmp_path


def run_command(words: list[str]) -> str:
    """Run one command of a page, and return what it prints."""
    if words[0] == "make":
        assert set(words[1:]) <= TARGETS, words
        return ""
    assert words[0] == "multisrt", f"cannot run {words}; mark the block as not run"
    explores = words[1] == "explore"
    if explores and not {"--max-time", "--spec"} & set(words):
        words = [*words, "--max-time", str(SHORT_S)]
    if words[1:3] == ["experiment", "run"] and "--workers" not in words:
        words = [*words, "--workers", "1"]
    done = CliRunner().invoke(cli, words[1:])
    # What is stopped early is no success.
    assert done.exit_code in ((0, 3) if explores else (0,)), (words, done.output, done.exception)
    return done.output


def check_session(text: str) -> None:
    """Run a session of ``$ command`` lines, each with the output that is to follow."""
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, _, expected = part.partition("\n")
        got = run_command(shlex.split(command, comments=True))
        flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
        assert doctest.OutputChecker().check_output(expected, got, flags), got


def run_python(code: str, page: Path, known: dict[str, object]) -> None:
    """Run Python: a session with its output, or a program."""
    if ">>> " not in code:
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compile(code, page.name, "exec"), known)
        return
    test = doctest.DocTestParser().get_doctest(code, known, page.name, str(page), 0)
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS)
    told: list[str] = []
    runner.run(test, out=told.append, clear_globs=False)
    known.update(test.globs)
    assert runner.failures == 0, "".join(told)


@pytest.mark.slow
@pytest.mark.parametrize("page", sorted({*WITH_EXAMPLES} - WITH_OWN_TESTS), ids=name)
def test_examples_run(page, workplace):
    known: dict[str, object] = {"__name__": "__main__"}
    for block in blocks(page):
        if block.reason is not None:
            continue
        if block.file:
            Path(block.file).write_text(block.text)
        match block.language:
            case "python" if not block.file:
                run_python(block.text, page, known)
            case "bash":
                for words in block.commands:
                    run_command(words)
            case "console":
                check_session(block.text)
            case "toml":
                tomllib.loads(block.text)
            case "json":
                json.loads(block.text)
            case "yaml":
                yaml.safe_load(block.text)
            case "xml":
                ElementTree.fromstring(block.text)
            case language:
                assert language in ("text", "python"), f"{page.name}: a block of {language!r}"


@pytest.mark.parametrize("page", WITH_EXAMPLES, ids=name)
def test_python_in_pages_compiles(page):
    for block in blocks(page):
        if block.language == "python" and ">>> " not in block.text:
            compile(block.text, page.name, "exec")
            for attribute in re.findall(r"\bms\.(\w+)", block.text):
                assert hasattr(ms, attribute), attribute


@pytest.mark.parametrize("page", WITH_EXAMPLES, ids=name)
def test_commands_in_pages_have_the_options_they_name(page):
    for block in blocks(page):
        for words in block.commands if block.language in ("bash", "console") else []:
            if words[0] != "multisrt":
                continue
            known: click.Command = cli
            for word in words[1:]:
                if not isinstance(known, click.Group) or word not in known.commands:
                    break
                known = known.commands[word]
            options = {name for p in known.params for name in (*p.opts, *p.secondary_opts)}
            for word in words:
                if re.fullmatch(r"--[a-z-]+", word):
                    assert word in options, words


def test_few_blocks_are_not_run():
    marked = [(page, block) for page, block in ALL_BLOCKS if block.reason is not None]
    assert len(marked) <= MAX_NOT_RUN
    assert all(len(block.reason or "") > 10 for _, block in marked)
    assert len(ALL_BLOCKS) > 3 * len(marked)


def test_a_wrong_example_is_found(workplace):
    with pytest.raises(AssertionError, match="options"):
        run_command(["multisrt", "explore", "open", "--options", "x=1"])
    with pytest.raises(AssertionError, match="cannot run"):
        run_command(["rm", "plan.png"])
    with pytest.raises(AssertionError):
        run_python(">>> 1 + 1\n3\n", Path("page.md"), {})


def test_every_make_target_of_the_readme_exists():
    named = set(re.findall(r"`make ([a-z]+)`", (ROOT / "README.md").read_text()))
    assert named
    assert named <= TARGETS


# Links -------------------------------------------------------------------------------------

LINK = re.compile(r"\]\(([^)\s]+)\)")
FENCED = re.compile(r"^(`{3,}).*?^\1$", re.DOTALL | re.MULTILINE)


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as code hosts and the site make them."""
    headings = re.findall(r"^#+ (.+)$", FENCED.sub("", page.read_text()), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.lower()).strip().replace(" ", "-") for h in headings}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page):
    for link in LINK.findall(FENCED.sub("", page.read_text())):
        if "://" in link:
            continue
        file, _, anchor = link.partition("#")
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target), link


def test_every_page_is_in_a_table_of_contents():
    listed = set()
    for index in sorted(DOCS.rglob("*.md")):
        for found in BLOCK.finditer(index.read_text()):
            if found["language"] == "{toctree}":
                entries = [line for line in found["text"].split("\n") if line[:1] not in ("", ":")]
                names = [re.sub(r"^.*<(.*)>$", r"\1", entry) for entry in entries]
                listed |= {(index.parent / entry).resolve() for entry in names}
    pages = {page.with_suffix("") for page in DOCS.rglob("*") if page.suffix in (".md", ".rst")}
    assert pages - {DOCS / "index"} == listed


def test_every_picture_is_shown_in_a_page():
    text = "".join(page.read_text() for page in PAGES)
    for picture in (DOCS / "pictures").rglob("*.svg"):
        assert picture.name in text, picture


def test_the_page_of_the_format_is_of_the_version_that_is_written():
    title, _, text = (DOCS / "recording.md").read_text().partition("\n")
    assert title == f"# The recording format, version {VERSION}"
    assert f"| `format`, `format_version` | `{FORMAT}`, {VERSION} |" in text
