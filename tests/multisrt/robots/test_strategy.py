"""Strategies made of explorer classes and of functions."""

from __future__ import annotations

from functools import partial
from typing import Any

import msgspec
import pytest

import multisrt as ms
from multisrt.robots.explorer import Done, RobotSelf
from multisrt.robots.strategy import NoOptions, Strategy, kebab_case


class Tuning(msgspec.Struct, frozen=True, kw_only=True):
    """Settings for tests."""

    margin_m: float = 0.1


class Stays:
    """Stays where it is.

    More lines.
    """

    def __init__(self, me: RobotSelf, options: Tuning) -> None:
        self.me, self.options = me, options

    def run(self) -> Any:
        """End at once."""
        yield Done(complete=False, reason=f"margin {self.options.margin_m}")


class StaysPlainly:
    def __init__(self, me: RobotSelf) -> None:
        self.me = me

    def run(self) -> Any:
        """End at once."""
        yield Done(complete=False, reason="stays")


def test_name_summary_and_options_come_from_the_class() -> None:
    made = Strategy.of(Stays)
    assert (made.name, made.summary, made.options) == ("stays", "Stays where it is", Tuning)
    assert made.explorer is Stays


def test_what_is_given_goes_before_the_class() -> None:
    class Other(Tuning, frozen=True, kw_only=True):
        pass

    made = Strategy.of(Stays, name="waits", summary="Waits", options=Other)
    assert (made.name, made.summary, made.options) == ("waits", "Waits", Other)


def test_a_lambda_needs_a_name() -> None:
    with pytest.raises(ms.InvalidInputError, match=r"a lambda has no name: give name=, as in Str"):
        Strategy.of(lambda me: StaysPlainly(me))
    assert Strategy.of(lambda me: StaysPlainly(me), name="stays").name == "stays"


def test_a_partial_is_to_be_a_function() -> None:
    with pytest.raises(ms.InvalidInputError, match=r"not of functools\.partial.*; write def my_ru"):
        Strategy.of(partial(Stays, options=Tuning()), name="stays")


def test_a_class_that_takes_the_robot_alone_has_no_options() -> None:
    made = Strategy.of(StaysPlainly)
    assert made.options is NoOptions
    assert made.summary == f"StaysPlainly of {__name__}"
    built: Any = made.explorer(None, made.options())  # type: ignore[arg-type]
    assert isinstance(built, StaysPlainly)


def test_a_function_that_builds_an_explorer_is_named_by_itself() -> None:
    def slow_rule(me: RobotSelf, options: Any) -> Stays:
        """Build one."""
        return Stays(me, options)

    made = Strategy.of(slow_rule)
    assert (made.name, made.summary, made.options) == ("slow-rule", "Build one", NoOptions)


def test_an_attribute_options_stands_in_for_an_annotation() -> None:
    class Bare(Stays):
        Options = Tuning

        def __init__(self, me, options) -> None:
            pass

    assert Strategy.of(Bare).options is Tuning


def test_annotations_of_other_parameters_need_not_resolve() -> None:
    class Partly(Stays):
        def __init__(self, me: OnlyForCheckers, options: Tuning) -> None:  # type: ignore[name-defined] # noqa: F821
            pass

    assert Strategy.of(Partly).options is Tuning


def test_an_annotation_of_options_that_does_not_resolve_is_told() -> None:
    class Lost(Stays):
        def __init__(self, me: RobotSelf, options: Tunning) -> None:  # type: ignore[name-defined] # noqa: F821
            pass

    with pytest.raises(ms.InvalidInputError, match=r"'Tunning'.*Lost, cannot be resolved"):
        Strategy.of(Lost)


@pytest.mark.parametrize("given", ["minpos", 3, Tuning()])
def test_neither_class_nor_function_is_refused(given: Any) -> None:
    with pytest.raises(ms.InvalidInputError, match="made of the class of an explorer"):
        Strategy.of(given)


def test_a_class_that_takes_something_else_is_refused() -> None:
    class Needy:
        def __init__(self, me: RobotSelf, options: Tuning, world: str) -> None:
            pass

    class Idle:
        pass

    with pytest.raises(ms.InvalidInputError, match="it needs world, too"):
        Strategy.of(Needy)  # type: ignore[arg-type]
    with pytest.raises(ms.InvalidInputError, match="it takes no argument"):
        Strategy.of(Idle)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "kebab"),
    [("NearestFrontier", "nearest-frontier"), ("SRTWalker", "srt-walker"), ("_my_rule", "my-rule")],
)
def test_names_become_words_with_hyphens(name: str, kebab: str) -> None:
    assert kebab_case(name) == kebab
