"""`multisrt explore`: run one exploration, or several strategies side by side."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from multisrt.analysis.progress import Progress
from multisrt.cli import candidates
from multisrt.cli.imports import (
    import_all,
    import_option,
    named_check,
    named_strategy,
    require_known,
)
from multisrt.cli.layers import without_option
from multisrt.cli.output_options import REPLAY_NAME, force_option, out_folder, quiet_option
from multisrt.cli.outputs import (
    new_folder,
    remove_made_of_run,
    require_no_file,
    require_no_run,
    run_folder,
    stem_of,
)
from multisrt.cli.own_map import world_options
from multisrt.cli.run_options import DRIVES, FAULTS, OVERRIDES, USUAL, spec_of_options
from multisrt.cli.sections import SectionedCommand
from multisrt.cli.spec_files import read_run_spec
from multisrt.cli.summary import print_summary, robot_to_ask
from multisrt.cli.view import MAX_RUNS, live_page, open_page, require_few, write_page
from multisrt.cli.watching import Watching, require_terminal
from multisrt.geometry.errors import InvalidInputError

if TYPE_CHECKING:
    from multisrt.finished_run import Run
    from multisrt.informed.reference import Regret
    from multisrt.replay import LiveReplay
    from multisrt.spec import RunSpec

NO_SUCCESS = 3
"""Exit code if an exploration is not a success."""

OWN_WORLD = "apartment"
"""The environment that a user-defined strategy explores if none is named."""

SECTIONS = {
    "Run": ("--strategy", "--import", "--option", "--seed", "--max-time", "--spec"),
    "Team": ("--robots", "--starts", "--start", "--robot", "--fault"),
    "Robots": ("--range", "--beams", "--footprint", "--drive", "--speed", "--turning-radius"),
    "Radio": (
        *("--radio-range", "--no-multi-hop", "--latency", "--jitter", "--loss", "--walls"),
        "--base",
    ),
    "Generators": ("--set",),
    "Image maps": ("--resolution", "--threshold", "--starts-from"),
    "Output": (
        *("--out", "--force", "--view", "--live", "--no-open", "--watch"),
        *("--without", "--regret", "--details", "--quiet"),
    ),
}
"""Headings of the help page, and the options below each."""

EXCEPT_SPEC = (
    *("spec_file", "imports", "out", "without", "force", "view", "live", "no_open"),
    *("watch", "regret", "details", "quiet"),
)
"""Parameters that a spec does not describe."""

EXAMPLES = """
\b
Examples:
  multisrt explore office
  multisrt explore museum --robots 4 --starts clustered --radio-range 15
  multisrt explore museum --robots 4 --strategy srt-radial --strategy srt-star
  multisrt explore office --robots 4 --strategy minpos --view
  multisrt explore dungeon --set difficulty=0.8 --set size_m=30 --set seed=3
  multisrt explore museum --robots 4 --live
  multisrt explore museum --robots 4 --watch
  multisrt explore floor.yaml --start 2.5,4 --start 3.5,4 --range 6
  multisrt explore plan.png --resolution 0.05 --footprint box:0.6x0.4
  multisrt explore office --robots 3 --radio-range 15 --base 2,3
  multisrt explore office --radio-range 9 --base 2,3 --option home=worth
  multisrt explore office --robots 3 --fault death:2@30 --fault late:1@60
  multisrt explore office --robot footprint=disc:0.3,range=6 --robot speed=1
  multisrt explore museum --robots 4 --without outlines --without nodes
  multisrt explore mine.py:Mine --robots 3
  multisrt explore museum --strategy mine.py:Mine --strategy minpos
  multisrt explore --spec runs/office-srt-radial-0/spec.toml --out again
  multisrt explore --spec runs/office-mine-0/spec.toml --import mine.py

\b
Files written, with several strategies in one folder each:
  tree.svg         the exploration trees or trajectories, in layers
  run.json         spec, outcome, digest and metrics
  spec.toml        the spec; 'multisrt explore --spec' repeats the run
  recording.jsonl  every event of the run, one per line
  replay.html      with --view or --live: the replay of all strategies

\b
Exit code:
  0  every run succeeded: 95 % covered, no collision   2    bad input
  3  a run did not succeed, however it ended           130  interrupted
