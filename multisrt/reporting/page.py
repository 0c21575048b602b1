"""The report: a self-contained page, with its figures and tables as files beside it."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Final
from urllib.parse import quote

from multisrt.drawing.svg import printable
from multisrt.experiments.measures import Measure, measure_named
from multisrt.experiments.results import Results
from multisrt.geometry.errors import InvalidInputError
from multisrt.reporting import figures, overall_figures, tables
from multisrt.reporting.claims import Claim, PrintedTable
from multisrt.reporting.custom_strategies import cautions, imports
from multisrt.reporting.layout import Cell, Footnotes, Table, number, slug
from multisrt.reporting.overview import overview
from multisrt.reporting.reruns import MAX_FAILURES, Failure, Gallery, Specs, Tree, failures
from multisrt.reporting.reruns import gallery as drawn_gallery
from multisrt.reporting.run_rows import COLUMNS, RunRows, run_rows
from multisrt.reporting.study import Study, chosen_measures, other_measures
from multisrt.reporting.style import Picture
from multisrt.reporting.words import HOW_TO_READ, Findings, findings, what_was_run

PAGE_NAME: Final = "index.html"
GENERATOR: Final = "multisrt report"
CONTENTS: Final = {PAGE_NAME, "figures", "tables", "gallery", "replays", "specs", "failures"}
"""Names in the folder of a report; a folder with any other name is never replaced."""

TEAM_MEASURES: Final = ("isolated_total_s", "imbalance")
"""Measures of the cooperation of a team."""

MAX_FIGURES: Final = 16
"""Upper bound of the figures of one kind on the page; it links to the files of the others."""

MAX_BYTES_OF_TREES: Final = 250_000
"""Upper bound of the size of the pictures of runs on the page, in bytes; it links to the others."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasurePart:
    """The part of a page on one measure."""

    measure: Measure
    findings: Findings
    table: Table
    growth: Table | None = None
    pictures: tuple[Picture, ...] = ()


@dataclass(slots=True, kw_only=True)
class Contents:
    """The contents of a report."""

    study: Study
    headlines: list[MeasurePart] = field(default_factory=list)
    of_teams: list[MeasurePart] = field(default_factory=list)
    others: list[MeasurePart] = field(default_factory=list)
    same_everywhere: list[str] = field(default_factory=list)
    overview: Table | None = None
    success: Table | None = None
    gap: Table | None = None
    computing: Table | None = None
    printed: list[Table] = field(default_factory=list)
    claims: Sequence[Claim] = ()
    coverage: list[Picture] = field(default_factory=list)
    delivered: list[Picture] = field(default_factory=list)
    across: list[Picture] = field(default_factory=list)
    rates: list[Picture] = field(default_factory=list)
    gallery: Gallery = field(default_factory=Gallery)
    failures: list[Failure] = field(default_factory=list)
    imports: list[str] = field(default_factory=list)
    runs: RunRows = field(default_factory=RunRows)

    def tables(self) -> list[Table]:
        """Return all tables."""
        parts = (*self.headlines, *self.of_teams, *self.others)
        growth = [part.growth for part in parts]
        found = [self.overview, self.success, *(part.table for part in parts), *growth]
        return [t for t in (*found, self.gap, self.computing, *self.printed) if t is not None]

    def pictures(self) -> list[Picture]:
        """Return all figures."""
        parts = (*self.headlines, *self.of_teams)
        of_measures = [picture for part in parts for picture in part.pictures]
        return [*of_measures, *self.coverage, *self.across, *self.rates]


