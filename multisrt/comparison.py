"""Compare strategies from Python: `compare` and the `Comparison` that it returns."""

from __future__ import annotations

import inspect
import tempfile
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

import msgspec

from multisrt.environments.environment import Environment
from multisrt.experiments.from_keywords import from_fields, from_keywords
from multisrt.experiments.live import LiveProgress
from multisrt.experiments.modules import Entrant, import_modules, named
from multisrt.experiments.results import Results
from multisrt.experiments.runner import require_no_import, run_experiment
from multisrt.experiments.spec import (
    EnvironmentChoice,
    ExperimentSpec,
    FaultsChoice,
    StartsChoice,
    TeamChoice,
)
from multisrt.experiments.store import Store
from multisrt.experiments.user_source import require_files
from multisrt.geometry.errors import InvalidInputError
from multisrt.reporting.shown import Drawings, ShownTable, shown
from multisrt.spec import RadioSpec
from multisrt.spec.keywords import OF_MAP_FILES, refuse_unknown

if TYPE_CHECKING:
    import pandas
    import polars

    from multisrt.experiments.measures import Measure
    from multisrt.extras.frames import DataFrame, Package

FIRST_MEASURE = "time_to_95_s"
"""The measure that tables and figures show by default."""

INSTEAD = {
    "max_time_s": "stop=ms.StopRule(max_time_s=SECONDS)",
    "range_m": "range_finder=ms.RangeFinderSpec(range_m=METRES)",
    "beams": "range_finder=ms.RangeFinderSpec(beams=NUMBER)",
    "radio_range_m": "radios=METRES",
    "options": "multisrt.StrategyChoice(name=NAME, options={...}) as strategy",
    **OF_MAP_FILES,
}
"""Keywords of `multisrt.explore` that `compare` takes in a different form."""

World = str | Path | Environment | EnvironmentChoice


