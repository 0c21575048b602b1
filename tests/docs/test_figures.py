"""The pictures of the pages are those that the code draws today: else, ``make pictures``."""

import runpy
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "docs" / "figures"


@pytest.fixture(scope="module")
def program():
    """The program that draws the pictures."""
    sys.path.insert(0, str(FOLDER))
    try:
        yield runpy.run_path(str(FOLDER / "__main__.py"))
    finally:
        sys.path.remove(str(FOLDER))


def test_there_is_a_file_for_every_figure(program):
    drawn = {(folder, name) for folder, all in program["FIGURES"].items() for name in all}
    pictures = program["PICTURES"]
    stored = {
        ("" if file.parent == pictures else file.parent.name, file.stem)
        for file in pictures.rglob("*.svg")
    }
    # `docs/plan.py` draws the plan; see test_plan.py.
    assert stored == drawn | {("", "plan")}


@pytest.mark.slow
def test_pictures_of_algorithms_are_those_of_today(program):
    for name, draw in program["FIGURES"]["algorithms"].items():
        stored = (program["PICTURES"] / "algorithms" / f"{name}.svg").read_text()
        assert draw() == stored, f"{name}: make pictures"


@pytest.mark.slow
def test_the_replay_of_the_documentation_is_that_of_today(program):
    (name, make), *others = program["runs"].PAGES.items()
    assert not others
    assert make() == (program["PICTURES"] / f"{name}.html").read_text("utf-8"), "make pictures"


# That of the tutorial is held to its command; see test_tutorial.py.
@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "museum-team-radial",
        "museum-team-animation",
        "apartment-minpos-animation",
        "museum-team-star",
        "apartment-minpos",
        "star-radial-teams",
    ],
)
def test_pictures_of_runs_are_those_of_today(program, name):
    stored = (program["PICTURES"] / f"{name}.svg").read_text()
    assert program["FIGURES"][""][name]() == stored, "make pictures"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["world-apartment", "strategy-minpos"])
def test_pictures_of_the_gallery_are_those_of_today(program, name):
    stored = (program["PICTURES"] / "gallery" / f"{name}.svg").read_text()
    assert program["FIGURES"]["gallery"][name]() == stored, "make pictures"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["trajectories", "without-layers"])
def test_figures_of_papers_are_those_of_today(program, name):
    stored = (program["PICTURES"] / "figures" / f"{name}.svg").read_text()
    assert program["FIGURES"]["figures"][name]() == stored, "make pictures"
