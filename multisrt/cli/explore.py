"""`multisrt explore`: run an exploration, or several strategies side by side."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from multisrt.cli.given import DRIVES, FAULTS, OVERRIDES, spec_of_file, spec_of_words
from multisrt.cli.progress import Progress
from multisrt.cli.summary import print_summary

if TYPE_CHECKING:
    from multisrt.run import Run
    from multisrt.spec import RunSpec

NOT_COMPLETE = 3
"""Exit code where an exploration stalled or ran out of time."""

EXAMPLES = """
\b
Examples:
  multisrt explore office
  multisrt explore museum --robots 4 --starts clustered --radio-range 15
  multisrt explore museum --robots 4 --strategy srt-radial --strategy srt-star --out compared
  multisrt explore office --strategy minpos --robots 4 --radio-range 15
  multisrt explore floor.yaml --start 2.5,4 --start 3.5,4 --range 6
  multisrt explore plan.png --resolution 0.05 --footprint box:0.6x0.4 --drive reeds-shepp
  multisrt explore office --robots 3 --fault death:2@30:moving --fault late:1@60 --loss 0.1
  multisrt explore office --robot footprint=box:0.6x0.4,range=6 --robot speed=1
  multisrt explore --spec runs/office-srt-radial-0/spec.toml --out again

\b
The output folder gets, with several strategies in a folder each:
  tree.svg         the trees or ways, with one layer for each thing drawn
  run.json         spec, outcome, digest and metrics
  spec.toml        the spec, which repeats the run
  recording.jsonl  all that happened, one event a line