def compare(
    environments: World | Iterable[World] | ExperimentSpec | None = None,
    strategies: Entrant | Iterable[Entrant] | None = None,
    robots: int | TeamChoice | Iterable[int | TeamChoice] | None = None,
    seeds: int | Sequence[int] | None = None,
    *,
    starts: str | StartsChoice | Iterable[str | StartsChoice] | None = None,
    radios: str | float | RadioSpec | Iterable[str | float | RadioSpec] | None = None,
    faults: str | FaultsChoice | Iterable[str | FaultsChoice] | None = None,
    name: str | None = None,
    recordings: str | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    store: str | Path | None = None,
    remake: bool = False,
    imports: Sequence[str] = (),
    progress: bool = True,
    **fields: Any,
) -> Comparison:
    """Compare strategies in simulated runs and summarise the results.

    Conditions are crossed: every strategy is run in every environment, with every team, radio and
    so on. The design is paired: in repetition k all strategies have the same worlds, starts, faults
    and random draws of the radio. Runs are executed by worker processes. They import a script that
    defines a strategy itself, so its other statements must be guarded::

        if __name__ == "__main__":
            print(ms.compare("museum", [Mine, "minpos"], seeds=20))

    The short form gives the conditions as arguments; omitted ones have the defaults of
    `ExperimentSpec`. The long form takes an `ExperimentSpec`, which describes all conditions; only
    `workers`, `cluster`, `store`, `remake`, `imports` and `progress` may be given as well.

    Parameters
    ----------
    environments : str, Path, Environment or EnvironmentChoice, or several; or ExperimentSpec
        Names in the catalogue, suites or their worlds ("indoor-30", "indoor-30/07"), map files or
        environments; or the whole experiment.
    strategies : str, StrategyChoice, Strategy, class or function, or several
        Names of registered strategies, with or without options; or user-defined strategies, as
        accepted by `Strategy.of` or as references (``"mine.py:Mine"``), which are registered here
        and imported by the worker processes. Marks in tables compare the others with the first.
    robots : int or TeamChoice, or several, optional
        Team sizes, or teams whose robots differ.
    seeds : int or sequence of int, optional
        Number of repetitions, or their consecutive seeds: ``range(1, 21)`` or ``[1, 2]``.
    starts, radios, faults : optional
        One or several, as in an experiment file; a number is the range of a radio (m).
    name : str, optional
        Title of reports; "Comparison" by default.
    recordings : {"none", "failed", "all"}, optional
        Which recordings are kept beside `store`; "none" by default. An `ExperimentSpec` with its
        default "failed" keeps none if there is no `store`.
    workers : int, optional
        Number of processes on this machine; one for each core by default. 0: the runs are executed
        in this process, one after another and without limits; use it for strategies that are
        defined in a notebook cell, or for debugging.
    cluster : str, optional
        Address of a `dask.distributed` scheduler to use instead of local processes.
    store : str or Path, optional
        File in which results are kept. When `compare` is called again, it executes only the runs
        that are missing. ``multisrt report`` reads the file. By default results are kept in memory
        only.
    remake : bool
        Whether runs in `store` are repeated if their user-defined strategy has changed since;
        otherwise such runs are an error.
    imports : sequence of str
        Modules or files with more strategies (``"mine.py"``), imported by this process and by the
        workers.
    progress : bool
        Whether to show the progress: as a bar on a terminal and in a notebook, otherwise as a line
        on standard error every 30 s.
    **fields
        Other fields of `ExperimentSpec`: `bodies`, `blocks`, `exclude`, `drive`,
        `range_finder`, `base` (also as a pair of coordinates), `stop`, `limits`,
        `success_coverage`, `horizon_s`, `reference`, `about`.

    Returns
    -------
    Comparison
        The results, with tables, figures and a report.

    Raises
    ------
    InvalidInputError
        If a field is invalid, the two forms are mixed, or a run is impossible; the message names
        the field or the condition. Also if worker processes cannot import a strategy; the message
        states the remedy.

    Examples
    --------
    >>> import multisrt as ms
    >>> found = ms.compare("open", ["srt-star", "srt-radial"], seeds=2, progress=False)
    >>> len(found.results)
    4
    >>> print(found.table("makespan_s"))  # doctest: +ELLIPSIS
    Time until all are done (s)...

    The same from an `ExperimentSpec`, with the fields of an experiment file:

    >>> spec = ms.ExperimentSpec(
    ...     name="Star against Radial",
    ...     environments=("garden", "clutter"),
    ...     strategies=("srt-star", "srt-radial"),
    ...     robots=(1, 2, 4, 8),
    ... )
    >>> found = ms.compare(spec, store="star.sqlite")  # doctest: +SKIP
    >>> found.report("report")  # doctest: +SKIP
    """
    require_no_import()
    if environments is None:
        raise InvalidInputError(
            'name the environments to compare in: ms.compare("museum", [Mine, "minpos"])'
        )
    import_modules(imports)
    short = {
        "strategies": None if strategies is None else named(strategies),
        "robots": robots,
        "seeds": seeds,
        "starts": starts,
        "radios": radios,
        "faults": faults,
        "name": name,
        "recordings": recordings,
    }
    given = {key: value for key, value in (short | fields).items() if value is not None}
    if isinstance(environments, ExperimentSpec):
        if given:
            raise InvalidInputError(
                "an ExperimentSpec is complete: with it, give only workers, cluster, store, "
                f"remake, imports and progress, and leave out {', '.join(given)}"
            )
        spec = from_fields(environments)
        if store is None and spec.recordings == "failed":
            spec = msgspec.structs.replace(spec, recordings="none")
    else:
        if strategies is None:
            raise InvalidInputError("name the strategies to compare, or give an ExperimentSpec")
        known = [*inspect.signature(compare).parameters, *ExperimentSpec.__struct_fields__]
        refuse_unknown("compare", given, known, INSTEAD)
        spec = from_keywords({"environments": environments} | given)
    if spec.recordings != "none" and store is None:
        raise InvalidInputError(
            "recordings are kept beside the results: say where those go (store=...)"
        )
    if store is not None:
        require_files(spec)
    with ExitStack() as stack:
        if store is None:
            scratch = stack.enter_context(tempfile.TemporaryDirectory(prefix="multisrt-"))
            store = Path(scratch) / "results.sqlite"
        opened = stack.enter_context(Store.create_or_open(store, spec, Path.cwd(), remake=remake))
        live = stack.enter_context(LiveProgress(progress))
        run_experiment(opened, workers=workers, cluster=cluster, modules=imports, progress=live)
        return Comparison(opened.results(), Path.cwd())


