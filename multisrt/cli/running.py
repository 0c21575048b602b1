"""Executing the runs of an experiment, for `experiment run` and `reproduce`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from multisrt.cli.output_options import quiet_option

if TYPE_CHECKING:
    from multisrt.experiments.results import Results
    from multisrt.experiments.spec import ExperimentSpec


@dataclass(frozen=True, slots=True, kw_only=True)
class Running:
    """How the runs of an experiment are executed, mostly as given on the command line.

    Attributes
    ----------
    workers : int or None
        Number of processes on this machine; None: one for each core; 0: this process alone.
    cluster : str or None
        Address of a `dask.distributed` scheduler instead.
    retry : bool
        Whether runs that failed without a result are repeated.
    remake : bool
        Whether runs of user-defined strategies that have changed since are repeated.
    quiet : bool
        Whether only errors are printed.
    reference : str or None
        What times are also compared with; None: as the experiment says.
    made : Path or None
        The store of another experiment, from which the results of runs are taken that are runs
        of both.
    """

    workers: int | None
    cluster: str | None
    retry: bool
    quiet: bool
    reference: str | None = None
    remake: bool = False
    made: Path | None = None


def running_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options --workers, --cluster, --reference, --retry and --quiet to a command.

    Parameters
    ----------
    command : callable
        The command, which takes a keyword `running` of type `Running` instead of them.

    Returns
    -------
    callable
        The command with its options.
    """

    @wraps(command)
    def with_running(
        *args: Any,
        workers: int | None,
        cluster: str | None,
        reference: str | None,
        retry: bool,
        quiet: bool,
        **others: Any,
    ) -> None:
        if workers is not None and cluster is not None:
            raise click.UsageError("give --workers or --cluster, not both: a cluster has its own")
        running = Running(
            workers=workers, cluster=cluster, retry=retry, quiet=quiet, reference=reference
        )
        command(*args, running=running, **others)

    options = (
        click.option(
            "--workers",
            type=click.IntRange(0),
            metavar="N",
            help="Number of processes on this machine; 0: run in this process, without "
            "limits.  [default: one for each core]",
        ),
        click.option(
            "--cluster",
            metavar="ADDRESS",
            help="Address of a dask.distributed scheduler to use instead: tcp://HOST:8786.",
        ),
        click.option(
            "--reference",
            type=click.Choice(["none", "informed"]),
            help="Also report times as multiples of those of a team that knows the map: one plan "
            "for each world, team and starts, up to a minute each.",
        ),
        click.option("--retry", is_flag=True, help="Repeat runs that failed without a result."),
        quiet_option(),
    )
    decorated: Callable[..., None] = with_running
    for option in reversed(options):
        decorated = option(decorated)
    return decorated


def make_runs(
    path: Path,
    spec: ExperimentSpec,
    folder: Path | None = None,
    *,
    running: Running,
    modules: Sequence[str] = (),
    run_s: float | None = None,
    what: str = "runs",
    afterwards: Callable[[], tuple[int, float]] | None = None,
) -> Results:
    """Execute the runs of an experiment that have no result yet.

    Parameters
    ----------
    path : Path
        The store; it is created if necessary.
    spec : ExperimentSpec
        The experiment.
    folder : Path, optional
        Folder that relative paths of environments refer to; by default the working directory.
    running : Running
        How the runs are executed.
    modules : sequence of str
        Modules that workers import.
    run_s : float, optional
        Known computing time of a run, on average, in seconds; the expected time is then printed.
    what : str
        What the runs are called there.
    afterwards : callable, optional
        ``afterwards()`` returns the number of runs of ablations that follow, and the computing
        time of each in seconds.

    Returns
    -------
    Results
        All results, those of earlier calls included.

    Raises
    ------
    MultiSrtError
        As `Store.create_or_open` and `run_experiment` raise it. A store that was created here is
        removed if no run could be made.
    click.Abort
        If interrupted, after a message that says how many runs are stored.
    """
    import msgspec

    from multisrt.experiments.live import LiveProgress
    from multisrt.experiments.runner import run_experiment
    from multisrt.experiments.store import Store
    from multisrt.geometry.errors import MultiSrtError

    if running.reference is not None:
        spec = msgspec.structs.replace(spec, reference=running.reference)
    was_there, has_begun = path.exists(), True
    try:
        with Store.create_or_open(path, spec, folder, remake=running.remake) as opened:
            if running.retry:
                opened.forget()
            if running.made is not None:
                with Store.open(running.made) as other:
                    opened.take_from(other)
            missing = opened.planned - opened.done
            if run_s is not None and missing and not running.quiet:
                then = (0, 0.0) if afterwards is None else afterwards()
                click.echo(
                    expected_text(
                        missing, opened.planned, run_s, running, what=what, afterwards=then
                    )
                )
            try:
                with LiveProgress(not running.quiet) as live:
                    run_experiment(
                        opened,
                        workers=running.workers,
                        cluster=running.cluster,
                        modules=modules,
                        progress=live,
                    )
            except KeyboardInterrupt:
                stored = f"{opened.done} of {opened.planned} runs are stored in {path}"
                waiting = len(opened.plans.missing()) if spec.reference == "informed" else 0
                if waiting:
                    stored += f"; {waiting} of them wait for the informed plan"
                click.echo(f"{stored}; the same command continues", err=True)
                raise click.Abort from None
            except MultiSrtError:
                has_begun = opened.done > 0
                raise
            return opened.results()
    except MultiSrtError:
        if not (was_there or has_begun):
            with suppress(OSError):  # where nothing can be removed either
                path.unlink()
        raise


