"""What is said of the separate parts of a world, and of robots that start in a minor one."""

import re

import pytest
import shapely

from multisrt.cli.reach import areas, around, elsewhere
from multisrt.environments.environment import Environment

ROOMS = Environment("rooms", shapely.union_all([shapely.box(0, 0, 2, 2), shapely.box(3, 0, 13, 4)]))
WALLS = shapely.box(1, 1, 9, 9) - shapely.box(1.5, 1.5, 8.5, 8.5)
PLAN = Environment.from_outline("plan", shapely.box(0, 0, 10, 10), [WALLS])


def test_a_start_in_the_largest_area_needs_no_word():
    assert elsewhere(ROOMS, (5.0, 1.0, 0.0)) == ""


def test_a_start_in_a_minor_area_is_said():
    assert elsewhere(ROOMS, (1.0, 1.0)) == (
        "free space has 2 separate parts (40, 4 m2), and the start is in that of 4 m2 (9 %); "
        "the largest has 40 m2, e.g. at (8.00, 2.00)"
    )


def test_a_start_outside_of_the_building_is_said():
    assert elsewhere(PLAN, (0.5, 0.5)) == (
        "free space has 2 separate parts (49, 36 m2), and the start is in that of 36 m2 (42 %), "
        "which lies around others and touches the border of the map; the largest inside has "
        "49 m2, e.g. at (5.00, 5.00)"
    )


def test_a_start_outside_is_said_even_where_most_of_free_space_is():
    wide = shapely.box(0, 0, 12, 12)
    plan = Environment.from_outline("wide", wide, [WALLS])
    assert "lies around others" in elsewhere(plan, (11.0, 11.0))


def test_a_start_in_the_largest_of_many_is_said_by_its_share():
    halls = [shapely.box(11 * k, 0, 11 * k + 10, 4 + 0.1 * (k == 0)) for k in range(7)]
    world = Environment("halls", shapely.union_all(halls))
    assert elsewhere(world, (1.0, 1.0)) == (
        "free space has 7 separate parts (41, 40, 40, 40, 40, ... m2), and the start is in that "
        "of 41 m2 (15 %)"
    )


def test_areas_and_what_lies_around():
    assert areas(PLAN) == "2 separate parts (49, 36 m2)"
    assert around(PLAN) == (
        "the part of 36 m2 lies around the others: it touches the border of the map"
    )
    assert around(ROOMS) == ""


def test_large_areas_are_told_in_digits():
    park = Environment(
        "park", shapely.union_all([shapely.box(0, 0, 600, 650), shapely.box(601, 0, 700, 200)])
    )
    assert areas(park) == "2 separate parts (390,000, 19,800 m2)"
    assert "that of 19,800 m2 (5 %); the largest has 390,000 m2" in elsewhere(park, (650.0, 100.0))
    assert "409,800 m2 free" in repr(park)


PAGE = Environment.from_outline("page", shapely.box(0, 0, 30, 40), [WALLS])


def test_a_page_around_a_small_plan_is_told_with_a_start_inside():
    assert around(PAGE) == (
        "the part of 1136 m2 lies around the others: it touches the border of the map; if it is "
        "the page around a building, explore the inside with --start 5.00,5.00"
    )
    said = elsewhere(PAGE, (20.0, 20.0))
    assert said.startswith("free space has 2 separate parts (1136, 49 m2), and the start is in")
    assert said.endswith(
        "that of 1136 m2 (96 %), which lies around others and touches the border of the map; the "
        "largest inside has 49 m2, e.g. at (5.00, 5.00); if it is the page around a building, "
        "explore the inside with --start 5.00,5.00"
    )


def test_a_start_inside_is_not_sent_to_the_page():
    two = Environment.from_outline("two", shapely.box(0, 0, 12, 12), [WALLS])
    assert elsewhere(two, (5.0, 5.0)) == (
        "free space has 2 separate parts (80, 49 m2), and the start is in that of 49 m2 (38 %); "
        "that of 80 m2 lies around others"
    )


