"""`multisrt environments` and `multisrt strategies`: what there is."""

from __future__ import annotations

from pathlib import Path

import click

from multisrt.cli.tables import show as show_table
from multisrt.cli.tables import table


@click.group(invoke_without_command=True)
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

    listed = table("environment", "kind", "size (m)", ">free (m2)", "what it is")
    for entry in catalog():
        size = f"{entry.width_m:.0f} x {entry.height_m:.0f}"
        listed.add_row(entry.name, entry.kind, size, f"{entry.area_m2:.0f}", entry.summary)
    show_table(listed)


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
    from multisrt.simulation.worlds import build_environment, environment_spec

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


@click.command()
@click.argument("name", required=False)
def strategies(name: str | None) -> None:
    """List the strategies, or one strategy's options and their defaults.

    \b
    Examples:
      multisrt strategies
      multisrt strategies srt-radial
    """
    import msgspec

    from multisrt.robots.registry import broken_strategies, strategy
    from multisrt.robots.registry import strategies as all_strategies

    if name is None:
        listed = table("strategy", "what it does")
        for entry in all_strategies():
            listed.add_row(entry.name, entry.summary)
        show_table(listed)
        for broken, reason in broken_strategies().items():
            click.echo(f"{broken}: could not be loaded ({reason})", err=True)
        return
    chosen = strategy(name)
    click.echo(f"{chosen.name}: {chosen.summary}")
    listed = table("option", "default", "what it means")
    meanings: dict[str, str] = {}
    for kind in reversed(chosen.options.__mro__):
        meanings |= _documented_attributes(kind.__doc__ or "")
    for field in msgspec.structs.fields(chosen.options):
        default = str(field.default).lower() if field.default in (True, False) else field.default
        listed.add_row(field.name, str(default), meanings.get(field.name, ""))
    show_table(listed)


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
