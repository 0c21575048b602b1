import re
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from html.parser import HTMLParser
from urllib.parse import unquote

import click.testing
import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import multisrt as ms
from multisrt.cli import cli
from multisrt.drawing.looks import DASHES, MARKERS, look_of
from multisrt.drawing.svg import printable
from multisrt.experiments.crossing import Condition, runs
from multisrt.experiments.provenance import provenance
from multisrt.experiments.results import Result, Results
from multisrt.experiments.spec import ExperimentSpec, StrategyChoice
from multisrt.geometry.errors import InvalidInputError
from multisrt.reporting import figures
from multisrt.reporting import page as page_module
from multisrt.reporting.claims import Claim, PrintedTable
from multisrt.reporting.page import write_report
from multisrt.reporting.reruns import Specs, gallery, gallery_settings, median_run
from multisrt.reporting.run_rows import COLUMNS
from multisrt.reporting.study import Study
from multisrt.reporting.style import (
    MAX_LABEL,
    Picture,
    in_groups,
    short_labels,
)
from multisrt.spec import RunSpec
from tests.multisrt.experiments.results import metrics_of

ONE = ["known_complete_s"]
VOID = {"meta", "img", "link", "br", "hr", "input"}


class Page(HTMLParser):
    """The contents of a page, whose tags close in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.text = ""
        self._open: list[str] = []
        self.feed(text)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        self.text += data

    def all(self, tag: str) -> list[dict[str, str]]:
        return [attributes for found, attributes in self.tags if found == tag]


def made_up(
    strategies: Sequence[str] = ("a", "b"),
    robots: Sequence[int] = (1, 2),
    count: int = 6,
    *,
    fail: int = 0,
    about: str = "",
    environment: str = "open",
) -> Results:
    """Return results with random times; the first `fail` runs of each condition crashed."""
    rng = np.random.default_rng(3)
    template = ms.explore("open", seed=1).metrics
    found: list[Result] = []
    for strategy in strategies:
        for size in robots:
            for k in range(count):
                failed = k < fail
                time = float(100.0 / size * rng.lognormal(0.0, 0.2))
                found.append(
                    Result(
                        key=f"{len(found):032x}",
                        condition=Condition(
                            environment=environment, strategy=strategy, robots=size
                        ),
                        repetition=k,
                        status="crashed" if failed else "complete",
                        reason=f"its process died after {k} s" if failed else "",
                        metrics=None
                        if failed
                        else msgspec.structs.replace(
                            template, time_to_95_s=time, known_complete_s=1.1 * time
                        ),
                        covered_at_s=()
                        if failed
                        else tuple(time * p / 100.0 if p < 99 else None for p in range(101)),
                        computing_s=1.0,
                        memory_mb=100.0,
                    )
                )
    spec = ExperimentSpec(
        name="Made up", about=about, environments=("open",), strategies=("srt-star",)
    )
    return Results(spec, found, len(found), provenance())


@pytest.fixture(scope="module")
def real() -> Results:
    """Two strategies in a small world, once each, and one run that was refused."""
    spec = ExperimentSpec(
        name="Real",
        environments=("open",),
        strategies=("srt-radial", StrategyChoice(name="closest", label="near <first>")),
        repetitions=1,
    )
    found = []
    for planned in runs(spec):
        run = ms.explore(planned.spec)
        found.append(
            Result(
                key=planned.key,
                condition=planned.condition,
                repetition=planned.repetition,
                status=run.outcome,
                reason=run.reason,
                digest=run.digest,
                metrics=run.metrics,
            )
        )
    return Results(spec, found, len(found), provenance())


@pytest.fixture(scope="module")
def report(real, tmp_path_factory):
    """A report with all its sections."""
    stalled = msgspec.structs.replace(
        real.results[1],
        status="stalled",
        reason="robot 0 sees 3.5 m of frontier",
        metrics=msgspec.structs.replace(
            metrics_of(real.results[1]), coverage=0.8, given_up_m2={"too narrow": 12.5}
        ),
    )
    results = Results(real.experiment, (real.results[0], stalled), 4, real.provenance)
    claims = [
        Claim(text="a beats b", source="Some paper, section 4", verdict="holds", grounds=("so",))
    ]
    printed = [
        PrintedTable(title="Their times", source="Table 2", columns=("w", "t"), rows=(("x", "1"),))
    ]
    out = tmp_path_factory.mktemp("reports") / "report"
    return write_report(results, out, latex=True, claims=claims, comparisons=printed, measures=ONE)


@pytest.fixture
def no_figures(monkeypatch):
    """Figures are drawn elsewhere: most tests are about what stands around them."""
    svg = b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 3"/>'

    def blank(name, title, alt, *_):
        return Picture(name=name, title=title, alt=alt, svg=svg, pdf=b"%PDF")

    monkeypatch.setattr(figures, "drawn", blank)


# The page -----------------------------------------------------------------------------------


@pytest.mark.slow
def test_page_needs_nothing_from_elsewhere(report):
    text = report.read_text()
    page = Page(text)
    for tag, attributes in page.tags:
        assert tag not in ("link", "iframe", "object", "embed")
        for name in ("src", "href", "srcset", "data"):
            if (target := attributes.get(name)) is None:
                continue
            if tag == "img":
                assert target.startswith("data:image/svg+xml,")
                ET.fromstring(unquote(target.partition(",")[2]))
            elif target.startswith("#"):
                assert target[1:] in {a.get("id") for _, a in page.tags}
            else:
                assert (report.parent / target).is_file()
    assert page.all("script") == [{}]
    outside = re.sub(r'src="data:[^"]*"', "", text)
    assert "http" not in outside
    assert "@import" not in outside
    assert "url(" not in outside


@pytest.mark.slow
def test_page_is_for_everybody(report):
    page = Page(report.read_text())
    assert page.all("html") == [{"lang": "en"}]
    assert {"name": "viewport", "content": "width=device-width, initial-scale=1"} in page.all(
        "meta"
    )
    assert all(len(image["alt"]) > 30 for image in page.all("img"))
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    heads = [attributes.get("scope") for attributes in page.all("th")]
    assert None not in heads
    # The list of runs, by setting, does not sort.
    assert len(page.all("button")) == heads.count("col") - len(COLUMNS) > 0
    assert len(page.all("caption")) == len(page.all("table"))


@pytest.mark.slow
def test_page_has_all_sections_and_tables(report):
    page = Page(report.read_text())
    sections = {attributes["id"] for attributes in page.all("section")}
    assert sections >= {
        "claims", "overview", "findings", "success-rates", "measures", "across", "gallery",
        "failures", "computing", "run", "known_complete_s",
    }  # fmt: skip
    tables = {table["id"].removeprefix("table-") for table in page.all("table") if "id" in table}
    assert {path.stem for path in (report.parent / "tables").glob("*.csv")} == tables
    assert {path.stem for path in (report.parent / "tables").glob("*.tex")} == tables
    assert tables >= {"overview", "known-complete-s", "coverage", "success-rates", "computing"}
    assert "printed-1-their-times" in tables
    assert "4 runs asked for, 2 made (2 still missing" in page.text
    assert provenance().program in page.text
    assert "a beats b" in page.text


def test_figures_lie_beside_it_as_svg_and_pdf(report):
    folder = report.parent / "figures"
    drawings = sorted(path.stem for path in folder.glob("*.svg"))
    assert drawings == sorted(path.stem for path in folder.glob("*.pdf"))
    assert "boxes-known-complete-s-open" in drawings
    for path in folder.glob("*.svg"):
        ET.parse(path)
    assert all(path.read_bytes().startswith(b"%PDF") for path in folder.glob("*.pdf"))


@pytest.mark.slow
def test_labels_are_text_wherever_they_come(tmp_path):
    evil = '<script>alert("x")</script> $\\frac{1}{0}$ & \x07'
    results = made_up((evil, "b"), (1,), 5, about=evil, environment=evil)
    page = Page(write_report(results, tmp_path / "r", latex=True, measures=ONE).read_text())
    assert page.all("script") == [{}]
    assert 'alert("x")' in page.text
    for path in (tmp_path / "r" / "figures").glob("*.svg"):
        root = ET.parse(path).getroot()
        assert not list(root.iter("{http://www.w3.org/2000/svg}script"))


@pytest.mark.slow
def test_same_results_same_bytes(tmp_path):
    results = made_up(count=3, robots=(1,))
    for name in ("one", "two"):
        write_report(results, tmp_path / name, latex=True, gallery=False, measures=ONE)
    files = sorted(p.relative_to(tmp_path / "one") for p in (tmp_path / "one").rglob("*.*"))
    assert len(files) > 20
    for path in files:
        assert (tmp_path / "one" / path).read_bytes() == (tmp_path / "two" / path).read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("results", "said"),
    [
        (lambda: made_up(("a",), (1,), 3), "nothing to compare"),
        (
            lambda: made_up(("a", "b"), (1,), 1),
            "With these numbers of runs no difference can be significant",
        ),
        (lambda: made_up(("a", "b"), (1, 2), 2, fail=2), "its process died"),
        (lambda: made_up((), (), 0), "no results yet"),
    ],
    ids=["one strategy", "one run each", "all failed", "nothing"],
)
def test_little_is_enough_for_a_report(tmp_path, results, said):
    page = write_report(results(), tmp_path / "r", measures=ONE, latex=True)
    assert said in Page(page.read_text()).text
    for word in ("nan", "None", "Traceback"):
        assert not re.search(rf"\b{word}\b", Page(page.read_text()).text)


# Median runs and failures -------------------------------------------------------------------


@pytest.mark.slow
def test_gallery_draws_the_very_runs(real):
    made = gallery(Study(real), Specs(real))
    trees, notes = made.trees, made.notes
    assert notes == ()
    assert [tree.result.condition.strategy for tree in trees] == ["srt-radial", "near <first>"]
    assert real.results[0].digest in trees[0].svg


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_gallery_draws_no_run_but_the_measured_one(real, tmp_path):
    changed = [msgspec.structs.replace(result, digest="0" * 64) for result in real]
    results = Results(real.experiment, changed, 2, real.provenance)
    page = Page(write_report(results, tmp_path / "r", measures=ONE).read_text())
    assert page.text.count("makes another run of the same spec than the one that was") == 2
    assert not (tmp_path / "r" / "gallery").exists()


def test_gallery_lists_runs_that_cannot_be_drawn(real):
    unknown = [msgspec.structs.replace(result, key="0" * 32) for result in real]
    made = gallery(Study(Results(real.experiment, unknown, 2, real.provenance)), Specs(real))
    assert made.trees == ()
    assert len(made.notes) == 2
    gone = msgspec.structs.replace(real.experiment, environments=("gone.yaml",))
    lost = Results(gone, real.results, 2, real.provenance)
    notes = gallery(Study(lost), Specs(lost)).notes
    assert "gone.yaml" in notes[0]


def test_gallery_shows_every_world_before_smaller_teams():
    def results(*worlds: str) -> Study:
        parts = [made_up(("a", "b", "c"), (1, 2), 1, environment=world) for world in worlds]
        return Study(Results(parts[0].experiment, [r for p in parts for r in p], 1, provenance()))

    chosen = gallery_settings(results("u", "v", "w"))
    assert {(s.environment, s.robots) for s in chosen} == {("u", 2), ("v", 2), ("w", 2), ("u", 1)}


def time_of(result: Result | None) -> float:
    assert result is not None
    time = metrics_of(result).time_to_95_s
    assert time is not None
    return time


def test_median_run_is_in_the_middle():
    own = made_up(("a",), (1,), 5).results
    times = sorted(time_of(result) for result in own)
    assert time_of(median_run(list(own))) == times[2]
    assert median_run(list(made_up(("a",), (1,), 2, fail=2))) is None


@pytest.mark.slow
def test_failures_come_with_a_spec_that_repeats_them(report, real):
    page = Page(report.read_text())
    (path,) = (report.parent / "failures").iterdir()
    assert f"multisrt explore --spec failures/{path.name} --out again" in page.text
    assert "robot 0 sees 3.5 m of frontier" in page.text
    assert "covered 80.0 %" in page.text
    assert "left: 12.5 m2 too narrow" in page.text
    spec = RunSpec.from_toml(path.read_text())
    assert tomllib.loads(path.read_text())["strategy"] == "closest"
    assert ms.explore(spec).digest == real.results[1].digest


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_failures_are_grouped_regardless_of_numbers(tmp_path):
    text = Page(
        write_report(made_up(fail=3), tmp_path / "r", gallery=False, measures=ONE).read_text()
    ).text
    assert text.count("6 runs. its process died after 0 s") == 2


# The folder ---------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_a_report_is_replaced_and_nothing_else(tmp_path):
    results = made_up(("a",), (1,), 1)
    out = tmp_path / "deep" / "report"
    write_report(results, out, gallery=False, measures=ONE, latex=True)
    page = write_report(results, out, gallery=False, measures=ONE)
    assert not list((out / "tables").glob("*.tex"))
    assert [p.name for p in out.parent.iterdir()] == ["report"]
    (out / "notes.txt").write_text("mine")
    with pytest.raises(
        InvalidInputError, match=r"other contents than a report of this program \(notes.txt\)"
    ):
        write_report(results, out, gallery=False, measures=ONE)
    assert page.is_file()
    (tmp_path / "page").mkdir()
    (tmp_path / "page" / "index.html").write_text("<html>another's</html>")
    with pytest.raises(InvalidInputError, match="other contents than a report"):
        write_report(results, tmp_path / "page", gallery=False, measures=ONE)
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidInputError, match="is a file"):
        write_report(results, tmp_path / "file", gallery=False, measures=ONE)


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_nothing_half_written_stays(tmp_path, monkeypatch):
    results = made_up(("a",), (1,), 1)
    page = write_report(results, tmp_path / "r", gallery=False, measures=ONE)
    before = page.read_bytes()

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(page_module, "_page", fail)
    with pytest.raises(InvalidInputError, match="No space left on device"):
        write_report(results, tmp_path / "r", gallery=False, measures=ONE)
    assert [p.name for p in tmp_path.iterdir()] == ["r"]
    assert page.read_bytes() == before


# Looks --------------------------------------------------------------------------------------


def test_strategies_differ_in_more_than_colour():
    looks = [look_of(number) for number in range(len(MARKERS))]
    assert len({look.marker for look in looks}) == len(MARKERS)
    assert len({str(look.dashes) for look in looks}) == len(DASHES)
    assert len({(look.colour, look.marker) for look in map(look_of, range(64))}) == 64


@given(st.lists(st.text(min_size=1, max_size=80), min_size=1, max_size=12, unique_by=printable))
def test_labels_in_figures_fit_and_differ(labels):
    found = short_labels(labels)
    assert list(found) == labels
    assert len(set(found.values())) == len(labels)
    assert all(len(label) <= MAX_LABEL for label in found.values())


def test_short_labels_keep_the_part_that_differs():
    labels = [f"star, alpha = {k} and all else as it is by default" for k in (1, 2, 10)]
    found = list(short_labels(labels).values())
    assert [label.split()[0] for label in found] == ["…1", "…2", "…10"]


def test_many_strategies_fill_figures_that_all_show_the_baseline():
    names = [f"s{k}" for k in range(11)]
    groups = in_groups(names, "s3")
    assert all(group[0] == "s3" and len(group) <= 5 for group in groups)
    assert [name for group in groups for name in group[1:]] == [n for n in names if n != "s3"]
    assert in_groups(names[:5], "s3") == [names[:5]]


# The command --------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_command_writes_a_report(real, tmp_path):
    from multisrt.experiments.store import Store

    with Store.create_or_open(tmp_path / "results.sqlite", real.experiment) as store:
        for result in real:
            store.add(result)
    out = tmp_path / "report"
    arguments = ["report", str(tmp_path / "results.sqlite"), "--out", str(out), "--no-gallery"]
    done = click.testing.CliRunner().invoke(cli, [*arguments, "--measure", *ONE, "--latex"])
    assert done.exception is None, done.output
    assert "2 of 2 runs" in done.output
    assert (out / "tables" / "known-complete-s.tex").is_file()
    failed = click.testing.CliRunner().invoke(cli, [*arguments, "--baseline", "nobody"])
    assert isinstance(failed.exception, InvalidInputError)
