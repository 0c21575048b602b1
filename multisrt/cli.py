"""The command line. What a command needs is imported when it runs, so that help comes at once."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from multisrt.run import Run
    from multisrt.spec import RunSpec

COMPLETE, BAD_INPUT, NOT_COMPLETE, INTERRUPTED = 0, 2, 3, 130
"""Exit codes."""

MOSTLY = 0.9
"""Where less of the free space than this can be explored, a person is told so."""

EXPLORE_EXAMPLES = """
\b
Examples:
  multisrt explore office
  multisrt explore museum --strategy srt-star --seed 7 --out museum-star
  multisrt explore floor.yaml --start 2.5,4 --range 6
  multisrt explore plan.png --resolution 0.05 --footprint box:0.6x0.4
  multisrt explore office --option approach=false --option complete=false

\b
The output folder gets:
  tree.svg         the tree, with one layer for each thing drawn
  run.json         spec, outcome, digest and metrics
  recording.jsonl  all that happened, one event a line

Exit code: 0 complete, 3 stalled or out of time, 2 bad input.
"""


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="multisrt")
def cli() -> None:
    """Explore unknown planar worlds with robots, and compare how they do it.

    \b
    Examples:
      multisrt explore office
      multisrt environments
      multisrt strategies
    """


@cli.command(epilog=EXPLORE_EXAMPLES)
@click.argument("environment", metavar="ENV")
@click.option("--strategy", default="srt-radial", show_default=True, help="How to explore.")
@click.option("--seed", default=0, show_default=True, help="Seeds every random stream.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Where results go.  [default: runs/ENV-STRATEGY-SEED]",
)
@click.option(
    "--start",
    "starts",
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
    type=click.Choice(["differential", "holonomic"]),
    default="differential",
    show_default=True,
    help="How the body moves.",
)
@click.option("--speed", default=0.5, show_default=True, help="Greatest speed (m/s).")
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
def explore(environment: str, strategy: str, out: Path | None, quiet: bool, **given: Any) -> None:
    """Explore a world and leave the tree, the metrics and the recording.

    ENV is a name that 'multisrt environments' lists, or a map file: a ROS map_server YAML, an
    image with --resolution (its origin is the lower left corner), GeoJSON or WKT.
    """
    from multisrt.output_folder import output_folder
    from multisrt.run import RECORDING_NAME, RUN_NAME, TREE_NAME, Run
    from multisrt.simulation import simulate
    from multisrt.spec import build_environment

    spec = _spec(environment, strategy, **given)
    if out is None:
        out = Path("runs") / f"{Path(environment).stem}-{strategy}-{spec.seed}"
    with _Progress(quiet) as progress:
        progress.say("reading the world")
        world = build_environment(spec.environment)
        with output_folder(out) as folder:
            watch = progress.watcher(spec, world)
            run = Run(simulate(spec, world, path=folder / RECORDING_NAME, watch=watch), world)
            progress.say("measuring and drawing")
            run.save_svg(folder / TREE_NAME)
            run.save_summary(folder / RUN_NAME)
    if not quiet:
        _print_summary(run, out)
    if run.outcome != "complete":
        raise SystemExit(NOT_COMPLETE)


@cli.group(invoke_without_command=True)
@click.pass_context
def environments(context: click.Context) -> None:
    """List the worlds of the catalogue, or draw one.

    \b
    Examples:
      multisrt environments
      multisrt environments show hospital --out hospital.svg
    """
    if context.invoked_subcommand is not None:
        return
    from multisrt.environments.catalog import catalog

    table = _table("environment", "kind", "size (m)", ">free (m2)", "what it is")
    for entry in catalog():
        size = f"{entry.width_m:.0f} x {entry.height_m:.0f}"
        table.add_row(entry.name, entry.kind, size, f"{entry.area_m2:.0f}", entry.summary)
    _print(table)


@environments.command()
@click.argument("environment", metavar="ENV")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="The picture.  [default: ENV.svg]",
)
@click.option("--resolution", type=float, help="Metres per pixel of an image without its own.")
@click.option("--threshold", type=float, help="Lightness from 0 to 1 above which a pixel is free.")
def show(
    environment: str, out: Path | None, resolution: float | None, threshold: float | None
) -> None:
    """Draw a world of the catalogue or of a map file as SVG."""
    from multisrt.drawing import save_environment_svg
    from multisrt.environments.catalog import catalog
    from multisrt.spec import build_environment, environment_spec

    where = environment_spec(environment, resolution_m=resolution, threshold=threshold)
    world = build_environment(where)
    if out is None:
        out = Path(f"{Path(environment).stem}.svg")
    save_environment_svg(world, out)
    x0, y0, x1, y1 = world.bounds
    click.echo(
        f"{world.name}: {x1 - x0:.4g} x {y1 - y0:.4g} m, {world.area_m2:.4g} m2 free, "
        f"{len(world.free.geoms)} component(s), {len(world.edges)} edges"
    )
    for entry in catalog():
        if entry.name == environment and entry.parameters:
            values = ", ".join(f"{name}={value}" for name, value in entry.parameters)
            click.echo(f"parameters: {values}")
    click.echo(f"drawn in {out}")


@cli.command()
@click.argument("name", required=False)
def strategies(name: str | None) -> None:
    """List the strategies, or one strategy's options and their defaults.

    \b
    Examples:
      multisrt strategies
      multisrt strategies srt-radial
    """
    import msgspec

    from multisrt.registry import strategies as all_strategies
    from multisrt.registry import strategy

    if name is None:
        table = _table("strategy", "what it does")
        for entry in all_strategies():
            table.add_row(entry.name, entry.summary)
        _print(table)
        return
    chosen = strategy(name)
    click.echo(f"{chosen.name}: {chosen.summary}")
    table = _table("option", "default", "what it means")
    meanings = _documented_attributes(chosen.options.__doc__ or "")
    for field in msgspec.structs.fields(chosen.options):
        default = str(field.default).lower() if field.default in (True, False) else field.default
        table.add_row(field.name, str(default), meanings.get(field.name, ""))
    _print(table)


def main() -> None:
    """Run the command line; errors become one line and an exit code."""
    from multisrt.geometry.errors import MultiSrtError

    try:
        result = cli.main(prog_name="multisrt", standalone_mode=False)
    except click.exceptions.Abort:
        _fail("interrupted", INTERRUPTED)
    except click.ClickException as error:
        error.show()
        raise SystemExit(error.exit_code) from None
    except MultiSrtError as error:
        _fail(f"error: {error}", BAD_INPUT)
    raise SystemExit(result if isinstance(result, int) else COMPLETE)


def _fail(message: str, code: int) -> None:
    click.echo(message, err=True)
    raise SystemExit(code)


def _spec(environment: str, strategy: str, **given: Any) -> RunSpec:
    from multisrt.spec import (
        DriveSpec,
        RangeFinderSpec,
        RobotSpec,
        RunSpec,
        StopRule,
        environment_spec,
    )

    drive = DriveSpec(kind=given["drive"], speed_m_s=given["speed"])
    eyes = RangeFinderSpec(range_m=given["range_m"], beams=given["beams"])
    starts: list[Any] = [_start(text) for text in given["starts"]] or [None]
    max_time = given["max_time"]
    return RunSpec(
        environment=environment_spec(
            environment, resolution_m=given["resolution"], threshold=given["threshold"]
        ),
        strategy=strategy,
        options=dict(_key_and_value(text) for text in given["options"]),
        robots=tuple(
            RobotSpec(start=start, footprint=given["footprint"], drive=drive, range_finder=eyes)
            for start in starts
        ),
        stop=StopRule() if max_time is None else StopRule(max_time_s=max_time),
        seed=given["seed"],
    )


def _start(text: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) in (2, 3):
        return numbers
    raise click.BadParameter(f"{text!r} is not X,Y or X,Y,HEADING", param_hint="--start")


def _key_and_value(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals or not key or not value:
        raise click.BadParameter(f"{text!r} is not KEY=VALUE", param_hint="--option")
    return key.strip(), value.strip()


class _Progress:
    """What a person sees while a run goes on: the share covered, on a terminal only."""

    def __init__(self, quiet: bool) -> None:
        self.shown = not quiet and sys.stderr.isatty()

    def __enter__(self) -> _Progress:
        if self.shown:
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

            self.bar = Progress(
                TextColumn("{task.description}"),
                BarColumn(),
                TaskProgressColumn(),
                TextColumn("{task.fields[note]}"),
                console=Console(stderr=True),
                transient=True,
            )
            self.bar.start()
            self.task = self.bar.add_task("starting", total=None, note="")
        return self

    def __exit__(self, *_: object) -> None:
        if self.shown:
            self.bar.stop()

    def say(self, what: str) -> None:
        if self.shown:
            self.bar.update(self.task, description=what, total=None, note="")

    def watcher(self, spec: RunSpec, world: Any) -> Any:
        if not self.shown:
            return None
        from multisrt.events import NodeAdded
        from multisrt.metrics import CoverageMeter
        from multisrt.simulation import start_of

        self.say("preparing (the first run on a machine compiles, up to a minute)")
        starts = tuple(
            start_of(robot, world, spec.seed, number) for number, robot in enumerate(spec.robots)
        )
        meter = CoverageMeter(spec, world, starts)
        nodes = 0

        def watch(event: Any) -> None:
            nonlocal nodes
            if isinstance(event, NodeAdded):
                nodes += 1
                meter.add(event)
                self.bar.update(
                    self.task,
                    description="exploring",
                    total=1.0,
                    completed=meter.share,
                    note=f"{nodes} nodes, {event.time_s:.0f} s",
                )

        return watch


def _print_summary(run: Run, out: Path) -> None:
    from multisrt.run import RECORDING_NAME, RUN_NAME, TREE_NAME

    m = run.metrics
    spec = run.spec
    click.echo(f"{spec.strategy} in {run.environment.name}, seed {spec.seed}: {run.outcome}")
    click.echo(f"  {run.reason}")
    if m.explorable_area_m2 < MOSTLY * m.free_area_m2:
        click.echo(
            f"  the body {spec.robots[0].footprint} gets only to where {m.explorable_area_m2:.1f} "
            f"of {m.free_area_m2:.1f} m2 of free space can be seen"
        )
    table = _table("measure", ">value")
    x, y, _ = run.recording.starts[0]
    rows = (
        ("start", f"({x:.2f}, {y:.2f})"),
        ("covered", f"{m.coverage:.2%} of {m.explorable_area_m2:.1f} m2 explorable"),
        ("free space of the world", f"{m.free_area_m2:.1f} m2"),
        ("map known complete at", _seconds(m.exploration_time_s)),
        ("home at", _seconds(m.makespan_s)),
        ("90, 95, 99 % covered at", _times(m.time_to_90_s, m.time_to_95_s, m.time_to_99_s)),
        ("no run can be shorter than", _seconds(m.lower_bound_s)),
        ("distance", f"{m.total_distance_m:.1f} m"),
        ("nodes", _counted(m.nodes, m.nodes_by_stage)),
        ("frontier arcs given up", _counted(sum(m.arcs_closed.values()), m.arcs_closed)),
        ("collisions", str(m.collisions)),
        ("smallest clearance", f"{m.smallest_clearance_m:.3f} m"),
    )
    for row in rows:
        table.add_row(*row)
    _print(table)
    click.echo(f"{out / TREE_NAME}\n{out / RUN_NAME}\n{out / RECORDING_NAME}")


def _seconds(value: float | None) -> str:
    return "never" if value is None else f"{value:.1f} s"


def _times(*values: float | None) -> str:
    return ", ".join("never" if value is None else f"{value:.0f} s" for value in values)


def _counted(count: int, kinds: dict[str, int]) -> str:
    if not kinds:
        return str(count)
    return f"{count} ({', '.join(f'{n} {kind}' for kind, n in kinds.items())})"


def _documented_attributes(docstring: str) -> dict[str, str]:
    # The "Attributes" section of a numpydoc docstring, one entry a name.
    lines = docstring.partition("Attributes")[2].splitlines()[2:]
    meanings: dict[str, str] = {}
    name = ""
    for line in lines:
        stripped = line.strip()
        if " : " in line and len(line) - len(line.lstrip()) <= 4:
            name = stripped.split(" : ")[0]
            meanings[name] = ""
        elif name:
            meanings[name] = f"{meanings[name]} {stripped}".strip()
    return meanings


def _table(*columns: str) -> Any:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        right = column.startswith(">")
        table.add_column(column.lstrip(">"), justify="right" if right else "left")
    return table


def _print(table: Any) -> None:
    from rich.console import Console

    # Where no terminal says how wide it is, lines are as long as they need to be.
    width = None if sys.stdout.isatty() else 100
    Console(width=width, highlight=False).print(table)


if __name__ == "__main__":
    main()
