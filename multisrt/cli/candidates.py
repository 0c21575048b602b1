"""Candidates for completion in shells: worlds and their parameters, strategies and their options.

Completion runs with every press of the tab key: nothing here imports compiled kernels, or files
of others, which are read as text.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

if TYPE_CHECKING:
    from multisrt.cli.source import Option

Items = list[CompletionItem]
Complete = Callable[[click.Context, click.Parameter, str], Items]

FAULT_KINDS = ("death:", "silence:", "late:")
"""Prefixes of faults."""

PAPERS = ("multi-srt", "sbx-r", "minpos", "alvarez")
"""Names of the presets, which completion does not import."""


def worlds(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the worlds of the catalogue, those of a suite that is named, and files.

    Parameters
    ----------
    context, parameter
        As click gives them.
    incomplete : str
        What is there of the word.

    Returns
    -------
    list of CompletionItem
        Names with summaries; if none begins so, one that lets the shell complete a path.
    """
    from multisrt.environments import suites
    from multisrt.environments.catalog import summaries

    found = [CompletionItem(name, help=text) for name, text in summaries().items()]
    # Suites only by their whole name: their worlds would hide the catalogue.
    if (suite := incomplete.partition("/")[0]) in suites.names():
        found += map(CompletionItem, suites.load(suite).world_names)
    return _in_file(incomplete) if ":" in incomplete else _names_or_files(found, incomplete)


