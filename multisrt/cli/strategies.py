"""`multisrt strategies`: list strategies and their options."""

from __future__ import annotations

import click

from multisrt.cli.tables import show, table


@click.command()
@click.argument("name", metavar="[NAME]", required=False)
def strategies(name: str | None) -> None:
    """List the strategies, or the options of one.

    With NAME, list the options of this strategy, their defaults and meaning.

    \b
    Examples:
      multisrt strategies
      multisrt strategies srt-radial
    """
    import msgspec

    from multisrt.robots.registry import broken_strategies, strategy
    from multisrt.robots.registry import strategies as all_strategies

    if name is None:
        listed = table("strategy", "description")
        for entry in all_strategies():
            listed.add_row(entry.name, entry.summary)
        show(listed)
        for broken, reason in broken_strategies().items():
            click.echo(f"{broken}: could not be loaded ({reason})", err=True)
        return
    chosen = strategy(name)
    click.echo(f"{chosen.name}: {chosen.summary}")
    listed = table("option", "default", "description")
    meanings: dict[str, str] = {}
    for kind in reversed(chosen.options.__mro__):
        meanings |= _documented_attributes(kind.__doc__ or "")
    for field in msgspec.structs.fields(chosen.options):
        default = str(field.default).lower() if field.default in (True, False) else field.default
        listed.add_row(field.name, str(default), meanings.get(field.name, ""))
    show(listed)


def _documented_attributes(docstring: str) -> dict[str, str]:
    """Return the "Attributes" section of a numpydoc docstring, by attribute."""
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
