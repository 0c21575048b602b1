"""A comparison in a few lines of Python: the conditions, crossed, run and summed up."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import shapely

from multisrt.environments.environment import Environment
from multisrt.experiments.description import (
    EnvironmentChoice,
    ExperimentSpec,
    FaultsChoice,
    RadioChoice,
    StartsChoice,
    StrategyChoice,
    TeamChoice,
)
from multisrt.experiments.live import LiveProgress
from multisrt.experiments.results import Results
from multisrt.experiments.runner import run_experiment
from multisrt.experiments.store import Store
from multisrt.geometry.errors import InvalidInputError
from multisrt.reporting.layout import Table
from multisrt.spec import RadioSpec

if TYPE_CHECKING:
    import pandas

    from multisrt.experiments.measures import Measure
    from multisrt.reporting.style import Picture

FIRST_MEASURE = "exploration_time_s"

World = str | Path | Environment | EnvironmentChoice


def compare(
    environments: World | Iterable[World],
    strategies: str | StrategyChoice | Iterable[str | StrategyChoice],
    robots: int | TeamChoice | Iterable[int | TeamChoice] = 1,
    seeds: int | range = 20,
    *,
    starts: str | StartsChoice | Iterable[str | StartsChoice] = "scattered",
    radios: str | float | RadioSpec | Iterable[str | float | RadioSpec] = "unlimited",
    faults: str | FaultsChoice | Iterable[str | FaultsChoice] = "none",
    workers: int | None = None,
    cluster: str | None = None,
    store: str | Path | None = None,
    imports: Sequence[str] = (),
    progress: bool = True,
    name: str = "comparison",
    recordings: str = "none",
    **said: Any,
) -> Comparison:
    """Run strategies against one another, and sum up how they did.

    Every strategy meets the same worlds, starts, faults and draws of the radio in repetition k.
    Workers are programs of their own: a script needs no ``if __name__ == "__main__"``.

    Parameters
    ----------
    environments : str, Path, Environment or EnvironmentChoice, or several
        Names of the catalogue, map files, or worlds.
    strategies : str or StrategyChoice, or several
        Names of the registry, or with options. Marks compare with the first.
    robots : int or TeamChoice, or several
        Team sizes, or teams whose robots differ.
    seeds : int or range
        How many repetitions, or their seeds, one after the other.
    starts, radios, faults
        As in an experiment's file; a number is a radio's range (m).
    workers : int, optional
        Processes on this machine; by default one for each core.
    cluster : str, optional
        Address of a scheduler of `dask.distributed` instead.
    store : path, optional
        Where results are kept: called again, it goes on where it was, and `multisrt report` reads
        it. By default they are kept nowhere but in what is returned.
    imports : sequence of str
        Modules that workers import, for strategies that they register.
    progress : bool
        Whether to show how far it is, on a terminal.
    name : str
        What reports call it.
    recordings : {"none", "failed", "all"}
        Which recordings are kept beside `store`.
    **said
        Further fields of an `ExperimentSpec`, as its file writes them: ``bodies``, ``blocks``,
        ``exclude``, ``drive``, ``range_finder``, ``stop``, ``limits``, ``about``.

    Returns
    -------
    Comparison
        The results, with tables, figures and a report of them.

    Raises
    ------
    InvalidInputError
        If a run cannot be: the message says which condition, and why.

    Examples
    --------
    >>> import multisrt as ms
    >>> found = ms.compare(
    ...     environments=["garden", "clutter"],
    ...     strategies=["srt-star", "srt-radial"],
    ...     robots=[1, 2, 4, 8],
    ...     seeds=20,
    ... )  # doctest: +SKIP
    >>> print(found.table("exploration_time_s"))  # doctest: +SKIP
    >>> found.report("report")  # doctest: +SKIP
    """
    if recordings != "none" and store is None:
        raise InvalidInputError(
            "recordings are kept beside the results: say where those go (store=...)"
        )
    first, count = _repetitions(seeds)
    spec = _experiment(
        name=name,
        environments=[_environment(one) for one in _several(environments)],
        strategies=_several(strategies),
        robots=_several(robots),
        starts=_several(starts),
        radios=[_radio(one) for one in _several(radios)],
        faults=_several(faults),
        repetitions=count,
        first_seed=first,
        recordings=recordings,
        **said,
    )
    with ExitStack() as stack:
        path = Path(
            stack.enter_context(tempfile.TemporaryDirectory(prefix="multisrt-"))
            if store is None
            else Path(store).parent
        ) / ("results.sqlite" if store is None else Path(store).name)
        opened = stack.enter_context(Store.create_or_open(path, spec, Path.cwd()))
        live = stack.enter_context(LiveProgress(progress))
        run_experiment(opened, workers=workers, cluster=cluster, modules=imports, progress=live)
        return Comparison(opened.results(), Path.cwd())


class Comparison:
    """What came out of a comparison.

    Parameters
    ----------
    results : Results
        The runs.
    folder : Path
        What paths of its environments are relative to.

    Attributes
    ----------
    results : Results
        The runs.
    """

    def __init__(self, results: Results, folder: Path) -> None:
        self.results = results
        self._folder = folder

    def table(
        self, measure: str | Measure = FIRST_MEASURE, *, baseline: str | None = None
    ) -> ShownTable:
        """Sum up a measure: a row for each setting, a column for each strategy.

        Parameters
        ----------
        measure : str or Measure
            Of what.
        baseline : str, optional
            Which strategy the marks compare with; by default the first.

        Raises
        ------
        InvalidInputError
            If there is no such measure or strategy.
        """
        from multisrt.reporting.tables import summary_table

        made = summary_table(self.results, measure, baseline=baseline)
        return ShownTable(**{field.name: getattr(made, field.name) for field in fields(Table)})

    def plot(
        self, measure: str | Measure = FIRST_MEASURE, *, baseline: str | None = None
    ) -> Drawings:
        """Draw a measure: against the team's size, or how runs are spread if there is one size.

        Raises
        ------
        InvalidInputError
            If there is no such measure or strategy.
        """
        from multisrt.experiments.measures import measure_named
        from multisrt.reporting.figures import against_team_size, box_plots
        from multisrt.reporting.study import Study

        chosen = measure_named(measure) if isinstance(measure, str) else measure
        study = Study(self.results, baseline)
        return Drawings(against_team_size(study, chosen) or box_plots(study, chosen))

    def report(self, folder: str | Path, **options: Any) -> Path:
        """Write a report: one page, figures and tables beside it; see `write_report`.

        Returns
        -------
        Path
            The page.
        """
        from multisrt.reporting.page import write_report

        return write_report(self.results, Path(folder), folder=self._folder, **options)

    def frame(self) -> pandas.DataFrame:
        """Give the runs as a frame of pandas, a row for each.

        Raises
        ------
        InvalidInputError
            If pandas is not installed (``multisrt[frames]``).
        """
        from multisrt.experiments.frames import frame_of

        return frame_of(self.results)

    def __repr__(self) -> str:
        """Give the table that is asked for first."""
        complete = sum(result.status == "complete" for result in self.results)
        return f"{self.table()}\n{complete} of {self.results.asked} runs complete\n"


class ShownTable(Table):
    """A table that shows itself, on a terminal and in a notebook."""

    def __repr__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        return self.html()


class Drawings(tuple["Picture", ...]):
    """Figures of a comparison: they show themselves in a notebook, and are saved as files."""

    __slots__ = ()

    def save(self, folder: str | Path) -> list[Path]:
        """Write each as SVG and as PDF, and tell the files.

        Raises
        ------
        InvalidInputError
            If the folder cannot be written to.
        """
        written = []
        try:
            Path(folder).mkdir(parents=True, exist_ok=True)
            for picture in self:
                for suffix, data in ((".svg", picture.svg), (".pdf", picture.pdf)):
                    path = Path(folder) / f"{picture.name}{suffix}"
                    path.write_bytes(data)
                    written.append(path)
        except OSError as error:
            raise InvalidInputError(
                f"cannot write to {folder}: {error.strerror or error}"
            ) from None
        return written

    def __repr__(self) -> str:
        return "\n".join(picture.alt for picture in self)

    def _repr_html_(self) -> str:
        return "\n".join(picture.svg.decode() for picture in self)


# From what is said to an experiment ----------------------------------------------------------


def _several(given: object) -> list[Any]:
    if isinstance(given, Iterable) and not isinstance(given, (str, bytes, dict)):
        return list(given)
    return [given]


def _repetitions(seeds: int | range) -> tuple[int, int]:
    if isinstance(seeds, range):
        if seeds.step != 1 or not seeds:
            raise InvalidInputError(
                f"seeds are one after the other, as in range(100, 120), not {seeds}"
            )
        return seeds.start, len(seeds)
    if isinstance(seeds, bool) or not isinstance(seeds, int):
        raise InvalidInputError(f"seeds are a number of repetitions, or a range, not {seeds!r}")
    return 0, seeds


def _environment(given: object) -> object:
    if isinstance(given, Environment):
        return EnvironmentChoice(
            name=given.name,
            wkt=shapely.to_wkt(given.free, rounding_precision=-1),
            starts=given.starts,
        )
    return str(given) if isinstance(given, Path) else given


def _radio(given: object) -> object:
    if isinstance(given, (int, float)) and not isinstance(given, bool):
        return RadioChoice(range_m=float(given))
    if isinstance(given, RadioSpec) and not isinstance(given, RadioChoice):
        return RadioChoice(**msgspec.structs.asdict(given))
    return given


def _experiment(**said: Any) -> ExperimentSpec:
    known = ExperimentSpec.__struct_fields__
    try:
        plain = msgspec.to_builtins(said)
    except (TypeError, NotImplementedError) as error:
        raise InvalidInputError(
            f"a comparison of what cannot be written down: {error}; give text, numbers, and the "
            f"parts of an ExperimentSpec ({', '.join(known)})"
        ) from None
    return ExperimentSpec.from_dict(plain)
