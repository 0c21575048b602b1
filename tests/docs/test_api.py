"""The API reference: every public name once, and nothing that does not exist."""

import re
from collections import Counter
from importlib import import_module
from pathlib import Path
from typing import get_args

import pytest

import multisrt
from multisrt import events
from multisrt.robots import explorer

ROOT = Path(__file__).parents[2]
ENTRY = re.compile(r"^\.\. (?:auto\w+|alias):: (multisrt[\w.]*)$", re.MULTILINE)
DOCUMENTED = [
    found
    for page in sorted((ROOT / "docs" / "api").glob("*.rst"))
    for found in ENTRY.findall(page.read_text())
]


def found(name: str) -> object:
    owner, _, last = name.rpartition(".")
    try:
        return getattr(import_module(owner), last)
    except (AttributeError, ModuleNotFoundError):
        return import_module(name)


def test_every_public_name_is_documented_once():
    counted = Counter(DOCUMENTED)
    own = set(multisrt.__all__) - multisrt._MODULES.keys()
    missing = [name for name in sorted(own) if f"multisrt.{name}" not in counted]
    # Of a module, the names in it are documented.
    for module in multisrt._MODULES.values():
        offered = import_module(f"multisrt.{module}").__all__
        missing += [name for name in offered if f"multisrt.{module}.{name}" not in counted]
    assert not missing, "add these to a page in docs/api"
    assert [name for name, count in counted.items() if count > 1] == []


@pytest.mark.parametrize("module", ["driving", "envs", "robots.toolkit", "testing"])
def test_names_that_a_package_offers_are_documented(module):
    offered = import_module(f"multisrt.{module}")
    objects = {id(found(name)) for name in DOCUMENTED}
    missing = [name for name in offered.__all__ if id(getattr(offered, name)) not in objects]
    assert not missing, "add these to a page in docs/api"


def test_all_events_are_documented():
    names = {f"multisrt.events.{event.__name__}" for event in get_args(events.AnyEvent)}
    assert len(names) > 12
    assert names <= set(DOCUMENTED)


def test_everything_that_is_documented_exists():
    for name in DOCUMENTED:
        assert found(name).__doc__, name


def test_nothing_is_documented_under_two_names():
    objects = [found(name) for name in DOCUMENTED]
    assert len({id(thing) for thing in objects}) == len(objects)


def test_the_contract_of_explorers_is_documented_whole():
    defined = {
        f"multisrt.robots.explorer.{name}"
        for name, value in vars(explorer).items()
        if getattr(value, "__module__", "") == explorer.__name__ and not name.startswith("_")
    }
    assert len(defined) > 12
    assert defined <= set(DOCUMENTED)


def test_full_names_in_pages_exist():
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        for name in re.findall(r"`(multisrt(?:\.\w+)+)(?:\(\))?`", page.read_text()):
            assert found(name) is not None, (page, name)
