"""The runs of an experiment one by one, each with its replay or the command that repeats it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from multisrt.experiments.results import Result
from multisrt.reporting.custom_strategies import imported
from multisrt.reporting.layout import number
from multisrt.reporting.reruns import Gallery, Specs
from multisrt.reporting.study import Study

MAX_RUNS: Final = 2_000
"""Upper bound of the runs that are listed."""

MAX_BYTES_OF_SPECS: Final = 5_000_000
"""Upper bound of the size of all specs beside the page; maps of one's own are in each of them."""

COLUMNS: Final = ("run", "ended", "covered", "95 % (s)", "done (s)", "driven (m)", "again")
"""Headings of the list."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRow:
    """A run in the list.

    Attributes
    ----------
    cells : tuple of str
        Repetition, how it ended, and measures, in the order of `COLUMNS` without the last one.
    spec : str
        Name of the file with its spec; empty if there is none.
    imported : str
        What must be imported to repeat it; empty for a built-in strategy.
    replay : str
        Name of the page that replays it; empty if there is none.
    """

    cells: tuple[str, ...]
    spec: str = ""
    imported: str = ""
    replay: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRows:
    """The list of runs.

    Attributes
    ----------
    groups : list of (str, list of RunRow)
        The runs of each setting and strategy, with their names.
    specs : dict of str to str
        Texts of the specs, by the names of their files.
    left_out : int
        Number of runs beyond `MAX_RUNS`.
    """

    groups: list[tuple[str, list[RunRow]]] = field(default_factory=list)
    specs: dict[str, str] = field(default_factory=dict)
    left_out: int = 0


def run_rows(study: Study, specs: Specs, gallery: Gallery, out: Path) -> RunRows:
    """Return the list of the distinct runs.

    Parameters
    ----------
    study : Study
        The results.
    specs : Specs
        Specs of their runs.
    gallery : Gallery
        Runs that have a replay.
    out : Path
        The folder of the report, from which paths of imported files are relative.
    """
    replays = {tree.result.key: f"{tree.name}.html" for tree in gallery.trees if tree.replay}
    found, used, listed, asked = RunRows(), 0, 0, 0
    for setting in study.settings:
        for strategy in study.here(setting):
            own: list[RunRow] = []
            results = study.distinct(setting, strategy)
            asked += len(results)
            for result in results[: MAX_RUNS - listed]:
                spec = specs.of(result)
                text = "" if spec is None else spec.to_toml()
                used += len(text)
                name = ""
                if text and used <= MAX_BYTES_OF_SPECS:
                    name = f"{result.key[:12]}.toml"
                    found.specs[name] = text
                own.append(
                    RunRow(
                        cells=_cells(result),
                        spec=name,
                        imported="" if spec is None else imported(spec.strategy, out),
                        replay=replays.get(result.key, ""),
                    )
                )
            listed += len(own)
            if own:
                found.groups.append((f"{study.name(setting)}: {strategy}", own))
    return RunRows(groups=found.groups, specs=found.specs, left_out=asked - listed)


def _cells(result: Result) -> tuple[str, ...]:
    ended = result.status.replace("_", " ")
    if result.failed and result.status == "complete":
        ended = "unsuccessful"
    m = result.metrics
    if m is None:
        return (str(result.repetition), ended, "", "", "", "")
    to_95 = "" if m.time_to_95_s is None else number(m.time_to_95_s, 1)
    measures: Sequence[str] = (
        f"{number(100.0 * m.coverage, 1)} %",
        to_95,
        number(m.makespan_s, 1),
        number(m.total_distance_m, 1),
    )
    return (str(result.repetition), ended, *measures)