def write_report(
    results: Results,
    out: str | Path,
    *,
    latex: bool = False,
    claims: Sequence[Claim] = (),
    comparisons: Sequence[PrintedTable] = (),
    gallery: bool = True,
    replays: bool = True,
    measures: Sequence[str] = (),
    baseline: str | None = None,
    folder: Path | None = None,
    progress: Callable[[str], None] | None = None,
) -> Path:
    """Write a report: a page, figures as SVG and PDF, tables as CSV.

    Equal results give equal bytes. A report in the same folder is replaced once the new one is
    complete.

    Parameters
    ----------
    results : Results
        Results of an experiment.
    out : str or Path
        The folder of the report.
    latex : bool, optional
        Whether tables are also written as LaTeX.
    claims : sequence of Claim, optional
        Judged claims of a paper.
    comparisons : sequence of PrintedTable, optional
        Tables of a paper beside the results.
    gallery : bool, optional
        Whether median runs are simulated again and drawn.
    replays : bool, optional
        Whether pages that replay the runs of the gallery are written beside the report.
    measures : sequence of str, optional
        Names of the measures to discuss; by default `study.HEADLINES`, and `study.DELIVERY` with a
        base station.
    baseline : str, optional
        Label of the strategy that the others are compared with; by default the first one.
    folder : Path, optional
        Folder that relative paths of the experiment's environments start from.
    progress : callable, optional
        Called with a line on each step.

    Returns
    -------
    Path
        The page, ``index.html`` in the folder.

    Raises
    ------
    InvalidInputError
        If a measure or the baseline is unknown, or the folder cannot be written or has other
        contents than a report.

    Examples
    --------
    >>> import multisrt as ms
    >>> from tempfile import TemporaryDirectory
    >>> compared = ms.compare("open", "closest", 1, 2, progress=False)
    >>> with TemporaryDirectory() as folder:
    ...     write_report(compared.results, f"{folder}/report", measures=["coverage"]).name
    'index.html'
    """
    path = Path(out)
    say = progress or (lambda _: None)
    study = Study(results, baseline)
    chosen = chosen_measures(study, measures)
    with _replaced(path) as unfinished:
        contents = _contents(study, chosen, say)
        contents.claims = claims
        contents.printed = [_printed(i, table) for i, table in enumerate(comparisons, start=1)]
        specs = Specs(results, folder)
        contents.failures = failures(study, specs, path)
        contents.imports = imports(results, folder or Path())
        if gallery:
            contents.gallery = drawn_gallery(study, specs, say, replays=replays)
        contents.runs = run_rows(study, specs, contents.gallery, path)
        say("writing")
        _write(contents, unfinished, latex=latex)
    return path / PAGE_NAME


# What a report has --------------------------------------------------------------------------


def _contents(study: Study, chosen: Sequence[Measure], say: Callable[[str], None]) -> Contents:
    found = Contents(study=study)
    of_teams = [measure_named(name) for name in TEAM_MEASURES]
    for measure in chosen:
        say(measure.title)
        grows = measure.lower_is_better
        found.headlines.append(_measure_part(study, measure, growth=grows))
    for measure in other_measures(chosen):
        if not study.varies(measure):
            found.same_everywhere.append(measure.title)
        elif measure in of_teams:
            say(measure.title)
            found.of_teams.append(_measure_part(study, measure))
        else:
            found.others.append(
                MeasurePart(
                    measure=measure,
                    findings=findings(study, measure),
                    table=tables.measure_table(study, measure),
                )
            )
    if study.settings:
        say("coverage and comparisons over all settings")
        found.overview = overview(study)
        found.success = tables.success_table(study)
        found.gap = tables.gap_table(study)
        found.computing = tables.computing_table(study)
        found.coverage = figures.coverage_curves(study)
        found.delivered = figures.delivered_curves(study)
        found.rates = overall_figures.success_rates(study)
        found.across = [
            *overall_figures.profiles(study),
            *(p for measure in chosen for p in overall_figures.improvement(study, measure)),
            *overall_figures.gaps(study),
        ]
    return found


def _measure_part(study: Study, measure: Measure, *, growth: bool = False) -> MeasurePart:
    return MeasurePart(
        measure=measure,
        findings=findings(study, measure),
        table=tables.measure_table(study, measure),
        growth=tables.growth_table(study, measure) if growth else None,
        pictures=(
            *figures.box_plots(study, measure),
            *figures.against_team_size(study, measure),
        ),
    )


def _printed(place: int, printed: PrintedTable) -> Table:
    return Table(
        name=f"printed-{place}-{slug(printed.title)}",
        title=printed.title,
        columns=printed.columns,
        rows=tuple(tuple(Cell(text=text) for text in row) for row in printed.rows),
        notes=tuple(text for text in (printed.source, printed.note) if text),
    )


# Writing ------------------------------------------------------------------------------------


def _write(contents: Contents, folder: Path, *, latex: bool) -> None:
    (folder / "figures").mkdir()
    for picture in contents.pictures():
        (folder / "figures" / f"{picture.name}.svg").write_bytes(picture.svg)
        (folder / "figures" / f"{picture.name}.pdf").write_bytes(picture.pdf)
    (folder / "tables").mkdir()
    for table in contents.tables():
        (folder / "tables" / f"{table.name}.csv").write_text(table.csv(), encoding="utf-8")
        if latex:
            (folder / "tables" / f"{table.name}.tex").write_text(table.latex(), encoding="utf-8")
    trees = contents.gallery.trees
    _write_files(folder / "gallery", {f"{tree.name}.svg": tree.svg for tree in trees})
    _write_files(folder / "replays", {f"{t.name}.html": t.replay for t in trees if t.replay})
    _write_files(folder / "specs", contents.runs.specs)
    specs = {f.spec_name: f.spec.to_toml() for f in contents.failures if f.spec is not None}
    _write_files(folder / "failures", specs)
    (folder / PAGE_NAME).write_text(_page(contents), encoding="utf-8")


