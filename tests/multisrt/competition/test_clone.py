import numpy as np
import pytest

from multisrt.competition.clone import SIMULATOR_FILES, Clone
from multisrt.competition.worlds import competition_environment
from multisrt.geometry.errors import InvalidInputError


def test_another_folder_is_refused(tmp_path):
    with pytest.raises(InvalidInputError, match=r"not a clone .* no scripts/base_policy.py"):
        Clone(tmp_path)


def test_another_version_is_refused_unless_allowed(fake):
    with pytest.raises(InvalidInputError, match=r"base_policy.py is not .* \(8 more differ\)"):
        Clone(fake)
    assert Clone(fake, any_version=True).changed == tuple(SIMULATOR_FILES)


def test_changed_options_are_refused(fake):
    path = fake / "configs" / "multi-robot.yaml"
    path.write_text(path.read_text().replace("comm_range: 15", "comm_range: 50"))
    with pytest.raises(InvalidInputError, match="comm_range: 50; it is 15"):
        Clone(fake, any_version=True).options()


def test_starts_are_free_and_those_of_the_seed(fake):
    clone = Clone(fake, any_version=True)
    drawn = clone.starts("env1", 20, 0)
    assert drawn == clone.starts("env1", 20, 0) != clone.starts("env1", 20, 1)
    occupied, _ = clone.cells("env1")
    for column, row in drawn:
        assert not occupied[row - 5 : row + 6, column - 5 : column + 6].any()


def test_wrong_starts_and_maps_are_told(fake):
    clone = Clone(fake, any_version=True)
    for start, told in ((0, 0), "is in a wall"), ((500, 0), "has 120 columns and 80 rows"):
        with pytest.raises(InvalidInputError, match=told):
            clone.require_start("env1", start)
    with pytest.raises(InvalidInputError, match="no map 'env9'"):
        clone.maps(("env9",))


def test_maps_are_worlds(fake):
    world = competition_environment(fake, "env1")
    # Walls of 3 cells around 120 x 80 cells, and one of 3 cells with a door of 12.
    assert world.area_m2 == pytest.approx((114 * 74 - 3 * 74 + 3 * 12) * 0.01)
    assert world.name == "env1"


def test_maps_of_the_competition_are_worlds(real):
    world = competition_environment(real, "env4")
    occupied, inside = Clone(real).cells("env4")
    assert world.area_m2 == pytest.approx(np.sum(~occupied & inside) * 0.01, rel=0.01)