class Comparison:
    """The results of a comparison, with tables, figures and a report.

    Parameters
    ----------
    results : Results
        The runs.
    folder : Path
        Folder that relative paths of environments refer to.

    Attributes
    ----------
    results : Results
        The runs, in the order of the experiment.

    Examples
    --------
    >>> import multisrt as ms
    >>> found = ms.compare("open", ["srt-star", "srt-radial"], seeds=2, progress=False)
    >>> sorted({result.status for result in found.results})
    ['complete']
    >>> found.plot("makespan_s").save("figures")  # doctest: +SKIP
    """

    def __init__(self, results: Results, folder: Path) -> None:
        self.results = results
        self._folder = folder

    def overview(self, *, baseline: str | None = None) -> ShownTable:
        """Return a table of success, coverage, exploration times and distance.

        Parameters
        ----------
        baseline : str, optional
            Strategy that the marks compare with; the first one by default.

        Returns
        -------
        ShownTable
            One row for each setting and strategy.

        Raises
        ------
        InvalidInputError
            If there is no such strategy.

        Examples
        --------
        >>> import multisrt as ms
        >>> found = ms.compare("open", ["minpos", "closest"], [2, 4], seeds=20)  # doctest: +SKIP
        >>> found.overview(baseline="closest")  # doctest: +SKIP
        """
        from multisrt.reporting.overview import overview_table

        return shown(overview_table(self.results, baseline=baseline))

    def table(
        self, measure: str | Measure = FIRST_MEASURE, *, baseline: str | None = None
    ) -> ShownTable:
        """Summarise a measure: one row for each setting, one column for each strategy.

        Parameters
        ----------
        measure : str or Measure
            The measure; see `multisrt.experiments.measures.MEASURES`.
        baseline : str, optional
            Strategy that the marks compare with; the first one by default.

        Returns
        -------
        ShownTable
            The table, which prints itself on a terminal and in a notebook.

        Raises
        ------
        InvalidInputError
            If there is no such measure or strategy.

        Examples
        --------
        >>> import multisrt as ms
        >>> found = ms.compare("open", ["minpos", "closest"], [2, 4], seeds=20)  # doctest: +SKIP
        >>> found.table("makespan_s", baseline="closest")  # doctest: +SKIP
        """
        from multisrt.reporting.tables import summary_table

        return shown(summary_table(self.results, measure, baseline=baseline))

    def plot(
        self, measure: str | Measure = FIRST_MEASURE, *, baseline: str | None = None
    ) -> Drawings:
        """Draw a measure against the team size, or as box plots if there is one size only.

        Parameters
        ----------
        measure : str or Measure
            The measure; see `multisrt.experiments.measures.MEASURES`.
        baseline : str, optional
            Strategy that the others are compared with; the first one by default.

        Returns
        -------
        Drawings
            The figures, which show themselves in a notebook.

        Raises
        ------
        InvalidInputError
            If there is no such measure or strategy.

        Examples
        --------
        >>> import multisrt as ms
        >>> found = ms.compare("open", ["minpos", "closest"], [2, 4], seeds=20)  # doctest: +SKIP
        >>> found.plot("makespan_s").save("figures")  # doctest: +SKIP
        """
        from multisrt.experiments.measures import measure_named
        from multisrt.reporting.figures import against_team_size, box_plots
        from multisrt.reporting.study import Study

        chosen = measure_named(measure) if isinstance(measure, str) else measure
        study = Study(self.results, baseline)
        return Drawings(against_team_size(study, chosen) or box_plots(study, chosen))

    def report(self, folder: str | Path, **options: Any) -> Path:
        """Write a report: one page, with figures and tables beside it.

        Parameters
        ----------
        folder : str or Path
            Folder of the report; a report that is already there is replaced.
        **options
            Further arguments of `multisrt.reporting.page.write_report`.

        Returns
        -------
        Path
            The page.

        Raises
        ------
        InvalidInputError
            If the folder cannot be written, or holds anything but a report.

        Examples
        --------
        >>> import multisrt as ms
        >>> found = ms.compare("open", ["minpos", "closest"], [2, 4], seeds=20)  # doctest: +SKIP
        >>> found.report("report", baseline="closest", latex=True)  # doctest: +SKIP
        """
        from multisrt.reporting.page import write_report

        return write_report(self.results, Path(folder), folder=self._folder, **options)

    @overload
    def frame(self, frame: Literal["pandas"] | None = None) -> pandas.DataFrame: ...

    @overload
    def frame(self, frame: Literal["polars"]) -> polars.DataFrame: ...

    def frame(self, frame: Package | None = None) -> DataFrame:
        """Return the runs as a data frame, one row per run.

        Parameters
        ----------
        frame : {"pandas", "polars"}, optional
            Library of the data frame; by default pandas if it is installed, else polars.

        Returns
        -------
        pandas.DataFrame or polars.DataFrame
            The columns are those of `multisrt.experiments.frames.columns`.

        Raises
        ------
        MissingExtraError
            If neither pandas nor polars is installed (``multisrt[frames]``).

        Examples
        --------
        >>> import multisrt as ms
        >>> found = ms.compare("open", "srt-radial", robots=[1, 2], seeds=1, progress=False)
        >>> found.frame()[["strategy", "robots", "status"]]
             strategy  robots    status
        0  srt-radial       1  complete
        1  srt-radial       2  complete
        """
        from multisrt.experiments.frames import frame_of

        return frame_of(self.results, frame)

    def __repr__(self) -> str:
        """Return the overview and the number of successful runs."""
        from multisrt.reporting.words import totals

        return f"{self.overview()}\n{totals(self.results)}\n"

    def _repr_html_(self) -> str:
        from multisrt.reporting.words import totals

        return self.overview().notebook_html(totals(self.results))
