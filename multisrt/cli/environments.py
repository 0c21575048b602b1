"""`multisrt environments`: list, draw, check and repair environments."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from multisrt.cli import candidates
from multisrt.cli.mistakes import CommandGroup, is_world
from multisrt.cli.output_options import force_option, height_option, quiet_option
from multisrt.cli.outputs import require_place, require_svg, stem_of
from multisrt.cli.own_map import world_options
from multisrt.cli.reach import areas, around
from multisrt.cli.run_options import world_of_options
from multisrt.cli.tables import show as show_table
from multisrt.cli.tables import table
from multisrt.environments.area_text import area_text, extent_text
from multisrt.environments.written_suffixes import READABLE_SUFFIXES, SUFFIXES

if TYPE_CHECKING:
    from multisrt.environments.environment import Environment

PROBLEM = 1
"""Exit code if the map has a problem for the body."""

SPECK_M = 0.01
"""Default size of the specks that --fix drops, in metres."""

FIXED = [usual for usual, *_ in SUFFIXES.values()]
"""Suffixes of the copies that --fix writes."""

CHECK_EXAMPLES = """
\b
Examples:
  multisrt environments check plan.png --resolution 0.05 --out check.svg
  multisrt environments check office --footprint box:0.6x0.4
  multisrt environments check page.png --resolution 0.05 --start 7,7
  multisrt environments check drawn.geojson --fix clean.geojson
  multisrt environments check scan.yaml --fix scan.wkt --close 0.3

\b
Exit code:
  0  the map suits the body        2    bad input, or rings to be fixed
  1  it does not: 'problem: ...'   130  interrupted
