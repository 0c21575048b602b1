"""Every map of a folder, explored by two robots: ``python -m benchmarks.maps FOLDER --out DIR``.

Reads all files of the folder, chooses a body that fits each map, explores the map by `srt-radial`
and `minpos`, and writes `maps.md`, a table with a row for each file, and `maps.svg`, a sheet with a
small picture of each run of `srt-radial`. Runs that are already in `DIR/maps.sqlite` are not
repeated.
"""

from __future__ import annotations

import argparse
import html
import math
import re
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Final, Literal

import multisrt as ms
from multisrt.analysis.map_check import MapCheck, check_map
from multisrt.drawing.small_svg import small_svg
from multisrt.environments.environment import Environment
from multisrt.environments.formats import format_of, read_environment
from multisrt.experiments.results import Result
from multisrt.experiments.spec import Block, EnvironmentChoice, ExperimentSpec, Limits
from multisrt.experiments.store import Store
from multisrt.presets.summary import markdown_table
from multisrt.recording import Recording
from multisrt.terminal import LiveLine

STRATEGIES: Final = ("srt-radial", "minpos")

SCALES_M: Final = (
    ("*/cave*.png", 16.0 / 500.0),
    ("*/hospital.png", 140.0 / 3117.0),
    ("*/hospital_section.png", 40.0 / 1086.0),
    ("*/nav2d/*.png", 0.04),
    ("*/willow-full.pgm", 0.1),
    ("*/mresim/*", 0.078),
    ("*/explore_bench/*", 0.1),
    ("*/ir2_dungeon/*", 0.1),
    ("*.map", 0.5),
    ("*/maes/*", 0.5),
    ("*", 0.05),
)
"""Metres per pixel or cell of files without a scale of their own; the first pattern counts."""

TEAMS: Final = {"maze": "maze1.png", "rooms": "rooms.png"}
"""Image to which a team file belongs, by a word in the name of the team file."""

BODY_M: Final = 0.25
"""Radius of the default body, in metres."""

MIN_BODY_M: Final = 0.1
"""Minimum radius of a body in metres: doors of some maps are drawn closed but for a crack."""

SPARE_M: Final = 0.1
"""Room on either side of a body in a passage, in metres: a cell of the raster, as frontiers that
are narrower than the body are left out."""

MIN_REACHED: Final = 2.0 / 3.0
"""Share of the main part that must be reached, with room to spare, by the default body. In other
maps the body is somewhat smaller than the largest disc that reaches 95 % of it."""

PICTURE, GAP, LABEL, COLUMNS = 180, 16, 14, 7
"""Side of a picture on the sheet, gap, height of a label, and number of pictures in a row."""

MAX_LABEL = 34
"""Length in characters of a label that is as wide as a picture; of longer ones the end is shown."""

COLUMN_NAMES: Final = (
    "file",
    "format",
    "size (m)",
    "free space (m2)",
    "vertices",
    "body",
    *(f"{name}: {what}" for name in STRATEGIES for what in ("coverage", "time (s)")),
    "computing (s)",
)


@dataclass(frozen=True, slots=True)
class Subject:
    """A map that was read."""

    label: str
    format: str
    choice: EnvironmentChoice
    world: Environment
    check: MapCheck

    @property
    def body(self) -> str:
        """The default body, or a smaller disc if that would reach too little."""
        radius = BODY_M
        if self.check.reached_share < MIN_REACHED:
            largest = self.check.largest.radius_m
            radius = max(largest - SPARE_M, 0.5 * largest, MIN_BODY_M)
        return f"disc:{radius:.2g}"

    @property
    def starts(self) -> Literal["clustered", "suggested"]:
        """``suggested`` if there are enough suggested starts, else ``clustered``."""
        return "suggested" if len(self.world.starts) >= 2 else "clustered"

    @property
    def key(self) -> tuple[str, str, str, str]:
        """What its runs depend on: equal for two files that hold one world of one name."""
        return (self.world.name, self.world.digest, self.body, self.starts)

    @property
    def block(self) -> Block:
        """Its block of the experiment."""
        return Block(environments=(self.choice,), bodies=(self.body,), starts=(self.starts,))


