"""Options of strategies, drawn from what their structures declare.

Nothing here names an option: the type, the default and the checks of a structure of options say
what can be drawn, so that an option which is added to a strategy is drawn as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import msgspec
from msgspec import inspect

from multisrt.campaign.chance import Chance, rounded
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.strategy import Strategy
from multisrt.spec import Scalar

MAX_TRIES: Final = 6
"""Values of one option that are drawn until the structure takes one."""

NUMBERS: Final = {0: 0.3, 1: 0.2, 2: 0.15, 3: 0.12, 5: 0.13, 8: 0.07, 20: 0.03}
"""How many options are given other values than their defaults, with weights."""

FACTOR: Final = 4.0
"""Largest factor, and inverse of the smallest, by which a number differs from its default."""

LENGTH_FACTOR: Final = 2.0
"""The same for the smallest of a length: cells of half the width already are four times as many."""

LENGTHS_M: Final = (0.1, 4.0)
"""Smallest and largest value of a length whose default is computed, in metres."""

SHORT_WAITS: Final = 0.3
"""Share of draws with shorter waits: a robot that waits for ever shows in a run that goes on for
longer than all waits together."""

SHORTER: Final = (3.0, 12.0)
"""Smallest and largest factor by which they are shorter."""

FEW_ATTEMPTS: Final = 0.15
"""Share of draws in which all numbers of attempts are small: robots reach the limits of what they
try, and what they do then."""

FEW: Final = (1, 3)
"""Smallest and largest number of attempts in these draws."""

NONE: Final = "none"
"""None, as it is written in a spec."""


def draw_options(
    strategy: Strategy, chance: Chance, given: Mapping[str, Scalar] | None = None
) -> dict[str, Scalar]:
    """Return options for a strategy, each of which it takes, and all together.

    Parameters
    ----------
    strategy : Strategy
        The strategy.
    chance : Chance
        Where random choices come from.
    given : mapping of str to scalar, optional
        Options that are given already; those that the strategy does not have are left out.

    Returns
    -------
    dict of str to scalar
        Options by name, without those left at their defaults.

    Examples
    --------
    >>> from multisrt.robots.registry import strategy
    >>> minpos = strategy("minpos")
    >>> options = draw_options(minpos, Chance(7), {"home": "worth", "unknown": 1})
    >>> options["home"], "unknown" in options
    ('worth', False)
    """
    fields = _fields(strategy.options)
    found = {name: value for name, value in (given or {}).items() if name in fields}
    found = {name: value for name, value in found.items() if _takes(strategy, {name: value})}
    if chance.happens(SHORT_WAITS):
        found |= _short_waits(strategy, fields, chance.magnitude(*SHORTER))
    if chance.happens(FEW_ATTEMPTS):
        found |= _few_attempts(strategy, fields, found, chance)
    free = [name for name in fields if name not in found]
    for name in chance.some_of(free, min(chance.weighted(NUMBERS), len(free))):
        for _ in range(MAX_TRIES):
            value = _value(fields[name], chance)
            if value != fields[name].default and _takes(strategy, found | {name: value}):
                found[name] = value
                break
    while found and not _takes(strategy, found):
        found.popitem()
    return found


def _short_waits(
    strategy: Strategy, fields: Mapping[str, inspect.Field], factor: float
) -> dict[str, Scalar]:
    """Return options with all times but periods divided by a factor."""
    shorter = {
        name: rounded(field.default / factor)
        for name, field in fields.items()
        if name.endswith("_s") and not name.endswith("_period_s") and _is_positive(field.default)
    }
    return {name: value for name, value in shorter.items() if _takes(strategy, {name: value})}


def _few_attempts(
    strategy: Strategy,
    fields: Mapping[str, inspect.Field],
    given: Mapping[str, Scalar],
    chance: Chance,
) -> dict[str, Scalar]:
    """Return options with small whole numbers in place of all larger ones."""
    found: dict[str, Scalar] = {}
    for name, field in fields.items():
        if name in given or not isinstance(field.type, inspect.IntType) or field.default <= FEW[1]:
            continue
        few = {name: chance.whole(*FEW)}
        if _takes(strategy, {**given, **found, **few}):
            found |= few
    return found


def _is_positive(default: Any) -> bool:
    return isinstance(default, int | float) and default > 0.0


def _fields(options: type[msgspec.Struct]) -> dict[str, inspect.Field]:
    described = inspect.type_info(options)
    assert isinstance(described, inspect.StructType)
    return {field.name: field for field in described.fields}


def _takes(strategy: Strategy, options: Mapping[str, Scalar]) -> bool:
    try:
        strategy.parse_options(options)
    except InvalidInputError:
        return False
    return True


def _value(field: inspect.Field, chance: Chance) -> Scalar:
    kinds = list(field.type.types) if isinstance(field.type, inspect.UnionType) else [field.type]
    some = [kind for kind in kinds if not isinstance(kind, inspect.NoneType)]
    default = None if field.default is msgspec.NODEFAULT else field.default
    if len(some) < len(kinds) and default is not None and chance.happens(0.3):
        return NONE
    match kind := chance.one_of(some):
        case inspect.BoolType():
            return not default if isinstance(default, bool) else chance.happens(0.5)
        case inspect.LiteralType():
            return chance.one_of([value for value in kind.values if value is not None])
        case inspect.IntType():
            return int(_within(kind, _whole(default, chance)))
        case inspect.FloatType():
            return _within(kind, _number(field.name, default, chance))
    return NONE if default is None else str(default)  # text without choices is left as it is


def _whole(default: Any, chance: Chance) -> int:
    usual = default if isinstance(default, int) and default > 0 else 3
    if chance.happens(0.4):
        return chance.whole(0, 2)
    return round(chance.magnitude(usual / FACTOR, usual * FACTOR))


def _number(name: str, default: Any, chance: Chance) -> float:
    if chance.happens(0.1):
        return 0.0
    usual = float(default) if isinstance(default, int | float) and default > 0.0 else 1.0
    if usual <= 1.0 and not name.endswith(("_m", "_s")) and chance.happens(0.5):
        return chance.number(0.0, 1.0)  # probably a share
    if default is None and name.endswith("_m"):
        return chance.magnitude(*LENGTHS_M)  # by default often the body's width
    low = usual / (LENGTH_FACTOR if name.endswith("_m") else FACTOR)
    return chance.magnitude(low, usual * FACTOR)


def _within(kind: inspect.IntType | inspect.FloatType, value: float) -> float:
    if kind.ge is not None:
        value = max(value, kind.ge)
    if kind.le is not None:
        value = min(value, kind.le)
    return rounded(value) if isinstance(kind, inspect.FloatType) else value