def _write_files(folder: Path, texts: Mapping[str, str]) -> None:
    if texts:
        folder.mkdir()
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


def _page(contents: Contents) -> str:
    import jinja2
    from markupsafe import Markup

    beside = files("multisrt.reporting")
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    environment.filters["image"] = lambda svg: Markup(_image(svg))
    environment.filters["size"] = _size
    environment.filters["number"] = number
    environment.filters["printable"] = printable
    notes = Footnotes()
    environment.filters["table"] = lambda table: Markup(table.html(notes))
    template = environment.from_string(beside.joinpath("page.html.j2").read_text("utf-8"))
    study = contents.study
    return template.render(
        contents=contents,
        study=study,
        results=study.results,
        generator=GENERATOR,
        version=study.results.provenance.versions.get("multisrt", ""),
        run=what_was_run(study),
        cautions=cautions(study.results),
        imports=contents.imports,
        how_to_read=HOW_TO_READ,
        max_figures=MAX_FIGURES,
        max_failures=MAX_FAILURES,
        run_columns=COLUMNS,
        replay_mb=sum(len(tree.replay) for tree in contents.gallery.trees) / 1e6,
        shown_trees=_shown(contents.gallery.trees),
        style=Markup(beside.joinpath("page.css").read_text("utf-8")),
        script=Markup(beside.joinpath("page.js").read_text("utf-8")),
    )


def _shown(trees: Sequence[Tree]) -> set[str]:
    # Names of the trees on the page: the smallest ones, as many as fit.
    shown, used = set(), 0
    for tree in sorted(trees, key=lambda tree: len(tree.small)):
        used += len(tree.small)
        if used <= MAX_BYTES_OF_TREES:
            shown.add(tree.name)
    return shown


def _image(svg: bytes | str) -> str:
    # A data address isolates the names, styles and scripts of a drawing. In quotes, < and > stand
    # for themselves.
    text = svg.decode() if isinstance(svg, bytes) else svg
    text = re.sub(r"^<\?xml.*?\?>\s*(<!DOCTYPE[^>]*>\s*)?", "", text, flags=re.DOTALL)
    text = re.sub(r"\s*\n\s*", " ", text).replace("> <", "><").strip()
    return "data:image/svg+xml," + quote(text, safe=" =:/,;-.()+*!@?~$'|[]{}^<>")


def _size(svg: bytes | str) -> dict[str, int]:
    # Width and height, so that the page reserves room for the image.
    text = svg if isinstance(svg, str) else svg.decode()
    found = re.search(r"viewBox=[\"']0 0 ([\d.]+) ([\d.]+)[\"']", text)
    assert found is not None
    width, height = float(found[1]), float(found[2])
    return {"width": 560, "height": round(560 * height / width)}


@contextmanager
def _replaced(path: Path) -> Iterator[Path]:
    """Yield a folder to write to, which replaces `path` on success."""
    try:
        path = path.resolve()
        _require_replaceable(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_name(f".{path.name}.unfinished-{os.getpid()}")
        shutil.rmtree(unfinished, ignore_errors=True)
        unfinished.mkdir()
        try:
            yield unfinished
            old = path.with_name(f".{path.name}.old-{os.getpid()}")
            if path.exists():
                path.rename(old)
            unfinished.rename(path)
            shutil.rmtree(old, ignore_errors=True)
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)
    except OSError as error:
        raise InvalidInputError(
            f"cannot write the report {path}: {error.strerror or error}"
        ) from None


def _require_replaceable(path: Path) -> None:
    if not path.exists():
        return
    if not path.is_dir():
        raise InvalidInputError(f"{path} is a file; a report is a folder: choose another name")
    there = {entry.name for entry in path.iterdir()}
    if not there:
        return
    page = path / PAGE_NAME
    if there <= CONTENTS and page.is_file() and GENERATOR in page.read_text("utf-8")[:2000]:
        return
    strange = sorted(there - CONTENTS)
    what = f" ({strange[0]})" if strange else ""
    raise InvalidInputError(
        f"{path} has other contents than a report of this program{what}; choose another folder"
    )
