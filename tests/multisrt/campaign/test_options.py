"""Drawing options from what their structures declare."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

import msgspec
import pytest

from multisrt.campaign.chance import Chance
from multisrt.campaign.options import NONE, draw_options
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.registry import strategies, strategy
from multisrt.robots.strategy import Strategy

DRAWS = 300


class Options(msgspec.Struct, frozen=True, kw_only=True):
    """Options of a strategy that no campaign knows."""

    share: Annotated[float, msgspec.Meta(ge=0.2, le=0.6)] = 0.5
    rule: Literal["near", "far"] = "near"
    fast: bool = False
    after: int = 4
    limit_s: float | None = None
    width_m: float = 0.1
    word: str = "free"

    def __post_init__(self) -> None:
        if self.after < 2:
            raise InvalidInputError("after is at least 2")
        if self.fast and self.rule == "far":
            raise InvalidInputError("what is far is slow")


def _unused(me: object, options: object) -> Any:
    raise AssertionError


@pytest.fixture(scope="module")
def draws() -> list[dict[str, bool | int | float | str]]:
    """Options that were drawn for a structure of its own."""
    made = Strategy(name="own", summary="Own", options=Options, explorer=_unused)
    return [draw_options(made, Chance(1, number)) for number in range(DRAWS)]


def _values(draws: list[dict[str, bool | int | float | str]], name: str) -> Iterator[Any]:
    return (options[name] for options in draws if name in options)


def test_an_option_unknown_to_the_campaign_is_drawn(draws):
    drawn = {name for options in draws for name in options}
    assert drawn == {"share", "rule", "fast", "after", "limit_s", "width_m"}
    assert set(_values(draws, "rule")) == {"far"}
    assert set(_values(draws, "fast")) == {True}
    assert len(set(_values(draws, "limit_s"))) > 5


def test_declared_bounds_and_checks_hold(draws):
    assert all(0.2 <= share <= 0.6 for share in _values(draws, "share"))
    assert min(_values(draws, "after")) == 2
    assert not any(options.keys() >= {"fast", "rule"} for options in draws)
    assert min(_values(draws, "width_m")) >= 0.0


def test_options_that_are_given_are_kept_if_there_are_any():
    given: dict[str, bool | float | str] = {"home": "worth", "pursue": True, "effort": 0.1}
    assert draw_options(strategy("minpos"), Chance(4), given).items() >= {
        ("home", "worth"),
        ("pursue", True),
    }
    assert draw_options(strategy("informed"), Chance(4), given)["effort"] == 0.1
    # Multi-SRT knows no pairs.
    assert "home" not in draw_options(strategy("srt-star"), Chance(4), {"home": "relays"})


@pytest.mark.parametrize("name", [each.name for each in strategies()])
def test_every_strategy_takes_what_is_drawn_for_it(name):
    taken = strategy(name)
    drawn = [draw_options(taken, Chance(2, number)) for number in range(40)]
    for options in drawn:
        taken.parse_options(options)
    assert len({key for options in drawn for key in options}) >= 3 - (name == "informed")


def test_at_times_all_waits_are_shorter_by_one_factor_but_not_the_periods():
    class Waits(msgspec.Struct, frozen=True, kw_only=True):
        first_s: float = 30.0
        last_s: float = 6.0
        look_period_s: float = 30.0
        width_m: float = 30.0

    made = Strategy(name="own", summary="Own", options=Waits, explorer=_unused)
    drawn = [draw_options(made, Chance(1, number)) for number in range(DRAWS)]
    factors = [
        (30.0 / float(options["first_s"]), 6.0 / float(options["last_s"]))
        for options in drawn
        if options.keys() == {"first_s", "last_s"} and all(options.values())
    ]
    hasty = [first for first, last in factors if first == pytest.approx(last, rel=0.01)]
    assert 0.03 * DRAWS < len(hasty) < 0.3 * DRAWS
    assert min(hasty) > 2.9
    assert max(hasty) < 12.1


def test_none_is_drawn_where_a_default_is_not_none():
    class Given(msgspec.Struct, frozen=True, kw_only=True):
        wait_s: float | None = 3.0

    made = Strategy(name="own", summary="Own", options=Given, explorer=_unused)
    drawn = [draw_options(made, Chance(1, n)).get("wait_s") for n in range(60)]
    assert NONE in drawn


def test_sometimes_all_numbers_of_attempts_are_small():
    limits = ("patience", "max_waits", "max_jams", "max_instant_goals", "max_vain_motions")
    few = 0
    for number in range(DRAWS):
        options = draw_options(strategy("minpos"), Chance(2, number))
        few += all(options.get(name) in (1, 2, 3) for name in limits)
    assert 0.1 * DRAWS < few < 0.2 * DRAWS
