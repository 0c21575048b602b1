"""Usage errors of the command line in one line, with a suggestion."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from multisrt.geometry.errors import did_you_mean

OTHERWISE = {"help": "--help", "version": "--version"}
"""Words that other programs take as commands."""

OTHER_NAMES = {
    "--limit": "--max-time",
    "--time": "--max-time",
    "--time-limit": "--max-time",
    "--timeout": "--max-time",
    "--duration": "--max-time",
}
"""Names that other programs give options, where a command has the option."""

KINDS = {
    "a valid integer range": "a whole number",
    "a valid integer": "a whole number",
    "a valid float range": "a number",
    "a valid float": "a number",
}
"""Kinds of values, as click and as people call them, the longest first."""


class CommandGroup(click.Group):
    """A group of commands that says what an unknown command may have been meant to be.

    Parameters
    ----------
    *args, **kwargs
        As for `click.Group`.
    meant : callable, optional
        Takes the words after the group's name; returns the words that were probably meant, or
        none if it does not know.
    """

    def __init__(
        self,
        *args: Any,
        meant: Callable[[Sequence[str]], Sequence[str]] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        self._meant = meant

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of the work, in which the commands were added."""
        return list(self.commands)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find a command by its name; an unknown one is an error with a hint."""
        known = self.get_command(ctx, args[0]) is not None
        if not known and not ctx.resilient_parsing and not args[0].startswith("-"):
            raise click.UsageError(self._unknown(ctx, args), ctx)
        return super().resolve_command(ctx, args)

    def _unknown(self, ctx: click.Context, args: Sequence[str]) -> str:
        said = f"there is no command {args[0]!r}"
        words = () if self._meant is None else self._meant(args)
        if args[0] in OTHERWISE:
            words = [*args[1:2], OTHERWISE[args[0]]]
        below = [
            [name, args[0]]
            for name, command in self.commands.items()
            if isinstance(command, click.Group) and args[0] in command.commands
        ]
        if not words and below:
            words = [*below[0], *args[1:]]
        if words:
            return f"{said} (did you mean '{' '.join((ctx.command_path, *words))}'?)"
        return f"{said}{did_you_mean(args[0], self.commands)}"


def is_world(word: str) -> bool:
    """Whether a word names a world of the catalogue or of a suite, or a file that is there."""
    from multisrt.environments import suites
    from multisrt.environments.catalog import names

    return word in names() or suites.is_world(word) or Path(word).is_file()


def usage_message(error: click.ClickException) -> str:
    """Return an error of usage as one line.

    Parameters
    ----------
    error : click.ClickException
        The error.

    Returns
    -------
    str
        What is wrong, and which help page has more.
    """
    said = _said(error).rstrip(".")
    for kind, plain in KINDS.items():
        said = said.replace(kind, plain)
    context = error.ctx if isinstance(error, click.UsageError) else None
    page = "multisrt" if context is None else context.command_path
    if said[1:2].islower():
        said = said[0].lower() + said[1:]
    return f"{said}; see '{page} --help'"


def _said(error: click.ClickException) -> str:
    message = error.message
    if isinstance(error, click.NoSuchOption):
        known = [] if error.ctx is None else error.ctx.command.get_params(error.ctx)
        names = [name for parameter in known for name in parameter.opts if name.startswith("-")]
        said = f"there is no option {error.option_name}"
        if (meant := OTHER_NAMES.get(error.option_name)) in names:
            return f"{said} (did you mean {meant!r}?)"
        return said + did_you_mean(error.option_name, names)
    if isinstance(error, click.MissingParameter):
        return f"{_named(error)} is missing"
    if isinstance(error, click.BadParameter):
        if isinstance(getattr(error.param, "type", None), click.Choice):
            message = _among(message, error.param)
        return f"{_named(error)}: {message}"
    if found := re.fullmatch(r"Got unexpected extra arguments? \((.*)\)", message):
        spaced = re.match(r"-?\.?\d", found[1])
        meant = (
            "; write X,Y and KEY=VALUE without a space"
            if spaced
            else _meant_strategy(found[1], error)
        )
        return f"too many words: {found[1]}{meant}"
    return message


def _meant_strategy(words: str, error: click.ClickException) -> str:
    from multisrt.robots.loading import is_reference

    context = error.ctx if isinstance(error, click.UsageError) else None
    known = [] if context is None else context.command.params
    if is_reference(words) and any("--strategy" in parameter.opts for parameter in known):
        return f" (did you mean --strategy {words}?)"
    return ""


def _named(error: click.BadParameter) -> str:
    # What the user calls it: --strategy, or PAPER.
    hint = error.param_hint
    if hint is None and error.param is not None:
        option = isinstance(error.param, click.Option)
        hint = error.param.opts[0] if option else error.param.human_readable_name.strip("[]")
    return hint if isinstance(hint, str) else " / ".join(hint or ())


def _among(message: str, parameter: click.Parameter | None) -> str:
    assert parameter is not None
    assert isinstance(parameter.type, click.Choice)
    found = re.match(r"'(.*?)' is not one of", message)
    if found is None:
        return message
    choices = [str(choice) for choice in parameter.type.choices]
    return f"{found[1]!r} is not one of {', '.join(choices)}{did_you_mean(found[1], choices)}"
