"""`multisrt check`: check a user-defined strategy against the contract of explorers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from multisrt.cli import candidates
from multisrt.cli.imports import import_all, import_option
from multisrt.cli.output_options import quiet_option

if TYPE_CHECKING:
    from multisrt.environments.environment import Environment

DEFECT = 1
"""Exit code if the explorer has a defect."""

EXAMPLES = """
\b
Examples:
  multisrt check mine.py
  multisrt check mine.py:Mine --option margin_m=0.05
  multisrt check mine.py --robots 2 --robots 5 --world office
  multisrt check mine --import lab.mine

\b
Exit code:
  0  it keeps to the contract of explorers   2    bad input
  1  it has a defect, or a warning with      130  interrupted
     --strict
"""


# The defaults in brackets are those of `check_explorer`; a test compares them.
@click.command(epilog=EXAMPLES)
@click.argument("strategy", shell_complete=candidates.strategies)
@click.option(
    "--option",
    "options",
    multiple=True,
    metavar="KEY=VALUE",
    shell_complete=candidates.options,
    help="Option of the strategy; repeatable.",
)
@import_option
@click.option(
    "--robots",
    "teams",
    type=click.IntRange(1),
    multiple=True,
    metavar="N",
    help="Number of robots; repeat it for several teams.  [default: 1 and 3]",
)
@click.option(
    "--world",
    "worlds",
    multiple=True,
    metavar="ENV",
    shell_complete=candidates.worlds,
    help="Environment or map file to explore; repeatable.  [default: three small worlds]",
)
@click.option("--seed", type=click.IntRange(0), help="Seed of all runs.  [default: 1]")
@click.option(
    "--max-time",
    type=click.FloatRange(0.0, min_open=True),
    help="Simulated time by which every run must be over (s).  [default: 10000]",
)
@click.option(
    "--max-actions",
    type=click.IntRange(1),
    help="Maximum number of actions of a robot.  [default: 10000]",
)
@click.option(
    "--max-decision",
    type=click.FloatRange(0.0, min_open=True),
    help="Maximum computing time before an action (s).  [default: 10]",
)
@click.option(
    "--anywhere",
    is_flag=True,
    help="Allow bodies to enter space that their robots do not know to be free.",
)
@click.option("--strict", is_flag=True, help="Exit with 1 for a warning, too.")
@quiet_option("defects and warnings")
def check(
    strategy: str,
    options: tuple[str, ...],
    imports: tuple[str, ...],
    teams: tuple[int, ...],
    worlds: tuple[str, ...],
    anywhere: bool,
    strict: bool,
    quiet: bool,
    **limits: Any,
) -> None:
    """Check your own explorer, and report its first defect.

    It explores small worlds, alone and in a team, and every action is checked against the
    contract of explorers. The check stops at the first defect, and reports what the explorer did,
    where, and what to change.

    STRATEGY is a file (mine.py), a class or Strategy in it (mine.py:Mine), one in a module
    (package.module:Mine), or a name that 'multisrt strategies' lists.
    """
    from multisrt.cli.run_options import options_of
    from multisrt.environments.catalog import names
    from multisrt.robots.defects import ExplorerDefect
    from multisrt.robots.registry import is_known
    from multisrt.terminal import LiveLine

    import_all(imports)
    if strategy in names() and not is_known(strategy):
        raise click.UsageError(
            f"{strategy} is an environment, not a strategy: multisrt check STRATEGY --world "
            f"{strategy}"
        )
    with LiveLine(not quiet, f"check {strategy}") as live:
        from multisrt.testing import check_explorer

        def progress(what: str, done: int, total: int) -> None:
            live.update(description=what, completed=done, total=total)

        fields = {"max_time": "max_time_s", "max_decision": "max_decision_s"}
        given: dict[str, Any] = {
            fields.get(name, name): value for name, value in limits.items() if value is not None
        }
        if teams:
            given["teams"] = teams
        try:
            checked = check_explorer(
                strategy,
                options=options_of(options),
                worlds=[_world(name) for name in worlds] or None,
                only_known=not anywhere,
                progress=progress,
                **given,
            )
        except ExplorerDefect as defect:
            click.echo(f"defect: {defect.where}:\n  {defect.what}\n  {defect.remedy}", err=True)
            raise SystemExit(DEFECT) from None
    if not quiet:
        click.echo(str(checked))
    elif checked.warnings:
        click.echo("\n".join(f"WARNING: {warning}" for warning in checked.warnings), err=True)
    if strict and checked.warnings:
        raise SystemExit(DEFECT)


def _world(name: str) -> Environment:
    from multisrt.simulation.worlds import build_environment, environment_spec

    return build_environment(environment_spec(name))