@pytest.mark.slow
def test_explore_says_where_the_robots_are(call, folder):
    (folder / "plan.wkt").write_text(shapely.to_wkt(PLAN.free))
    (folder / "rooms.wkt").write_text(shapely.to_wkt(ROOMS.free))
    small = ("--footprint", "disc:0.2")
    code, out, _ = call("explore", "rooms.wkt", "--start", "1,1", *small)
    assert code == 0
    assert "2 separate parts (40, 4 m2), and the start is in that of 4 m2 (9 %)" in out
    # The body is not the reason why the other room is not explorable.
    assert "with the body" not in out
    _, out, _ = call("explore", "rooms.wkt", "--start", "5,1", *small, "--out", "large")
    assert "separate parts" not in out
    assert "with the body" not in out
    _, out, _ = call("explore", "plan.wkt", "--start", "0.5,0.5", *small)
    assert "which lies around others and touches the border of the map" in out


@pytest.mark.slow
def test_explore_says_where_the_body_is_the_reason(call):
    # Two rooms of 30 m2, with a door of 0.4 m between them.
    code, out, _ = call("explore", "narrow.wkt", "--start", "1,1", "--range", "1")
    assert code == 0
    assert "separate parts" not in out
    assert re.search(r"with the body disc:0.25 only \d+\.\d of 60\.1 m2 of free space are", out)


def test_environments_show_tells_of_areas(call, folder):
    (folder / "plan.wkt").write_text(shapely.to_wkt(PLAN.free))
    code, out, _ = call("environments", "show", "plan.wkt")
    assert code == 0
    assert "2 separate parts (49, 36 m2)" in out
    assert "the part of 36 m2 lies around the others" in out


def test_experiment_check_warns_of_starts_outside(call, folder):
    # There is more paper around the wide plan than room in the building: no start is drawn there.
    wide = Environment.from_outline("wide", shapely.box(0, 0, 12, 12), [WALLS])
    for world in (PLAN, wide):
        (folder / f"{world.name}.wkt").write_text(shapely.to_wkt(world.free))
    text = (
        'name = "plans"\nenvironments = ["{}.wkt"]\nstrategies = ["closest"]\n'
        'bodies = ["disc:0.2"]\nrepetitions = 1\n{}'
    )
    for name in ("plan", "wide"):
        (folder / "plans.toml").write_text(text.format(name, ""))
        code, _, err = call("experiment", "check", "plans.toml", "--seconds", "0")
        assert (code, err) == (0, "")
    given = "starts = [{ places = [[0.5, 0.5]] }]"
    (folder / "plans.toml").write_text(text.format("wide", given))
    code, _, err = call("experiment", "check", "plans.toml", "--seconds", "0")
    assert code == 0
    (warning,) = err.splitlines()
    assert warning.startswith("warning: [wide, closest, 1 robot")
    assert "which lies around others and touches the border of the map" in warning


def test_experiment_check_warns_of_a_page_around_a_small_plan(call, folder):
    (folder / "page.wkt").write_text(shapely.to_wkt(PAGE.free))
    text = (
        'name = "pages"\nenvironments = ["page.wkt"]\nstrategies = ["closest"]\n'
        'bodies = ["disc:0.2"]\nrepetitions = 1\nrobots = {}\n'
    )
    for robots, places in ((1, "[[5.00,5.00]]"), (2, "[[5.00,5.00], ...]")):
        (folder / "pages.toml").write_text(text.format([robots]))
        code, _, err = call("experiment", "check", "pages.toml", "--seconds", "0")
        assert code == 0
        (warning,) = err.splitlines()
        assert "the start is in that of 1136 m2 (96 %), which lies around others" in warning
        assert warning.endswith(
            "; if it is the page around a building, start inside with "
            f"starts = [{{ places = {places} }}]"
        )


def test_the_page_is_told_without_advice_to_robots_inside():
    room, page = PAGE.component(5.0, 5.0), PAGE.component(20.0, 20.0)
    assert around(PAGE, room) == (
        "the part of 1136 m2 lies around the others: it touches the border of the map"
    )
    assert around(PAGE, page) == around(PAGE)
