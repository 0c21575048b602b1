"""`multisrt strategies`: list strategies and their options."""

from __future__ import annotations

import click

from multisrt.cli import candidates
from multisrt.cli.imports import named_strategy
from multisrt.cli.tables import show, table

EXAMPLE = "minpos"
"""The strategy whose options the list of all suggests."""

AS_ABOVE = "As above"
"""How a docstring refers to that of the class from which an option is inherited."""

PLAIN = ("true", "false", "none")
"""Words for values that are no names, which the default or the text shows."""


@click.command()
@click.argument("words", metavar="[NAME]", nargs=-1, shell_complete=candidates.strategies)
def strategies(words: tuple[str, ...]) -> None:
    """List the strategies, or the options of one.

    With NAME, list the options of this strategy, their defaults and meaning. For a strategy of
    your own it is FILE.py, FILE.py:CLASS or MODULE:CLASS.

    \b
    Examples:
      multisrt strategies
      multisrt strategies srt-radial
      multisrt strategies mine.py:Mine
    """
    # 'strategies show NAME' is meant as 'environments show ENV'.
    names = words[1:] if words[:1] == ("show",) else words
    if len(names) > 1 or (words and not names):
        raise click.UsageError(
            "name one strategy" + (f": too many words: {' '.join(names[1:])}" if names else "")
        )
    name = names[0] if names else None
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
        click.echo(f"next: multisrt strategies {EXAMPLE}  (the options of one)")
        return
    from multisrt.experiments.schema import documented_attributes
    from multisrt.robots.strategy import fields_own_first
    from multisrt.validation_errors import allowed_words, written

    chosen = named_strategy(name)
    click.echo(f"{chosen.name}: {chosen.summary}")
    fields = fields_own_first(chosen.options)
    if not fields:
        click.echo("it has no options")
        return
    listed = table("option", "default", "description")
    meanings: dict[str, str] = {}
    for kind in reversed(chosen.options.__mro__):
        for option, meaning in documented_attributes(kind.__doc__ or "").items():
            meanings[option] = _whole(meaning, meanings.get(option, ""))
    for field in fields:
        meaning = meanings.get(field.name, "")
        values = allowed_words(field.type)
        if set(values) - set(PLAIN):
            meaning = f"{meaning} Values: {', '.join(values)}.".strip()
        listed.add_row(field.name, written(field.default), meaning)
    show(listed)


def _whole(meaning: str, inherited: str) -> str:
    """Return what an option means, where that is "As above; ..." of an inherited one."""
    if not inherited or not meaning.startswith(AS_ABOVE):
        return meaning
    rest = meaning.removeprefix(AS_ABOVE).lstrip(";. ")
    return f"{inherited.rstrip('.')}; {rest}" if rest else inherited