"""


# Every default is that of the specs: an option that is not given is not passed on. The values in
# brackets are for people; a test compares them with the specs, whose import would delay the help.
@click.command(cls=SectionedCommand, sections=SECTIONS, epilog=EXAMPLES)
@click.argument("environment", metavar="[ENV]", required=False, shell_complete=candidates.worlds)
@click.option(
    "--strategy",
    "strategies",
    multiple=True,
    metavar="NAME",
    shell_complete=candidates.strategies,
    help="Strategy, or FILE.py:CLASS or MODULE:CLASS for one of your own; repeat it to run several "
    "and compare them.  [default: srt-radial]",
)
@import_option
@click.option(
    "--option",
    "options",
    multiple=True,
    metavar="KEY=VALUE",
    shell_complete=candidates.options,
    help="Option of the strategy, as 'multisrt strategies NAME' lists them; repeatable.",
)
@click.option("--seed", type=int, help="Seed of all random streams.  [default: 0]")
@click.option(
    "--max-time", type=float, help="Simulated time at which a run is stopped (s).  [default: 86400]"
)
@click.option(
    "--spec",
    "spec_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Run this spec (TOML or JSON), instead of ENV and all options but those of output.",
)
@click.option("--robots", type=int, metavar="N", help="Number of robots.  [default: 1]")
@click.option(
    "--starts",
    type=click.Choice(["scattered", "clustered", "random", "suggested", "base"]),
    help="Where robots without a start of their own (--start, --robot start=X,Y) start; suggested: "
    "by the map file; base: around the base station.  [default: scattered]",
)
@click.option(
    "--start",
    multiple=True,
    metavar="X,Y[,HEADING]",
    help="Start of a robot (m, rad); repeat it for a team.",
)
@click.option(
    "--robot",
    multiple=True,
    metavar="KEY=VALUE,...",
    shell_complete=candidates.robots,
    help="Values that differ for one robot; once for each robot, in order. Keys: "
    f"{', '.join(OVERRIDES)}; '{USUAL}' if nothing differs.",
)
@click.option(
    "--fault",
    "faults",
    multiple=True,
    metavar="FAULT",
    shell_complete=candidates.faults,
    help=f"A fault, times in seconds; repeatable: {FAULTS}.",
)
@click.option("--range", "range_m", type=float, help="Range of the range finder (m).  [default: 4]")
@click.option(
    "--beams",
    type=int,
    help="Beams of the range finder.  [default: none, the exact visibility polygon]",
)
@click.option(
    "--footprint",
    help="Body (m): disc:R, box:LxW or 'polygon:x,y x,y ...'.  [default: disc:0.25]",
)
@click.option(
    "--drive",
    type=click.Choice(DRIVES),
    help="Kinematics; the last two are cars.  [default: differential]",
)
@click.option("--speed", type=float, help="Speed (m/s).  [default: 0.5]")
@click.option(
    "--turning-radius", type=float, help="Minimum turning radius of a car (m).  [default: 0.6]"
)
@click.option(
    "--radio-range", type=float, help="Range of the radio (m).  [default: none, unlimited]"
)
@click.option("--no-multi-hop", is_flag=True, help="Robots do not relay messages.")
@click.option("--latency", type=float, help="Delay of every message (s).  [default: 0]")
@click.option("--jitter", type=float, help="Maximum random additional delay (s).  [default: 0]")
@click.option(
    "--loss", type=float, help="Probability that a message is lost, below 1.  [default: 0]"
)
@click.option(
    "--walls",
    type=click.Choice(["pass", "block", "weaken"]),
    help="Effect of walls on the radio signal.  [default: pass]",
)
@click.option(
    "--base",
    metavar="X,Y",
    help="Base station (m), which robots reach by radio; adds measures of what it knows. Robots "
    "drive there with --option home=in-time, worth, relays or chain.",
)
@world_options
@out_folder("the results", "runs/ENV-STRATEGY-SEED, with a number if it exists")
@force_option("the run in DIR")
@without_option("map")
@click.option(
    "--view",
    is_flag=True,
    help="Replay the runs in a browser when they have ended; writes replay.html.",
)
@click.option(
    "--live",
    is_flag=True,
    help="Replay the runs in a browser during the runs: the page of --view, rewritten every few "
    "seconds.",
)
@click.option(
    "--no-open", is_flag=True, help="Do not open the page of --view or --live in a browser."
)
@click.option(
    "--regret",
    is_flag=True,
    help="Compare with a plan that knows the map; computing it takes up to a minute.",
)
@click.option(
    "--details",
    is_flag=True,
    help="Print all measures, not only the main ones; with more than two runs, a line for each.",
)
@click.option("--watch", is_flag=True, help="Draw the team in the terminal while it runs.")
@quiet_option()
@click.pass_context
def explore(
    context: click.Context,
    /,
    environment: str | None,
    strategies: tuple[str, ...],
    imports: tuple[str, ...],
    out: Path | None,
    spec_file: Path | None,
    force: bool,
    quiet: bool,
    without: tuple[str, ...],
    **given: Any,
) -> None:
    """Explore an environment with one robot or a team.

    Writes a picture, the metrics and the recording of the run.

    ENV is a name that 'multisrt environments' lists, a world of a suite (indoor-30/07), or a map
    file: a ROS map_server YAML, an image with --resolution (its origin is the lower left corner),
    GeoJSON, WKT, SVG, DXF, a numpy array, a world of Stage, a grid or scenario of MovingAI, IMR
    polygons or HouseExpo. If it is FILE.py:CLASS or MODULE:CLASS, this strategy of your own
    explores the apartment.
    """
    from multisrt.experiments.results import is_success
    from multisrt.robots.loading import is_reference

    if force and out is None:
        raise click.UsageError("--force replaces the run in --out DIR, which is not given")
    progress = _progress(watch=given["watch"], quiet=quiet)
    _require_opened(given)
    import_all(imports)
    own = environment if environment is not None and is_reference(environment) else None
    if own is not None:
        if strategies:
            raise click.UsageError(
                f"{own} is a strategy: name an environment (ENV), and give {own} with --strategy"
            )
        environment, strategies = OWN_WORLD, (own,)
    if spec_file is not None:
        _require_nothing_else(context)
        specs = [read_run_spec(spec_file)]
        require_known(specs[0].strategy, spec_file)
        name = spec_file.stem
    elif environment is None:
        raise click.UsageError(
            "name a world (ENV; 'multisrt environments' lists some) or a spec (--spec FILE)"
        )
    else:
        if Path(environment).suffix == ".toml":
            raise click.UsageError(
                f"{environment} is not a map: did you mean --spec {environment}?"
            )
        names = _named(strategies)
        specs = [spec_of_options(environment, name, given) for name in names or (None,)]
        _require_shared_options(specs)
        name = stem_of(environment)
    _require_shown(specs, given)
    usual = _usual_folder(specs, name)
    whole = out or new_folder(usual)
    folders = [whole] if len(specs) == 1 else [whole / spec.strategy for spec in specs]
    for folder in folders:
        require_no_run(folder, force=force)
    page = whole / REPLAY_NAME
    if given["view"] or given["live"]:
        require_no_file(page, force=force)
    kept = page if given["live"] else None
    with live_page(kept, opens=not given["no_open"]) as live:
        runs = _run_all(specs, folders, progress, without, force=force, live=live, keep=kept)
    if force:
        remove_made_of_run(whole, kept)  # of several runs, in the folder above theirs
    if not quiet:
        if own is not None:
            click.echo(
                f"no environment is named: {OWN_WORLD} is explored; for another: multisrt "
                f"explore ENV --strategy {own}"
            )
        regrets = _regrets(runs) if given["regret"] else None
        print_summary(runs, folders, regrets, details=given["details"])
    _show_page(runs, page, given, quiet=quiet)
    if not quiet:
        if out is None and whole != usual:
            click.echo(f"{usual} is there already: this is in {whole}")
        _print_next(runs, whole, folders, given)
    if not all(is_success(run.metrics) for run in runs):
        raise SystemExit(NO_SUCCESS)


def _progress(*, watch: bool, quiet: bool) -> Progress:
    if not watch:
        return Progress(quiet)
    if quiet:
        raise click.UsageError("--watch and --quiet exclude each other: give one of them")
    require_terminal()
    return Watching()


def _require_opened(given: dict[str, Any]) -> None:
    if given["no_open"] and not (given["view"] or given["live"]):
        raise click.UsageError("--no-open needs --view or --live: give one of them")


def _show_page(runs: list[Run], page: Path, given: dict[str, Any], *, quiet: bool) -> None:
    if given["view"] and not given["live"]:
        write_page([run.recording for run in runs], page)
        open_page(page, opens=not given["no_open"])
    if (given["view"] or given["live"]) and not quiet:
        click.echo(page)


def _print_next(runs: list[Run], whole: Path, folders: list[Path], given: dict[str, Any]) -> None:
    if not given["details"]:
        click.echo(f"all measures: in {'each ' * (len(runs) > 1)}run.json, or here with --details")
    if not (given["view"] or given["live"]):
        shown = whole if len(runs) <= MAX_RUNS else folders[0]
        click.echo(f"next: multisrt view {shlex.quote(str(shown))}")
    asked = shlex.quote(str(folders[0]))
    click.echo(f"next: multisrt why {asked} --robot {robot_to_ask(runs[0])}")


def _named(strategies: tuple[str, ...]) -> list[str]:
    names = [named_strategy(text).name for text in strategies]
    if twice := {name for name in names if names.count(name) > 1}:
        raise click.BadParameter(
            f"the strategy {min(twice)} is given twice; FILE.py:CLASS=OTHER gives one of your own "
            "another name, and an experiment compares one with other options ('multisrt "
            "experiment')",
            param_hint="--strategy",
        )
    return names


def _require_shared_options(specs: list[RunSpec]) -> None:
    # Options are for all strategies that are compared: an option of one of them is not dropped.
    import msgspec

    from multisrt.robots.registry import strategy

    for key in specs[0].options:
        known = {
            spec.strategy: msgspec.structs.fields(strategy(spec.strategy).options) for spec in specs
        }
        without = [name for name in known if all(key != field.name for field in known[name])]
        if 0 < len(without) < len(known):
            raise InvalidInputError(
                f"--option {key} applies to all strategies, and {without[0]} has no such option: "
                "run the strategies separately"
            )


def _require_shown(specs: list[RunSpec], given: dict[str, Any]) -> None:
    # What cannot be compared or shown of these runs is reported before they are made.
    if given["regret"]:
        _require_plans(specs)
    if given["view"] or given["live"]:
        require_few(len(specs))


def _require_plans(specs: list[RunSpec]) -> None:
    # Report that no plan fits a team before its runs.
    import msgspec

    from multisrt.robots.registry import strategy

    for spec in specs:
        plan = msgspec.structs.replace(spec, strategy="informed", options={})
        strategy(plan.strategy).require_fit(plan)


def _regrets(runs: list[Run]) -> list[Regret]:
    from multisrt.informed.reference import regret

    with Progress(quiet=False) as progress:
        planning = progress.planning("informed plan")
        return [regret(run.recording, run.metrics, run.environment, planning) for run in runs]


def _require_nothing_else(context: click.Context) -> None:
    for parameter in context.command.params:
        name = parameter.name
        if name is None or name in EXCEPT_SPEC:
            continue
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            given = "ENV" if isinstance(parameter, click.Argument) else parameter.opts[0]
            raise click.UsageError(f"--spec describes the whole run: leave out {given}")


def _usual_folder(specs: list[RunSpec], name: str) -> Path:
    of_one = f"{specs[0].strategy}-" if len(specs) == 1 else ""
    return Path("runs") / f"{name}-{of_one}{specs[0].seed}"


def _run_all(
    specs: list[RunSpec],
    folders: list[Path],
    shown: Progress,
    without: tuple[str, ...],
    *,
    force: bool,
    live: LiveReplay | None,
    keep: Path | None,
) -> list[Run]:
    from multisrt.environments.area_text import extent_text
    from multisrt.finished_run import RECORDING_NAME, RUN_NAME, SPEC_NAME, TREE_NAME, Run
    from multisrt.robots.registry import strategy
    from multisrt.simulation.simulate import simulate
    from multisrt.simulation.worlds import build_environment

    # What the last strategy cannot do is reported before the first one runs.
    for spec in specs:
        strategy(spec.strategy).parse_options(spec.options)
        strategy(spec.strategy).require_fit(spec)
    runs = []
    look = None if live is None else live.look
    with shown as progress:
        progress.say("reading the environment")
        world = build_environment(specs[0].environment)
        progress.tell(f"{world.name}: {extent_text(world.bounds, world.area_m2)}")
        for spec, out in zip(specs, folders, strict=True):
            with run_folder(out, force=force, keep=keep) as folder, named_check(spec.strategy):
                watch = progress.watcher(spec, world)
                path, planning = folder / RECORDING_NAME, progress.planning(spec.strategy)
                recording = simulate(
                    spec, world, path=path, watch=watch, planning=planning, look=look
                )
                run = Run(recording, world)
                if live is not None:
                    live.add(recording)
                progress.say(f"{spec.strategy}: measuring and drawing")
                run.save_svg(folder / TREE_NAME, without=without)
                run.save_summary(folder / RUN_NAME)
                run.save_spec(folder / SPEC_NAME)
            runs.append(run)
    return runs
