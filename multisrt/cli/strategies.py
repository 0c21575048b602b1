"""`multisrt strategies`: list strategies and their options."""

from __future__ import annotations

import inspect

import click

from multisrt.cli import candidates
from multisrt.cli.imports import named_strategy
from multisrt.cli.tables import show, table

AS_ABOVE = "As above"
"""How a docstring refers to that of the class from which an option is inherited."""


@click.command()
@click.argument("name", metavar="[NAME]", required=False, shell_complete=candidates.strategies)
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
    import msgspec

    from multisrt.experiments.schema import documented_attributes
    from multisrt.validation_errors import written

    chosen = named_strategy(name)
    click.echo(f"{chosen.name}: {chosen.summary}")
    if not msgspec.structs.fields(chosen.options):
        click.echo("it has no options")
        return
    listed = table("option", "default", "description")
    meanings: dict[str, str] = {}
    defined: dict[str, int] = {}
    for depth, kind in enumerate(reversed(chosen.options.__mro__)):
        defined |= dict.fromkeys(inspect.get_annotations(kind), depth)
        for option, meaning in documented_attributes(kind.__doc__ or "").items():
            meanings[option] = _whole(meaning, meanings.get(option, ""))
    # What the strategy adds or changes, before what it inherits.
    fields = msgspec.structs.fields(chosen.options)
    for field in sorted(fields, key=lambda field: -defined[field.name]):
        listed.add_row(field.name, written(field.default), meanings.get(field.name, ""))
    show(listed)


def _whole(meaning: str, inherited: str) -> str:
    """Return what an option means, where that is "As above; ..." of an inherited one."""
    if not inherited or not meaning.startswith(AS_ABOVE):
        return meaning
    rest = meaning.removeprefix(AS_ABOVE).lstrip(";. ")
    return f"{inherited.rstrip('.')}; {rest}" if rest else inherited
