"""Mutations of parsed trees: of JSON, of its lines, of TOML and of YAML.

A file is parsed, a part of the tree is replaced, deleted, repeated, exchanged, nested or retyped,
and the tree is written again. What cannot be parsed any more, or not be written, is changed as
text.
"""

from __future__ import annotations

import copy
import json
import math
import tomllib
from collections.abc import Callable, Sequence
from typing import Any, Final

import tomli_w
import yaml
from numpy.random import Generator

from benchmarks.fuzz.mutations import Mutation, of_text, pick

Tree = Any
"""None, a boolean, a number, a text, or a list or dictionary of trees."""

VALUES: Final[tuple[Tree, ...]] = (
    *(None, True, False, 0, 1, -1, 2, 3, 100, 0.5, -0.5, 1e-9, 5e-324, 1e7, 1e308, -1e308),
    *(math.nan, math.inf, -math.inf, 2**31, 2**63 - 1, 2**63, -(2**63), 2**64, 10**30),
    *("", " ", "a", "0", "nan", "\0", "\x1b[2J", "a\nb", "\u202e", "\ud800", "a" * 5000, "b " * 99),
    *("/dev/zero", "..", "../..", "/", ".", "~"),
    *([], {}, [[]], [None], {"": None}, [0, 0], [0.0] * 3, [1] * 1000, {"a": {"a": {}}}),
)
"""Replacements of a part of a tree."""

DEPTHS: Final = (1, 1, 2, 10, 100, 400)
"""How deep a part of a tree is nested."""

STOP: Final = 0.25
"""Probability that the walk down to a part ends at each level."""

UNREADABLE: Final = (
    *(ValueError, TypeError, LookupError, ArithmeticError, RecursionError, AttributeError),
    yaml.YAMLError,
)
"""What parsers raise, and writers if a tree cannot be written."""


def of_tree(read: Callable[[bytes], Tree], write: Callable[[Tree], bytes]) -> Mutation:
    """Return a mutation of files that hold a tree; it changes some of them as text.

    Parameters
    ----------
    read, write : callable
        Return the tree of a content, and the content of a tree.
    """

    def mutate(
        content: bytes, rng: Generator, seeds: Sequence[bytes], words: Sequence[bytes]
    ) -> bytes:
        if rng.random() < 0.3:
            return of_text(content, rng, seeds, words)
        try:
            others = [read(seed) for seed in seeds]
            return write(changed(read(content), rng, others, words))
        except UNREADABLE:
            return of_text(content, rng, seeds, words)

    return mutate


def changed(
    tree: Tree, rng: Generator, others: Sequence[Tree] = (), words: Sequence[bytes] = ()
) -> Tree:
    """Return a tree with one part changed; the given one is changed, too.

    Parameters
    ----------
    tree : Tree
        The tree.
    rng : numpy.random.Generator
        Random generator.
    others : sequence of Tree
        Trees of other files, for splices.
    words : sequence of bytes
        The dictionary of the format.
    """
    root = [tree]
    holder, key = _place(root, rng)
    part = holder[key]
    match int(rng.integers(12)):
        case 0 | 1 | 2:
            holder[key] = copy.deepcopy(pick(rng, VALUES))
        case 3 if words:
            holder[key] = _value(pick(rng, words))
        case 4 | 5 if len(root) == 1 and holder is not root:
            del holder[key]
        case 6:
            _repeat(holder, key, rng)
        case 7:
            other_holder, other_key = _place(root, rng)
            other = copy.deepcopy(other_holder[other_key])
            other_holder[other_key], holder[key] = copy.deepcopy(part), other
        case 8:
            for _ in range(pick(rng, DEPTHS)):
                part = [part] if rng.random() < 0.5 else {_key(holder, rng, words): part}
            holder[key] = part
        case 9:
            holder[key] = _retyped(part)
        case 10 if isinstance(holder, dict):
            del holder[key]
            holder[_key(holder, rng, words)] = part
        case 11 if others:
            other_holder, other_key = _place([copy.deepcopy(pick(rng, others))], rng)
            holder[key] = other_holder[other_key]
        case _:
            holder[key] = _other_number(part, rng)
    return root[0]


def _place(root: list[Tree], rng: Generator) -> tuple[Any, Any]:
    """Return a container and the key of a part, the root itself among them."""
    holder: Any = root
    key: Any = 0
    while isinstance(part := holder[key], list | dict) and part and rng.random() > STOP:
        holder = part
        at = int(rng.integers(len(part)))
        key = list(part)[at] if isinstance(part, dict) else at
    return holder, key


def _repeat(holder: Any, key: Any, rng: Generator) -> None:
    if isinstance(holder, dict):
        holder[f"{key}{pick(rng, ('2', ' ', '_'))}"] = copy.deepcopy(holder[key])
    else:
        times = 2 ** int(rng.integers(10))
        holder[key:key] = [copy.deepcopy(holder[key]) for _ in range(times)]


def _retyped(part: Tree) -> Tree:
    match part:
        case dict():
            return list(part.values())
        case list():
            return {str(k): value for k, value in enumerate(part)}
        case bool() | None:
            return str(part).lower()
        case str():
            return [part]
        case int():
            return float(part)
        case _:
            return str(part)


def _other_number(part: Tree, rng: Generator) -> Tree:
    if isinstance(part, int | float) and not isinstance(part, bool) and math.isfinite(part):
        moved = float(part) * float(rng.normal(1.0, 0.5)) + float(rng.normal(0.0, 0.1))
        return round(moved) if isinstance(part, int) and math.isfinite(moved) else moved
    return int(rng.integers(-3, 20))


def _key(holder: Any, rng: Generator, words: Sequence[bytes]) -> str:
    if words and rng.random() < 0.5:
        return str(_value(pick(rng, words)))
    known = [str(key) for key in holder] if isinstance(holder, dict) else []
    return pick(rng, [*known, "", "a", "\x1b[2J", "b" * 300])


def _value(word: bytes) -> Tree:
    """Return what a word of a dictionary means in JSON; else the word as text."""
    try:
        return json.loads(word)
    except UNREADABLE:
        return word.decode(errors="replace")


# Formats ------------------------------------------------------------------------------------


def _json(tree: Tree) -> bytes:
    return json.dumps(tree).encode()


of_json: Final = of_tree(json.loads, _json)
of_toml: Final = of_tree(
    lambda content: tomllib.loads(content.decode()), lambda tree: tomli_w.dumps(tree).encode()
)
of_yaml: Final = of_tree(
    yaml.safe_load, lambda tree: yaml.safe_dump(tree, sort_keys=False).encode()
)


def of_json_lines(
    content: bytes, rng: Generator, seeds: Sequence[bytes], words: Sequence[bytes]
) -> bytes:
    """Change the tree of one line of a file with a tree in each line, or the file as text."""
    lines = content.splitlines()
    if not lines or rng.random() < 0.3:
        return of_text(content, rng, seeds, words)
    at = int(rng.integers(len(lines)))
    others = pick(rng, seeds).splitlines() or [b"null"]
    lines[at] = of_json(lines[at], rng, [pick(rng, others)], words)
    return b"\n".join(lines) + b"\n"