def main() -> None:
    """Read and explore the maps, and write the table and the sheet."""
    given = _arguments()
    given.out.mkdir(parents=True, exist_ok=True)
    subjects, refused = read_all(given.folder)
    if not subjects:
        sys.exit(f"{given.folder} has no map that can be read")
    spec = experiment(subjects)
    store = given.out / "maps.sqlite"
    results = ms.compare(spec, store=store, workers=given.workers).results
    by_run: dict[str, dict[str, Result]] = defaultdict(dict)
    for result in results:
        by_run[result.condition.environment][result.condition.strategy] = result
    labels = {subject.key: subject.label for subject in reversed(subjects)}
    made = {subject.label: by_run[labels[subject.key]] for subject in subjects}
    (given.out / "maps.md").write_text(page(subjects, made, refused), encoding="utf-8")
    with Store.open(store) as opened:
        recordings = {
            subject.label: Recording.load(path)
            for subject in subjects
            if (path := opened.recording_path(made[subject.label][STRATEGIES[0]].key)).exists()
        }
    (given.out / "maps.svg").write_text(contact_sheet(recordings), encoding="utf-8")
    print(f"{given.out / 'maps.md'} and {given.out / 'maps.svg'} are written")
    if len(recordings) < len(subjects):
        print(f"the sheet has {len(recordings)} of {len(subjects)} maps: other recordings are gone")


def read_all(folder: Path) -> tuple[list[Subject], dict[str, str]]:
    """Return the maps of a folder, and the errors of files that are not maps, by name."""
    subjects, refused = [], {}
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.suffix != ".md")
    with LiveLine(True, "maps", "files read", counted=True) as line:
        for done, path in enumerate(files):
            line.update(completed=done, total=len(files))
            label = path.relative_to(folder).as_posix()
            try:
                subjects.append(read(path, label))
            except ms.MultiSrtError as error:
                refused[label] = str(error).replace(f"{folder}/", "").replace(str(folder), ".")
    return subjects, refused


def read(path: Path, label: str) -> Subject:
    """Return the map of a file; for a team file, the map to which it belongs."""
    image, team = path, None
    for word, name in TEAMS.items():
        if path.suffix == ".txt" and re.fullmatch(rf"team_.*{word}", path.stem):
            image, team = path.with_name(name), path
    known = format_of(image)
    scale = None
    if known.name in ("image", "numpy array", "MovingAI grid", "MovingAI scenario"):
        scale = next(metres for pattern, metres in SCALES_M if fnmatch(str(image), pattern))
    world = read_environment(image, resolution_m=scale, starts_from=team)
    choice = EnvironmentChoice(
        name=str(image),
        label=label,
        resolution_m=scale,
        starts_from=None if team is None else str(team),
    )
    name = known.name if team is None else f"{known.name} and team"
    check = check_map(world, ms.Footprint.disc(BODY_M + SPARE_M))
    return Subject(label, name, choice, world, check)


def experiment(subjects: Sequence[Subject]) -> ExperimentSpec:
    """Return the experiment: two robots in each map, by each strategy.

    Files that hold the same world are explored once.
    """
    distinct = {subject.key: subject for subject in reversed(subjects)}
    return ExperimentSpec(
        name="Maps",
        strategies=STRATEGIES,
        robots=(2,),
        repetitions=1,
        blocks=tuple(subject.block for subject in reversed(distinct.values())),
        limits=Limits(computing_s=3600.0, memory_mb=6000),
        recordings="all",
    )


