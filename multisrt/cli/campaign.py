"""`multisrt campaign`: missions of all kinds that try to break the program."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from multisrt.cli import candidates
from multisrt.cli.mistakes import CommandGroup
from multisrt.cli.output_options import quiet_option

if TYPE_CHECKING:
    from multisrt.campaign.lane import Found, Mission
    from multisrt.campaign.running import Progress
    from multisrt.campaign.store import Row
    from multisrt.campaign.violations import Violation

VIOLATED = 1
"""Exit code if an invariant does not hold."""

MAX_FAILURES = 20
"""Failures that are listed; the others are only counted."""

EXAMPLES = """
\b
Examples:
  multisrt campaign run --missions 1000
  multisrt campaign run --for 2h --workers 2 --seed 7 --store night.sqlite
  multisrt campaign show night.sqlite
  multisrt campaign invariants
  multisrt campaign replay night-failures/000123-no-collision
"""


class Duration(click.ParamType[float]):
    """A duration: ``90s``, ``15m``, ``1.5h`` or ``1h30m``."""

    name = "duration"
    _UNITS: Final = {"d": 86_400.0, "h": 3600.0, "min": 60.0, "m": 60.0, "s": 1.0}
    _PART: Final = rf"(\d+(?:\.\d+)?) ?({'|'.join(_UNITS)})"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return it in seconds."""
        if isinstance(value, float):
            return value
        text = str(value).strip()
        is_one = re.fullmatch(rf"{self._PART}(?: ?{self._PART})*", text) is not None
        parts = re.findall(self._PART, text) if is_one else []
        duration_s = sum(float(number) * self._UNITS[unit] for number, unit in parts)
        if duration_s == 0.0:
            self.fail(f"{value!r} is not a duration such as 90s, 15m or 1h30m", param, ctx)
        return duration_s


@click.group(cls=CommandGroup, epilog=EXAMPLES)
def campaign() -> None:
    """Test the program with random runs.

    Each mission is a run drawn from a seed: its world, team, radio, faults, strategy and options.
    It is checked against invariants, which must hold in every run.
    """


@campaign.command()
@click.option(
    "--missions",
    type=click.IntRange(1),
    metavar="N",
    help="Number of missions, including those that are stored.",
)
@click.option(
    "--for",
    "for_s",
    type=Duration(),
    metavar="TIME",
    help="Start no more missions after this time: 90s, 15m, 1h30m.",
)
@click.option(
    "--workers", type=click.IntRange(1), default=1, show_default=True, help="Number of processes."
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    metavar="S",
    help="Seed of the campaign.  [default: that of the store, 0 for a new one]",
)
@click.option(
    "--store",
    type=click.Path(path_type=Path),
    default=Path("campaign.sqlite"),
    show_default=True,
    metavar="FILE",
    help="File for the missions; the same command continues it.",
)
@click.option(
    "--shrink",
    type=click.IntRange(0),
    default=3,
    show_default=True,
    metavar="N",
    help="Number of failures to shrink for each invariant and strategy.",
)
@click.option("--stop-at-first", is_flag=True, help="End with the first mission that fails.")
@quiet_option("failures and the table")
def run(
    missions: int | None,
    for_s: float | None,
    workers: int,
    seed: int | None,
    store: Path,
    shrink: int,
    stop_at_first: bool,
    quiet: bool,
) -> None:
    """Execute missions and check them.

    Mission K of a seed is the same whatever their number. Each is stored when it is checked; after
    an interruption the same command continues. Failures are shrunk, and saved in folders next to
    the store, with the spec, the recording and a replay.

    \b
    Examples:
      multisrt campaign run --missions 1000
      multisrt campaign run --for 2h --workers 2 --seed 7 --store night.sqlite

    \b
    Exit code:
      0  all invariants hold   1  some do not   2  bad input   130  interrupted
    """
    from multisrt.campaign.running import run_campaign
    from multisrt.campaign.store import CampaignStore
    from multisrt.geometry.errors import counted
    from multisrt.terminal import LiveLine

    if missions is None and for_s is None:
        raise click.UsageError("give --missions or --for: a campaign needs an end")
    with CampaignStore.create_or_open(store, seed) as opened:
        try:
            with LiveLine(not quiet, f"campaign {opened.seed}", counted=True) as live:
                run_campaign(
                    opened,
                    missions=missions,
                    for_s=for_s,
                    workers=workers,
                    shrunk_each=shrink,
                    stop_at_first=stop_at_first,
                    progress=_watch(live.update, live.tell if live.rewritten else click.echo),
                )
        except KeyboardInterrupt:
            done = len(opened.done())
            verb = "is" if done == 1 else "are"
            stored = f"{counted(done, 'mission')} {verb} stored in {store}"
            click.echo(f"{stored}; the same command continues", err=True)
            raise click.Abort from None
        failed = _show_table(opened.rows())
    click.echo(f"missions: {store}")
    if failed:
        raise SystemExit(VIOLATED)


