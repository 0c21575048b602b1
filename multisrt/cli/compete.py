"""`multisrt compete`: run a strategy in the simulator of the indoor exploration competition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from multisrt.cli.output_options import out_folder, quiet_option

if TYPE_CHECKING:
    from multisrt.competition.jobs import Job, JobResult

EXAMPLES = """
\b
Examples:
  multisrt compete iec --maps env1 --robots 1 --draws 1
  multisrt compete iec
  multisrt compete iec --strategy minpos --maps env3,env4 --robots 2-5
  multisrt compete iec --policy mine.py --maps env1 --start 181,106
  multisrt compete iec --policy-out policy.py

\b
Exit code:
  0  all runs ended   2  bad input   130  interrupted; can be continued
"""


class _Numbers(click.ParamType[tuple[int, ...]]):
    """Numbers of robots: ``3``, ``1,3`` or ``2-5``."""

    name = "numbers"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, ...]:
        """Return the numbers in increasing order, without duplicates."""
        if isinstance(value, tuple):
            return value
        found: set[int] = set()
        for part in str(value).split(","):
            first, _, last = part.partition("-")
            if not (first.isdecimal() and (last or first).isdecimal()):
                self.fail(f"{value!r} is not numbers of robots such as 3, 1,3 or 2-5", param, ctx)
            low, high = int(first), int(last or first)
            if not 1 <= low <= high <= 5:
                self.fail(f"{part!r}: the competition has teams of 1 to 5 robots", param, ctx)
            found.update(range(low, high + 1))
        return tuple(sorted(found))


class _Cell(click.ParamType[tuple[int, int]]):
    """A cell of a map: ``column,row``."""

    name = "cell"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """Return column and row."""
        if isinstance(value, tuple):
            return value
        parts = str(value).split(",")
        if len(parts) != 2 or not all(part.strip().isdecimal() for part in parts):
            self.fail(f"{value!r} is not a cell such as 181,106", param, ctx)
        return int(parts[0]), int(parts[1])


@click.command(epilog=EXAMPLES)
@click.argument("clone", type=click.Path(path_type=Path))
@click.option(
    "--strategy",
    metavar="S",
    help="Strategy: gain-home, gain, closest, greedy or minpos.  [default: gain-home]",
)
@click.option(
    "--policy",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="A policy of the competition instead: a file with a class Policy.",
)
@click.option("--maps", metavar="NAMES", help="Maps, as in env1,env3.  [default: all seven]")
@click.option(
    "--robots",
    type=_Numbers(),
    default="1-5",
    metavar="N",
    show_default=True,
    help="Numbers of robots, as in 1, 1,3 or 2-5.",
)
@click.option(
    "--start",
    "starts",
    type=_Cell(),
    multiple=True,
    metavar="X,Y",
    help="Start, as a cell of a single map; repeatable.  [default: drawn]",
)
@click.option(
    "--draws",
    type=click.IntRange(1),
    default=4,
    show_default=True,
    help="Number of starts drawn on each map.",
)
@click.option(
    "--seed", type=click.IntRange(0), default=0, show_default=True, help="Seed of the draws."
)
@click.option("--steps", type=click.IntRange(1), help="Steps of a run.  [default: as published]")
@click.option(
    "--workers", type=click.IntRange(1), default=2, show_default=True, help="Number of processes."
)
@out_folder("the results; the same command continues them", "runs/compete-STRATEGY")
@click.option(
    "--policy-out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write the strategy as a policy file of the competition, without any runs.",
)
@click.option(
    "--as-it-is",
    is_flag=True,
    help="Run the original simulator, without replacing its slowest functions.",
)
@click.option("--any-version", is_flag=True, help="Allow another version of the competition.")
@quiet_option("the scores")
def compete(
    clone: Path,
    strategy: str | None,
    policy: Path | None,
    policy_out: Path | None,
    out: Path | None,
    any_version: bool,
    as_it_is: bool,
    quiet: bool,
    **which: Any,
) -> None:
    """Run a strategy in the simulator of a public competition.

    CLONE is a clone of the repository of the Indoor Exploration Competition (IROS 2026), which
    is not changed. Runs are executed as by its main.py, on its maps and with its numbers of steps,
    scored by its scoring.py, and compared with the published scores of the winners. Runs whose
    results are in the folder are not repeated.
    """
    from multisrt.competition.clone import Clone
    from multisrt.competition.jobs import JobStore
    from multisrt.competition.policies import GAIN_HOME, PolicySource
    from multisrt.competition.running import execute, planned_jobs
    from multisrt.terminal import LiveLine

    if strategy is not None and policy is not None:
        raise click.UsageError("--strategy and --policy exclude each other")
    source = PolicySource.read(policy) if policy else PolicySource.of(strategy or GAIN_HOME)
    found = Clone(clone, any_version=any_version)
    if policy_out is not None:
        _write(policy_out, source.text)
        click.echo(f"{source.name} as a policy file: {policy_out}")
        return
    found.options()
    given = which["maps"].split(",") if which["maps"] else ()
    names = found.maps(tuple(dict.fromkeys(given)))
    plan = {name: which[name] for name in ("draws", "seed", "steps")}
    jobs = planned_jobs(found, names, which["robots"], which["starts"], **plan)
    folder = out or Path("runs") / f"compete-{source.name}"
    store = JobStore(folder, source.digest, found.digest)
    missing = [
        job for job in jobs if job not in store.results or (as_it_is and store.results[job].fast)
    ]
    with LiveLine(not quiet, f"compete {source.name}", counted=True) as live:
        live.update(total=len(jobs), completed=len(jobs) - len(missing))
        done = len(jobs) - len(missing)
        workers = which["workers"]
        for job, result in execute(clone, any_version, source, missing, workers, as_it_is=as_it_is):
            store.add(job, result)
            done += 1
            live.update(
                completed=done,
                note=f"{job.map}, {job.robots} robots: {100 * result.coverage:.1f} %",
            )
    results = {job: store.results[job] for job in jobs}
    table = store.write_table(jobs)
    _show(source.name, results, names, which["robots"])
    if found.changed:
        click.echo(f"not the known version of the competition: {', '.join(found.changed)}")
    click.echo(f"runs: {table}")


def _write(path: Path, text: str) -> None:
    from multisrt.geometry.errors import InvalidInputError

    if path.exists():
        raise InvalidInputError(f"{path} exists; choose another name")
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InvalidInputError(f"cannot write {path}: {error.strerror}") from error


def _show(
    name: str, results: Mapping[Job, JobResult], maps: Sequence[str], robots: Sequence[int]
) -> None:
    """Print the scores, and which modules and functions computed them."""
    import numpy as np

    from multisrt.cli.tables import show, table
    from multisrt.competition.jobs import mean_coverages
    from multisrt.competition.published import MAX_DECISION_S, track, winning_score

    made = table("robots", *(f">{name}" for name in maps), ">mean", ">winner's score")
    tracks: dict[str, list[float]] = {"alone": [], "team": []}
    for number in robots:
        shares = mean_coverages(results, maps, number)
        tracks[track(number)].append(float(np.mean(shares)))
        made.add_row(
            str(number),
            *(f"{share:.2f}" for share in shares),
            f"{np.mean(shares):.2f}",
            f"{winning_score(number, maps):.2f}",
        )
    click.echo(f"{name}: share of the map that the base knows at the end (%)")
    show(made)
    for which, words in (("alone", "alone"), ("team", "in teams")):
        if tracks[which]:
            winner = winning_score(1 if which == "alone" else 2, maps)
            click.echo(f"{words}: {np.mean(tracks[which]):.2f} %, winner's score {winner:.2f} %")
    slowest = max(result.decision_s for result in results.values())
    over = f"; more than {MAX_DECISION_S:g} s is not allowed" if slowest > MAX_DECISION_S else ""
    click.echo(f"decisions: at most {1000.0 * slowest:.1f} ms for a robot and step{over}")
    replaced = sorted({part for result in results.values() for part in result.replaced})
    click.echo(
        "computed by "
        + ("the competition's own modules" if not replaced else "multisrt's exact stand-ins for ")
        + ", ".join(replaced)
    )
    count = sum(result.fast for result in results.values())
    if count:
        click.echo(
            f"{count} of {len(results)} runs with faster functions in place of the simulator's "
            "slowest; --as-it-is runs without"
        )
