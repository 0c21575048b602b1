"""`multisrt experiment check`: the conditions of an experiment, and how long it will take."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from multisrt.cli import candidates
from multisrt.cli.base_notes import base_apart
from multisrt.cli.imports import import_all, import_option, imports_again
from multisrt.cli.output_options import store_option
from multisrt.cli.reach import elsewhere
from multisrt.cli.spec_files import read_experiment
from multisrt.geometry.errors import InvalidInputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from multisrt.environments.environment import Environment
    from multisrt.experiments.crossing import Condition, PlannedRun
    from multisrt.experiments.estimate import Estimate
    from multisrt.experiments.job import Compilation
    from multisrt.experiments.results import Result
    from multisrt.experiments.spec import ExperimentSpec, Limits
    from multisrt.geometry.configuration import Configuration
    from multisrt.spec import RunSpec

MAX_ROWS = 24
"""Upper bound of the rows in the table of conditions; the rest is cut."""

MAX_TRIED = 200
"""Number of runs of which one must be possible, if none of the first repetition is."""


@click.command()
@click.argument(
    "file",
    metavar="FILE",
    type=click.Path(path_type=Path),
    shell_complete=candidates.files_named(".toml"),
)
@click.option(
    "--workers",
    type=click.IntRange(1),
    metavar="N",
    help="Number of workers to estimate for.  [default: one for each core]",
)
@click.option(
    "--seconds",
    default=30.0,
    show_default=True,
    type=click.FloatRange(0.0),
    help="Time for trial runs (s); 0 skips them and the estimate.",
)
@store_option("the results, as for 'experiment run'")
@import_option
def check(
    file: Path, workers: int | None, seconds: float, store: Path | None, imports: tuple[str, ...]
) -> None:
    """List an experiment's conditions and estimate its duration.

    FILE is read and every condition checked without storing anything. If there are results
    already, they must be those of this experiment. For the estimate a few trial runs are
    executed, cheap ones first, and discarded.

    \b
    Examples:
      multisrt experiment check star.toml
      multisrt experiment check star.toml --seconds 120 --workers 16
      multisrt experiment check star.toml --seconds 0
    """
    from multisrt.experiments.crossing import runs
    from multisrt.experiments.references import place_of

    import_all(imports)
    spec = read_experiment(file)
    planned = runs(spec, file.parent)
    stored = _stored(file.with_suffix(".sqlite") if store is None else store, spec, planned)
    everything = list(dict.fromkeys(run.condition for run in planned))
    many = "s" * (spec.repetitions != 1)
    click.echo(
        f"{spec.name}: {len(planned)} runs, {len(everything)} conditions of "
        f"{spec.repetitions} repetition{many} (seeds {spec.first_seed} to "
        f"{spec.first_seed + spec.repetitions - 1})"
    )
    if stored:
        click.echo(stored)
    if spec.reference == "informed":
        plans = len({place_of(run.spec) for run in planned})
        click.echo(f"beside the informed plan: at most {plans} plans, up to a minute each")
    warnings, refused = _poor_starts(planned)
    if refused.issuperset(everything) and all(
        map(_is_refused, planned[len(everything) : MAX_TRIED])
    ):
        _print_conditions(everything, {})
        tried = "no run" if len(planned) <= MAX_TRIED else f"none of the first {MAX_TRIED} runs"
        reasons = "\n  ".join(_by_reason(warnings))
        raise InvalidInputError(f"{tried} can be made:\n  {reasons}")
    found = _estimate(spec, planned, seconds, imports) if seconds else None
    _print_conditions(everything, {} if found is None else found.by_condition_s)
    if found is not None:
        _print_estimate(found, len(everything), workers)
        warnings |= _failures(found.probes)
    elif seconds:
        click.echo("no estimate: no trial run came to an end")
    for line in _by_reason(warnings):
        click.echo(f"warning: {line}", err=True)
    where = "" if store is None else f" --store {shlex.quote(str(store))}"
    click.echo(
        f"next: multisrt experiment run {shlex.quote(str(file))}{where}{imports_again(imports)}"
    )


def _stored(path: Path, spec: ExperimentSpec, planned: Sequence[PlannedRun]) -> str:
    """Return how many runs are stored; raise InvalidInputError if those are of another one."""
    from multisrt.experiments.store import Store

    if not path.exists():
        return ""
    with Store.open(path) as store:
        store.require_continuable_by(spec, planned)
        return f"{store.done} of them are stored in {path}"


def _poor_starts(planned: Sequence[PlannedRun]) -> tuple[dict[Condition, str], set[Condition]]:
    """Return what is wrong in the first repetition of conditions, and which of them are refused.

    They are refused if the team does not fit, say. Otherwise the team misses what lies in other
    parts of the world, or a base station that no robot gets to.
    """
    import msgspec

    from multisrt.environments.parts import is_poor_start
    from multisrt.experiments.mission import world_of

    found: dict[Condition, str] = {}
    refused: set[Condition] = set()
    tried: dict[Condition, tuple[str, bool]] = {}
    for run in planned:
        if run.repetition:
            break
        alike = msgspec.structs.replace(run.condition, faults="")
        if run.spec.base is None:
            alike = msgspec.structs.replace(alike, strategy="", radio="")
        if alike not in tried:
            try:
                world = world_of(run.spec.environment)
                starts = _starts(run.spec, world)
                x, y, _ = starts[0]
                poor = is_poor_start(world, x, y)
                told = [base_apart(run.spec, world, starts)]
                told += [elsewhere(world, (x, y), _by_places(len(run.spec.robots)))] * poor
                tried[alike] = "; ".join(filter(None, told)), False
            except InvalidInputError as error:
                tried[alike] = str(error), True
        why, is_refused = tried[alike]
        if why:
            found[run.condition] = why
        if is_refused:
            refused.add(run.condition)
    return found, refused


def _starts(spec: RunSpec, world: Environment) -> tuple[Configuration, ...]:
    """Return where the robots of a run start, or raise `InvalidInputError` if it is refused."""
    from multisrt.robots.registry import strategy
    from multisrt.simulation.setting_up import set_up
    from multisrt.simulation.starts import starts_of

    if spec.base is None or strategy(spec.strategy).plan is not None:
        return starts_of(spec, world)
    # With a base station, its place and the limit of time may be refused as well.
    return set_up(spec, world).starts


def _is_refused(run: PlannedRun) -> bool:
    from multisrt.experiments.mission import world_of

    try:
        _starts(run.spec, world_of(run.spec.environment))
    except InvalidInputError:
        return True
    return False


def _by_reason(warnings: Mapping[Condition, str]) -> Iterator[str]:
    """Yield a line for each reason, with the first condition that it is for."""
    conditions: dict[str, list[Condition]] = {}
    for condition, reason in warnings.items():
        conditions.setdefault(reason, []).append(condition)
    for reason, (first, *others) in conditions.items():
        more = f" and {len(others)} more condition{'s' * (len(others) > 1)}" if others else ""
        yield f"[{first}]{more}: {reason}"


def _by_places(robots: int) -> Callable[[str], str]:
    """Return how an experiment file says that a team starts at a place."""
    others = ", ..." if robots > 1 else ""

    def remedy(place: str) -> str:
        return f"start inside with starts = [{{ places = [[{place}]{others}] }}]"

    return remedy


def _estimate(
    spec: ExperimentSpec, planned: list[PlannedRun], seconds: float, modules: tuple[str, ...]
) -> Estimate | None:
    import msgspec

    from multisrt.analysis.progress import compiling_note
    from multisrt.experiments.estimate import estimate
    from multisrt.experiments.job import Compiling
    from multisrt.experiments.live import LiveProgress
    from multisrt.experiments.modules import own_strategies, worker_references
    from multisrt.experiments.runner import job_of
    from multisrt.experiments.user_source import provenance_with
    from multisrt.experiments.worker import Worker

    made_by = provenance_with(own_strategies(spec))
    worker = Worker(worker_references(spec, modules), made_by)

    def make(run: PlannedRun, limits: Limits) -> Result:
        plain = msgspec.structs.replace(spec, limits=limits, recordings="none")
        return worker.make(job_of(run, plain), tell)

    with LiveProgress() as live:

        def tell(now: Compilation) -> None:
            told = compiling_note(now.done, now.about) if isinstance(now, Compiling) else "runs"
            live.update(description=told)

        try:
            return estimate(
                spec,
                planned,
                make,
                budget_s=seconds,
                watch=lambda run: live.say(f"trying [{run.condition}]"),
            )
        finally:
            worker.stop()


def _print_conditions(everything: list[Condition], took: dict[Condition, float]) -> None:
    from multisrt.cli.tables import show, table

    # A column for each label that varies; the others are printed once, below the table.
    names = ("environment", "strategy", "robots", "team", "starts", "radio", "body", "faults")
    varying = [
        name
        for name in names
        if len({getattr(one, name) for one in everything}) > 1
        or name in ("environment", "strategy", "robots")
    ]
    made = table(
        *(">robots" if name == "robots" else name for name in varying),
        *([">s/run"] if took else []),
    )
    shown = everything if len(everything) <= MAX_ROWS else everything[: MAX_ROWS - 4]
    for one in shown:
        cells = [str(getattr(one, name)) for name in varying]
        made.add_row(*cells, *([f"{took[one]:.2g}"] if took else []))
    show(made)
    if len(shown) < len(everything):
        click.echo(f"... and {len(everything) - len(shown)} more conditions")
    fixed = [f"{n} {getattr(everything[0], n)}" for n in names if n not in varying and n != "team"]
    if fixed:
        click.echo(f"all: {', '.join(fixed)}")


def _print_estimate(found: Estimate, conditions: int, workers: int | None) -> None:
    from multisrt.experiments.live import duration
    from multisrt.experiments.runner import cores

    number = workers or cores()
    times = [duration(s / number) for s in (found.computing_s, found.low_s, found.high_s)]
    tried = len(found.probes)
    click.echo(
        f"estimate: {times[0]} with {number} worker{'s' * (number != 1)} "
        f"({times[1]} to {times[2]})\n"
        f"  from one run each of {tried} of {conditions} conditions, in {duration(found.took_s)}"
        + ("; the others from their labels" if tried < conditions else "")
    )
    if found.cut_off:
        click.echo(
            f"  {found.cut_off} of them did not end in time: it will take longer; allow more "
            "--seconds"
        )


def _failures(probes: Sequence[Result]) -> dict[Condition, str]:
    return {
        probe.condition: f"{probe.status}: {probe.account}"
        for probe in probes
        if probe.failed and probe.status != "over_time"
    }