def strategies(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the strategies that begin so, those of --import too, and files; see `worlds`."""
    from multisrt.robots.registry import strategies as all_strategies

    given = context.params.get(parameter.name or "")
    before = given if isinstance(given, tuple) else ()
    summaries = {known.name: known.summary for known in all_strategies()}
    summaries = dict.fromkeys(_imported(context), "") | summaries
    found = [
        CompletionItem(name, help=summary or None)
        for name, summary in summaries.items()
        if name not in before
    ]
    files = references(context, parameter, incomplete) if incomplete else []
    return _beginning(found, incomplete) + files


def references(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the Python files that begin so, or after ``FILE.py:`` its strategies."""
    if ":" in incomplete:
        return _in_file(incomplete)
    return files_named(".py")(context, parameter, incomplete)


def labels(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the strategies in the results that a command is given; see `worlds`."""
    from multisrt.experiments.store_file import labels_in

    results = _argument(context, "results")
    found = labels_in(Path(results)) if results else []
    return _beginning(map(CompletionItem, found), incomplete)


def files_named(*suffixes: str) -> Complete:
    """Return what completes the paths of files with certain suffixes, by way of their folders.

    Parameters
    ----------
    *suffixes : str
        Such as ".py".

    Returns
    -------
    callable
        For click: takes context, parameter and what is there of the word.
    """

    def complete(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
        folder, slash, begun = incomplete.rpartition("/")
        above = folder + slash
        try:
            there = sorted(Path(above or ".").iterdir())
        except OSError:
            return []
        shown = [path for path in there if begun or not path.name.startswith(".")]
        named = [
            f"{above}{path.name}{'/' * path.is_dir()}"
            for path in shown
            if path.is_dir() or path.suffix in suffixes
        ]
        return _beginning(map(CompletionItem, named), incomplete)

    return complete


def options(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return options ``KEY=`` of the strategies given, or values where the key is complete.

    Parameters
    ----------
    context, parameter
        As click gives them; ``--strategy`` and ``--import`` count if they stand before.
    incomplete : str
        What is there of the word.

    Returns
    -------
    list of CompletionItem
        Keys that all of the strategies have, or ``KEY=VALUE`` for options with few values.
    """
    found = [_options_of(name, context) for name in _asked(context)]
    known = [own for own in found if own is not None]
    if not known:
        return []
    shared = {key: known[0][key] for key in known[0] if all(key in own for own in known)}
    return _keys_or_values(shared, incomplete)


def parameters(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return parameters ``NAME=`` of the generator given, or values where the name is complete.

    Parameters
    ----------
    context, parameter
        As click gives them; the environment counts if it stands before.
    incomplete : str
        What is there of the word.

    Returns
    -------
    list of CompletionItem
        The parameters that the generator lists, its seed, and its difficulty if it has one; without
        those that are given already.
    """
    from multisrt.cli.source import Option, keywords_of
    from multisrt.environments.catalog import generator_reference
    from multisrt.environments.generators.difficulty import KNOB, RANGES

    name = _argument(context, "environment")
    module, _, function = generator_reference(name).partition(":")
    found = keywords_of(module, function) if module else {}
    if name in RANGES:
        found.setdefault(KNOB, Option("", ()))
    given = {text.partition("=")[0] for text in context.params.get(parameter.name or "") or ()}
    return _keys_or_values({key: found[key] for key in found if key not in given}, incomplete)


def robots(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the keys of ``--robot`` that may follow, or the drives; see `worlds`."""
    from multisrt.cli.run_options import DRIVES, OVERRIDES

    before, comma, last = incomplete.rpartition(",")
    words = [f"{key}=" for key in OVERRIDES] + [f"drive={drive}" for drive in DRIVES]
    if "=" not in last:
        words = [word for word in words if word.endswith("=")]
    return _beginning((CompletionItem(f"{before}{comma}{word}") for word in words), incomplete)


def faults(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the kinds of faults that begin so; see `worlds`."""
    return _beginning(map(CompletionItem, FAULT_KINDS), incomplete)


def papers(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the papers of `multisrt reproduce` that begin so; see `worlds`."""
    return _beginning(map(CompletionItem, PAPERS), incomplete)


def folders(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return an item that lets the shell complete a folder; see `worlds`."""
    return [CompletionItem(incomplete, type="dir")]


def _keys_or_values(options: Mapping[str, Option], incomplete: str) -> Items:
    """Return the keys ``KEY=`` that begin so, or what follows ``KEY=`` if that is few words."""
    key, equals, _ = incomplete.partition("=")
    if equals and key in options:
        return _beginning((CompletionItem(f"{key}={w}") for w in options[key].words), incomplete)
    items = (
        CompletionItem(f"{name}=", help=f"default {option.default}" if option.default else None)
        for name, option in options.items()
    )
    return _beginning(items, incomplete)


def _beginning(items: Iterable[CompletionItem], incomplete: str) -> Items:
    return [item for item in items if item.value.startswith(incomplete)]


def _in_file(incomplete: str) -> Items:
    from multisrt.cli.source import strategies_in

    place, _, _ = incomplete.partition(":")
    return _beginning(
        (CompletionItem(f"{place}:{name}") for name in strategies_in(place)), incomplete
    )


def _asked(context: click.Context) -> tuple[str, ...]:
    """Return the strategies that a command is given: references, names, or the default."""
    from multisrt.cli.run_options import DEFAULT_STRATEGY
    from multisrt.robots.loading import is_reference

    if given := context.params.get("strategies"):
        return tuple(given)
    if strategy := _argument(context, "strategy"):
        return (strategy,)
    environment = _argument(context, "environment")
    return (environment if is_reference(environment) else DEFAULT_STRATEGY,)


def _argument(context: click.Context, name: str) -> str:
    """Return an argument of the command; empty if it is not given or there is none."""
    if value := context.params.get(name):
        return str(value)
    # While the last option lacks its value, click leaves all arguments in their order.
    names = [one.name for one in context.command.params if isinstance(one, click.Argument)]
    given = dict(zip(names, context.args, strict=False))
    return given.get(name, "")


def _options_of(name: str, context: click.Context) -> dict[str, Option] | None:
    """Return the options of a strategy by its name or a reference; None if it is not found."""
    import msgspec

    from multisrt.cli.source import Option, strategies_in
    from multisrt.robots.loading import is_reference, split_reference
    from multisrt.robots.registry import is_known, strategy
    from multisrt.validation_errors import allowed_words, written

    if is_reference(name):
        place, wanted, _ = split_reference(name)
        there = strategies_in(place)
        if wanted:
            return there[wanted].options if wanted in there else None
        return next(iter(there.values())).options if len(there) == 1 else None
    if not is_known(name):
        return _imported(context).get(name)
    return {
        field.name: Option(written(field.default), tuple(allowed_words(field.type)))
        for field in msgspec.structs.fields(strategy(name).options)
    }


def _imported(context: click.Context) -> dict[str, dict[str, Option]]:
    """Return the options of the strategies that --import names, by the strategies' names."""
    references = context.params.get("imports")
    if not references:
        return {}
    from multisrt.cli.source import strategies_in
    from multisrt.robots.loading import split_reference

    found = {}
    for reference in references:
        place, wanted, own_name = split_reference(reference)
        for name, own in strategies_in(place).items():
            known_as = own_name or own.name
            if wanted in ("", name) and known_as:
                found[known_as] = own.options
    return found


def _names_or_files(items: Iterable[CompletionItem], incomplete: str) -> Items:
    # Shells complete paths on their own, but not beside words that are given to them.
    found = _beginning(items, incomplete)
    if not found:
        return [CompletionItem(incomplete, type="file")]
    return found + [CompletionItem(name) for name in _files(incomplete)]


def _files(incomplete: str) -> Iterator[str]:
    if incomplete:
        for path in sorted(Path().iterdir()):
            if path.name.startswith(incomplete) and path.is_file():
                yield path.name
