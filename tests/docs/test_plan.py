import re
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
MAX_ROOMS = 32


@pytest.fixture(scope="module")
def plan(load_module) -> ModuleType:
    """The program that draws the plan."""
    return load_module(ROOT / "docs" / "plan.py")


def test_the_picture_shows_the_rooms_and_arrows_of_today(plan):
    lines, arrows = plan.read_rooms()
    shown = plan.PICTURE.read_text()
    assert set(re.findall(r'class="name"[^>]*>(\w+)<', shown)) == set(lines)
    assert shown.count('<path class="') == sum(map(len, arrows.values()))


def test_no_arrow_runs_upwards_and_rooms_are_few(plan):
    _, arrows = plan.read_rooms()
    floors = plan.floors_of(arrows)
    level = {room: k for k, rooms in enumerate(floors) for room in rooms}
    assert all(level[other] < level[room] for room in arrows for other in arrows[room])
    assert len(arrows) <= MAX_ROOMS


def test_every_room_is_described(plan):
    page = (ROOT / "docs" / "architecture.md").read_text()
    table = page[page.index("## Packages and modules") : page.index("## Data flow")]
    for room in plan.read_rooms()[0]:
        assert f"`{room}" in table, room


def test_rooms_are_coloured_by_what_imports_them(plan):
    arrows = {"simulation": {"robots", "world"}, "robots": {"geometry"}, "world": {"geometry"}}
    kinds = plan.kinds_of(arrows | {"geometry": set(), "cli": {"simulation"}})
    truth = ["simulation", "world"]
    assert kinds == dict.fromkeys(["robots", "geometry"], "robots") | dict.fromkeys(
        truth, "truth"
    ) | {"cli": ""}


def test_a_cycle_is_refused(plan):
    with pytest.raises(plan.CircularImportsError, match="a, b"):
        plan.floors_of({"a": {"b"}, "b": {"a"}, "c": {"a"}})


def test_arrows_that_a_longer_path_implies_are_not_direct(plan):
    arrows = {"a": {"b", "c"}, "b": {"c"}, "c": set()}
    assert plan.direct_arrows(arrows) == {"a": {"b"}, "b": {"c"}, "c": set()}
    assert plan.floors_of(arrows) == [["c"], ["b"], ["a"]]