Exit code: 0 complete, 3 stalled or out of time, 2 bad input.
"""


@click.command(epilog=EXAMPLES)
@click.argument("environment", metavar="ENV", required=False)
@click.option(
    "--strategy",
    "strategies",
    multiple=True,
    default=["srt-radial"],
    show_default=True,
    metavar="NAME",
    help="How to explore; repeat to run several and compare them.",
)
@click.option("--seed", default=0, show_default=True, help="Seeds every random stream.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Where results go.  [default: runs/ENV-STRATEGY-SEED]",
)
@click.option(
    "--spec",
    "spec_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Run a spec (TOML or JSON), which says all but --out and --quiet.",
)
@click.option("--robots", type=int, metavar="N", help="How many robots.  [default: 1]")
@click.option(
    "--starts",
    type=click.Choice(["scattered", "clustered"]),
    default="scattered",
    show_default=True,
    help="How places are drawn for robots without --start.",
)
@click.option(
    "--start",
    multiple=True,
    metavar="X,Y[,HEADING]",
    help="Where a robot starts (m, rad); repeat for a team.",
)
@click.option("--range", "range_m", default=4.0, show_default=True, help="Sensor range (m).")
@click.option("--beams", type=int, help="Beams of a laser.  [default: exact sensor]")
@click.option(
    "--footprint",
    default="disc:0.25",
    show_default=True,
    help="Body: disc:R, box:LxW or 'polygon:x,y x,y ...' (m).",
)
@click.option(
    "--drive",
    type=click.Choice(DRIVES),
    default="differential",
    show_default=True,
    help="How the body moves; the last two are cars.",
)
@click.option("--speed", default=0.5, show_default=True, help="Greatest speed (m/s).")
@click.option("--turning-radius", type=float, help="Tightest curve of a car (m).  [default: 0.6]")
@click.option(
    "--robot",
    multiple=True,
    metavar="KEY=VALUE,...",
    help=f"What is different with one robot; repeat, in order. Keys: {', '.join(OVERRIDES)}.",
)
@click.option("--radio-range", type=float, help="Range of the radio (m).  [default: unlimited]")
@click.option("--no-multi-hop", is_flag=True, help="Robots do not relay messages.")
@click.option("--latency", default=0.0, show_default=True, help="Time that a message takes (s).")
@click.option("--jitter", default=0.0, show_default=True, help="Up to so much more time (s).")
@click.option("--loss", default=0.0, show_default=True, help="Share of messages lost, from 0 to 1.")
@click.option(
    "--walls",
    type=click.Choice(["pass", "block", "weaken"]),
    default="pass",
    show_default=True,
    help="What walls do to the radio.",
)
@click.option("--fault", "faults", multiple=True, metavar="FAULT", help=f"{FAULTS}; repeat.")
@click.option("--resolution", type=float, help="Metres per pixel of an image without its own (m).")
@click.option("--threshold", type=float, help="Lightness from 0 to 1 above which a pixel is free.")
@click.option("--max-time", type=float, help="End the run at this time (s).")
@click.option(
    "--option",
    "options",
    multiple=True,
    metavar="KEY=VALUE",
    help="A parameter of the strategy; see 'multisrt strategies'.",
)
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
@click.pass_context
def explore(
    context: click.Context,
    /,
    environment: str | None,
    strategies: tuple[str, ...],
    out: Path | None,
    spec_file: Path | None,
    quiet: bool,
    **given: Any,
) -> None:
    """Explore a world and leave a picture, the metrics and the recording.

    ENV is a name that 'multisrt environments' lists, or a map file: a ROS map_server YAML, an
    image with --resolution (its origin is the lower left corner), GeoJSON or WKT.
    """
    if spec_file is not None:
        _require_nothing_else(context)
        specs = [spec_of_file(spec_file)]
        name = spec_file.stem
    elif environment is None:
        raise click.UsageError("name a world (ENV), or a spec (--spec FILE)")
    else:
        if len(set(strategies)) < len(strategies):
            raise click.BadParameter("a strategy is named twice", param_hint="--strategy")
        specs = [spec_of_words(environment, strategy, given) for strategy in strategies]
        name = Path(environment).stem
    folders = _folders(specs, out, name)
    runs = _run_all(specs, folders, quiet)
    if not quiet:
        print_summary(runs, folders)
    if any(run.outcome != "complete" for run in runs):
        raise SystemExit(NOT_COMPLETE)


def _require_nothing_else(context: click.Context) -> None:
    for parameter in context.command.params:
        name = parameter.name
        if name is None or name in ("spec_file", "out", "quiet"):
            continue
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            raise click.UsageError(
                f"--spec says everything: leave out {parameter.make_metavar(context)}"
                if isinstance(parameter, click.Argument)
                else f"--spec says everything: leave out {parameter.opts[0]}"
            )


def _folders(specs: list[RunSpec], out: Path | None, name: str) -> list[Path]:
    if len(specs) == 1:
        spec = specs[0]
        return [out or Path("runs") / f"{name}-{spec.strategy}-{spec.seed}"]
    return [(out or Path("runs") / f"{name}-{spec.seed}") / spec.strategy for spec in specs]


def _run_all(specs: list[RunSpec], folders: list[Path], quiet: bool) -> list[Run]:
    from multisrt.cli.output_folder import output_folder
    from multisrt.robots.registry import strategy
    from multisrt.run import RECORDING_NAME, RUN_NAME, SPEC_NAME, TREE_NAME, Run
    from multisrt.simulation.simulate import simulate
    from multisrt.simulation.worlds import build_environment

    # What is wrong with the last one is told before the first one runs.
    for spec in specs:
        strategy(spec.strategy).parse_options(spec.options)
    runs = []
    with Progress(quiet) as progress:
        progress.say("reading the world")
        world = build_environment(specs[0].environment)
        for spec, out in zip(specs, folders, strict=True):
            with output_folder(out) as folder:
                watch = progress.watcher(spec, world)
                run = Run(simulate(spec, world, path=folder / RECORDING_NAME, watch=watch), world)
                progress.say(f"{spec.strategy}: measuring and drawing")
                run.save_svg(folder / TREE_NAME)
                run.save_summary(folder / RUN_NAME)
                run.save_spec(folder / SPEC_NAME)
            runs.append(run)
    return runs
