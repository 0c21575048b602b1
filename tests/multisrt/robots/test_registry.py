"""The registry: strategies by name, their options, and those of other packages."""

import math
from dataclasses import replace

import msgspec
import pytest

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.srt_options import SrtOptions
from multisrt.robots import registry
from multisrt.robots.explorer import Done, Explorer, RobotSelf
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.registry import register, strategies, strategy
from multisrt.robots.strategy import Strategy


class Options(msgspec.Struct, frozen=True, kw_only=True):
    speed: float = 1.0
    turns: int = 3
    eager: bool = False
    mood: str = "calm"


def no_explorer(me: RobotSelf, options: object) -> Explorer:
    raise NotImplementedError


@pytest.fixture
def own():
    """A strategy."""
    return Strategy(name="own", summary="mine", options=Options, explorer=no_explorer)


def test_the_srt_family_is_registered():
    assert [s.name for s in strategies()][:3] == ["srt-ball", "srt-star", "srt-radial"]
    assert all(s.summary for s in strategies())


def test_an_unknown_strategy_lists_all():
    with pytest.raises(InvalidInputError) as error:
        strategy("srt-radiall")
    assert "'srt-radiall' (did you mean 'srt-radial'?)" in str(error.value)
    for known in strategies():
        assert known.name in str(error.value)


def test_a_new_strategy_is_found(own):
    register(own)
    assert strategy("own") is own
    assert own in strategies()


def test_duplicates_are_refused(own):
    register(own)
    with pytest.raises(InvalidInputError, match="'own' already"):
        register(replace(own, summary="another"))
    with pytest.raises(InvalidInputError, match="'srt-star' already"):
        register(Strategy(name="srt-star", summary="", options=Options, explorer=no_explorer))


def test_registering_the_same_again_does_nothing(own):
    class Alone:
        def __init__(self, me):
            self.me = me

        def run(self):
            yield Done(complete=False, reason="as I like")

    class WithOptions(Alone):
        def __init__(self, me, options: Options):
            super().__init__(me)

    for kind in (Alone, WithOptions):
        register(kind)
        register(kind)
        register(Strategy.of(kind), replace=True)
        register(kind)
    register(own)
    register(own)
    assert [s.name for s in strategies()][-3:] == ["alone", "with-options", "own"]


def test_options_have_defaults(own):
    assert own.parse_options({}) == Options()
    given = strategy("srt-star").parse_options({})
    assert given == MultiSrtOptions()
    # In its own tree, a robot of a team explores like a robot that is alone.
    assert msgspec.structs.asdict(SrtOptions()).items() <= msgspec.structs.asdict(given).items()


@pytest.mark.parametrize(
    ("key", "text", "value"),
    [
        ("speed", "2.5", 2.5),
        ("speed", 2, 2.0),
        ("turns", "7", 7),
        ("eager", "true", True),
        ("eager", "false", False),
        ("eager", True, True),
        ("mood", "wild", "wild"),
    ],
)
def test_options_may_be_written_as_text(own, key, text, value):
    assert getattr(own.parse_options({key: text}), key) == value


def test_an_unknown_option_lists_all(own):
    with pytest.raises(InvalidInputError) as error:
        own.parse_options({"sped": 1.0})
    assert str(error.value) == (
        "own has no option 'sped' (did you mean 'speed'?); it has: speed, turns, eager, mood"
    )


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("speed", "fast"),
        ("turns", 1.5),
        ("turns", "1.5"),
        ("eager", "maybe"),
        ("mood", 3),
        ("speed", [1.0]),
    ],
)
def test_a_value_of_the_wrong_kind_is_refused_by_name(own, key, value):
    with pytest.raises(InvalidInputError, match=f"option {key}=.*of own"):
        own.parse_options({key: value})


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("alpha", "7"),
        ("alpha", math.nan),
        ("max_draws", 0),
        ("cones", "2"),
        ("backtrack", "sideways"),
        ("margin_m", "0"),
    ],
)
def test_a_value_that_is_not_allowed_is_refused_by_name(key, value):
    with pytest.raises(InvalidInputError, match=key) as error:
        strategy("srt-star").parse_options({key: value})
    assert "srt-star" in str(error.value)


class EntryPoint:
    def __init__(self, name, loaded):
        self.name = name
        self.load = lambda: loaded


def test_other_packages_add_strategies_by_entry_points(own, monkeypatch):
    monkeypatch.undo()
    found = [EntryPoint("other", own)]
    monkeypatch.setattr(registry, "entry_points", lambda group: found)
    fresh = registry._registry.__wrapped__
    assert list(fresh())[-1] == "own"
    found.append(EntryPoint("another", own))
    with pytest.raises(InvalidInputError, match="'other' gives a second strategy 'own'"):
        fresh()


def test_a_broken_entry_point_does_not_hide_the_others(own, monkeypatch):
    monkeypatch.undo()

    class Broken(EntryPoint):
        def __init__(self, name):
            self.name = name

        def load(self):
            raise ImportError("No module named 'elsewhere'")

    found = [Broken("broken"), EntryPoint("other", own), EntryPoint("wrong", 7)]
    monkeypatch.setattr(registry, "entry_points", lambda group: found)
    fresh = registry._registry.__wrapped__()
    assert list(fresh)[-1] == "own"
    monkeypatch.setattr(registry, "_registry", lambda: fresh)
    assert registry.broken_strategies() == {
        "broken": "ImportError: No module named 'elsewhere'",
        "wrong": "it gives a int, not a Strategy",
    }
    with pytest.raises(InvalidInputError, match="'broken' of another package could not be loaded"):
        strategy("broken")
    with pytest.raises(InvalidInputError, match="there is no strategy 'brocken'"):
        strategy("brocken")