"""


def _meant(words: Sequence[str]) -> Sequence[str]:
    return ("show", *words) if is_world(words[0]) else ()


@click.group(cls=CommandGroup, meant=_meant, invoke_without_command=True)
@click.pass_context
def environments(context: click.Context) -> None:
    """List the environments and suites; draw, check or export one.

    The worlds of a suite are held out for comparisons: NAME/00, NAME/01 and so on.

    \b
    Examples:
      multisrt environments
      multisrt environments show hospital --out hospital.svg
      multisrt environments export hospital --out hospital.yaml
      multisrt environments show indoor-30/07
      multisrt environments check plan.png --resolution 0.05
    """
    if context.invoked_subcommand is not None:
        return
    from multisrt.environments import suites
    from multisrt.environments.catalog import catalog

    listed = table("environment", "kind", "size (m)", ">free (m2)", "description")
    for entry in catalog():
        size = f"{entry.width_m:.0f} x {entry.height_m:.0f}"
        listed.add_row(entry.name, entry.kind, size, f"{entry.area_m2:.0f}", entry.summary)
    show_table(listed)
    kept = table("suite", ">version", ">worlds", "description")
    for name in suites.names():
        suite = suites.load(name)
        kept.add_row(name, str(suite.version), str(len(suite)), suite.about)
    click.echo()
    show_table(kept)


@environments.command()
@click.argument("environment", metavar="ENV", shell_complete=candidates.worlds)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="File for the picture (.svg).  [default: ENV.svg]",
)
@force_option()
@world_options
@quiet_option()
def show(
    environment: str,
    *,
    out: Path | None,
    force: bool,
    quiet: bool,
    **given: Any,
) -> None:
    """Draw an environment as SVG.

    ENV is a name that 'multisrt environments' lists, a world of a suite (indoor-30/07), or a map
    file as for 'multisrt explore'.

    \b
    Examples:
      multisrt environments show hospital --out hospital.svg
      multisrt environments show dungeon --set difficulty=0.8 --set seed=3
      multisrt environments show plan.png --resolution 0.05
    """
    from multisrt.drawing import save_environment_svg
    from multisrt.simulation.worlds import build_environment

    where = world_of_options(environment, given)
    if out is None:
        out = Path(f"{stem_of(environment)}.svg")
    require_svg(out)
    require_place(out, force=force)
    world = build_environment(where)
    save_environment_svg(world, out)
    if not quiet:
        _describe(world, environment)
        click.echo(f"written to {out}")


@environments.command()
@click.argument("environment", metavar="ENV", shell_complete=candidates.worlds)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    required=True,
    metavar="FILE",
    help="Map file, whose suffix determines the format.",
)
@force_option()
@click.option(
    "--cell",
    "cell_m",
    type=float,
    metavar="M",
    help="Width of a pixel of .yaml (m).  [default: 0.05, wider for large worlds]",
)
@height_option()
@world_options
@quiet_option()
def export(
    environment: str,
    *,
    out: Path,
    force: bool,
    cell_m: float | None,
    height_m: float | None,
    quiet: bool,
    **given: Any,
) -> None:
    """Write an environment as a map file.

    ENV is a name that 'multisrt environments' lists, a world of a suite (indoor-30/07), or a map
    file as for 'multisrt explore'.

    \b
    Formats, by the suffix of --out:
      .yaml     ROS map server, with an image .pgm next to it
      .geojson  polygons, with suggested starts; also .json
      .wkt      well-known text: free space only
      .svg      outlines, with suggested starts; for a picture see 'show'
      .dxf      closed outlines in layers, with suggested starts
      .stl      walls as solids
      .glb      walls and floor as solids

    \b
    Examples:
      multisrt environments export hospital --out hospital.yaml --cell 0.1
      multisrt environments export office --out office.geojson
      multisrt environments export plan.png --resolution 0.05 --out plan.dxf
      multisrt environments export maze --out maze.stl --height 2.5
    """
    from multisrt.exporting import MapOptions, save_environment
    from multisrt.exporting.worlds import map_files, map_writer
    from multisrt.geometry.errors import InvalidInputError
    from multisrt.simulation.worlds import build_environment
    from multisrt.terminal import LiveLine

    sizes = {"cell_m": cell_m, "height_m": height_m}
    chosen: dict[str, Any] = {name: m for name, m in sizes.items() if m is not None}
    for name in chosen:
        if name not in map_writer(out).options:
            option = "--cell" if name == "cell_m" else "--height"
            raise InvalidInputError(f"{option} has no meaning for {out.suffix.lower()}")
    options = MapOptions(**chosen)
    where = world_of_options(environment, given)
    files = map_files(out)
    for file in files:
        require_place(file, force=force)
    with LiveLine(not quiet, "building", environment) as live:
        world = build_environment(where)
        live.update(description="writing", note=str(out))
        save_environment(world, out, options=options, overwrite=force)
    if not quiet:
        _describe(world, environment)
        cells = _area_in_cells(world, cell_m) if "cell_m" in map_writer(out).options else ""
        click.echo(f"written to {' and '.join(map(str, files))}{cells}")


def _area_in_cells(world: Environment, cell_m: float | None) -> str:
    """Return how much is free in cells, after a comma; empty if it is as much as in the world."""
    from multisrt.exporting.map_content import MapContent
    from multisrt.exporting.rasters import raster_of

    raster = raster_of(MapContent(environment=world), cell_m)
    in_cells, whole = area_text(raster.free_m2), area_text(world.area_m2)
    if in_cells == whole:
        return ""
    return f", with {in_cells} m2 free in cells of {raster.cell_m:g} m (the world has {whole} m2)"


def _describe(world: Environment, name: str) -> None:
    extent = extent_text(world.bounds, world.area_m2)
    click.echo(f"{world.name}: {extent}, {len(world.edges)} edges, {areas(world)}")
    if world.cleaning:
        click.echo(f"cleaned: {world.cleaning}")
    if world.layers is not None:
        click.echo(world.layers)
    if said := around(world):
        click.echo(said)
    if parameters := _parameters(name):
        click.echo(parameters)


def _parameters(name: str) -> str:
    """Return the parameters of a generator, and how they are set; empty for other worlds."""
    from multisrt.environments.catalog import as_text, default_parameters
    from multisrt.environments.generators.difficulty import KNOB, RANGES

    defaults = (*default_parameters(name), ("seed", 0))
    if len(defaults) == 1:
        return ""
    values = ", ".join(f"{parameter}={as_text(value)}" for parameter, value in defaults)
    besides = f"; also {KNOB}, from 0 to 1" if name in RANGES else ""
    return f"parameters: {values} by default, set by --set NAME=VALUE{besides}"


@environments.command(epilog=CHECK_EXAMPLES)
@click.argument("environment", metavar="ENV", shell_complete=candidates.worlds)
@click.option(
    "--footprint",
    default="disc:0.25",
    show_default=True,
    help="Body (m): disc:R, box:LxW or 'polygon:x,y x,y ...'.",
)
@click.option(
    "--start",
    "starts",
    multiple=True,
    metavar="X,Y[,HEADING]",
    help="Start of a robot (m, rad), which sets the main part; repeat it for a team.",
)
@click.option(
    "--share",
    type=click.FloatRange(0.0, 1.0, min_open=True),
    default=0.95,
    show_default=True,
    help="Share of the main part that a body is to reach.",
)
@click.option(
    "--out", type=click.Path(path_type=Path), metavar="FILE", help="File for a picture (.svg)."
)
@click.option(
    "--fix",
    type=click.Path(path_type=Path),
    metavar="OUT",
    help="Repair rings, drop specks and superfluous vertices, and write a clean copy "
    f"({', '.join(FIXED[:-1])} or {FIXED[-1]}), which is then checked.",
)
@click.option(
    "--specks",
    type=click.FloatRange(0.0),
    metavar="METRES",
    help=f"With --fix: drop obstacles and parts up to this size.  [default: {SPECK_M:g}]",
)
@click.option(
    "--close",
    type=click.FloatRange(0.0),
    metavar="METRES",
    help="With --fix: close passages narrower than this.  [default: none]",
)
@click.option(
    "--simplify",
    type=click.FloatRange(0.0),
    metavar="METRES",
    help="With --fix: remove vertices, moving walls by at most this.  [default: on straight "
    "lines only]",
)
@force_option("FILE and OUT")
@world_options
@quiet_option("problems and errors")
def check(
    environment: str,
    *,
    footprint: str,
    starts: tuple[str, ...],
    share: float,
    out: Path | None,
    fix: Path | None,
    force: bool,
    quiet: bool,
    **given: Any,
) -> None:
    """Check whether a map suits a body, and repair it.

    Reports the size of the map, its separate parts, its narrowest passage, the largest body that
    reaches nearly everything, and what is out of reach of the given body.

    ENV is a name that 'multisrt environments' lists, or a map file as for 'multisrt explore'.
    """
    from multisrt.analysis.map_check import check_map
    from multisrt.cli.map_report import report
    from multisrt.cli.run_options import start_of
    from multisrt.drawing import save_map_check_svg
    from multisrt.exporting import save_environment
    from multisrt.exporting.written import require_suffix
    from multisrt.geometry.bodies.footprint import Footprint
    from multisrt.geometry.configuration import Configuration
    from multisrt.terminal import LiveLine

    body = Footprint.parse(footprint)
    places = [Configuration(*start_of(text, "--start")) for text in starts]
    if fix is not None:
        require_suffix(fix, READABLE_SUFFIXES, "repaired copies")
    if fix is None and (names := [name for name in ("specks", "close", "simplify") if given[name]]):
        raise click.UsageError(f"--{names[0]} requires --fix OUT")
    if out is not None:
        require_svg(out)
    for path in (out, fix):
        if path is not None:
            require_place(path, force=force)
    with LiveLine(not quiet, "check", environment):
        world = _read(environment, given, repair=fix is not None)
        if fix is not None:
            world = _fixed(world, given)
            save_environment(world, fix, overwrite=force)
        checked = check_map(world, body, share=share, starts=places)
    if out is not None:
        save_map_check_svg(checked, out)
    if not quiet:
        click.echo("\n".join(report(checked)))
        for path in filter(None, (fix, out)):
            click.echo(f"written to {path}")
    for problem in checked.problems:
        click.echo(f"problem: {problem}", err=quiet)
    if checked.problems:
        raise SystemExit(PROBLEM)


def _read(name: str, given: dict[str, Any], *, repair: bool) -> Environment:
    from multisrt.environments.formats import read_environment
    from multisrt.simulation.worlds import build_environment
    from multisrt.spec import FileEnvironment

    where = world_of_options(name, given)
    if repair and isinstance(where, FileEnvironment):
        return read_environment(
            where.path,
            resolution_m=where.resolution_m,
            threshold=where.threshold,
            starts_from=where.starts_from,
            repair=True,
        )
    return build_environment(where)


def _fixed(world: Environment, given: dict[str, Any]) -> Environment:
    from multisrt.environments.cleaning import CleaningOptions
    from multisrt.environments.fixing import fixed

    specks = SPECK_M if given["specks"] is None else given["specks"]
    return fixed(
        world,
        CleaningOptions(
            speck_m=specks, gap_m=given["close"] or 0.0, tolerance_m=given["simplify"] or 0.0
        ),
    )