def _watch(update: Callable[..., None], tell: Callable[[str], None]) -> Callable[[Progress], None]:
    from multisrt.campaign.lane import Found
    from multisrt.experiments.live import duration
    from multisrt.geometry.errors import counted

    shrinking: set[int] = set()

    def watch(now: Progress) -> None:
        if isinstance(now.latest, Found):
            shrinking.add(now.latest.number)
        elif now.latest is not None:
            shrinking.discard(now.latest.number)
        parts = [counted(now.done, "mission")] if now.total is None else []
        if now.failed:
            parts.append(f"{now.failed} failed")
        if now.made:
            parts.append(f"{now.made / now.elapsed_s * 3600.0:,.0f} an hour".replace(",", " "))
            if now.total is not None and now.total > now.done:
                left_s = (now.total - now.done) * now.elapsed_s / now.made
                parts.append(f"{duration(left_s)} left")
        if shrinking:
            parts.append(f"shrinks mission {', '.join(map(str, sorted(shrinking)))}")
        update(total=now.total, completed=now.done, note=", ".join(parts) or "starting")
        for line in [] if now.latest is None else _failures(now.latest):
            tell(line)

    return watch


def _failures(latest: Mission | Found) -> Iterable[str]:
    # What a mission violates when it is found; then the folder of each failure.
    from multisrt.campaign.lane import Found

    if isinstance(latest, Found):
        for violation in latest.violations:
            yield _line(latest.number, violation.invariant, violation.says, "")
        return
    for violation, folder in zip(latest.verdict.violations, latest.folders, strict=True):
        if folder:
            yield f"mission {latest.number}: {_command(folder)}"
        else:  # it was not drawn: there is nothing to shrink
            yield _line(latest.number, violation.invariant, violation.says, "")


def _line(number: int, invariant: str, says: str, folder: str) -> str:
    return f"mission {number}: {invariant}: {says}" + (f"; {_command(folder)}" if folder else "")


def _command(folder: str) -> str:
    return f"multisrt campaign replay {shlex.quote(folder)}"


def _found_again(store: Path, folder: str) -> str:
    # The folder of a failure: beside its store, which may have been moved, or where it was made.
    from multisrt.campaign.running import failures_of

    places = (failures_of(store) / Path(folder).name, Path(folder)) if folder else ()
    return next((str(place) for place in places if place.is_dir()), "")


def _show_table(rows: Iterable[Row]) -> int:
    """Print what the missions came to; return the number of those that failed."""
    from multisrt.campaign.summary import further, summary
    from multisrt.cli.tables import show_blocks
    from multisrt.geometry.errors import counted

    found = summary(rows)
    if not found:
        click.echo("no mission is stored yet")
        return 0
    every = found[-1]
    headings = ["strategy", ">missions", *(f">{name}" for name in every.outcomes), ">s (median)"]
    headings += [f">{name}" for name in every.violations]
    table = [
        [
            each.strategy,
            str(each.missions),
            *(str(each.outcomes.get(name, 0)) for name in every.outcomes),
            f"{each.median_s:.2f}",
            *(str(each.violations.get(name, 0)) for name in every.violations),
        ]
        for each in found
    ]
    show_blocks(headings, table)
    click.echo(
        f"{counted(every.missions, 'mission')}, {every.failed:,} of them failed; "
        f"{further(every.repeated, every.refused)}"
    )
    return every.failed


