"""Candidates for completion in shells: worlds, strategies, their options, robots and faults.

Completion runs with every press of the tab key: nothing here imports compiled kernels.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import click
from click.shell_completion import CompletionItem

Items = list[CompletionItem]
Complete = Callable[[click.Context, click.Parameter, str], Items]

FAULT_KINDS = ("death:", "silence:", "late:")
"""Prefixes of faults."""


def worlds(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the worlds of the catalogue and the files that begin so.

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
    from multisrt.environments.catalog import summaries

    found = [CompletionItem(name, help=text) for name, text in summaries().items()]
    return _classes(incomplete) if ":" in incomplete else _names_or_files(found, incomplete)


def strategies(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the strategies that begin so, and the files; see `worlds`."""
    from multisrt.robots.registry import strategies as all_strategies

    given = context.params.get(parameter.name or "")
    before = given if isinstance(given, tuple) else ()
    found = [
        CompletionItem(known.name, help=known.summary)
        for known in all_strategies()
        if known.name not in before
    ]
    return _beginning(found, incomplete) + own_strategies(context, parameter, incomplete)


def own_strategies(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the Python files that begin so, or after ``FILE.py:`` its classes; see `worlds`."""
    if ":" in incomplete:
        return _classes(incomplete)
    return files_named(".py")(context, parameter, incomplete) if incomplete else []


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
        As click gives them; ``--strategy`` counts if it stands before.
    incomplete : str
        What is there of the word.

    Returns
    -------
    list of CompletionItem
        Keys that all of the strategies have, or ``KEY=VALUE`` for options with few values.
    """
    import msgspec

    from multisrt.cli.run_options import DEFAULT_STRATEGY
    from multisrt.robots.registry import strategies as all_strategies
    from multisrt.validation_errors import allowed_words, written

    asked = context.params.get("strategies") or (DEFAULT_STRATEGY,)
    fields = [
        {field.name: field for field in msgspec.structs.fields(known.options)}
        for known in all_strategies()
        if known.name in asked
    ]
    if not fields:
        return []
    shared = {key: fields[0][key] for key in fields[0] if all(key in own for own in fields)}
    key, equals, _ = incomplete.partition("=")
    if equals and key in shared:
        found = [CompletionItem(f"{key}={value}") for value in allowed_words(shared[key].type)]
    else:
        found = [
            CompletionItem(f"{name}=", help=f"default {written(field.default)}")
            for name, field in shared.items()
        ]
    return _beginning(found, incomplete)


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
    from multisrt.cli.reproduce import PAPERS

    return _beginning(map(CompletionItem, PAPERS), incomplete)


def folders(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return an item that lets the shell complete a folder; see `worlds`."""
    return [CompletionItem(incomplete, type="dir")]


def _beginning(items: Iterable[CompletionItem], incomplete: str) -> Items:
    return [item for item in items if item.value.startswith(incomplete)]


def _classes(incomplete: str) -> Items:
    # Read, not imported: code of others does not run because a key is pressed.
    place, _, _ = incomplete.partition(":")
    try:
        tree = ast.parse(Path(place).read_bytes())
    except (OSError, SyntaxError, ValueError):
        return []
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    names = [node.name for node in classes if node.name[0] != "_" and not _has_options(node)]
    return _beginning((CompletionItem(f"{place}:{name}") for name in names), incomplete)


def _has_options(node: ast.ClassDef) -> bool:
    return any(word in ast.unparse(base) for base in node.bases for word in ("Struct", "Options"))


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
