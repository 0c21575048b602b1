"""The syntax of the world files of Player/Stage: entities, properties, macros and includes."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, NamedTuple

from multisrt.environments.formats.files import named_file, read_text
from multisrt.geometry.errors import MapFormatError, shortened, shown

MAX_WORLD_BYTES: Final = 4 * 2**20
"""Upper bound of the size of a world file and of each file that it includes, in bytes (4 MiB)."""

MAX_INCLUDES: Final = 64
"""Upper bound of the include statements of a world."""

MAX_INCLUDE_DEPTH: Final = 16
"""Upper bound of the files that include each other in a chain."""

MAX_TOKENS: Final = 500_000
"""Upper bound of the tokens of a world and of all files that it includes."""

MAX_NESTING: Final = 32
"""Upper bound of the nesting of entities, and of macros defined by macros."""

MAX_ITEMS: Final = 200_000
"""Upper bound of the properties and entities of a world, with all macros expanded."""

Value = str | float
"""A value of a property."""


@dataclass(frozen=True, slots=True)
class Property:
    """A property of an entity.

    Attributes
    ----------
    values : tuple of str or float
        Its value, or those of its tuple.
    place : str
        File and line, for messages.
    """

    values: tuple[Value, ...]
    place: str


@dataclass(frozen=True, slots=True)
class Entity:
    """An entity of a world: a model, a block, a window, or the world itself.

    Attributes
    ----------
    kind : str
        Its type, with macros resolved; empty for the world itself.
    word : str
        The type as written, possibly the name of a macro.
    place : str
        File and line, for messages.
    properties : dict of str to Property
        Its properties, those of the macros first; of several of one name, the last counts.
    children : list of Entity
        The entities in it, in the order of the file.
    """

    kind: str
    word: str
    place: str
    properties: dict[str, Property] = field(default_factory=dict)
    children: list["Entity"] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Worldfile:
    """A parsed world file.

    Attributes
    ----------
    root : Entity
        The world itself.
    missing : tuple of str
        Names of included files that do not exist.
    """

    root: Entity
    missing: tuple[str, ...]


def parse_worldfile(path: Path) -> Worldfile:
    """Return the entities of a world file, with includes read and macros expanded.

    A file is a sequence of properties ``NAME VALUE``, entities ``TYPE ( ... )`` that contain
    properties and entities, macros ``define NAME TYPE ( ... )`` and includes ``include "FILE"``.
    A value is a number, a string in double quotes, or a tuple ``[ VALUE ... ]``. Comments extend
    from ``#`` to the end of the line.

    Parameters
    ----------
    path : Path
        The world file. All files that it includes, directly or indirectly, are named relative to
        its folder and must be in it or below it.

    Returns
    -------
    Worldfile
        Its entities. Of several macros of one name, the first counts.

    Raises
    ------
    MapFormatError
        If the syntax is wrong, files include each other in a circle, a macro is defined in terms
        of itself, a name leads out of the folder, or a bound of this module is exceeded.

    Notes
    -----
    Source: the class Worldfile of Stage 4. Differs in: tuples may extend over several lines,
    numbers may have an exponent, macros may be used before they are defined, and an included file
    that does not exist is no error here.

    Examples
    --------
    >>> with open("hall.world", "w") as file:
    ...     _ = file.write('define wall model ( size [4 1 1] )  wall ( color "red" )')
    >>> (wall,) = parse_worldfile(Path("hall.world")).root.children
    >>> wall.kind, wall.properties["size"].values, wall.properties["color"].values
    ('model', (4.0, 1.0, 1.0), ('red',))
    """
    source = _Source(path)
    syntax = _Syntax(source.tokens(path, read_text(path, max_bytes=MAX_WORLD_BYTES), ()))
    root = _Expansion(syntax.macros).world(syntax.items)
    return Worldfile(root, tuple(dict.fromkeys(source.missing)))


# Tokens -------------------------------------------------------------------------------------


class _Token(NamedTuple):
    kind: str
    text: str
    place: str


_TOKEN = re.compile(
    r"""
    (?P<space>   [ \t\r\n\f\v]+ | \#[^\r\n]* )
  | (?P<string>  "[^"\r\n]*" )
  | (?P<number>  [+-]? (?: \d+ (?: \.\d* )? | \.\d+ ) (?: [eE][+-]?\d+ )? (?![\w.+-]) )
  | (?P<word>    [A-Za-z] [A-Za-z0-9._-]* (?: \[\d+\] )? )
  | (?P<sign>    [()\[\]] )
    """,
    re.VERBOSE | re.ASCII,
)


class _Source:
    """The tokens of a world file and of the files that it includes."""

    def __init__(self, path: Path) -> None:
        self._folder = path.parent
        self._includes = 0
        self._tokens = 0
        self.missing: list[str] = []

    def tokens(self, path: Path, text: str, above: tuple[Path, ...]) -> Iterator[_Token]:
        """Yield the tokens of a file that the files `above` include in a chain."""
        chain = (*above, path.resolve())
        awaits_name = False
        for token in self._of_text(path, text):
            if awaits_name:
                if token.kind != "string":
                    raise MapFormatError(
                        f"{token.place}: include is followed by {shown(token.text)}; "
                        'it must be followed by the name of a file, such as "map.inc"'
                    )
                yield from self._included(token, chain)
                awaits_name = False
            elif token.text == "include" and token.kind == "word":
                awaits_name = True
            else:
                yield token
        if awaits_name:
            raise MapFormatError(
                f"{path} ends after include, which must be followed by the name of a file"
            )

    def _of_text(self, path: Path, text: str) -> Iterator[_Token]:
        at, line = 0, 1
        while at < len(text):
            place = f"{path}, line {line}"
            match = _TOKEN.match(text, at)
            if match is None:
                rest = re.split(r"[\s()\[\]]", text[at : at + 60], maxsplit=1)[0] or text[at]
                raise MapFormatError(f"{place}: {_fault(rest)}")
            kind = match.lastgroup or ""
            at = match.end()
            line += match.group().count("\n")
            if kind == "space":
                continue
            self._tokens += 1
            if self._tokens > MAX_TOKENS:
                raise MapFormatError(
                    f"{place}: the world has more than {MAX_TOKENS:,} words, with all includes; "
                    "remove what is not needed for the floorplan"
                )
            found = match.group()
            yield _Token(kind, found[1:-1] if kind == "string" else found, place)

    def _included(self, token: _Token, chain: tuple[Path, ...]) -> Iterator[_Token]:
        self._includes += 1
        if self._includes > MAX_INCLUDES or len(chain) > MAX_INCLUDE_DEPTH:
            raise MapFormatError(
                f"{token.place}: a world includes at most {MAX_INCLUDES} files, "
                f"{MAX_INCLUDE_DEPTH} in a chain; join some of them"
            )
        path = named_file(self._folder, token.text, token.place)
        if path is None:
            self.missing.append(token.text)
            return
        if path.resolve() in chain:
            raise MapFormatError(
                f"{token.place}: {shortened(token.text)} includes itself, directly or through "
                "other files; remove one of the includes"
            )
        yield from self.tokens(path, read_text(path, max_bytes=MAX_WORLD_BYTES), chain)


def _fault(text: str) -> str:
    if text[0] == '"':
        return "a string has no closing quote in its line; add it"
    if text[0] in "+-.0123456789":
        return f"{shown(text)} is not a number; write it with a point, such as -0.5"
    return f"{shown(text)} does not belong in a world file; values are separated by spaces"


# Syntax -------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Block:
    """A type with what is in its parentheses, before macros are expanded."""

    word: str
    place: str
    items: list["tuple[str, Property] | _Block"] = field(default_factory=list)


class _Syntax:
    """The items and macros of a sequence of tokens, parsed without recursion."""

    def __init__(self, tokens: Iterator[_Token]) -> None:
        self._tokens = tokens
        self._place = ""
        self.items: list[tuple[str, Property] | _Block] = []
        self.macros: dict[str, _Block] = {}
        self._parse()

    def _parse(self) -> None:
        opened: list[_Block] = []
        for token in self._tokens:
            self._place = token.place
            if token.text == ")" and token.kind == "sign":
                if not opened:
                    raise MapFormatError(f"{token.place}: a ) closes nothing; remove it")
                opened.pop()
                continue
            if token.kind != "word":
                raise MapFormatError(
                    f"{token.place}: {shown(token.text)} stands where a name is expected"
                )
            items = opened[-1].items if opened else self.items
            if token.text == "define" and not opened:
                opened.append(self._define())
                continue
            after = self._next(f"{shortened(token.text)} is followed by a value or by ( ... )")
            if after.kind == "sign" and after.text == "(":
                block = _Block(token.text, token.place)
                items.append(block)
                opened.append(block)
                if len(opened) > MAX_NESTING:
                    raise MapFormatError(
                        f"{token.place}: entities are nested more than {MAX_NESTING} deep"
                    )
            else:
                items.append((token.text, Property(self._values(token, after), token.place)))
        if opened:
            raise MapFormatError(
                f"{opened[-1].place}: the ( of {shortened(opened[-1].word)} is not closed; add a )"
            )

    def _define(self) -> _Block:
        expected = "define is followed by a name, a type and ( ... )"
        name, base, sign = (self._next(expected) for _ in range(3))
        if name.kind != "word" or base.kind != "word" or sign[:2] != ("sign", "("):
            raise MapFormatError(f"{name.place}: {expected}")
        macro = _Block(base.text, base.place)
        self.macros.setdefault(name.text, macro)
        return macro

    def _values(self, name: _Token, first: _Token) -> tuple[Value, ...]:
        if first.kind in ("string", "number"):
            return (_value(first),)
        if first[:2] != ("sign", "["):
            raise MapFormatError(
                f"{first.place}: {shortened(name.text)} is followed by {shown(first.text)}; a "
                "value is a number, a string in quotes or a tuple in [ ]"
            )
        values: list[Value] = []
        while True:
            token = self._next(f"the tuple of {shortened(name.text)} is not closed; add a ]")
            if token[:2] == ("sign", "]"):
                return tuple(values)
            if token.kind not in ("string", "number"):
                raise MapFormatError(
                    f"{token.place}: {shown(token.text)} is in the tuple of "
                    f"{shortened(name.text)}; it must consist of numbers and strings"
                )
            values.append(_value(token))

    def _next(self, expected: str) -> _Token:
        token = next(self._tokens, None)
        if token is None:
            raise MapFormatError(f"{self._place} is the end of the file; {expected}")
        self._place = token.place
        return token


def _value(token: _Token) -> Value:
    if token.kind == "string":
        return token.text
    number = float(token.text)
    if not math.isfinite(number):
        raise MapFormatError(f"{token.place}: {shown(token.text)} is too large")
    return number


# Macros -------------------------------------------------------------------------------------


class _Expansion:
    """Entities of blocks: each has the items of its macros, the base first, and then its own."""

    def __init__(self, macros: dict[str, _Block]) -> None:
        self._macros = macros
        self._items = 0

    def world(self, items: list[tuple[str, Property] | _Block]) -> Entity:
        root = Entity("", "", "")
        self._fill(root, items, 0)
        return root

    def _entity(self, block: _Block, depth: int) -> Entity:
        if depth > MAX_NESTING:
            raise MapFormatError(
                f"{block.place}: entities are nested more than {MAX_NESTING} deep when macros are "
                "expanded; does a macro contain itself?"
            )
        chain = [block]
        while (macro := self._macros.get(chain[-1].word)) is not None:
            chain.append(macro)
            if len(chain) > MAX_NESTING:
                raise MapFormatError(
                    f"{block.place}: {shortened(block.word)} is defined by itself, or by a chain "
                    f"of more than {MAX_NESTING} macros"
                )
        entity = Entity(chain[-1].word, block.word, block.place)
        for part in reversed(chain):
            self._fill(entity, part.items, depth)
        return entity

    def _fill(self, entity: Entity, items: list[tuple[str, Property] | _Block], depth: int) -> None:
        self._items += len(items)
        if self._items > MAX_ITEMS:
            raise MapFormatError(
                f"{entity.place}: the world has more than {MAX_ITEMS:,} properties and entities "
                "when macros are expanded"
            )
        for item in items:
            if isinstance(item, _Block):
                entity.children.append(self._entity(item, depth + 1))
            else:
                entity.properties[item[0]] = item[1]