def missing_runs(path: Path, spec: ExperimentSpec, besides: ExperimentSpec) -> int:
    """Return the number of runs of an experiment that have no result in a store.

    Runs of another experiment are not counted, from which they will be taken.

    Parameters
    ----------
    path : Path
        The store, which need not exist.
    spec : ExperimentSpec
        The experiment.
    besides : ExperimentSpec
        The other experiment.

    Raises
    ------
    InvalidInputError
        If the file holds another experiment.
    """
    from multisrt.experiments.crossing import conditions
    from multisrt.experiments.store import Store

    asked, common = conditions(spec), range(min(spec.repetitions, besides.repetitions))
    others = {(at, k) for at in conditions(besides) for k in common}
    if not path.exists():
        return len({(at, k) for at in asked for k in range(spec.repetitions)} - others)
    with Store.create_or_open(path, spec) as opened:
        return len({(run.condition, run.repetition) for run in opened.missing()} - others)


def expected_text(
    missing: int,
    planned: int,
    run_s: float,
    running: Running,
    *,
    what: str = "runs",
    afterwards: tuple[int, float] = (0, 0.0),
) -> str:
    """Return how long the missing runs of an experiment take, in words.

    Parameters
    ----------
    missing, planned : int
        Number of runs that are missing, and of all.
    run_s : float
        Computing time of a run, on average, in seconds.
    running : Running
        How the runs are executed.
    what : str
        What the runs are called.
    afterwards : (int, float)
        Number of runs of ablations that follow, and the computing time of each in seconds.

    Returns
    -------
    str
        One line.
    """
    of_all = "" if missing == planned else f" of {planned}"
    parts = [f"{missing}{of_all} {what}, {_effort(missing, run_s, running)}"]
    if afterwards[0]:
        parts.append(f"then {afterwards[0]} runs of ablations, {_effort(*afterwards, running)}")
    return "; ".join((*parts, "an interrupted experiment continues with the same command"))


def _effort(missing: int, run_s: float, running: Running) -> str:
    from multisrt.experiments.live import duration
    from multisrt.experiments.runner import cores

    text = f"about {duration(missing * run_s)} of one core"
    workers = cores() if running.workers is None else max(1, running.workers)
    if running.cluster is None and workers > 1:
        text += f", {duration(missing * run_s / min(workers, missing))} with {workers} processes"
    return text


def print_gaps(results: Results) -> None:
    """Print times above those of the informed plan and above lower bounds, if a plan was made.

    Parameters
    ----------
    results : Results
        Results of an experiment.
    """
    from multisrt.reporting.study import Study
    from multisrt.reporting.tables import gap_table
    from multisrt.terminal import terminal_width

    asked = results.unreferenced or any(result.reference for result in results)
    if asked and (gaps := gap_table(Study(results))) is not None:
        click.echo(gaps.text(terminal_width()))