def page(
    subjects: Sequence[Subject],
    made: Mapping[str, Mapping[str, Result]],
    refused: Mapping[str, str],
) -> str:
    """Return the table as a page of Markdown."""
    results = {result.key: result for of in made.values() for result in of.values()}.values()
    complete = sum(result.status == "complete" for result in results)
    hours = sum(result.computing_s for result in results) / 3600.0
    lines = [
        "# Maps of other projects",
        "",
        "Made with `python -m benchmarks.maps FOLDER --out DIR`: every file of a folder with maps "
        "that other projects publish, read and explored by two robots. The files themselves are "
        "not part of this project.",
        "",
        f"{len(subjects)} files are maps; {complete} of {len(results)} runs ended complete; "
        f"{hours:.1f} core-hours. Files without a scale were given one: that stated by their "
        "project, else 0.05 m a pixel and 0.5 m a cell. The body is a disc with a radius of "
        f"{BODY_M:g} m if one of {BODY_M + SPARE_M:g} m reaches two thirds of the part that "
        f"is explored, else one that is {SPARE_M:g} m smaller than the largest that reaches 95 % "
        f"of it, or half as large, but not less than {MIN_BODY_M:g} m. The robots start where the "
        "file suggests, or close together. Coverage is the share of the area that the bodies could "
        "see from there; robots keep off walls, and leave out passages that are hardly wider than "
        "they are. Time is that until both have returned.",
        "",
        markdown_table(COLUMN_NAMES, [row(subject, made[subject.label]) for subject in subjects]),
        "",
        *_unfinished(made),
        "## The explorations by `srt-radial`",
        "",
        "Each colour is the area that one of the two robots saw first, with its path. Files that "
        "hold the same world share a picture.",
        "",
        "![Small pictures of all maps, explored by two robots](maps.svg)",
        "",
        "## Files that are not maps, or cannot be read",
        "",
        *(f"- `{name}`: {html.escape(why, quote=False)}" for name, why in refused.items()),
    ]
    return "\n".join(lines) + "\n"


def row(subject: Subject, made: Mapping[str, Result]) -> tuple[str, ...]:
    """Return the row of a map."""
    x0, y0, x1, y1 = subject.world.bounds
    cells = []
    for name in STRATEGIES:
        result = made[name]
        if result.metrics is None:
            cells += [result.status, "-"]
        else:
            sign = "" if result.status == "complete" else "*"
            cells += [f"{result.metrics.coverage:.3f}{sign}", f"{result.metrics.makespan_s:.0f}"]
    return (
        f"`{subject.label}`",
        subject.format,
        f"{x1 - x0:.0f} x {y1 - y0:.0f}",
        f"{subject.world.area_m2:.0f}",
        f"{len(subject.world.edges):,}",
        subject.body,
        *cells,
        f"{sum(result.computing_s for result in made.values()):.0f}",
    )


def _unfinished(made: Mapping[str, Mapping[str, Result]]) -> list[str]:
    lines = [
        f"- `{label}`, {name}: {result.status.replace('_', ' ')}; {result.reason}"
        for label, by_strategy in made.items()
        for name, result in by_strategy.items()
        if result.status != "complete"
    ]
    return ["## Runs that did not end complete (*)", "", *lines, ""] if lines else []


def contact_sheet(recordings: Mapping[str, Recording]) -> str:
    """Return small pictures of runs beside each other, with their labels, as an SVG document."""
    cell = PICTURE + GAP
    rows = math.ceil(len(recordings) / COLUMNS)
    width, height = GAP + COLUMNS * cell, GAP + rows * (cell + LABEL)
    drawn = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'font-family="Helvetica, Arial, sans-serif" font-size="9">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
    ]
    for number, (label, recording) in enumerate(recordings.items()):
        x, y = GAP + number % COLUMNS * cell, GAP + number // COLUMNS * (cell + LABEL)
        place = f'x="{x}" y="{y}" width="{PICTURE}" height="{PICTURE}"'
        drawn.append(small_svg(recording, label).replace("<svg ", f"<svg {place} ", 1))
        shown = label if len(label) <= MAX_LABEL else f"…{label[1 - MAX_LABEL :]}"
        name = html.escape(shown)
        drawn.append(f'<text x="{x}" y="{y + PICTURE + LABEL - 3}">{name}</text>')
    return "\n".join([*drawn, "</svg>"]) + "\n"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="explore every map of a folder")
    parser.add_argument("folder", type=Path, help="folder with map files, at any depth")
    parser.add_argument("--out", type=Path, required=True, help="folder for the results")
    parser.add_argument(
        "--workers", type=int, help="number of processes; by default one for each core"
    )
    return parser.parse_args()


if __name__ == "__main__":
    main()