@campaign.command()
@click.argument(
    "store",
    metavar="STORE",
    type=click.Path(path_type=Path),
    shell_complete=candidates.files_named(".sqlite"),
)
@click.option(
    "--number",
    type=click.IntRange(0),
    metavar="K",
    help="Print the spec of mission K instead, as TOML.",
)
def show(store: Path, number: int | None) -> None:
    """Print the results of a campaign, or the spec of a mission.

    \b
    Examples:
      multisrt campaign show night.sqlite
      multisrt campaign show night.sqlite --number 123 > mission.toml
      multisrt explore --spec mission.toml
    """
    from multisrt.campaign.draws import draw
    from multisrt.campaign.store import CampaignStore
    from multisrt.geometry.errors import InvalidInputError

    with CampaignStore.open(store) as opened:
        if number is not None:
            if not opened.is_of_this_program:
                raise InvalidInputError(
                    f"{store} was made by another version of this program, which drew other "
                    "missions; those that failed are in the folders beside it"
                )
            if number not in opened.done():
                click.echo(f"mission {number} is not in {store}: not executed yet", err=True)
            click.echo(draw(opened.seed, number).to_toml(), nl=False)
            return
        rows = list(opened.rows())
    _show_table(rows)
    failures = [
        _line(row.number, violation.invariant, violation.says, _found_again(store, folder))
        for row in rows
        for violation, folder in zip(row.violations, row.folders, strict=True)
    ]
    for line in failures[:MAX_FAILURES]:
        click.echo(line)
    if len(failures) > MAX_FAILURES:
        click.echo(f"... and {len(failures) - MAX_FAILURES} more")


def _moment(violations: Iterable[Violation]) -> str:
    # The part of a link at which a replay opens at the first violation that has a time.
    for violation in violations:
        if violation.time_s is not None:
            robot = "" if violation.robot is None else f"&robot={violation.robot}"
            return f"#t={violation.time_s:.2f}{robot}"
    return ""


@campaign.command()
def invariants() -> None:
    """List the invariants that every mission is checked against.

    \b
    Examples:
      multisrt campaign invariants
    """
    from multisrt.campaign.listing import descriptions
    from multisrt.cli.tables import show, table

    made = table("invariant", "description")
    for name, text in descriptions().items():
        made.add_row(name, text)
    show(made)


@campaign.command()
@click.argument("failure", metavar="FAILURE", type=click.Path(path_type=Path))
def replay(failure: Path) -> None:
    """Repeat a failure, and report whether it still fails.

    FAILURE is a folder that 'multisrt campaign run' wrote. If it still fails, its recording and its
    replay are rewritten; nothing is opened.

    \b
    Examples:
      multisrt campaign replay night-failures/000123-no-collision

    \b
    Exit code:
      0  it no longer fails   1  an invariant is violated   2  bad input
    """
    from multisrt.campaign.failure import (
        FAILURE_NAME,
        REPLAY_NAME,
        folder_of,
        read_failure,
    )
    from multisrt.campaign.lane import replayed
    from multisrt.campaign.listing import require_invariant
    from multisrt.campaign.shrinking import is_alike
    from multisrt.geometry.errors import InvalidInputError

    found, spec = read_failure(failure)
    folder = folder_of(failure)
    try:
        require_invariant(found.invariant)
    except InvalidInputError as error:
        raise InvalidInputError(f"{folder / FAILURE_NAME}: {error}") from None
    violations = replayed(spec, folder, found.violation)
    still = [violation for violation in violations if is_alike(violation, found.violation)]
    click.echo(f"failed with: {found.invariant}: {found.says}")
    for violation in violations:
        prefix = "still fails" if violation in still else "fails differently"
        click.echo(f"{prefix}: {violation.invariant}: {violation.says}")
    if not violations:
        click.echo("does not fail any more")
    if (page := folder / REPLAY_NAME).is_file():
        click.echo(f"{page}{_moment(violations)}")
    if violations:
        raise SystemExit(VIOLATED)
