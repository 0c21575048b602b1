"""`multisrt strategies`: list strategies and their options."""

from __future__ import annotations

import click

from multisrt.cli.imports import named_strategy
from multisrt.cli.tables import show, table


@click.command()
@click.argument("name", metavar="[NAME]", required=False)
def strategies(name: str | None) -> None:
    """List the strategies, or the options of one.

    With NAME, list the options of this strategy, their defaults and meaning. For a strategy of
    your own it is FILE.py, FILE.py:CLASS or MODULE:CLASS.

    \b
    Examples:
      multisrt strategies
      multisrt strategies srt-radial
      multisrt strategies mine.py:Mine
    """
    import msgspec

    from multisrt.experiments.schema import documented_attributes
    from multisrt.robots.registry import broken_strategies
    from multisrt.robots.registry import strategies as all_strategies

    if name is None:
        listed = table("strategy", "description")
        for entry in all_strategies():
            listed.add_row(
                entry.name, entry.summary + (" (sees the map)" if entry.sees_truth else "")
            )
        show(listed)
        for broken, reason in broken_strategies().items():
            click.echo(f"{broken}: could not be loaded ({reason})", err=True)
        return
    chosen = named_strategy(name)
    click.echo(f"{chosen.name}: {chosen.summary}")
    if not msgspec.structs.fields(chosen.options):
        click.echo("it has no options")
        return
    listed = table("option", "default", "description")
    meanings: dict[str, str] = {}
    for kind in reversed(chosen.options.__mro__):
        meanings |= documented_attributes(kind.__doc__ or "")
    for field in msgspec.structs.fields(chosen.options):
        default = str(field.default).lower() if field.default in (True, False) else field.default
        listed.add_row(field.name, str(default), meanings.get(field.name, ""))
    show(listed)
