"""Making the runs of an experiment, as `experiment run` and `reproduce` both do."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from multisrt.experiments.description import ExperimentSpec
    from multisrt.experiments.results import Results

Command = TypeVar("Command", bound=Callable[..., Any])


def _one_of_them(context: click.Context, option: click.Parameter, value: Any) -> Any:
    others = {"workers", "cluster"} - {option.name}
    if value is not None and any(context.params.get(other) is not None for other in others):
        raise click.UsageError("give --workers or --cluster, not both: a cluster has its own")
    return value


def running_options(command: Command) -> Command:
    """Let a command be told who makes its runs, and which: workers, cluster, retry, quiet."""
    for option in reversed(
        (
            click.option(
                "--workers",
                type=click.IntRange(1),
                callback=_one_of_them,
                metavar="N",
                help="Processes on this machine.  [default: one for each core]",
            ),
            click.option(
                "--cluster",
                callback=_one_of_them,
                metavar="ADDRESS",
                help="A scheduler of dask.distributed instead: tcp://HOST:8786.",
            ),
            click.option(
                "--retry", is_flag=True, help="Make runs again that did not come to an end."
            ),
            click.option("--quiet", is_flag=True, help="Print nothing but errors."),
        )
    ):
        command = option(command)
    return command


def make_runs(
    path: Path,
    spec: ExperimentSpec,
    folder: Path | None = None,
    *,
    workers: int | None,
    cluster: str | None,
    retry: bool,
    quiet: bool,
    modules: Sequence[str] = (),
) -> Results:
    """Make the runs of an experiment that its store has no result of, and give all results.

    Parameters
    ----------
    path : Path
        The store; it is made if there is none.
    spec : ExperimentSpec
        The experiment.
    folder : Path, optional
        What paths of its environments are relative to.
    workers, cluster, retry, quiet
        As the options say.
    modules : sequence of str
        What workers import.

    Raises
    ------
    InvalidInputError
        As `Store.create_or_open` and `run_experiment` do.
    click.Abort
        If it was interrupted; what is there by then has been told.
    """
    from multisrt.experiments.live import LiveProgress
    from multisrt.experiments.runner import run_experiment
    from multisrt.experiments.store import Store
    from multisrt.geometry.errors import InvalidInputError

    was_there, has_begun = path.exists(), True
    try:
        with Store.create_or_open(path, spec, folder) as opened:
            if retry:
                opened.forget()
            try:
                with LiveProgress(not quiet) as live:
                    run_experiment(
                        opened, workers=workers, cluster=cluster, modules=modules, progress=live
                    )
            except KeyboardInterrupt:
                told = f"{opened.done} of {opened.asked} runs are stored in {path}"
                click.echo(f"{told}; the same command goes on", err=True)
                raise click.Abort from None
            except InvalidInputError:
                has_begun = opened.done > 0
                raise
            return opened.results()
    except InvalidInputError:
        # A store is not left behind by what could not even begin.
        if not (was_there or has_begun):
            path.unlink()
        raise
