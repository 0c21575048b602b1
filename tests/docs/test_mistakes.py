"""The page of mistakes says what the checker says of the explorers in the tests."""

from pathlib import Path

PROGRAM = Path(__file__).parents[2] / "docs" / "mistakes.py"


def test_the_page_is_the_one_that_is_written(load_module):
    program = load_module(PROGRAM)
    assert program.PAGE.read_text() == program.page(), "python docs/mistakes.py"


def test_twenty_mistakes_and_more_are_shown(load_module):
    program = load_module(PROGRAM)
    names = [name for group in program.SHOWN.values() for name in group]
    assert len(names) == len(set(names)) >= 20
    assert set(names) <= {*program.TOLD, *program.WARNED}
