"""Whether the fields of a strategy can be used, in words that say what to write instead."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any, NoReturn

import msgspec

from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.robots.defects import article, brief
from multisrt.validation_errors import explained

MAX_NAME_LENGTH = 60
"""Maximum length of a name in characters: folders and table columns are named after it."""

_NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")


def require_fields(
    name: object, summary: object, options: object, explorer: object, **callables: object
) -> None:
    """Check the fields of a strategy.

    Parameters
    ----------
    name, summary, options, explorer : object
        As those of `Strategy`.
    **callables : object
        Its other fields: functions or None.

    Raises
    ------
    InvalidInputError
        If one cannot be used; the message says which, and what to give.

    Examples
    --------
    >>> class Options(msgspec.Struct, frozen=True, kw_only=True):
    ...     margin_m: float = 0.1
    >>> require_fields("My Rule", "Goes far", Options, lambda me, options: None)
    Traceback (most recent call last):
    ...
    multisrt.geometry.errors.InvalidInputError: name of a strategy is 'My Rule'; give lower-case \
letters and digits, joined by hyphens: 'my-rule'
    """
    if not isinstance(name, str):
        _refuse("name of a strategy", name, "give text, such as 'my-rule'")
    if not _NAME.fullmatch(name) or len(name) > MAX_NAME_LENGTH:
        _refuse_name(name)
    whose = f"of strategy {name!r}"
    if not isinstance(summary, str):
        _refuse(f"summary {whose}", summary, "give one line of text that says what it does")
    if len(summary.splitlines()) > 1:
        _refuse(f"summary {whose}", summary, "give one line: lists of strategies show it")
    _require_options(options, whose)
    _require_explorer(explorer, whose)
    for field, value in callables.items():
        if value is not None and not callable(value):
            _refuse(f"{field} {whose}", value, "give a function, or None")


def _require_options(options: object, whose: str) -> None:
    remedy = "class Options(msgspec.Struct, frozen=True, kw_only=True): ..."
    if isinstance(options, msgspec.Struct):
        kind = type(options).__name__
        _refuse(f"options {whose}", options, f"give the class, options={kind}, not an instance")
    if not (isinstance(options, type) and issubclass(options, msgspec.Struct)):
        _refuse(f"options {whose}", options, f"give a frozen structure: {remedy}")
    if not options.__struct_config__.frozen:
        raise InvalidInputError(
            f"options {whose}: {options.__name__} can be changed, and all robots share it; write "
            f"{remedy}"
        )
    for field in msgspec.structs.fields(options):
        if field.default is not msgspec.NODEFAULT:
            _require_default(field, options.__name__, whose)


def _require_default(field: msgspec.structs.FieldInfo, options: str, whose: str) -> None:
    try:
        msgspec.convert(msgspec.to_builtins(field.default), field.type)
    except msgspec.ValidationError as error:
        raise InvalidInputError(
            f"options {whose}: the default of {options}.{field.name} is {brief(field.default)}, "
            f"which is not as declared: {explained(error, field.type)}; change the default or the "
            "annotation"
        ) from None


def _require_explorer(explorer: object, whose: str) -> None:
    what = f"explorer {whose}"
    if hasattr(explorer, "run") and not isinstance(explorer, type):
        kind = type(explorer).__name__
        _refuse(what, explorer, f"give the class, explorer={kind}: every robot gets one of its own")
    if not callable(explorer):
        _refuse(what, explorer, "give the class of an explorer, or a function that builds one")
    title = getattr(explorer, "__qualname__", type(explorer).__name__)
    if isinstance(explorer, type) and not callable(getattr(explorer, "run", None)):
        raise InvalidInputError(
            f"{what}: the class {title} has no run(); write def run(self), a generator that "
            "yields actions and is sent their outcomes"
        )
    made: Any = inspect.unwrap(explorer)
    if inspect.isabstract(made):
        own = [name for name in vars(made) if name not in dir(made.__base__)]
        lacking = ", ".join(
            f"{name}(){did_you_mean(name, own)}" for name in sorted(made.__abstractmethods__)
        )
        raise InvalidInputError(f"{what}: the class {made.__qualname__} does not define {lacking}")
    _require_parameters(explorer, what, title)


def _require_parameters(explorer: Callable[..., Any], what: str, title: str) -> None:
    try:
        # A wrapper is called with its own parameters, not with those of what it wraps.
        signature = inspect.signature(explorer, follow_wrapped=False)
    except (TypeError, ValueError):  # built in, without a signature
        return
    try:
        signature.bind(None, None)
    except TypeError:
        is_class = isinstance(explorer, type)
        takes = f"{title}.__init__" if is_class else f"{title}()"
        head = "def __init__(self, me, options)" if is_class else f"def {title}(me, options)"
        raise InvalidInputError(
            f"{what}: {takes} takes {signature}, and is given the robot (a RobotSelf) and the "
            f"options; write {head}"
        ) from None


def _refuse_name(name: str) -> NoReturn:
    words = re.findall("[a-z0-9]+", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", name).lower())
    better = "-".join(words)[:MAX_NAME_LENGTH].strip("-") or "my-rule"
    limit = f" (at most {MAX_NAME_LENGTH})" if len(name) > MAX_NAME_LENGTH else ""
    raise InvalidInputError(
        f"name of a strategy is {brief(name)}; give lower-case letters and digits{limit}, joined "
        f"by hyphens: {better!r}"
    )


def _refuse(field: str, value: object, remedy: str) -> NoReturn:
    raise InvalidInputError(f"{field} is {brief(value)}, {article(type(value).__name__)}; {remedy}")
