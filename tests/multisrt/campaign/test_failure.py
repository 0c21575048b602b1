"""The folder of a failure."""

import re

import pytest

from multisrt.campaign.failure import (
    FAILURE_NAME,
    SPEC_NAME,
    Failure,
    read_failure,
    write_failure,
)
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import CatalogEnvironment, RobotSpec, RunSpec

SPEC = RunSpec(environment=CatalogEnvironment(name="open"), seed=3)
DRAWN = RunSpec(environment=CatalogEnvironment(name="museum"), robots=(RobotSpec(),) * 3)
FAILURE = Failure(
    says='robot 1 touches a "wall"', invariant="no-collision", seed=7, number=12, robot=1, tries=9
)


@pytest.fixture
def folder(tmp_path):
    """The folder of a failure."""
    folder = tmp_path / "failures" / "000012-no-collision"
    write_failure(folder, FAILURE, SPEC, DRAWN)
    return folder


def test_a_failure_is_read_as_it_was_written(folder):
    assert read_failure(folder) == (FAILURE, SPEC)
    assert read_failure(folder / SPEC_NAME) == (FAILURE, SPEC)
    assert RunSpec.from_toml((folder / "drawn.toml").read_text()) == DRAWN
    assert FAILURE.violation.robot == 1
    first = (folder / FAILURE_NAME).read_text().splitlines()[0]
    assert "touches a" in first


def test_another_path_is_refused_in_plain_words(folder, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "campaign.sqlite").write_text("")
    for path, said in (
        (tmp_path / "nope", f"there is no {tmp_path}/nope: name the folder of a failure"),
        (tmp_path / "campaign.sqlite", "is a file, but not one of a failure: name the folder"),
        (tmp_path / "empty", "is not the folder of a failure, as it has no failure.toml: name"),
        (folder.parent, f"as it has no failure.toml: name one in it, such as {folder}"),
    ):
        with pytest.raises(InvalidInputError, match=re.escape(said)) as told:
            read_failure(path)
        assert "Errno" not in str(told.value)


@pytest.mark.parametrize(("name", "text"), [(FAILURE_NAME, "says = 1"), (SPEC_NAME, "seed = -1")])
def test_a_damaged_file_is_named(folder, name, text):
    (folder / name).write_text(text)
    with pytest.raises(InvalidInputError, match=name):
        read_failure(folder)


def test_a_folder_that_cannot_be_made_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidInputError, match="cannot create the folder"):
        write_failure(tmp_path / "file" / "there", FAILURE, SPEC, DRAWN)
